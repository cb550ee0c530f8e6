/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_rows.h"

#include "core/checked.h"

static cau_result no_memory(size_t bytes, CauError *err) {
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu bytes of pixels", bytes);
}

cau_result exr_rows_reserve(ExrRows *rows, const ExrPart *part, int32_t y0, int32_t y1, CauError *err) {
    size_t row, bytes;
    if (!checked_mul((size_t)exr_box_width(part->data_window), exr_part_pixel_bytes(part), &row) ||
        !checked_mul(row, (size_t)((int64_t)y1 - y0 + 1), &bytes))
        return no_memory(SIZE_MAX, err);
    rows->y0 = y0;
    rows->y1 = y1;
    rows->row_bytes = row;
    if (bytes <= rows->capacity) return CAU_OK;
    free(rows->bytes);
    rows->capacity = 0;
    rows->bytes = malloc(bytes);
    if (!rows->bytes) return no_memory(bytes, err);
    rows->capacity = bytes;
    return CAU_OK;
}

void exr_rows_free(ExrRows *rows) {
    free(rows->bytes);
    *rows = (ExrRows){0};
}

size_t exr_channel_offset(const ExrPart *part, size_t channel) {
    size_t bytes = 0;
    for (size_t c = 0; c < channel; c++) bytes += exr_type_bytes(part->channels[c].type);
    return bytes * (size_t)exr_box_width(part->data_window);
}

cau_result exr_packed_reserve(ExrPacked *packed, size_t more, CauError *err) {
    size_t need;
    if (!checked_add(packed->size, more, &need)) return no_memory(more, err);
    if (need <= packed->capacity) return CAU_OK;
    uint8_t *grown = realloc(packed->bytes, need);
    if (!grown) return no_memory(need, err);
    packed->bytes = grown;
    packed->capacity = need;
    return CAU_OK;
}

cau_result exr_packed_end(ExrPacked *packed, size_t bytes, CauError *err) {
    void *array = packed->ends;
    if (!array_reserve(&array, &packed->end_capacity, packed->count + 1, sizeof *packed->ends))
        return no_memory(sizeof *packed->ends, err);
    packed->ends = array;
    packed->size += bytes;
    packed->ends[packed->count++] = packed->size;
    return CAU_OK;
}

void exr_packed_free(ExrPacked *packed) {
    free(packed->bytes);
    free(packed->ends);
    *packed = (ExrPacked){0};
}
