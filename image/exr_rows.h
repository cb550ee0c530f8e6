/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Pixels on their way: rows as the file lays them out, and packed chunks.
 *
 *  A row holds its channels one after the other, in the order of the part, each in its stored type, over the
 * whole width of the data window. This is what a scan-line chunk unpacks to, so nothing is rearranged on the
 * way from file to file. */
#ifndef IMAGE_EXR_ROWS_H
#define IMAGE_EXR_ROWS_H

#include "image/exr_header.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ExrRows {
    uint8_t *bytes;
    size_t capacity;
    int32_t y0, y1;   /**< inclusive, in the file's coordinates */
    size_t row_bytes; /**< width x bytes of a pixel over all channels */
} ExrRows;

/** Packed chunks one after the other, in the order of the file. */
typedef struct ExrPacked {
    uint8_t *bytes;
    size_t size, capacity;
    size_t *ends; /**< ends[i]: where chunk i ends in `bytes` */
    size_t count, end_capacity;
} ExrPacked;

/** Makes room for rows y0..y1 of `part`; what was in them is lost. */
cau_result exr_rows_reserve(ExrRows *rows, const ExrPart *part, int32_t y0, int32_t y1, CauError *err);
void exr_rows_free(ExrRows *rows);

/** Where a channel begins in a row, in bytes. */
size_t exr_channel_offset(const ExrPart *part, size_t channel);

static inline uint8_t *exr_rows_at(const ExrRows *rows, int64_t y, size_t offset) {
    return rows->bytes + (size_t)(y - rows->y0) * rows->row_bytes + offset;
}

/** Room for `more` bytes behind those that are there. */
cau_result exr_packed_reserve(ExrPacked *packed, size_t more, CauError *err);
/** Says that the chunk ends `bytes` behind the last one. */
cau_result exr_packed_end(ExrPacked *packed, size_t bytes, CauError *err);
static inline void exr_packed_clear(ExrPacked *packed) { packed->size = packed->count = 0; }
void exr_packed_free(ExrPacked *packed);

#ifdef __cplusplus
}
#endif
#endif
