/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Pictures for looking at, by OpenImageIO. */
#ifndef BRIDGE_PICTURE_H
#define BRIDGE_PICTURE_H

#include "core/error.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Writes 8-bit RGB as PNG to `path`, whatever its ending; `shown` is the name for messages. */
cau_result picture_write_png(
    const char *path, const char *shown, const uint8_t *rgb, size_t width, size_t height, CauError *err);

#ifdef __cplusplus
}
#endif
#endif
