/* SPDX-License-Identifier: Apache-2.0 */
#include "core/checked.h"
#include "image/layer_names.h"

#include <jansson.h>

static const char *const kind_names[] = {"radiance", "indirect", "irradiance", "seen", "error", "bias"};
enum { KIND_COUNT = sizeof kind_names / sizeof *kind_names };

const char *cau_layer_kind_name(cau_layer_kind kind) {
    return (unsigned)kind < KIND_COUNT ? kind_names[kind] : "unknown";
}

bool layer_kind_from_name(const char *name, cau_layer_kind *out) {
    for (int i = 0; i < KIND_COUNT; i++)
        if (strcmp(name, kind_names[i]) == 0) {
            *out = (cau_layer_kind)i;
            return true;
        }
    return false;
}

cau_result layer_list_add(
    LayerList *list, const char *layer, const char *light, cau_layer_kind kind, CauError *err) {
    void *array = list->entries;
    LayerEntry entry = {string_copy(layer), string_copy(light), kind};
    bool fits = array_reserve(&array, &list->capacity, list->count + 1, sizeof entry);
    list->entries = array;
    if (!entry.layer || !entry.light || !fits) {
        free(entry.layer);
        free(entry.light);
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the list of layers");
    }
    list->entries[list->count++] = entry;
    return CAU_OK;
}

void layer_list_free(LayerList *list) {
    for (size_t i = 0; i < list->count; i++) {
        free(list->entries[i].layer);
        free(list->entries[i].light);
    }
    free(list->entries);
    *list = (LayerList){0};
}

char *layer_list_encode(const LayerList *list) {
    json_t *array = json_array();
    bool ok = array != NULL;
    for (size_t i = 0; ok && i < list->count; i++) {
        const LayerEntry *e = &list->entries[i];
        json_t *item = json_pack(
            "{s:s, s:s, s:s}", "layer", e->layer, "light", e->light, "kind", cau_layer_kind_name(e->kind));
        ok = item && json_array_append_new(array, item) == 0;
    }
    char *text = ok ? json_dumps(array, JSON_COMPACT) : NULL;
    json_decref(array);
    return text;
}

static cau_result decode_entry(LayerList *out, const json_t *item, size_t index, CauError *err) {
    const char *layer = NULL, *light = NULL, *kind_name = NULL;
    json_error_t where;
    /* STRICT: an unknown key may change the meaning of the entry, so it is not skipped. */
    if (json_unpack_ex((json_t *)(uintptr_t)item, &where, JSON_STRICT, "{s:s, s:s, s:s}", "layer", &layer,
            "light", &light, "kind", &kind_name) != 0)
        return error_set(
            err, CAU_ERROR_INPUT, "attribute %s, entry %zu: %s", CAU_ATTRIBUTE_LAYERS, index, where.text);
    cau_layer_kind kind;
    if (!layer_kind_from_name(kind_name, &kind))
        return error_set(err, CAU_ERROR_INPUT,
            "attribute %s, entry %zu: unknown kind \"%s\", not one of radiance, indirect, irradiance, seen, "
            "error, bias",
            CAU_ATTRIBUTE_LAYERS, index, kind_name);
    for (size_t i = 0; i < out->count; i++)
        if (strcmp(out->entries[i].layer, layer) == 0)
            return error_set(err, CAU_ERROR_INPUT, "attribute %s: layer \"%s\" is listed twice",
                CAU_ATTRIBUTE_LAYERS, layer);
    return layer_list_add(out, layer, light, kind, err);
}

cau_result layer_list_decode(LayerList *out, const char *json, CauError *err) {
    *out = (LayerList){0};
    json_error_t where;
    json_t *root = json_loads(json, JSON_REJECT_DUPLICATES, &where);
    if (!root)
        return error_set(err, CAU_ERROR_INPUT, "attribute %s is not valid JSON: %s (position %d)",
            CAU_ATTRIBUTE_LAYERS, where.text, where.position);
    cau_result result = CAU_OK;
    if (!json_is_array(root))
        result = error_set(err, CAU_ERROR_INPUT, "attribute %s is not a list", CAU_ATTRIBUTE_LAYERS);
    for (size_t i = 0; result == CAU_OK && i < json_array_size(root); i++)
        result = decode_entry(out, json_array_get(root, i), i, err);
    json_decref(root);
    if (result != CAU_OK) layer_list_free(out);
    return result;
}
