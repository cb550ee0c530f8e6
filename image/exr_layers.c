/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_layers.h"

#include "core/checked.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

const char *exr_layer_shown(const ExrLayer *layer) { return layer->full[0] ? layer->full : "R,G,B"; }

bool exr_layer_same_view(const ExrLayer *a, const ExrLayer *b) {
    return a->view && b->view ? strcmp(a->view, b->view) == 0 : !a->view && !b->view;
}

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

/* The view at `index` of those that the part lists; NULL beyond the last. *length without a zero. */
static const char *listed_view(const ExrPart *part, size_t index, size_t *length) {
    const ExrAttr *attr = exr_attr_find(part, "multiView");
    const char *bytes = attr ? attr->data : NULL;
    size_t at = 0;
    while (attr && strcmp(attr->type, "stringvector") == 0 && at + 4 <= attr->size) {
        uint32_t bytes_of;
        memcpy(&bytes_of, bytes + at, sizeof bytes_of);
        at += sizeof bytes_of;
        if (bytes_of > attr->size - at) return NULL;
        *length = bytes_of;
        if (index-- == 0) return bytes + at;
        at += bytes_of;
    }
    return NULL;
}

/* The view of a layer whose part holds several; *at_end: it is the name's last word. */
static char *view_of_several(const ExrLayer *layer, const ExrPart *part, bool *at_end) {
    const char *view, *dot = strrchr(layer->name, '.'), *word = dot ? dot + 1 : layer->name;
    size_t length;
    *at_end = false;
    if (layer->bare) {
        view = listed_view(part, 0, &length);
        return view ? strndup(view, length) : NULL;
    }
    for (size_t i = 0; (view = listed_view(part, i, &length)); i++)
        if (strlen(word) == length && memcmp(view, word, length) == 0) {
            *at_end = true;
            return string_copy(word);
        }
    return NULL;
}

static cau_result split_name(ExrLayer *layer, const ExrPart *part, CauError *err) {
    bool at_end = false;
    layer->view = exr_attr_text(exr_attr_find(part, "view"));
    if (!layer->view) layer->view = view_of_several(layer, part, &at_end);
    layer->pass = string_copy(layer->name);
    if (!layer->pass) return no_memory(err);
    char *dot = strrchr(layer->pass, '.');
    if (at_end) *(dot ? dot : layer->pass) = '\0';
    dot = strrchr(layer->pass, '.');
    layer->pass_at = dot ? (size_t)(dot + 1 - layer->pass) : 0;
    memmove(layer->pass, layer->pass + layer->pass_at, strlen(layer->pass + layer->pass_at) + 1);
    size_t room = strlen(layer->name) + (layer->view ? strlen(layer->view) : 0) + 2;
    layer->full = array_new(room, 1);
    if (!layer->full) return no_memory(err);
    bool added = layer->view && !at_end && !(layer->bare && layer->name[0]); /* names of parts differ */
    snprintf(layer->full, room, "%s%s%s", layer->name, added && layer->name[0] ? "." : "",
        added ? layer->view : "");
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
    for (size_t i = 0; i < out->count; i++) {
        cau_result result = split_name(&out->layers[i], &header->parts[out->layers[i].part], err);
        if (result == CAU_OK) continue;
        exr_layers_free(out);
        return result;
    }
    return CAU_OK;
}

void exr_layers_free(ExrLayers *list) {
    for (size_t i = 0; i < list->count; i++) {
        free(list->layers[i].name);
        free(list->layers[i].full);
        free(list->layers[i].view);
        free(list->layers[i].pass);
    }
    free(list->layers);
    *list = (ExrLayers){0};
}
