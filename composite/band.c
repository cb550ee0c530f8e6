/* SPDX-License-Identifier: Apache-2.0 */
#include "composite/band.h"

#include "core/checked.h"

cau_result band_create(Band *out, const ExrPart *part, const bool *wanted, CauError *err) {
    int64_t rows = exr_box_height(part->data_window);
    if (rows > exr_band_rows(part)) rows = exr_band_rows(part);
    size_t samples, bytes;
    bool fits = checked_mul((size_t)exr_box_width(part->data_window), (size_t)rows, &samples);
    *out = (Band){array_new(part->channel_count, sizeof *out->planes), part->channel_count};
    for (size_t c = 0; out->planes && fits && c < out->count; c++) {
        if (wanted && !wanted[c]) continue;
        fits = checked_mul(samples, exr_type_bytes(part->channels[c].type), &bytes) &&
               (out->planes[c] = array_new(bytes, 1)) != NULL;
    }
    if (out->planes && fits) return CAU_OK;
    band_free(out);
    return error_set(
        err, CAU_ERROR_RESOURCE, "out of memory for %zu channels of %d rows", part->channel_count, (int)rows);
}

void band_free(Band *band) {
    for (size_t c = 0; band->planes && c < band->count; c++) free(band->planes[c]);
    free(band->planes);
    *band = (Band){0};
}
