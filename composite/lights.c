/* SPDX-License-Identifier: Apache-2.0 */
/* Which layers of a caustics file are light, and which light a user means. */
#include "composite/job.h"

#include "core/checked.h"
#include "core/nearest.h"

#include <stdio.h>

static cau_result no_memory(CauError *err) {
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the list of lights");
}

static int *slot_of(Light *light, cau_layer_kind kind) {
    switch (kind) {
    case CAU_LAYER_RADIANCE:
        return &light->radiance;
    case CAU_LAYER_INDIRECT:
        return &light->indirect;
    case CAU_LAYER_IRRADIANCE:
        return &light->irradiance;
    case CAU_LAYER_SEEN:
        return &light->seen;
    default:
        return NULL;
    }
}

static cau_result new_light(Lights *lights, const char *name, Light **out, CauError *err) {
    void *array = lights->lights;
    if (!array_reserve(&array, &lights->capacity, lights->count + 1, sizeof **out)) return no_memory(err);
    lights->lights = array;
    Light *light = *out = &lights->lights[lights->count];
    *light = (Light){.name = string_copy(name),
        .radiance = -1,
        .indirect = -1,
        .irradiance = -1,
        .seen = -1,
        .both = setting_plain,
        .indirect_only = setting_plain};
    if (!light->name) return no_memory(err);
    lights->count++;
    return CAU_OK;
}

static cau_result add_layer(
    Lights *lights, const char *light_name, cau_layer_kind kind, int layer, CauError *err) {
    Light *light = NULL;
    for (size_t i = 0; !light && i < lights->count; i++) {
        Light *l = &lights->lights[i];
        int *slot = slot_of(l, kind);
        /* Two lamps may share a name: then each has its own layers. */
        if (strcmp(l->name, light_name) == 0 && slot && *slot < 0) light = l;
    }
    if (!light) CAU_TRY(new_light(lights, light_name, &light, err));
    *slot_of(light, kind) = layer;
    return CAU_OK;
}

/* The layer's own name: what a host put before it ("ViewLayer.caustics_key") is not part of it. */
static int find_layer(const Picture *p, const char *name) {
    for (size_t i = 0; i < p->layers.count; i++)
        if (strcmp(p->layers.layers[i].pass, name) == 0 && exr_layer_is_rgb(&p->layers.layers[i]))
            return (int)i;
    return -1;
}

static cau_result from_header(Lights *out, const Picture *p, const char *json, CauError *err) {
    LayerList list;
    cau_result result = layer_list_decode(&list, json, err);
    if (result != CAU_OK) error_prefix(err, "\"%s\": ", exr_reader_path(p->reader));
    for (size_t i = 0; result == CAU_OK && i < list.count; i++) {
        const LayerEntry *e = &list.entries[i];
        if (e->kind == CAU_LAYER_ERROR || e->kind == CAU_LAYER_BIAS) continue;
        int layer = find_layer(p, e->layer);
        if (layer < 0)
            result = error_set(err, CAU_ERROR_INPUT,
                "\"%s\": the header lists a layer \"%s\", but there are no channels \"%s.R\", \"%s.G\", "
                "\"%s.B\"",
                exr_reader_path(p->reader), e->layer, e->layer, e->layer, e->layer);
        else
            result = add_layer(out, e->light, e->kind, layer, err);
    }
    layer_list_free(&list);
    return result;
}

static cau_result from_names(Lights *out, const Picture *p, CauError *err) {
    for (size_t i = 0; i < p->layers.count; i++) {
        const char *name = p->layers.layers[i].pass;
        cau_layer_kind kind;
        char *light = array_new(strlen(name) + 1, 1);
        if (!light) return no_memory(err);
        cau_result result = CAU_OK;
        if (exr_layer_is_rgb(&p->layers.layers[i]) && layer_name_parse(name, light, &kind) &&
            kind != CAU_LAYER_ERROR && kind != CAU_LAYER_BIAS)
            result = add_layer(out, light, kind, (int)i, err);
        free(light);
        CAU_TRY(result);
    }
    return CAU_OK;
}

/* Base and place, from the first of its layers. */
static cau_result name_layers(Light *light, const Picture *p, CauError *err) {
    static const struct {
        size_t offset;
        const char *suffix;
    } ways[] = {{offsetof(Light, radiance), ""}, {offsetof(Light, indirect), CAU_SUFFIX_INDIRECT},
        {offsetof(Light, irradiance), CAU_SUFFIX_IRRADIANCE}, {offsetof(Light, seen), CAU_SUFFIX_SEEN}};
    int index = -1;
    size_t way = 0;
    for (; index < 0 && way < sizeof ways / sizeof *ways; way++)
        memcpy(&index, (const char *)light + ways[way].offset, sizeof index);
    const ExrLayer *layer = index < 0 ? NULL : &p->layers.layers[index];
    const char *suffix = ways[way - 1].suffix;
    light->base = string_copy(layer ? layer->pass : "");
    light->place = string_copy(layer ? layer->name : "");
    if (!light->base || !light->place) return no_memory(err);
    size_t n = strlen(light->base), m = strlen(suffix);
    if (n > m && strcmp(light->base + n - m, suffix) == 0) light->base[n - m] = '\0';
    light->place[layer ? layer->pass_at : 0] = '\0';
    return CAU_OK;
}

cau_result lights_find(Lights *out, const Picture *caustics, CauError *err) {
    *out = (Lights){0};
    const ExrAttr *attr = exr_attr_find(&caustics->header->parts[0], CAU_ATTRIBUTE_LAYERS);
    char *json = exr_attr_text(attr);
    if (attr && !json)
        return error_set(err, CAU_ERROR_INPUT, "\"%s\": attribute %s is of type %s, not a text",
            exr_reader_path(caustics->reader), CAU_ATTRIBUTE_LAYERS, attr->type);
    cau_result result = json ? from_header(out, caustics, json, err) : from_names(out, caustics, err);
    free(json);
    for (size_t i = 0; result == CAU_OK && i < out->count; i++)
        result = name_layers(&out->lights[i], caustics, err);
    return result;
}

size_t picture_colour_part(const Picture *p, const Lights *lights) {
    for (size_t i = 0; i < lights->count; i++) {
        const Light *l = &lights->lights[i];
        int layer = l->radiance >= 0 ? l->radiance : l->indirect >= 0 ? l->indirect : l->seen;
        /* An output of `add` may hold both: its own space is that of both. */
        if (layer >= 0 && !exr_attr_find(&p->header->parts[0], CAU_ATTRIBUTE_MERGE))
            return p->layers.layers[layer].part;
    }
    const ExrLayer *layer;
    CauError unused = {0};
    return picture_default_layer(&layer, p, "", &unused) == CAU_OK ? layer->part : 0;
}

void lights_free(Lights *lights) {
    for (size_t i = 0; i < lights->count; i++) {
        free(lights->lights[i].name);
        free(lights->lights[i].base);
        free(lights->lights[i].place);
    }
    free(lights->lights);
    free(lights->tint_space);
    *lights = (Lights){0};
}

/* "key", "caustics_key" and "ViewLayer.caustics_key". */
static bool same_layer(const Light *light, const char *suffix, const char *name) {
    char layer[512];
    snprintf(layer, sizeof layer, "%s%s", light->base, suffix);
    size_t prefix = strlen(CAU_LAYER_PREFIX), place = strlen(light->place);
    return strcmp(layer, name) == 0 ||
           (strncmp(light->place, name, place) == 0 && strcmp(layer, name + place) == 0) ||
           (strncmp(layer, CAU_LAYER_PREFIX, prefix) == 0 && strcmp(layer + prefix, name) == 0);
}

static cau_result unknown_light(const Lights *lights, const char *name, CauError *err) {
    const char **names = array_new(lights->count, sizeof *names);
    if (!names) return no_memory(err);
    char text[400] = "";
    size_t used = 0;
    for (size_t i = 0; i < lights->count; i++) {
        names[i] = lights->lights[i].name;
        if (used + strlen(names[i]) + 3 < sizeof text)
            used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", i ? ", " : "", names[i]);
    }
    int nearest = nearest_name(name, names, lights->count);
    if (nearest < 0)
        error_set(err, CAU_ERROR_INPUT, "there is no light \"%s\": the caustics hold no light layers", name);
    else
        error_set(err, CAU_ERROR_INPUT, "there is no light \"%s\"; did you mean \"%s\"? The lights are: %s",
            name, names[nearest], text);
    free(names);
    return CAU_ERROR_INPUT;
}

static cau_result by_original_name(Light **out, const Lights *lights, const char *name, CauError *err) {
    for (size_t i = 0; i < lights->count; i++) {
        Light *l = &lights->lights[i];
        if (strcmp(l->name, name) != 0) continue;
        if (*out)
            return error_set(err, CAU_ERROR_INPUT,
                "two lights are called \"%s\": name the layer instead, \"%s\" or \"%s\"", name, (*out)->base,
                l->base);
        *out = l;
    }
    return CAU_OK;
}

cau_result lights_match(
    Light **out, bool *indirect_only, const Lights *lights, const char *name, CauError *err) {
    *out = NULL;
    *indirect_only = false;
    for (size_t i = 0; i < lights->count; i++) {
        Light *l = &lights->lights[i];
        if (!same_layer(l, "", name)) continue;
        if (*out)
            return error_set(err, CAU_ERROR_INPUT,
                "\"%s\" may be the layer \"%s%s\" or \"%s%s\": name the one that is meant", name,
                (*out)->place, (*out)->base, l->place, l->base);
        *out = l;
    }
    if (!*out) CAU_TRY(by_original_name(out, lights, name, err));
    for (size_t i = 0; !*out && i < lights->count; i++)
        if (lights->lights[i].indirect >= 0 && same_layer(&lights->lights[i], CAU_SUFFIX_INDIRECT, name)) {
            *out = &lights->lights[i];
            *indirect_only = true;
        }
    return *out ? CAU_OK : unknown_light(lights, name, err);
}
