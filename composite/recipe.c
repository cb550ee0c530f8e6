/* SPDX-License-Identifier: Apache-2.0 */
/* Settings of lights: from a recipe file, from the caller, and into the output's header. */
#include "composite/job.h"

#include "core/checked.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <sys/stat.h>

enum { RECIPE_MAX_BYTES = 16 << 20 };

typedef enum FieldKind { FIELD_NUMBER, FIELD_COLOUR, FIELD_SWITCH } FieldKind;

/* Every setting of a light: in a recipe, in the public structure, and in ours. */
static const struct Field {
    const char *key;
    FieldKind kind;
    uint32_t set;
    size_t ours, theirs;
    double least, most;
} fields[] = {
    {"gain", FIELD_NUMBER, CAU_MERGE_GAIN, offsetof(Setting, gain), offsetof(cau_merge_light, gain),
        -HUGE_VAL, HUGE_VAL},
    {"ev", FIELD_NUMBER, CAU_MERGE_EV, offsetof(Setting, ev), offsetof(cau_merge_light, ev), -HUGE_VAL,
        HUGE_VAL},
    {"tint", FIELD_COLOUR, CAU_MERGE_TINT, offsetof(Setting, tint), offsetof(cau_merge_light, tint),
        -HUGE_VAL, HUGE_VAL},
    {"temperature", FIELD_NUMBER, CAU_MERGE_TEMPERATURE, offsetof(Setting, temperature_k),
        offsetof(cau_merge_light, temperature_k), 1667, 25000},
    {"saturation", FIELD_NUMBER, CAU_MERGE_SATURATION, offsetof(Setting, saturation),
        offsetof(cau_merge_light, saturation), 0, 100},
    {"mute", FIELD_SWITCH, CAU_MERGE_MUTE, offsetof(Setting, mute), 0, 0, 1},
    {"solo", FIELD_SWITCH, CAU_MERGE_SOLO, offsetof(Setting, solo), 0, 0, 1},
};
enum { FIELDS = sizeof fields / sizeof *fields };

const Setting setting_plain = {.gain = 1, .tint = {1, 1, 1}, .temperature_k = 6500, .saturation = 1};

static cau_result check_range(
    const struct Field *field, const double *values, const char *light, CauError *err) {
    for (int i = 0; i < (field->kind == FIELD_COLOUR ? 3 : 1); i++)
        if (values[i] < field->least || values[i] > field->most)
            return error_set(err, CAU_ERROR_USAGE, "light \"%s\": %s is %g, not %g to %g", light, field->key,
                values[i], field->least, field->most);
    return CAU_OK;
}

static cau_result apply_entry(Setting *s, const cau_merge_light *e, CauError *err) {
    for (int i = 0; i < FIELDS; i++) {
        const struct Field *field = &fields[i];
        size_t count = field->kind == FIELD_COLOUR ? 3 : 1;
        if (!(e->set & field->set)) continue;
        if (field->kind == FIELD_SWITCH) {
            *(bool *)((char *)s + field->ours) = true;
            continue;
        }
        const double *from = (const double *)(const void *)((const char *)e + field->theirs);
        CAU_TRY(check_range(field, from, e->light ? e->light : "(every light)", err));
        memcpy((char *)s + field->ours, from, count * sizeof *from);
    }
    return CAU_OK;
}

cau_result setting_apply(Lights *lights, const cau_merge_light *e, CauError *err) {
    Light *light = NULL;
    bool indirect_only;
    for (size_t i = 0; !e->light && i < lights->count; i++)
        CAU_TRY(apply_entry(&lights->lights[i].both, e, err));
    if (!e->light) return CAU_OK;
    CAU_TRY(lights_match(&light, &indirect_only, lights, e->light, err));
    return apply_entry(indirect_only ? &light->indirect_only : &light->both, e, err);
}

static cau_result bad_value(const char *light, const char *key, const char *wanted, CauError *err) {
    return error_set(err, CAU_ERROR_INPUT, "light \"%s\": \"%s\" must be %s", light, key, wanted);
}

static cau_result read_number(
    double *out, const json_t *value, const char *light, const char *key, CauError *err) {
    if (!json_is_number(value) || !isfinite(json_number_value(value)))
        return bad_value(light, key, "a number", err);
    *out = json_number_value(value);
    return CAU_OK;
}

static cau_result read_field(
    Setting *s, const struct Field *field, const char *light, const json_t *value, CauError *err) {
    void *to = (char *)s + field->ours;
    double numbers[3];
    if (field->kind == FIELD_SWITCH) {
        if (!json_is_boolean(value)) return bad_value(light, field->key, "true or false", err);
        *(bool *)to = json_is_true(value);
        return CAU_OK;
    }
    if (field->kind == FIELD_COLOUR) {
        if (!json_is_array(value) || json_array_size(value) != 3)
            return bad_value(light, field->key, "a list of three numbers", err);
        for (size_t i = 0; i < 3; i++)
            CAU_TRY(read_number(&numbers[i], json_array_get(value, i), light, field->key, err));
    } else {
        CAU_TRY(read_number(numbers, value, light, field->key, err));
    }
    if (check_range(field, numbers, light, err) != CAU_OK) return CAU_ERROR_INPUT;
    memcpy(to, numbers, (field->kind == FIELD_COLOUR ? 3 : 1) * sizeof *numbers);
    return CAU_OK;
}

static cau_result read_setting(
    Setting *s, const char *light, const char *key, const json_t *value, CauError *err) {
    char known[128] = "";
    for (int i = 0; i < FIELDS; i++) {
        if (strcmp(key, fields[i].key) == 0) return read_field(s, &fields[i], light, value, err);
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", i ? ", " : "", fields[i].key);
    }
    return error_set(
        err, CAU_ERROR_INPUT, "light \"%s\": unknown key \"%s\", not one of %s", light, key, known);
}

static cau_result read_lights(Lights *lights, json_t *object, CauError *err) {
    const char *name, *key;
    json_t *settings, *value;
    if (!json_is_object(object)) return error_set(err, CAU_ERROR_INPUT, "\"lights\" must be an object");
    json_object_foreach(object, name, settings) {
        Light *light = NULL;
        bool indirect_only;
        CAU_TRY(lights_match(&light, &indirect_only, lights, name, err));
        if (!json_is_object(settings))
            return error_set(err, CAU_ERROR_INPUT, "light \"%s\" must be an object of settings", name);
        Setting *s = indirect_only ? &light->indirect_only : &light->both;
        json_object_foreach(settings, key, value) CAU_TRY(read_setting(s, name, key, value, err));
    }
    return CAU_OK;
}

static cau_result read_tint_space(Lights *lights, const json_t *value, CauError *err) {
    if (!json_is_string(value))
        return error_set(err, CAU_ERROR_INPUT, "\"tint_space\" must be the name of a colour space");
    free(lights->tint_space);
    lights->tint_space = string_copy(json_string_value(value));
    return lights->tint_space ? CAU_OK : error_set(err, CAU_ERROR_RESOURCE, "out of memory for a recipe");
}

static cau_result read_recipe(Lights *lights, json_t *root, CauError *err) {
    const char *key;
    json_t *value;
    if (!json_is_object(root)) return error_set(err, CAU_ERROR_INPUT, "a recipe is a JSON object");
    json_t *version = json_object_get(root, "caustics_recipe");
    if (!json_is_integer(version) || json_integer_value(version) != 1)
        return error_set(
            err, CAU_ERROR_INPUT, "\"caustics_recipe\" must be there and be 1, the version known here");
    json_object_foreach(root, key, value) {
        if (strcmp(key, "caustics_recipe") == 0) continue;
        if (strcmp(key, "tint_space") == 0)
            CAU_TRY(read_tint_space(lights, value, err));
        else if (strcmp(key, "lights") == 0)
            CAU_TRY(read_lights(lights, value, err));
        else
            return error_set(err, CAU_ERROR_INPUT,
                "unknown key \"%s\", not one of caustics_recipe, tint_space, lights", key);
    }
    return CAU_OK;
}

cau_result recipe_apply_text(Lights *lights, const char *json, const char *from, CauError *err) {
    json_error_t where;
    json_t *root = json_loads(json, JSON_REJECT_DUPLICATES, &where);
    if (!root)
        return error_set(
            err, CAU_ERROR_INPUT, "%s, line %d, column %d: %s", from, where.line, where.column, where.text);
    cau_result result = read_recipe(lights, root, err);
    json_decref(root);
    if (result != CAU_OK) error_prefix(err, "%s: ", from);
    return result;
}

cau_result recipe_apply(Lights *lights, const char *path, CauError *err) {
    struct stat info;
    if (stat(path, &info) != 0 || !S_ISREG(info.st_mode) || info.st_size > RECIPE_MAX_BYTES)
        return error_set(err, CAU_ERROR_INPUT,
            "cannot read the recipe \"%s\": it is not a file of at most %d bytes", path, RECIPE_MAX_BYTES);
    json_error_t where;
    json_t *root = json_load_file(path, JSON_REJECT_DUPLICATES, &where);
    if (!root)
        return error_set(err, CAU_ERROR_INPUT, "recipe \"%s\", line %d, column %d: %s", path, where.line,
            where.column, where.text);
    cau_result result = read_recipe(lights, root, err);
    json_decref(root);
    if (result != CAU_OK) error_prefix(err, "recipe \"%s\": ", path);
    return result;
}

/* File names need not be UTF-8; JSON must. */
static json_t *text_or_null(const char *text) {
    json_t *value = text ? json_string(text) : json_null();
    return value ? value : json_string("(not UTF-8)");
}

static void record_setting(json_t *lights, const char *name, const Setting *s) {
    json_t *item = json_object();
    for (int i = 0; i < FIELDS; i++) {
        const void *from = (const char *)s + fields[i].ours;
        const double *numbers = from;
        json_object_set_new(item, fields[i].key,
            fields[i].kind == FIELD_SWITCH   ? json_boolean(*(const bool *)from)
            : fields[i].kind == FIELD_COLOUR ? json_pack("[f,f,f]", numbers[0], numbers[1], numbers[2])
                                             : json_real(numbers[0]));
    }
    json_object_set_new(lights, name, item);
}

static json_t *recipe_json(const Job *job) {
    json_t *lights = json_object(), *root = json_object();
    for (size_t i = 0; i < job->lights.count; i++) {
        const Light *l = &job->lights.lights[i];
        char name[512];
        record_setting(lights, l->base, &l->both);
        snprintf(name, sizeof name, "%s%s", l->base, CAU_SUFFIX_INDIRECT);
        if (l->indirect >= 0) record_setting(lights, name, &l->indirect_only);
    }
    json_object_set_new(root, "caustics_recipe", json_integer(1));
    if (strcmp(job->tint_space, job->beauty_space) != 0)
        json_object_set_new(root, "tint_space", text_or_null(job->tint_space));
    json_object_set_new(root, "lights", lights);
    return root;
}

char *recipe_text(const Job *job) {
    json_t *root = recipe_json(job);
    char *text = json_dumps(root, JSON_INDENT(2) | JSON_REAL_PRECISION(17));
    json_decref(root);
    return text;
}

/* What was done to each layer, for whoever wants to do it again in another program. */
static json_t *record_terms(const Job *job) {
    json_t *terms = json_array();
    for (size_t t = 0; t < job->term_count; t++) {
        const Term *term = &job->terms[t];
        json_t *matrix = json_array();
        for (int i = 0; i < 9; i++)
            json_array_append_new(matrix, json_real(term->diagonal && i % 4 ? 0 : term->matrix[i]));
        json_t *item = json_object();
        json_object_set_new(
            item, "layer", text_or_null(exr_layer_shown(&job->caustics.layers.layers[term->layer])));
        json_object_set_new(item, "times_albedo", json_boolean(term->times_albedo));
        json_object_set_new(item, "matrix", matrix);
        json_array_append_new(terms, item);
    }
    return terms;
}

char *recipe_record(const Job *job) {
    const cau_merge_options *o = job->options;
    json_t *root = json_object();
    json_object_set_new(root, "program", text_or_null("caustic-merge " CAUSTICS_VERSION));
    json_object_set_new(root, "beauty", text_or_null(o->beauty));
    json_object_set_new(root, "caustics", text_or_null(o->caustics));
    json_object_set_new(root, "pass", text_or_null(exr_layer_shown(job->target)));
    json_object_set_new(root, "albedo", text_or_null(job->albedo ? exr_layer_shown(job->albedo) : NULL));
    json_object_set_new(root, "beauty_space", text_or_null(job->beauty_space));
    json_object_set_new(root, "caustics_space", text_or_null(job->caustics_space));
    json_object_set_new(root, "tint_space", text_or_null(job->tint_space));
    if (o->has_offset) json_object_set_new(root, "offset", json_pack("[i,i]", o->offset_x, o->offset_y));
    json_object_set_new(
        root, "holdout", json_boolean(o->holdout || o->holdout_alpha || o->holdout_name_count));
    json_object_set_new(root, "into_passes", json_boolean(o->into_groups || o->into_diffuse));
    json_object_set_new(root, "recipe", recipe_json(job));
    json_object_set_new(root, "terms", record_terms(job));
    char *earlier = exr_attr_text(exr_attr_find(&job->beauty.header->parts[0], CAU_ATTRIBUTE_MERGE));
    json_t *before = earlier ? json_loads(earlier, 0, NULL) : NULL;
    if (before) json_object_set_new(root, "before", before);
    free(earlier);
    char *text = json_dumps(root, JSON_COMPACT);
    json_decref(root);
    return text;
}
