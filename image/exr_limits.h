/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What a header may claim, given the size of its file. */
#ifndef IMAGE_EXR_LIMITS_H
#define IMAGE_EXR_LIMITS_H

#include "image/exr_header.h"

enum {
    EXR_LARGEST_SIDE = 65536, /**< pixels, width or height */
    EXR_MOST_CHANNELS = 1024, /**< in one part */
    EXR_MOST_PARTS = 1024,
    EXR_LARGEST_COORD = 1 << 30 /**< so that differences of coordinates fit in 32 bits */
};

/** Refuses sizes beyond the limits above, and pixels that `file_bytes` cannot possibly hold. */
cau_result exr_limits_check(const ExrHeader *header, int64_t file_bytes, const char *path, CauError *err);

#endif
