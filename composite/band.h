/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Planes that hold one band of a part's rows. */
#ifndef COMPOSITE_BAND_H
#define COMPOSITE_BAND_H

#include "image/exr_header.h"
#include "image/half.h"

#include <string.h>

typedef struct Band {
    void **planes; /**< one per channel; NULL for a channel that is not wanted */
    size_t count;
} Band;

/** Planes for the channels with wanted[c] (all when `wanted` is NULL), as many rows as a band of `part` has.
 */
cau_result band_create(Band *out, const ExrPart *part, const bool *wanted, CauError *err);
void band_free(Band *band);

/** Sample `at` of a plane as a number. */
static inline double sample_get(const void *plane, size_t at, ExrPixelType type) {
    if (type == EXR_TYPE_HALF) return (double)half_to_float(((const uint16_t *)plane)[at]);
    if (type == EXR_TYPE_FLOAT) return (double)((const float *)plane)[at];
    return (double)((const uint32_t *)plane)[at];
}

#endif
