/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Writes any scan-line or tiled EXR file from an ExrHeader and bands of rows.
 *
 *  Parts are written in order, each from its first band to its last (see exr_bands()). Packing may happen in
 * several threads, each with an encoder of its own; what they made is put into the file in order, by one. The
 * file is not atomic by itself: give it the temporary name of a FileAtomic. */
#ifndef IMAGE_EXR_WRITER_H
#define IMAGE_EXR_WRITER_H

#include "image/exr_rows.h"

typedef struct ExrWriter ExrWriter;
typedef struct ExrEncoder ExrEncoder;

/** `path` must exist (file_atomic_begin() made it). `header` must outlive the writer.
 *  `shown` is the name for error messages, which is not the temporary one. */
cau_result exr_writer_open(
    ExrWriter **out, const char *path, const char *shown, const ExrHeader *header, CauError *err);

/** Whether chunks can be packed by encoders and put packed; else only rows can be put. */
bool exr_writer_takes_packed(const ExrWriter *writer);

/** The next band of the part, as an encoder packed it or as it was in another file of the same layout. */
cau_result exr_writer_put_packed(
    ExrWriter *writer, size_t part, int32_t y0, const ExrPacked *packed, CauError *err);

/** The next band of the part, packed here. */
cau_result exr_writer_put_rows(ExrWriter *writer, size_t part, const ExrRows *rows, CauError *err);

/** Writes the chunk tables and closes. *writer becomes NULL, also on failure. */
cau_result exr_writer_close(ExrWriter **writer, CauError *err);

/** Closes without caring for the content. NULL inside is allowed. */
void exr_writer_abort(ExrWriter **writer);

/** It must be freed before the writer is closed. */
cau_result exr_encoder_create(ExrEncoder **out, const ExrWriter *writer, CauError *err);
/** NULL inside is allowed; *encoder becomes NULL. */
void exr_encoder_free(ExrEncoder **encoder);

/** Packs a band; its rows must be those of whole chunks. */
cau_result exr_encoder_pack(
    ExrEncoder *encoder, size_t part, const ExrRows *rows, ExrPacked *packed, CauError *err);

/** Changes an int attribute of the first part of a finished file: for counts that are known only when the
 * pixels are written. */
cau_result exr_writer_patch_int(
    const char *path, const char *shown, const char *name, int32_t value, CauError *err);

#endif
