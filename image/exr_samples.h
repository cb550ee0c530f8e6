/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Samples of a row as numbers. */
#ifndef IMAGE_EXR_SAMPLES_H
#define IMAGE_EXR_SAMPLES_H

#include "image/exr_header.h"
#include "image/half.h"

/** Sample `at` of a channel's row as a number. Rows of mixed types need not be aligned. */
static inline double exr_sample(const uint8_t *row, size_t at, ExrPixelType type) {
    uint16_t h;
    uint32_t u;
    float f;
    switch (type) {
    case EXR_TYPE_HALF:
        memcpy(&h, row + 2 * at, sizeof h);
        return (double)half_to_float(h);
    case EXR_TYPE_FLOAT:
        memcpy(&f, row + 4 * at, sizeof f);
        return (double)f;
    default:
        memcpy(&u, row + 4 * at, sizeof u);
        return (double)u;
    }
}

/** `count` samples from the beginning of `row` on, as numbers. */
void exr_samples(double *out, const uint8_t *row, size_t count, ExrPixelType type);

#endif
