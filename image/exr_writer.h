/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Writes any scan-line or tiled EXR file from an ExrHeader and bands of rows.
 *
 *  Parts are written in order, each from its first row to its last (the last to the first with decreasing
 * line order). The file is not atomic by itself: give it the temporary name of a FileAtomic. */
#ifndef IMAGE_EXR_WRITER_H
#define IMAGE_EXR_WRITER_H

#include "image/exr_header.h"

typedef struct ExrWriter ExrWriter;

/** `path` must exist (file_atomic_begin() made it). `header` must outlive the writer.
 *  `shown` is the name for error messages, which is not the temporary one. */
cau_result exr_writer_open(
    ExrWriter **out, const char *path, const char *shown, const ExrHeader *header, CauError *err);

/** Writes rows y0..y1, as exr_band_at() gives them. planes[c] is channel c's row y0, each row the width
 * of the data window in the stored type, without gaps. */
cau_result exr_writer_band(
    ExrWriter *writer, size_t part, int32_t y0, int32_t y1, const void *const *planes, CauError *err);

/** Writes the chunk tables and closes. *writer becomes NULL, also on failure. */
cau_result exr_writer_close(ExrWriter **writer, CauError *err);

/** Closes without caring for the content. NULL inside is allowed. */
void exr_writer_abort(ExrWriter **writer);

#endif
