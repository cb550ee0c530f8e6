/* SPDX-License-Identifier: Apache-2.0 */
/* A recipe as the lights of a scene file: strength and colour are multiplied where they stand in the text, so
 * that blanks, order and the spelling of every other number stay. */
#include "composite/hosts/hosts.h"

#include "composite/hosts/json_text.h"
#include "core/checked.h"
#include "core/file_atomic.h"
#include "core/nearest.h"

#include <jansson.h>
#include <math.h>

/* One light of the scene, or its world. */
typedef struct Source {
    json_t *json;
    const char *at;       /* its object in the text */
    const char *label;    /* what its layer is named after */
    const char *strength; /* the key */
    LayerBase base;
    const Light *light; /* of the recipe; NULL: it stays */
} Source;

/* Bytes at..end give way to `text`. */
typedef struct Edit {
    const char *at, *end;
    char text[4 * HOST_NUMBER_MAX];
} Edit;

typedef struct Scene {
    char *text;
    json_t *root;
    Source *sources;
    Edit *edits;
    size_t source_count, edit_count;
} Scene;

static cau_result no_memory(CauError *err) {
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the scene's lights");
}

static void add_source(Scene *s, json_t *json, const char *at, const char *strength, const char *fallback) {
    const char *group = json_string_value(json_object_get(json, "group"));
    const char *name = json_string_value(json_object_get(json, "name"));
    const char *label = group ? group : name ? name : fallback;
    if (json_is_object(json) && at && label)
        s->sources[s->source_count++] =
            (Source){.json = json, .at = at, .label = label, .strength = strength};
}

/* Lights of one group share a layer, and so a name. */
static cau_result name_sources(Scene *s, CauError *err) {
    const char **labels = array_new(s->source_count, sizeof *labels);
    LayerBase *bases = array_new(s->source_count, sizeof *bases);
    size_t *which = array_new(s->source_count, sizeof *which), count = 0;
    cau_result result = labels && bases && which ? CAU_OK : no_memory(err);
    for (size_t i = 0; result == CAU_OK && i < s->source_count; i++) {
        for (which[i] = 0; which[i] < count; which[i]++)
            if (strcmp(labels[which[i]], s->sources[i].label) == 0) break;
        if (which[i] == count) labels[count++] = s->sources[i].label;
    }
    if (result == CAU_OK) result = layer_names_map(labels, count, bases, err);
    for (size_t i = 0; result == CAU_OK && i < s->source_count; i++) s->sources[i].base = bases[which[i]];
    free(labels);
    free(bases);
    free(which);
    return result;
}

static cau_result find_sources(Scene *s, CauError *err) {
    json_t *lights = json_object_get(s->root, "lights");
    const char *root = json_text_skip(s->text), *list = json_text_member(root, "lights");
    size_t count = json_array_size(lights);
    s->sources = array_new(count + 1, sizeof *s->sources);
    s->edits = array_new(2 * (count + 1), sizeof *s->edits);
    if (!s->sources || !s->edits) return no_memory(err);
    for (size_t i = 0; list && i < count; i++) {
        json_t *light = json_array_get(lights, i);
        const char *type = json_string_value(json_object_get(light, "type"));
        bool sun = type && strcmp(type, "sun") == 0;
        add_source(s, light, json_text_element(list, i), sun ? "strength" : "power_w", NULL);
    }
    add_source(s, json_object_get(s->root, "world"), json_text_member(root, "world"), "strength", "world");
    return name_sources(s, err);
}

static bool is_plain(const Setting *s) {
    return s->gain == 1 && s->ev == 0 && s->tint[0] == 1 && s->tint[1] == 1 && s->tint[2] == 1 && !s->mute &&
           !s->solo && s->temperature_k == setting_plain.temperature_k && s->saturation == 1;
}

static bool ends_with(const char *text, const char *end) {
    size_t n = strlen(text), m = strlen(end);
    return n > m && strcmp(text + n - m, end) == 0;
}

static cau_result unknown_light(const Scene *s, const char *name, CauError *err) {
    const char **names = array_new(s->source_count, sizeof *names);
    if (!names) return no_memory(err);
    for (size_t i = 0; i < s->source_count; i++) names[i] = s->sources[i].label;
    int nearest = nearest_name(name, names, s->source_count);
    error_set(err, CAU_ERROR_INPUT, "the recipe's light \"%s\" is not in the scene%s%s%s", name,
        nearest >= 0 ? "; did you mean \"" : ", which has no lights", nearest >= 0 ? names[nearest] : "",
        nearest >= 0 ? "\"?" : "");
    free(names);
    return CAU_ERROR_INPUT;
}

static cau_result match(Scene *s, const Light *l, CauError *err) {
    bool found = false;
    for (size_t i = 0; i < s->source_count; i++) {
        Source *source = &s->sources[i];
        const char *base = source->base.name + strlen(CAU_LAYER_PREFIX);
        if (strcmp(l->name, base) != 0 && strcmp(l->name, source->label) != 0) continue;
        source->light = l;
        found = true;
    }
    if (found) return CAU_OK;
    if (!ends_with(l->name, CAU_SUFFIX_INDIRECT)) return unknown_light(s, l->name, err);
    if (is_plain(&l->both)) return CAU_OK;
    return error_set(err, CAU_ERROR_INPUT,
        "\"%s\" is a light's indirect layer alone, and a scene has no strength for that: leave it out of the "
        "recipe",
        l->name);
}

static void edit(Scene *s, const char *at, const char *end, const char *text) {
    Edit *e = &s->edits[s->edit_count++];
    *e = (Edit){.at = at, .end = end};
    snprintf(e->text, sizeof e->text, "%s", text);
}

/* Exchanges a member's value, or puts a new member behind `after`, else first in the object. */
static void set_member(
    Scene *s, const Source *source, const char *key, const char *after, const char *value) {
    const char *at = json_text_member(source->at, key), *before = json_text_member(source->at, after);
    char text[sizeof((Edit *)0)->text];
    if (at) {
        edit(s, at, json_text_end(at), value);
        return;
    }
    at = before ? json_text_end(before) : source->at + 1;
    bool last = *json_text_skip(at) == '}';
    snprintf(text, sizeof text, "%s\"%s\": %s%s", before ? ", " : "", key, value, before || last ? "" : ", ");
    edit(s, at, at, text);
}

static cau_result set_colour(Scene *s, const Source *source, const double tint[3], CauError *err) {
    json_t *list = json_object_get(source->json, "color");
    bool world = source->json == json_object_get(s->root, "world");
    char number[3][HOST_NUMBER_MAX], text[sizeof((Edit *)0)->text];
    if (list && json_array_size(list) != 3)
        return error_set(err, CAU_ERROR_INPUT, "light \"%s\": its color is a texture, which cannot be tinted",
            source->label);
    for (size_t i = 0; i < 3; i++) {
        double old = list ? json_number_value(json_array_get(list, i)) : world ? 0 : 1;
        host_number(number[i], old * tint[i]);
    }
    snprintf(text, sizeof text, "[%s, %s, %s]", number[0], number[1], number[2]);
    set_member(s, source, "color", source->strength, text);
    return CAU_OK;
}

static cau_result multiply(Scene *s, const Source *source, bool solo, CauError *err) {
    const Setting *v = &source->light->both;
    json_t *old = json_object_get(source->json, source->strength);
    bool world = source->json == json_object_get(s->root, "world");
    if (!json_is_number(old) && !(world && !old))
        return error_set(err, CAU_ERROR_INPUT, "light \"%s\": its %s is not a number that can be multiplied",
            source->label, source->strength);
    bool grey = v->tint[0] == v->tint[1] && v->tint[1] == v->tint[2];
    double factor = v->mute || (solo && !v->solo) ? 0 : v->gain * exp2(v->ev) * (grey ? v->tint[0] : 1);
    double strength = (old ? json_number_value(old) : 1) * factor;
    for (int i = 0; i < 3; i++)
        if (!(strength >= 0) || !isfinite(strength) || (!grey && v->tint[i] < 0))
            return error_set(err, CAU_ERROR_INPUT,
                "light \"%s\": gain %g, ev %g and tint %g make it negative or infinite, which no light of a "
                "scene "
                "is",
                source->label, v->gain, v->ev, v->tint[i]);
    char text[HOST_NUMBER_MAX];
    host_number(text, strength);
    if (factor != 1) set_member(s, source, source->strength, "color", text);
    return grey ? CAU_OK : set_colour(s, source, v->tint, err);
}

static int by_place(const void *a, const void *b) {
    const Edit *x = a, *y = b;
    return (x->at > y->at) - (x->at < y->at);
}

static char *apply_edits(Scene *s, size_t *size) {
    char *text = NULL;
    FILE *out = open_memstream(&text, size);
    if (!out) return NULL;
    const char *at = s->text;
    qsort(s->edits, s->edit_count, sizeof *s->edits, by_place);
    for (size_t i = 0; i < s->edit_count; i++) {
        fwrite(at, 1, (size_t)(s->edits[i].at - at), out);
        fputs(s->edits[i].text, out);
        at = s->edits[i].end;
    }
    fputs(at, out);
    if (fclose(out) == 0) return text;
    free(text);
    return NULL;
}

static cau_result write_scene(Scene *s, const char *path, CauError *err) {
    size_t size;
    char *text = apply_edits(s, &size);
    if (!text) return no_memory(err);
    /* A member spelled with escapes would not have been found, and now be there twice. */
    json_t *again = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
    cau_result result = again ? file_write_atomic(path, text, size, err)
                              : error_set(err, CAU_ERROR_INPUT, "its lights spell their keys with escapes");
    json_decref(again);
    free(text);
    return result;
}

static cau_result change(Scene *s, const Lights *lights, CauError *err) {
    bool solo = false;
    CAU_TRY(find_sources(s, err));
    for (size_t i = 0; i < lights->count; i++) {
        const Light *l = &lights->lights[i];
        if (l->both.saturation != 1 || l->both.temperature_k != setting_plain.temperature_k)
            return error_set(err, CAU_ERROR_INPUT,
                "light \"%s\": a scene's light has a colour, but neither saturation nor temperature: use a "
                "tint",
                l->name);
        solo = solo || lights->lights[i].both.solo;
        CAU_TRY(match(s, &lights->lights[i], err));
    }
    for (size_t i = 0; i < s->source_count; i++)
        if (s->sources[i].light) CAU_TRY(multiply(s, &s->sources[i], solo, err));
    return CAU_OK;
}

cau_result host_to_scene(const Lights *lights, const char *path, CauError *err) {
    Scene s = {0};
    size_t size;
    json_error_t where;
    CAU_TRY(host_read_file(&s.text, &size, path, err));
    s.root = json_loadb(s.text, size, JSON_REJECT_DUPLICATES, &where);
    cau_result result = CAU_OK;
    if (!s.root)
        result =
            error_set(err, CAU_ERROR_INPUT, "line %d, column %d: %s", where.line, where.column, where.text);
    else if (!json_is_integer(json_object_get(s.root, "caustics_scene")))
        result = error_set(err, CAU_ERROR_INPUT, "it is no scene: it has no \"caustics_scene\"");
    if (result == CAU_OK) result = change(&s, lights, err);
    if (result == CAU_OK && s.edit_count) result = write_scene(&s, path, err);
    json_decref(s.root);
    free(s.text);
    free(s.sources);
    free(s.edits);
    if (result == CAU_ERROR_INPUT) error_prefix(err, "scene \"%s\": ", path);
    return result;
}
