/* SPDX-License-Identifier: Apache-2.0 */
#include "bridge/exr_imf.h"
#include "core/checked.h"
#include "image/exr_reader_private.h"
#include "image/exr_scan.h"
#include "image/exr_zip.h"

#include <string.h>

struct ExrDecoder {
    const ExrReader *reader;
    ExrZip *zip;
    uint8_t *packed; /* one chunk as in the file */
    size_t packed_capacity;
    uint8_t *chunk; /* one chunk unpacked that is a tile, or only partly wanted */
    size_t chunk_capacity;
    exr_decode_pipeline_t pipeline; /* for the codecs that are OpenEXRCore's */
    size_t pipeline_part;
    bool pipeline_ready;
    ImfReader *imf; /* for what OpenEXRCore 3.1 cannot decode; opened when needed */
};

/* The pixels that one chunk covers. */
typedef struct Chunk {
    int32_t column, y; /* of tiles, and the first row */
    int64_t x, width, height;
    size_t row_bytes;
} Chunk;

static cau_result failed(const ExrDecoder *d, exr_result_t code, CauError *err) {
    /* The library says so too when a damaged chunk leads its decoder to an absurd size. */
    if (code == EXR_ERR_OUT_OF_MEMORY)
        return error_set(err, CAU_ERROR_INPUT,
            "cannot read \"%s\": a chunk asks for more memory than there is: the file is damaged",
            d->reader->path);
    /* The record of the library's last message is the only thing of the reader that is written. */
    return exr_core_error((ExrCoreFile *)&d->reader->file, code, "read", d->reader->path, err);
}

static cau_result no_memory(const ExrDecoder *d, CauError *err) {
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for reading \"%s\"", d->reader->path);
}

cau_result exr_decoder_create(ExrDecoder **out, const ExrReader *reader, CauError *err) {
    ExrDecoder *d = *out = array_new(1, sizeof *d);
    if (d) d->zip = exr_zip_create();
    if (d && d->zip) {
        d->reader = reader;
        return CAU_OK;
    }
    free(d);
    *out = NULL;
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for reading \"%s\"", reader->path);
}

void exr_decoder_free(ExrDecoder **decoder) {
    ExrDecoder *d = *decoder;
    if (!d) return;
    imf_reader_close(&d->imf);
    if (d->pipeline_ready) exr_decoding_destroy(d->reader->context, &d->pipeline);
    exr_zip_free(d->zip);
    free(d->packed);
    free(d->chunk);
    free(d);
    *decoder = NULL;
}

static Chunk chunk_at(const ExrPart *p, int32_t column, int32_t y) {
    int64_t width = exr_box_width(p->data_window), left = (int64_t)p->data_window.y1 - y + 1;
    Chunk chunk = {.column = column, .y = y, .width = width, .height = exr_chunk_rows(p)};
    if (p->tiled) {
        chunk.x = (int64_t)column * p->tile_width;
        chunk.width = width - chunk.x < p->tile_width ? width - chunk.x : p->tile_width;
    }
    if (chunk.height > left) chunk.height = left;
    chunk.row_bytes = (size_t)chunk.width * exr_part_pixel_bytes(p);
    return chunk;
}

static cau_result find_chunk(
    const ExrDecoder *d, size_t part, const Chunk *chunk, exr_chunk_info_t *info, CauError *err) {
    const ExrReader *r = d->reader;
    const ExrPart *p = &r->header.parts[part];
    exr_result_t code;
    if (p->tiled) {
        int row = (int)(((int64_t)chunk->y - p->data_window.y0) / p->tile_height);
        code = exr_read_tile_chunk_info(r->context, (int)part, chunk->column, row, 0, 0, info);
    } else {
        code = exr_read_scanline_chunk_info(r->context, (int)part, chunk->y, info);
    }
    if (code != EXR_ERR_SUCCESS) return failed(d, code, err);
    if (info->width == chunk->width && info->height == chunk->height &&
        info->unpacked_size == chunk->row_bytes * (uint64_t)chunk->height &&
        info->packed_size <= (uint64_t)r->file.size)
        return CAU_OK;
    return error_set(err, CAU_ERROR_INPUT,
        "\"%s\": the chunk at row %d is %d x %d pixels in %llu bytes, not %d x %d: the file is damaged",
        r->path, chunk->y, info->width, info->height, (unsigned long long)info->packed_size,
        (int)chunk->width, (int)chunk->height);
}

static bool reserve(uint8_t **buffer, size_t *capacity, size_t bytes) {
    if (bytes <= *capacity) return true;
    free(*buffer);
    *capacity = 0;
    *buffer = malloc(bytes);
    if (*buffer) *capacity = bytes;
    return *buffer != NULL;
}

static cau_result unpack_here(ExrDecoder *d, size_t part, const Chunk *chunk, const exr_chunk_info_t *info,
    uint8_t *out, CauError *err) {
    size_t bytes = (size_t)info->unpacked_size;
    /* Nothing packs to more than its own size. */
    size_t packed = info->packed_size < bytes ? (size_t)info->packed_size : bytes;
    bool stored = d->reader->header.parts[part].codec == EXR_CODEC_NONE;
    if (info->packed_size > bytes || (stored && packed < bytes))
        return error_set(err, CAU_ERROR_INPUT,
            "\"%s\": the chunk at row %d has %llu bytes for %zu bytes of pixels: the file is damaged",
            d->reader->path, chunk->y, (unsigned long long)info->packed_size, bytes);
    uint8_t *to = packed == bytes ? out : NULL;
    if (!to) {
        if (!reserve(&d->packed, &d->packed_capacity, packed)) return no_memory(d, err);
        to = d->packed;
    }
    exr_result_t code = exr_read_chunk(d->reader->context, (int)part, info, to);
    if (code != EXR_ERR_SUCCESS) return failed(d, code, err);
    if (packed == bytes || exr_zip_unpack(d->zip, to, packed, out, bytes)) return CAU_OK;
    return error_set(err, CAU_ERROR_INPUT,
        "\"%s\": the chunk at row %d cannot be unpacked: the file is damaged", d->reader->path, chunk->y);
}

/* RLE, PIZ, PXR24: the library unpacks into our memory, in the layout of the file. */
static cau_result unpack_there(
    ExrDecoder *d, size_t part, const exr_chunk_info_t *info, uint8_t *out, CauError *err) {
    exr_const_context_t context = d->reader->context;
    exr_result_t code;
    if (d->pipeline_ready && d->pipeline_part == part) {
        code = exr_decoding_update(context, (int)part, info, &d->pipeline);
    } else {
        if (d->pipeline_ready) exr_decoding_destroy(context, &d->pipeline);
        d->pipeline = (exr_decode_pipeline_t)EXR_DECODE_PIPELINE_INITIALIZER;
        code = exr_decoding_initialize(context, (int)part, info, &d->pipeline);
        d->pipeline_ready = code == EXR_ERR_SUCCESS;
        d->pipeline_part = part;
        if (code == EXR_ERR_SUCCESS)
            code = exr_decoding_choose_default_routines(context, (int)part, &d->pipeline);
        d->pipeline.unpack_and_convert_fn = NULL;
    }
    if (code == EXR_ERR_SUCCESS) code = exr_decoding_run(context, (int)part, &d->pipeline);
    if (code != EXR_ERR_SUCCESS) return failed(d, code, err);
    /* A chunk that would not shrink is stored as it is, and left where it was read to. */
    const void *from =
        info->packed_size == info->unpacked_size ? d->pipeline.packed_buffer : d->pipeline.unpacked_buffer;
    memcpy(out, from, (size_t)info->unpacked_size);
    return CAU_OK;
}

static cau_result unpack(ExrDecoder *d, size_t part, const Chunk *chunk, uint8_t *out, CauError *err) {
    exr_chunk_info_t info;
    CAU_TRY(find_chunk(d, part, chunk, &info, err));
    ExrCodec codec = d->reader->header.parts[part].codec;
    if (codec == EXR_CODEC_NONE || codec == EXR_CODEC_ZIP || codec == EXR_CODEC_ZIPS)
        return unpack_here(d, part, chunk, &info, out, err);
    return unpack_there(d, part, &info, out, err);
}

/* A chunk's rows y0..y1, channel by channel, to their place in the rows of the whole part. */
static void scatter(
    const ExrPart *p, const Chunk *chunk, const uint8_t *from, int64_t y0, int64_t y1, const ExrRows *rows) {
    size_t width = (size_t)exr_box_width(p->data_window), before = 0;
    for (size_t c = 0; c < p->channel_count; c++) {
        size_t bytes = exr_type_bytes(p->channels[c].type);
        for (int64_t y = y0; y <= y1; y++)
            memcpy(exr_rows_at(rows, y, before * width + (size_t)chunk->x * bytes),
                from + (size_t)(y - chunk->y) * chunk->row_bytes + before * (size_t)chunk->width,
                (size_t)chunk->width * bytes);
        before += bytes;
    }
}

static cau_result read_chunk(
    ExrDecoder *d, size_t part, const Chunk *chunk, const ExrRows *rows, CauError *err) {
    const ExrPart *p = &d->reader->header.parts[part];
    int64_t y0 = chunk->y, y1 = y0 + chunk->height - 1;
    if (!p->tiled && y0 >= rows->y0 && y1 <= rows->y1)
        return unpack(d, part, chunk, exr_rows_at(rows, y0, 0), err);
    if (!reserve(&d->chunk, &d->chunk_capacity, chunk->row_bytes * (size_t)chunk->height))
        return no_memory(d, err);
    CAU_TRY(unpack(d, part, chunk, d->chunk, err));
    if (y0 < rows->y0) y0 = rows->y0;
    if (y1 > rows->y1) y1 = rows->y1;
    scatter(p, chunk, d->chunk, y0, y1, rows);
    return CAU_OK;
}

/* The first row of the chunk that holds row y. */
static int32_t chunk_start(const ExrPart *p, int32_t y) {
    return y - (int32_t)(((int64_t)y - p->data_window.y0) % exr_chunk_rows(p));
}

/* OpenEXRCore 3.1 has no DWA, and its B44 decoder returns rubbish for a part that has float channels too. */
static bool core_can_decode(const ExrPart *part) { return part->codec < EXR_CODEC_B44; }

static cau_result open_imf(ExrDecoder *d, CauError *err) {
    CAU_TRY(exr_scan(d->reader->path, err));
    return imf_reader_open(&d->imf, d->reader->path, err);
}

cau_result exr_decoder_rows(
    ExrDecoder *d, size_t part, int32_t y0, int32_t y1, ExrRows *rows, CauError *err) {
    const ExrPart *p = &d->reader->header.parts[part];
    CAU_TRY(exr_reader_can_read(d->reader, part, err));
    if (y0 > y1 || y0 < p->data_window.y0 || y1 > p->data_window.y1)
        return error_set(
            err, CAU_ERROR_INTERNAL, "rows %d to %d of \"%s\" do not exist", y0, y1, d->reader->path);
    CAU_TRY(exr_rows_reserve(rows, p, y0, y1, err));
    if (!core_can_decode(p)) {
        if (!d->imf) CAU_TRY(open_imf(d, err));
        return imf_reader_rows(d->imf, part, p, rows, err);
    }
    int columns = exr_chunk_columns(p);
    for (int64_t y = chunk_start(p, y0); y <= y1; y += exr_chunk_rows(p))
        for (int x = 0; x < columns; x++) {
            Chunk chunk = chunk_at(p, x, (int32_t)y);
            CAU_TRY(read_chunk(d, part, &chunk, rows, err));
        }
    return CAU_OK;
}

cau_result exr_decoder_packed(
    ExrDecoder *d, size_t part, int32_t y0, int32_t y1, ExrPacked *packed, CauError *err) {
    const ExrPart *p = &d->reader->header.parts[part];
    CAU_TRY(exr_reader_can_read(d->reader, part, err));
    exr_packed_clear(packed);
    int columns = exr_chunk_columns(p);
    for (int64_t y = y0; y <= y1; y += exr_chunk_rows(p))
        for (int x = 0; x < columns; x++) {
            Chunk chunk = chunk_at(p, x, (int32_t)y);
            exr_chunk_info_t info;
            CAU_TRY(find_chunk(d, part, &chunk, &info, err));
            CAU_TRY(exr_packed_reserve(packed, (size_t)info.packed_size, err));
            exr_result_t code =
                exr_read_chunk(d->reader->context, (int)part, &info, packed->bytes + packed->size);
            if (code != EXR_ERR_SUCCESS) return failed(d, code, err);
            CAU_TRY(exr_packed_end(packed, (size_t)info.packed_size, err));
        }
    return CAU_OK;
}
