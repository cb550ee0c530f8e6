/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_header.h"

#include "core/checked.h"

#include <string.h>
#include <strings.h>

static const char *const codec_names[EXR_CODEC_COUNT] = {
    "none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"};

const char *exr_codec_name(ExrCodec codec) {
    return (unsigned)codec < EXR_CODEC_COUNT ? codec_names[codec] : NULL;
}

bool exr_codec_from_name(const char *name, ExrCodec *out) {
    for (int i = 0; i < EXR_CODEC_COUNT; i++)
        if (strcasecmp(name, codec_names[i]) == 0) {
            *out = (ExrCodec)i;
            return true;
        }
    return false;
}

bool exr_codec_is_lossy(ExrCodec codec) { return codec >= EXR_CODEC_PXR24; }

static cau_result no_memory(CauError *err) {
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for an EXR header");
}

cau_result exr_header_create(ExrHeader *out, size_t count, CauError *err) {
    *out = (ExrHeader){.parts = array_new(count, sizeof *out->parts)};
    if (!out->parts) return no_memory(err);
    out->part_count = count;
    for (size_t i = 0; i < count; i++) {
        out->parts[i].codec = EXR_CODEC_ZIP;
        out->parts[i].pixel_aspect = 1;
        out->parts[i].screen_width = 1;
    }
    return CAU_OK;
}

static cau_result copy_part(ExrPart *to, const ExrPart *from, CauError *err) {
    *to = *from;
    to->name = NULL;
    to->channels = NULL;
    to->attrs = NULL;
    to->channel_count = to->channel_capacity = to->attr_count = to->attr_capacity = 0;
    if (from->name) CAU_TRY(exr_part_set_name(to, from->name, err));
    for (size_t c = 0; c < from->channel_count; c++) {
        const ExrChannel *channel = &from->channels[c];
        CAU_TRY(exr_part_add_channel(to, channel->name, channel->type, err));
        ExrChannel *copy = &to->channels[to->channel_count - 1]; /* sorted input: it lands last */
        copy->p_linear = channel->p_linear;
        copy->x_sampling = channel->x_sampling;
        copy->y_sampling = channel->y_sampling;
    }
    for (size_t a = 0; a < from->attr_count; a++) {
        const ExrAttr *attr = &from->attrs[a];
        CAU_TRY(exr_attr_set(to, attr->name, attr->type, attr->data, attr->size, err));
    }
    return CAU_OK;
}

cau_result exr_header_copy(ExrHeader *out, const ExrHeader *from, CauError *err) {
    CAU_TRY(exr_header_create(out, from->part_count, err));
    for (size_t i = 0; i < from->part_count; i++) {
        cau_result result = copy_part(&out->parts[i], &from->parts[i], err);
        if (result != CAU_OK) {
            exr_header_free(out);
            return result;
        }
    }
    return CAU_OK;
}

static void free_attr(ExrAttr *attr) {
    free(attr->name);
    free(attr->type);
    free(attr->data);
}

void exr_header_free(ExrHeader *header) {
    for (size_t i = 0; i < header->part_count; i++) {
        ExrPart *part = &header->parts[i];
        for (size_t c = 0; c < part->channel_count; c++) free(part->channels[c].name);
        for (size_t a = 0; a < part->attr_count; a++) free_attr(&part->attrs[a]);
        free(part->channels);
        free(part->attrs);
        free(part->name);
    }
    free(header->parts);
    *header = (ExrHeader){0};
}

cau_result exr_part_set_name(ExrPart *part, const char *name, CauError *err) {
    char *copy = string_copy(name);
    if (!copy) return no_memory(err);
    free(part->name);
    part->name = copy;
    return CAU_OK;
}

cau_result exr_part_add_channel(ExrPart *part, const char *name, ExrPixelType type, CauError *err) {
    size_t at = part->channel_count;
    while (at > 0 && strcmp(name, part->channels[at - 1].name) < 0) at--;
    if (at > 0 && strcmp(name, part->channels[at - 1].name) == 0)
        return error_set(err, CAU_ERROR_INPUT, "channel \"%s\" is named twice in one part", name);
    void *array = part->channels;
    if (!array_reserve(&array, &part->channel_capacity, part->channel_count + 1, sizeof *part->channels))
        return no_memory(err);
    part->channels = array;
    char *copy = string_copy(name);
    if (!copy) return no_memory(err);
    memmove(
        &part->channels[at + 1], &part->channels[at], (part->channel_count - at) * sizeof *part->channels);
    part->channels[at] = (ExrChannel){.name = copy, .type = type, .x_sampling = 1, .y_sampling = 1};
    part->channel_count++;
    return CAU_OK;
}

int exr_chunk_rows(const ExrPart *part) {
    static const int rows_of[EXR_CODEC_COUNT] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
    return part->tiled ? (int)part->tile_height : rows_of[part->codec];
}

int exr_chunk_columns(const ExrPart *part) {
    return part->tiled ? (int)((exr_box_width(part->data_window) + part->tile_width - 1) / part->tile_width)
                       : 1;
}

/* Small bands keep memory low, fit the cache and let a cancel be answered soon. */
int exr_band_rows(const ExrPart *part) {
    enum { LEAST = 16 };
    int64_t chunk = exr_chunk_rows(part), rows = (LEAST + chunk - 1) / chunk * chunk;
    int64_t height = exr_box_height(part->data_window);
    return (int)(part->tiled && rows > height ? height : rows);
}

ExrBands exr_bands(const ExrPart *part, int rows) {
    int64_t height = exr_box_height(part->data_window);
    return (ExrBands){.rows = rows, .count = (size_t)((height + rows - 1) / rows), .part = part};
}

void exr_band_at(const ExrBands *bands, size_t index, int32_t *y0, int32_t *y1) {
    const ExrPart *part = bands->part;
    size_t band = part->order == EXR_ORDER_DECREASING ? bands->count - 1 - index : index;
    int64_t first = part->data_window.y0 + (int64_t)band * bands->rows, last = first + bands->rows - 1;
    *y0 = (int32_t)first;
    *y1 = last < part->data_window.y1 ? (int32_t)last : part->data_window.y1;
}

size_t exr_part_pixel_bytes(const ExrPart *part) {
    size_t bytes = 0;
    for (size_t c = 0; c < part->channel_count; c++) bytes += exr_type_bytes(part->channels[c].type);
    return bytes;
}

const ExrAttr *exr_attr_find(const ExrPart *part, const char *name) {
    for (size_t a = 0; a < part->attr_count; a++)
        if (strcmp(part->attrs[a].name, name) == 0) return &part->attrs[a];
    return NULL;
}

const ExrAttr *exr_attr_find_any_case(const ExrPart *part, const char *name) {
    const ExrAttr *exact = exr_attr_find(part, name);
    for (size_t a = 0; !exact && a < part->attr_count; a++)
        if (strcasecmp(part->attrs[a].name, name) == 0) return &part->attrs[a];
    return exact;
}

cau_result exr_attr_set(
    ExrPart *part, const char *name, const char *type, const void *data, size_t size, CauError *err) {
    ExrAttr attr = {string_copy(name), string_copy(type), malloc(size ? size : 1), size};
    void *array = part->attrs;
    bool fits = array_reserve(&array, &part->attr_capacity, part->attr_count + 1, sizeof attr);
    part->attrs = array;
    if (!attr.name || !attr.type || !attr.data || !fits) {
        free_attr(&attr);
        return no_memory(err);
    }
    if (size) memcpy(attr.data, data, size);
    for (size_t a = 0; a < part->attr_count; a++)
        if (strcmp(part->attrs[a].name, name) == 0) {
            free_attr(&part->attrs[a]);
            part->attrs[a] = attr;
            return CAU_OK;
        }
    part->attrs[part->attr_count++] = attr;
    return CAU_OK;
}

cau_result exr_attr_set_text(ExrPart *part, const char *name, const char *text, CauError *err) {
    return exr_attr_set(part, name, "string", text, strlen(text), err);
}

cau_result exr_attr_set_int32(ExrPart *part, const char *name, int32_t value, CauError *err) {
    return exr_attr_set(part, name, "int", &value, sizeof value, err);
}

cau_result exr_attr_set_float32(ExrPart *part, const char *name, float value, CauError *err) {
    return exr_attr_set(part, name, "float", &value, sizeof value, err);
}

void exr_attr_remove(ExrPart *part, const char *name) {
    for (size_t a = 0; a < part->attr_count; a++)
        if (strcmp(part->attrs[a].name, name) == 0) {
            free_attr(&part->attrs[a]);
            part->attr_count--;
            memmove(&part->attrs[a], &part->attrs[a + 1], (part->attr_count - a) * sizeof *part->attrs);
            return;
        }
}

char *exr_attr_text(const ExrAttr *attr) {
    if (!attr || strcmp(attr->type, "string") != 0) return NULL;
    char *text = malloc(attr->size + 1);
    if (!text) return NULL;
    memcpy(text, attr->data, attr->size);
    text[attr->size] = '\0';
    return text;
}

bool exr_attr_int32(const ExrAttr *attr, int32_t *out) {
    if (!attr || strcmp(attr->type, "int") != 0 || attr->size != sizeof *out) return false;
    memcpy(out, attr->data, sizeof *out);
    return true;
}
