/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Writing 8-bit RGB; `path` must exist, `shown` is the name for messages. */
#ifndef COMPOSITE_PICTURE_FILE_H
#define COMPOSITE_PICTURE_FILE_H

#include "core/error.h"

#include <stddef.h>
#include <stdint.h>

cau_result png_write(
    const char *path, const char *shown, const uint8_t *rgb, size_t width, size_t height, CauError *err);
cau_result jpeg_write(
    const char *path, const char *shown, const uint8_t *rgb, size_t width, size_t height, CauError *err);

/** Draws printable ASCII, 12 x 14 pixels a letter, white, its left top at x, y; what does not fit is cut. */
void label_draw(uint8_t *rgb, size_t width, size_t height, size_t x, size_t y, const char *text);
enum { LABEL_STEP = 12, LABEL_HEIGHT = 14 };

#endif
