/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Half floats, by Imath's own conversion (round to nearest even). */
#ifndef IMAGE_HALF_H
#define IMAGE_HALF_H

#ifndef IMATH_HALF_NO_LOOKUP_TABLE
#define IMATH_HALF_NO_LOOKUP_TABLE /* no library needed, and no table in the cache */
#endif
#include <half.h>

#include <stdint.h>

#define HALF_LARGEST 65504.0f

static inline float half_to_float(uint16_t h) { return imath_half_to_float(h); }
static inline uint16_t half_from_float(float f) { return imath_float_to_half(f); }

#endif
