/* SPDX-License-Identifier: Apache-2.0 */
#include "core/checked.h"
#include "image/exr_writer_private.h"
#include "image/exr_zip.h"

#include <string.h>

struct ExrEncoder {
    const ExrWriter *writer;
    ExrZip *zip;
    uint8_t *tile; /* one tile's pixels in the layout of the file */
    size_t tile_capacity;
    exr_encode_pipeline_t pipeline; /* for the codecs that are OpenEXRCore's */
    size_t pipeline_part;
    bool pipeline_ready;
};

cau_result exr_encoder_create(ExrEncoder **out, const ExrWriter *writer, CauError *err) {
    ExrEncoder *e = *out = array_new(1, sizeof *e);
    if (e) e->zip = exr_zip_create();
    if (e && e->zip) {
        e->writer = writer;
        return CAU_OK;
    }
    free(e);
    *out = NULL;
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for writing \"%s\"", writer->shown);
}

void exr_encoder_free(ExrEncoder **encoder) {
    ExrEncoder *e = *encoder;
    if (!e) return;
    if (e->pipeline_ready) exr_encoding_destroy(e->writer->context, &e->pipeline);
    exr_zip_free(e->zip);
    free(e->tile);
    free(e);
    *encoder = NULL;
}

static cau_result no_memory(const ExrEncoder *e, CauError *err) {
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for writing \"%s\"", e->writer->shown);
}

static cau_result failed(const ExrEncoder *e, exr_result_t code, CauError *err) {
    return exr_core_error((ExrCoreFile *)&e->writer->file, code, "write", e->writer->shown, err);
}

/* The pipeline ends here: who puts the chunk into the file does so in order. */
static exr_result_t write_nothing(exr_encode_pipeline_t *pipeline) {
    (void)pipeline;
    return EXR_ERR_SUCCESS;
}

/* What is being packed, for the pipeline. */
typedef struct Pixels {
    const uint8_t *bytes;
    size_t count;
} Pixels;

/* The pixels are in the layout of the file already. */
static exr_result_t take_pixels(exr_encode_pipeline_t *pipeline) {
    const Pixels *pixels = pipeline->encoding_user_data;
    if (pipeline->packed_alloc_size < pixels->count) return EXR_ERR_INVALID_ARGUMENT;
    memcpy(pipeline->packed_buffer, pixels->bytes, pixels->count);
    pipeline->packed_bytes = pixels->count;
    return EXR_ERR_SUCCESS;
}

static exr_result_t prepare(ExrEncoder *e, size_t part, const exr_chunk_info_t *info) {
    exr_const_context_t context = e->writer->context;
    if (e->pipeline_ready && e->pipeline_part == part)
        return exr_encoding_update(context, (int)part, info, &e->pipeline);
    if (e->pipeline_ready) exr_encoding_destroy(context, &e->pipeline);
    e->pipeline = (exr_encode_pipeline_t)EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t code = exr_encoding_initialize(context, (int)part, info, &e->pipeline);
    e->pipeline_ready = code == EXR_ERR_SUCCESS;
    e->pipeline_part = part;
    /* The library chooses its routines only when every channel seems to come from somewhere. */
    for (int16_t c = 0; code == EXR_ERR_SUCCESS && c < e->pipeline.channel_count; c++) {
        exr_coding_channel_info_t *channel = &e->pipeline.channels[c];
        channel->user_data_type = channel->data_type;
        channel->user_bytes_per_element = (int16_t)channel->bytes_per_element;
        channel->user_pixel_stride = channel->bytes_per_element;
        channel->user_line_stride = channel->bytes_per_element * channel->width;
        channel->encode_from_ptr = (const uint8_t *)e;
    }
    if (code == EXR_ERR_SUCCESS)
        code = exr_encoding_choose_default_routines(context, (int)part, &e->pipeline);
    e->pipeline.convert_and_pack_fn = take_pixels;
    e->pipeline.yield_until_ready_fn = write_nothing;
    e->pipeline.write_fn = write_nothing;
    return code;
}

/* RLE, PIZ, PXR24. */
static cau_result pack_there(ExrEncoder *e, size_t part, int column, int32_t y, const uint8_t *pixels,
    size_t count, ExrPacked *packed, CauError *err) {
    const ExrPart *p = &e->writer->header->parts[part];
    exr_context_t context = e->writer->context;
    exr_chunk_info_t info;
    exr_result_t code = p->tiled ? exr_write_tile_chunk_info(context, (int)part, column,
                                       (int)((y - (int64_t)p->data_window.y0) / p->tile_height), 0, 0, &info)
                                 : exr_write_scanline_chunk_info(context, (int)part, y, &info);
    if (code == EXR_ERR_SUCCESS) code = prepare(e, part, &info);
    if (code != EXR_ERR_SUCCESS) return failed(e, code, err);
    Pixels source = {pixels, count};
    e->pipeline.encoding_user_data = &source;
    code = exr_encoding_run(context, (int)part, &e->pipeline);
    e->pipeline.encoding_user_data = NULL;
    if (code != EXR_ERR_SUCCESS) return failed(e, code, err);
    bool shrunk = e->pipeline.compressed_buffer && e->pipeline.compressed_bytes < count;
    memcpy(packed->bytes + packed->size, shrunk ? e->pipeline.compressed_buffer : pixels,
        shrunk ? e->pipeline.compressed_bytes : count);
    return exr_packed_end(packed, shrunk ? e->pipeline.compressed_bytes : count, err);
}

static cau_result pack_chunk(ExrEncoder *e, size_t part, int column, int32_t y, const uint8_t *pixels,
    size_t count, ExrPacked *packed, CauError *err) {
    ExrCodec codec = e->writer->header->parts[part].codec;
    CAU_TRY(exr_packed_reserve(packed, count, err));
    uint8_t *to = packed->bytes + packed->size;
    if (codec == EXR_CODEC_NONE) {
        memcpy(to, pixels, count);
        return exr_packed_end(packed, count, err);
    }
    if (codec != EXR_CODEC_ZIP && codec != EXR_CODEC_ZIPS)
        return pack_there(e, part, column, y, pixels, count, packed, err);
    size_t size = exr_zip_pack(e->zip, pixels, count, to);
    return size ? exr_packed_end(packed, size, err) : no_memory(e, err);
}

/* The tile's pixels out of the rows of the whole part; their number of bytes. */
static size_t gather(
    ExrEncoder *e, const ExrPart *p, const ExrRows *rows, int column, int64_t y0, int64_t y1) {
    size_t width = (size_t)exr_box_width(p->data_window), x = (size_t)column * p->tile_width, done = 0;
    size_t count = width - x < p->tile_width ? width - x : p->tile_width;
    for (int64_t y = y0; y <= y1; y++) {
        size_t before = 0;
        for (size_t c = 0; c < p->channel_count; c++) {
            size_t bytes = exr_type_bytes(p->channels[c].type);
            memcpy(e->tile + done, exr_rows_at(rows, y, before * width + x * bytes), count * bytes);
            done += count * bytes;
            before += bytes;
        }
    }
    return done;
}

static cau_result pack_tiles(ExrEncoder *e, size_t part, const ExrRows *rows, int64_t y0, int64_t y1,
    ExrPacked *packed, CauError *err) {
    const ExrPart *p = &e->writer->header->parts[part];
    size_t need = (size_t)p->tile_width * (size_t)(y1 - y0 + 1) * exr_part_pixel_bytes(p);
    if (need > e->tile_capacity) {
        free(e->tile);
        e->tile = malloc(need);
        e->tile_capacity = e->tile ? need : 0;
        if (!e->tile) return no_memory(e, err);
    }
    for (int column = 0; column < exr_chunk_columns(p); column++) {
        size_t count = gather(e, p, rows, column, y0, y1);
        CAU_TRY(pack_chunk(e, part, column, (int32_t)y0, e->tile, count, packed, err));
    }
    return CAU_OK;
}

cau_result exr_encoder_pack(
    ExrEncoder *e, size_t part, const ExrRows *rows, ExrPacked *packed, CauError *err) {
    const ExrPart *p = &e->writer->header->parts[part];
    int step = exr_chunk_rows(p);
    exr_packed_clear(packed);
    for (int64_t y = rows->y0; y <= rows->y1; y += step) {
        int64_t last = y + step - 1 < rows->y1 ? y + step - 1 : rows->y1;
        if (p->tiled)
            CAU_TRY(pack_tiles(e, part, rows, y, last, packed, err));
        else
            CAU_TRY(pack_chunk(e, part, 0, (int32_t)y, exr_rows_at(rows, y, 0),
                rows->row_bytes * (size_t)(last - y + 1), packed, err));
    }
    return CAU_OK;
}
