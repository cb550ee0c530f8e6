/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_reader.h"

#include "core/checked.h"
#include "image/exr_attr_io.h"
#include "image/exr_limits.h"
#include "image/exr_reader_private.h"

#include <string.h>

static cau_result failed(ExrReader *r, exr_result_t code, CauError *err) {
    return exr_core_error(&r->file, code, "read", r->path, err);
}

static ExrBox box_from_core(const exr_attr_box2i_t *b) {
    return (ExrBox){b->min.x, b->min.y, b->max.x, b->max.y};
}

static cau_result add_channels(ExrPart *part, const exr_attr_chlist_t *list, CauError *err) {
    for (int i = 0; i < list->num_channels; i++) {
        const exr_attr_chlist_entry_t *from = &list->entries[i];
        CAU_TRY(exr_part_add_channel(part, from->name.str, (ExrPixelType)from->pixel_type, err));
        for (size_t c = 0; c < part->channel_count; c++) {
            ExrChannel *channel = &part->channels[c];
            if (strcmp(channel->name, from->name.str) != 0) continue;
            channel->p_linear = from->p_linear;
            channel->x_sampling = from->x_sampling;
            channel->y_sampling = from->y_sampling;
        }
    }
    return CAU_OK;
}

static void take_tiles(ExrPart *part, const exr_attr_tiledesc_t *tiles) {
    part->tile_width = tiles->x_size;
    part->tile_height = tiles->y_size;
    part->levels = (ExrLevels)EXR_GET_TILE_LEVEL_MODE(*tiles);
}

/* Fields of ExrPart; false when the attribute is not one of them and must be kept as it is. */
static bool take_field(ExrPart *part, const exr_attribute_t *a, CauError *err, cau_result *result) {
    static const char *const implied[] = {"type", "version", "chunkCount"};
    for (size_t i = 0; i < sizeof implied / sizeof *implied; i++)
        if (strcmp(a->name, implied[i]) == 0) return true; /* the writer makes them anew */
    if (strcmp(a->name, "name") == 0 && a->type == EXR_ATTR_STRING)
        *result = exr_part_set_name(part, a->string->str, err);
    else if (strcmp(a->name, "channels") == 0 && a->type == EXR_ATTR_CHLIST)
        *result = add_channels(part, a->chlist, err);
    else if (strcmp(a->name, "compression") == 0 && a->type == EXR_ATTR_COMPRESSION)
        part->codec = (ExrCodec)a->uc;
    else if (strcmp(a->name, "lineOrder") == 0 && a->type == EXR_ATTR_LINEORDER)
        part->order = (ExrOrder)a->uc;
    else if (strcmp(a->name, "dataWindow") == 0 && a->type == EXR_ATTR_BOX2I)
        part->data_window = box_from_core(a->box2i);
    else if (strcmp(a->name, "displayWindow") == 0 && a->type == EXR_ATTR_BOX2I)
        part->display_window = box_from_core(a->box2i);
    else if (strcmp(a->name, "pixelAspectRatio") == 0 && a->type == EXR_ATTR_FLOAT)
        part->pixel_aspect = a->f;
    else if (strcmp(a->name, "screenWindowCenter") == 0 && a->type == EXR_ATTR_V2F)
        memcpy(part->screen_center, a->v2f, sizeof part->screen_center);
    else if (strcmp(a->name, "screenWindowWidth") == 0 && a->type == EXR_ATTR_FLOAT)
        part->screen_width = a->f;
    else if (strcmp(a->name, "tiles") == 0 && a->type == EXR_ATTR_TILEDESC)
        take_tiles(part, a->tiledesc);
    else
        return false;
    return true;
}

static cau_result read_part_header(ExrReader *r, int index, CauError *err) {
    ExrPart *part = &r->header.parts[index];
    exr_storage_t storage = EXR_STORAGE_SCANLINE;
    int32_t count = 0;
    exr_result_t code = exr_get_storage(r->context, index, &storage);
    if (code == EXR_ERR_SUCCESS) code = exr_get_attribute_count(r->context, index, &count);
    if (code != EXR_ERR_SUCCESS) return failed(r, code, err);
    part->tiled = storage == EXR_STORAGE_TILED || storage == EXR_STORAGE_DEEP_TILED;
    part->deep = storage == EXR_STORAGE_DEEP_SCANLINE || storage == EXR_STORAGE_DEEP_TILED;
    for (int32_t i = 0; i < count; i++) {
        const exr_attribute_t *attr = NULL;
        cau_result result = CAU_OK;
        code = exr_get_attribute_by_index(r->context, index, EXR_ATTR_LIST_FILE_ORDER, i, &attr);
        if (code != EXR_ERR_SUCCESS) return failed(r, code, err);
        if (!take_field(part, attr, err, &result)) result = exr_attr_from_core(part, attr, err);
        if (result == CAU_OK) continue;
        error_prefix(err, "\"%s\": ", r->path);
        return result;
    }
    if ((unsigned)part->codec >= EXR_CODEC_COUNT)
        return error_set(err, CAU_ERROR_INPUT, "\"%s\": unknown compression %d", r->path, (int)part->codec);
    return CAU_OK;
}

static cau_result read_headers(ExrReader *r, CauError *err) {
    int parts = 0;
    exr_result_t code = exr_get_count(r->context, &parts);
    if (code != EXR_ERR_SUCCESS) return failed(r, code, err);
    if (parts < 1) return error_set(err, CAU_ERROR_INPUT, "\"%s\" has no parts", r->path);
    CAU_TRY(exr_header_create(&r->header, (size_t)parts, err));
    for (int i = 0; i < parts; i++) CAU_TRY(read_part_header(r, i, err));
    return exr_limits_check(&r->header, r->file.size, r->path, err);
}

cau_result exr_reader_open(ExrReader **out, const char *path, CauError *err) {
    *out = NULL;
    ExrReader *r = array_new(1, sizeof *r);
    if (!r) return error_set(err, CAU_ERROR_RESOURCE, "cannot open \"%s\": out of memory", path);
    r->file.fd = -1;
    r->path = string_copy(path);
    cau_result result = r->path
                            ? exr_core_open_read(&r->context, &r->file, path, err)
                            : error_set(err, CAU_ERROR_RESOURCE, "cannot open \"%s\": out of memory", path);
    if (result == CAU_OK) result = read_headers(r, err);
    if (result != CAU_OK)
        exr_reader_close(&r);
    else
        *out = r;
    return result;
}

void exr_reader_close(ExrReader **reader) {
    ExrReader *r = *reader;
    if (!r) return;
    exr_core_close(&r->context, &r->file, r->path, NULL);
    exr_header_free(&r->header);
    free(r->path);
    free(r);
    *reader = NULL;
}

const ExrHeader *exr_reader_header(const ExrReader *reader) { return &reader->header; }
const char *exr_reader_path(const ExrReader *reader) { return reader->path; }

cau_result exr_reader_can_read(const ExrReader *r, size_t index, CauError *err) {
    const ExrPart *part = &r->header.parts[index];
    if (part->deep)
        return error_set(err, CAU_ERROR_INPUT,
            "\"%s\": part %zu is deep, which is not handled: flatten it first", r->path, index);
    for (size_t c = 0; c < part->channel_count; c++)
        if (part->channels[c].x_sampling != 1 || part->channels[c].y_sampling != 1)
            return error_set(err, CAU_ERROR_INPUT,
                "\"%s\": channel \"%s\" is sub-sampled (%d x %d), which is not handled: save the picture as "
                "R,G,B",
                r->path, part->channels[c].name, part->channels[c].x_sampling, part->channels[c].y_sampling);
    return CAU_OK;
}
