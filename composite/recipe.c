/* SPDX-License-Identifier: Apache-2.0 */
/* Settings of lights: from a recipe file, from the caller, and into the output's header. */
#include "composite/job.h"

#include "core/checked.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <sys/stat.h>

enum { RECIPE_MAX_BYTES = 16 << 20 };

cau_result setting_apply(Lights *lights, const cau_merge_light *e, CauError *err) {
    Light *light = NULL;
    bool indirect_only;
    CAU_TRY(lights_match(&light, &indirect_only, lights, e->light, err));
    Setting *s = indirect_only ? &light->indirect_only : &light->both;
    if (e->set & CAU_MERGE_GAIN) s->gain = e->gain;
    if (e->set & CAU_MERGE_EV) s->ev = e->ev;
    if (e->set & CAU_MERGE_TINT) memcpy(s->tint, e->tint, sizeof s->tint);
    if (e->set & CAU_MERGE_MUTE) s->mute = true;
    if (e->set & CAU_MERGE_SOLO) s->solo = true;
    return CAU_OK;
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

static cau_result read_setting(
    Setting *s, const char *light, const char *key, const json_t *value, CauError *err) {
    if (strcmp(key, "gain") == 0) return read_number(&s->gain, value, light, key, err);
    if (strcmp(key, "ev") == 0) return read_number(&s->ev, value, light, key, err);
    if (strcmp(key, "mute") == 0 || strcmp(key, "solo") == 0) {
        if (!json_is_boolean(value)) return bad_value(light, key, "true or false", err);
        *(key[0] == 'm' ? &s->mute : &s->solo) = json_is_true(value);
        return CAU_OK;
    }
    if (strcmp(key, "tint") == 0) {
        if (!json_is_array(value) || json_array_size(value) != 3)
            return bad_value(light, key, "a list of three numbers", err);
        for (size_t i = 0; i < 3; i++)
            CAU_TRY(read_number(&s->tint[i], json_array_get(value, i), light, key, err));
        return CAU_OK;
    }
    return error_set(err, CAU_ERROR_INPUT,
        "light \"%s\": unknown key \"%s\", not one of gain, ev, tint, mute, solo", light, key);
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
        if (strcmp(key, "lights") != 0)
            return error_set(
                err, CAU_ERROR_INPUT, "unknown key \"%s\", not one of caustics_recipe, lights", key);
        CAU_TRY(read_lights(lights, value, err));
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
    json_t *item = json_pack("{s:f, s:f, s:[f,f,f], s:b, s:b}", "gain", s->gain, "ev", s->ev, "tint",
        s->tint[0], s->tint[1], s->tint[2], "mute", s->mute, "solo", s->solo);
    json_object_set_new(lights, name, item);
}

char *recipe_record(const Job *job) {
    const cau_merge_options *o = job->options;
    json_t *lights = json_object(), *root = json_object();
    for (size_t i = 0; i < job->lights.count; i++) {
        const Light *l = &job->lights.lights[i];
        char name[512];
        record_setting(lights, l->base, &l->both);
        snprintf(name, sizeof name, "%s%s", l->base, CAU_SUFFIX_INDIRECT);
        if (l->indirect >= 0) record_setting(lights, name, &l->indirect_only);
    }
    json_object_set_new(root, "program", text_or_null("caustic-merge " CAUSTICS_VERSION));
    json_object_set_new(root, "beauty", text_or_null(o->beauty));
    json_object_set_new(root, "caustics", text_or_null(o->caustics));
    json_object_set_new(root, "pass", text_or_null(exr_layer_shown(job->target)));
    json_object_set_new(root, "albedo", text_or_null(job->albedo ? exr_layer_shown(job->albedo) : NULL));
    json_object_set_new(root, "beauty_space", text_or_null(job->beauty_space));
    json_object_set_new(root, "caustics_space", text_or_null(job->caustics_space));
    json_object_set_new(root, "tint_space", text_or_null(job->tint_space));
    if (o->has_offset) json_object_set_new(root, "offset", json_pack("[i,i]", o->offset_x, o->offset_y));
    json_object_set_new(root, "recipe", json_pack("{s:i, s:o}", "caustics_recipe", 1, "lights", lights));
    char *earlier = exr_attr_text(exr_attr_find(&job->beauty.header->parts[0], CAU_ATTRIBUTE_MERGE));
    json_t *before = earlier ? json_loads(earlier, 0, NULL) : NULL;
    if (before) json_object_set_new(root, "before", before);
    free(earlier);
    char *text = json_dumps(root, JSON_COMPACT);
    json_decref(root);
    return text;
}
