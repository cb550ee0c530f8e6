/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_writer.h"

#include "bridge/exr_imf.h"
#include "core/checked.h"
#include "image/exr_attr_io.h"
#include "image/exr_core.h"
#include "image/exr_zip.h"

#include <limits.h>
#include <string.h>

struct ExrWriter {
    const ExrHeader *header;
    char *shown;
    exr_context_t context;
    ExrCoreFile file;
    exr_encode_pipeline_t pipeline;
    size_t pipeline_part; /**< the part the pipeline was set up for */
    bool pipeline_ready;
    ImfWriter *imf; /**< writes instead of all the above when the core cannot */
};

static cau_result failed(ExrWriter *w, exr_result_t code, CauError *err) {
    return exr_core_error(&w->file, code, "write", w->shown, err);
}

static bool needs_long_names(const ExrHeader *header) {
    for (size_t i = 0; i < header->part_count; i++) {
        const ExrPart *part = &header->parts[i];
        for (size_t c = 0; c < part->channel_count; c++)
            if (strlen(part->channels[c].name) > 31) return true;
        for (size_t a = 0; a < part->attr_count; a++)
            if (strlen(part->attrs[a].name) > 31 || strlen(part->attrs[a].type) > 31) return true;
    }
    return false;
}

static exr_result_t define_channels(ExrWriter *w, int index, const ExrPart *part) {
    for (size_t c = 0; c < part->channel_count; c++) {
        const ExrChannel *channel = &part->channels[c];
        exr_result_t code = exr_add_channel(w->context, index, channel->name, (exr_pixel_type_t)channel->type,
            channel->p_linear ? EXR_PERCEPTUALLY_LINEAR : EXR_PERCEPTUALLY_LOGARITHMIC, channel->x_sampling,
            channel->y_sampling);
        if (code != EXR_ERR_SUCCESS) return code;
    }
    return EXR_ERR_SUCCESS;
}

static exr_attr_box2i_t core_box(ExrBox b) {
    exr_attr_box2i_t box;
    box.min.x = b.x0;
    box.min.y = b.y0;
    box.max.x = b.x1;
    box.max.y = b.y1;
    return box;
}

static cau_result define_part(ExrWriter *w, const ExrPart *part, CauError *err) {
    int index = 0;
    exr_attr_box2i_t data = core_box(part->data_window), display = core_box(part->display_window);
    exr_attr_v2f_t center;
    center.x = part->screen_center[0];
    center.y = part->screen_center[1];
    exr_result_t code =
        exr_add_part(w->context, part->name, part->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &index);
    if (code == EXR_ERR_SUCCESS)
        code = exr_initialize_required_attr(w->context, index, &display, &data, part->pixel_aspect, &center,
            part->screen_width, (exr_lineorder_t)part->order, (exr_compression_t)part->codec);
    if (code == EXR_ERR_SUCCESS && part->tiled)
        code = exr_set_tile_descriptor(
            w->context, index, part->tile_width, part->tile_height, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN);
    if (code == EXR_ERR_SUCCESS) code = define_channels(w, index, part);
    if (code != EXR_ERR_SUCCESS) return failed(w, code, err);
    for (size_t a = 0; a < part->attr_count; a++) {
        code = exr_attr_to_core(w->context, index, &part->attrs[a]);
        if (code == EXR_ERR_SUCCESS) continue;
        failed(w, code, err);
        error_prefix(err, "attribute \"%s\" of type \"%s\": ", part->attrs[a].name, part->attrs[a].type);
        return code == EXR_ERR_OUT_OF_MEMORY ? CAU_ERROR_RESOURCE : CAU_ERROR_INPUT;
    }
    return CAU_OK;
}

static cau_result define(ExrWriter *w, CauError *err) {
    if (needs_long_names(w->header)) exr_set_longname_support(w->context, 1);
    for (size_t i = 0; i < w->header->part_count; i++) CAU_TRY(define_part(w, &w->header->parts[i], err));
    exr_result_t code = exr_write_header(w->context);
    return code == EXR_ERR_SUCCESS ? CAU_OK : failed(w, code, err);
}

/* OpenEXRCore 3.1 has neither B44 nor DWA encoders and writes rows from the top only. */
static bool core_can_write(const ExrHeader *header) {
    for (size_t i = 0; i < header->part_count; i++)
        if (header->parts[i].codec >= EXR_CODEC_B44 || header->parts[i].order == EXR_ORDER_DECREASING)
            return false;
    return true;
}

static cau_result open_file(ExrWriter *w, const char *path, const char *shown, CauError *err) {
    w->shown = string_copy(shown);
    if (!w->shown) return error_set(err, CAU_ERROR_RESOURCE, "cannot write \"%s\": out of memory", shown);
    if (!core_can_write(w->header)) return imf_writer_open(&w->imf, path, shown, w->header, err);
    CAU_TRY(exr_core_open_write(&w->context, &w->file, path, err));
    return define(w, err);
}

cau_result exr_writer_open(
    ExrWriter **out, const char *path, const char *shown, const ExrHeader *header, CauError *err) {
    *out = NULL;
    ExrWriter *w = array_new(1, sizeof *w);
    if (!w) return error_set(err, CAU_ERROR_RESOURCE, "cannot write \"%s\": out of memory", shown);
    w->header = header;
    w->file.fd = -1;
    cau_result result = open_file(w, path, shown, err);
    if (result != CAU_OK)
        exr_writer_abort(&w);
    else
        *out = w;
    return result;
}

static exr_result_t chunk_info(ExrWriter *w, size_t part, int32_t x, int32_t y, exr_chunk_info_t *info) {
    const ExrPart *p = &w->header->parts[part];
    if (!p->tiled) return exr_write_scanline_chunk_info(w->context, (int)part, y, info);
    int tile_y = (int)((y - (int64_t)p->data_window.y0) / p->tile_height);
    return exr_write_tile_chunk_info(w->context, (int)part, x, tile_y, 0, 0, info);
}

/* Encodes the chunk whose first row is y; x counts tiles. */
static cau_result write_chunk(ExrWriter *w, size_t part, int32_t x, int32_t y, int32_t band_y0,
    const void *const *planes, CauError *err) {
    const ExrPart *p = &w->header->parts[part];
    exr_chunk_info_t info;
    exr_result_t code = chunk_info(w, part, x, y, &info);
    if (code != EXR_ERR_SUCCESS) return failed(w, code, err);
    bool fresh = !w->pipeline_ready || w->pipeline_part != part;
    if (fresh) {
        if (w->pipeline_ready) exr_encoding_destroy(w->context, &w->pipeline);
        w->pipeline = (exr_encode_pipeline_t)EXR_ENCODE_PIPELINE_INITIALIZER;
        code = exr_encoding_initialize(w->context, (int)part, &info, &w->pipeline);
        w->pipeline_ready = code == EXR_ERR_SUCCESS;
        w->pipeline_part = part;
    } else {
        code = exr_encoding_update(w->context, (int)part, &info, &w->pipeline);
    }
    if (code != EXR_ERR_SUCCESS) return failed(w, code, err);
    size_t width = (size_t)exr_box_width(p->data_window), row = (size_t)((int64_t)y - band_y0);
    size_t first = row * width + (p->tiled ? (size_t)x * p->tile_width : 0);
    for (size_t c = 0; c < p->channel_count; c++) {
        exr_coding_channel_info_t *channel = &w->pipeline.channels[c];
        size_t bytes = exr_type_bytes(p->channels[c].type);
        channel->user_data_type = (uint16_t)p->channels[c].type;
        channel->user_bytes_per_element = (int16_t)bytes;
        channel->user_pixel_stride = (int32_t)bytes;
        channel->user_line_stride = (int32_t)(bytes * width);
        channel->encode_from_ptr = (const uint8_t *)planes[c] + first * bytes;
    }
    if (fresh) {
        code = exr_encoding_choose_default_routines(w->context, (int)part, &w->pipeline);
        bool zip = (exr_compression_t)p->codec == EXR_COMPRESSION_ZIP ||
                   (exr_compression_t)p->codec == EXR_COMPRESSION_ZIPS;
        if (zip) w->pipeline.compress_fn = exr_zip_compress;
    }
    if (code == EXR_ERR_SUCCESS) code = exr_encoding_run(w->context, (int)part, &w->pipeline);
    return code == EXR_ERR_SUCCESS ? CAU_OK : failed(w, code, err);
}

cau_result exr_writer_band(
    ExrWriter *w, size_t part, int32_t y0, int32_t y1, const void *const *planes, CauError *err) {
    const ExrPart *p = &w->header->parts[part];
    if (w->imf) return imf_writer_band(w->imf, part, y0, y1, planes, err);
    int32_t step = (int32_t)p->tile_height, tiles = 1;
    if (p->tiled)
        tiles = (int32_t)((exr_box_width(p->data_window) + p->tile_width - 1) / p->tile_width);
    else if (exr_get_scanlines_per_chunk(w->context, (int)part, &step) != EXR_ERR_SUCCESS)
        return error_set(err, CAU_ERROR_INTERNAL, "cannot write \"%s\": the part has no rows", w->shown);
    for (int64_t y = y0; y <= y1; y += step)
        for (int32_t x = 0; x < tiles; x++) CAU_TRY(write_chunk(w, part, x, (int32_t)y, y0, planes, err));
    return CAU_OK;
}

static void destroy(ExrWriter **writer) {
    free((*writer)->shown);
    free(*writer);
    *writer = NULL;
}

cau_result exr_writer_close(ExrWriter **writer, CauError *err) {
    ExrWriter *w = *writer;
    if (w->pipeline_ready) exr_encoding_destroy(w->context, &w->pipeline);
    cau_result result =
        w->imf ? imf_writer_close(&w->imf, err) : exr_core_close(&w->context, &w->file, w->shown, err);
    destroy(writer);
    return result;
}

void exr_writer_abort(ExrWriter **writer) {
    if (!*writer) return;
    exr_writer_close(writer, NULL);
}
