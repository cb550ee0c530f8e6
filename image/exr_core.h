/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  OpenEXRCore, opened so that its messages reach our error record and its limits are set. */
#ifndef IMAGE_EXR_CORE_H
#define IMAGE_EXR_CORE_H

#include "core/error.h"

#include <openexr.h>
#include <stdatomic.h>

enum { EXR_CORE_TEXT_MAX = 256 };

/** What the callbacks know of one open file. Must stay where it is while the file is open. */
typedef struct ExrCoreFile {
    int fd;                       /**< -1 when closed */
    int write_errno;              /**< of the first failed write */
    int64_t size;                 /**< bytes, when reading */
    char text[EXR_CORE_TEXT_MAX]; /**< the library's last message */
    atomic_flag text_busy;        /**< guards it: decoders run in several threads */
} ExrCoreFile;

/** Opens `path`, which must be a regular file, and reads its header. */
cau_result exr_core_open_read(exr_context_t *out, ExrCoreFile *file, const char *path, CauError *err);

/** Opens the existing file `path` for writing from the start. */
cau_result exr_core_open_write(exr_context_t *out, ExrCoreFile *file, const char *path, CauError *err);

/** Ends writing (the chunk tables are written here) or reading, and closes the file. NULL is allowed. */
cau_result exr_core_close(exr_context_t *context, ExrCoreFile *file, const char *path, CauError *err);

/** Turns a failed library call into a sentence about `path`, saying what was being done. A failed write names
 *  the system's reason. */
cau_result exr_core_error(
    ExrCoreFile *file, exr_result_t code, const char *doing, const char *path, CauError *err);

#endif
