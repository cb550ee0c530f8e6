/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Half floats, by Imath's own conversion (round to nearest even). */
#ifndef IMAGE_HALF_H
#define IMAGE_HALF_H

#ifndef IMATH_HALF_NO_LOOKUP_TABLE
#define IMATH_HALF_NO_LOOKUP_TABLE /* no library needed, and no table in the cache */
#endif
#include <half.h>

#include <math.h>
#include <stdint.h>
#include <string.h>

#define HALF_LARGEST 65504.0f

static inline float half_to_float(uint16_t h) { return imath_half_to_float(h); }
static inline uint16_t half_from_float(float f) { return imath_float_to_half(f); }

/** One rounding only: by way of the float whose last bit is odd when anything was cut off ("round to odd").
 */
static inline uint16_t half_from_double(double v) {
    float f = (float)v;
    if ((double)f != v && isfinite(f)) {
        if (fabs((double)f) > fabs(v)) f = nextafterf(f, 0);
        uint32_t bits;
        memcpy(&bits, &f, sizeof bits);
        bits |= 1u;
        memcpy(&f, &bits, sizeof f);
    }
    return half_from_float(f);
}

#endif
