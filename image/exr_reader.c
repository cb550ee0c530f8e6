/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_reader.h"

#include "bridge/exr_imf.h"
#include "core/checked.h"
#include "image/exr_attr_io.h"
#include "image/exr_core.h"
#include "image/exr_limits.h"

#include <string.h>

struct ExrReader {
    char *path;
    ExrHeader header;
    exr_context_t context;
    ExrCoreFile file;
    exr_decode_pipeline_t pipeline;
    size_t pipeline_part;
    bool pipeline_ready;
    ImfReader *imf; /**< for what OpenEXRCore 3.1 cannot decode; opened when needed */
};

static cau_result failed(ExrReader *r, exr_result_t code, CauError *err) {
    /* The library says so too when a damaged chunk leads its decoder to an absurd size; our own memory for
     * the pixels is there already. */
    if (code == EXR_ERR_OUT_OF_MEMORY)
        return error_set(err, CAU_ERROR_INPUT,
            "cannot read \"%s\": a chunk asks for more memory than there is: the file is damaged", r->path);
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
    imf_reader_close(&r->imf);
    if (r->pipeline_ready) exr_decoding_destroy(r->context, &r->pipeline);
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

static exr_result_t chunk_info(ExrReader *r, size_t part, int32_t x, int32_t y, exr_chunk_info_t *info) {
    const ExrPart *p = &r->header.parts[part];
    if (!p->tiled) return exr_read_scanline_chunk_info(r->context, (int)part, y, info);
    int tile_y = (int)(((int64_t)y - p->data_window.y0) / p->tile_height);
    return exr_read_tile_chunk_info(r->context, (int)part, x, tile_y, 0, 0, info);
}

static exr_result_t prepare(ExrReader *r, size_t part, const exr_chunk_info_t *info) {
    if (r->pipeline_ready && r->pipeline_part == part)
        return exr_decoding_update(r->context, (int)part, info, &r->pipeline);
    if (r->pipeline_ready) exr_decoding_destroy(r->context, &r->pipeline);
    r->pipeline = (exr_decode_pipeline_t)EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t code = exr_decoding_initialize(r->context, (int)part, info, &r->pipeline);
    r->pipeline_ready = code == EXR_ERR_SUCCESS;
    r->pipeline_part = part;
    return code;
}

/* Decodes the chunk at column of tiles x and row y, which must cover `width` x `height` pixels. */
static cau_result read_chunk(ExrReader *r, size_t part, int32_t x, int32_t y, int64_t width, int64_t height,
    size_t first, void *const *planes, CauError *err) {
    const ExrPart *p = &r->header.parts[part];
    size_t row = (size_t)exr_box_width(p->data_window);
    exr_chunk_info_t info;
    exr_result_t code = chunk_info(r, part, x, y, &info);
    if (code == EXR_ERR_SUCCESS && (info.width != width || info.height != height))
        return error_set(err, CAU_ERROR_INPUT,
            "\"%s\": the chunk at row %d is %d x %d pixels, not %d x %d: the file "
            "is damaged",
            r->path, y, info.width, info.height, (int)width, (int)height);
    if (code == EXR_ERR_SUCCESS) code = prepare(r, part, &info);
    if (code != EXR_ERR_SUCCESS) return failed(r, code, err);
    for (size_t c = 0; c < p->channel_count; c++) {
        exr_coding_channel_info_t *channel = &r->pipeline.channels[c];
        size_t bytes = exr_type_bytes(p->channels[c].type);
        channel->user_data_type = (uint16_t)p->channels[c].type;
        channel->user_bytes_per_element = (int16_t)bytes;
        channel->user_pixel_stride = (int32_t)bytes;
        channel->user_line_stride = (int32_t)(bytes * row);
        channel->decode_to_ptr = planes[c] ? (uint8_t *)planes[c] + first * bytes : NULL;
    }
    /* Anew for each chunk: the choice depends on which planes are asked for. */
    code = exr_decoding_choose_default_routines(r->context, (int)part, &r->pipeline);
    if (code == EXR_ERR_SUCCESS) code = exr_decoding_run(r->context, (int)part, &r->pipeline);
    return code == EXR_ERR_SUCCESS ? CAU_OK : failed(r, code, err);
}

/* OpenEXRCore 3.1 has no DWA, and its B44 decoder returns rubbish for a part that has float channels too. */
static bool core_can_decode(const ExrPart *part) { return part->codec < EXR_CODEC_B44; }

cau_result exr_reader_band(
    ExrReader *r, size_t part, int32_t y0, int32_t y1, void *const *planes, CauError *err) {
    const ExrPart *p = &r->header.parts[part];
    CAU_TRY(exr_reader_can_read(r, part, err));
    if (!core_can_decode(p)) {
        if (!r->imf) CAU_TRY(imf_reader_open(&r->imf, r->path, err));
        return imf_reader_band(r->imf, part, p, y0, y1, planes, err);
    }
    int64_t width = exr_box_width(p->data_window), step_x = p->tiled ? p->tile_width : width;
    int32_t step = (int32_t)p->tile_height;
    if (!p->tiled) {
        exr_result_t code = exr_get_scanlines_per_chunk(r->context, (int)part, &step);
        if (code != EXR_ERR_SUCCESS) return failed(r, code, err);
    }
    for (int64_t y = y0; y <= y1; y += step)
        for (int64_t x = 0; x * step_x < width; x++) {
            int64_t w = width - x * step_x < step_x ? width - x * step_x : step_x;
            int64_t h = y1 - y + 1 < step ? y1 - y + 1 : step;
            size_t first = (size_t)((y - y0) * width + x * step_x);
            CAU_TRY(read_chunk(r, part, (int32_t)x, (int32_t)y, w, h, first, planes, err));
        }
    return CAU_OK;
}
