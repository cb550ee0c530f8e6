/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_layers.h"

#include "core/checked.h"

#include <string.h>
#include <strings.h>

const char *exr_layer_pass(const ExrLayer *layer) {
    const char *dot = strrchr(layer->name, '.');
    return dot ? dot + 1 : layer->name;
}

const char *exr_layer_shown(const ExrLayer *layer) { return layer->name[0] ? layer->name : "R,G,B"; }

/* 0, 1, 2 for red, green, blue; 3 for a single value; -1 for anything else. */
static int colour_index(const char *id, const char *layer) {
    static const char *const letters[] = {"R", "G", "B", "Y"}, *const words[] = {"red", "green", "blue"};
    for (int i = 0; i < 4; i++)
        if (strcmp(id, letters[i]) == 0) return i;
    if (strcmp(id, "V") == 0) return 3;
    for (int i = 0; i < 3; i++)
        if (strcasecmp(id, words[i]) == 0) return i;
    /* Cryptomatte names its channels r, g, b and a, so that nothing takes them for a colour. */
    const char *dot = strrchr(layer, '.');
    if (strncasecmp(dot ? dot + 1 : layer, "crypto", 6) == 0) return -1;
    for (int i = 0; i < 3; i++)
        if (strcasecmp(id, letters[i]) == 0) return i;
    return -1;
}

static cau_result no_memory(CauError *err) {
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the list of layers");
}

/* The layer of that name in that part, made when it is new. */
static cau_result layer_for(
    ExrLayers *list, size_t part, char *name, bool bare, ExrLayer **out, CauError *err) {
    for (size_t i = list->count; i-- > 0 && list->layers[i].part == part;)
        if (list->layers[i].bare == bare && strcmp(list->layers[i].name, name) == 0) {
            free(name);
            *out = &list->layers[i];
            return CAU_OK;
        }
    void *array = list->layers;
    if (!array_reserve(&array, &list->capacity, list->count + 1, sizeof *list->layers)) {
        free(name);
        return no_memory(err);
    }
    list->layers = array;
    *out = &list->layers[list->count++];
    **out = (ExrLayer){.name = name, .bare = bare, .part = part, .rgb = {-1, -1, -1}, .luma = -1};
    return CAU_OK;
}

static cau_result add_channel(
    ExrLayers *list, const ExrHeader *header, size_t part, size_t index, CauError *err) {
    const ExrPart *p = &header->parts[part];
    const char *full = p->channels[index].name, *dot = strrchr(full, '.');
    char *name = string_copy(dot ? full : (p->name ? p->name : ""));
    if (!name) return no_memory(err);
    if (dot) name[dot - full] = '\0';
    ExrLayer *layer = NULL;
    CAU_TRY(layer_for(list, part, name, !dot, &layer, err));
    layer->channel_count++;
    int colour = colour_index(dot ? dot + 1 : full, layer->name);
    /* "R" sorts before "r" and "red", so the first one found is the one to prefer. */
    if (colour >= 0 && colour < 3 && layer->rgb[colour] < 0) layer->rgb[colour] = (int)index;
    if (colour == 3 && layer->luma < 0) layer->luma = (int)index;
    return CAU_OK;
}

cau_result exr_layers_find(ExrLayers *out, const ExrHeader *header, CauError *err) {
    *out = (ExrLayers){0};
    for (size_t part = 0; part < header->part_count; part++)
        for (size_t c = 0; c < header->parts[part].channel_count; c++) {
            cau_result result = add_channel(out, header, part, c, err);
            if (result == CAU_OK) continue;
            exr_layers_free(out);
            return result;
        }
    return CAU_OK;
}

void exr_layers_free(ExrLayers *list) {
    for (size_t i = 0; i < list->count; i++) free(list->layers[i].name);
    free(list->layers);
    *list = (ExrLayers){0};
}
