/* SPDX-License-Identifier: Apache-2.0 */
#ifndef COMPOSITE_PNG_H
#define COMPOSITE_PNG_H

#include "core/error.h"

#include <stddef.h>
#include <stdint.h>

/** Writes 8-bit RGB to `path`; `shown` is the name for messages. */
cau_result png_write(
    const char *path, const char *shown, const uint8_t *rgb, size_t width, size_t height, CauError *err);

#endif
