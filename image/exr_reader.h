/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Reads any flat EXR file in bands of rows, in the stored types; nothing a file says is believed unchecked.
 *
 *  One reader may feed several decoders at once, each in a thread of its own. */
#ifndef IMAGE_EXR_READER_H
#define IMAGE_EXR_READER_H

#include "image/exr_rows.h"

typedef struct ExrReader ExrReader;
typedef struct ExrDecoder ExrDecoder;

/** Opens and checks the headers of all parts. */
cau_result exr_reader_open(ExrReader **out, const char *path, CauError *err);
/** NULL inside is allowed; *reader becomes NULL. */
void exr_reader_close(ExrReader **reader);

const ExrHeader *exr_reader_header(const ExrReader *reader);
const char *exr_reader_path(const ExrReader *reader);

/** What keeps a part from being read as pixels (deep, sub-sampled), as an error sentence; CAU_OK when
 * nothing. */
cau_result exr_reader_can_read(const ExrReader *reader, size_t part, CauError *err);

/** A decoder's memory grows with what it reads. It must be freed before the reader is closed. */
cau_result exr_decoder_create(ExrDecoder **out, const ExrReader *reader, CauError *err);
/** NULL inside is allowed; *decoder becomes NULL. */
void exr_decoder_free(ExrDecoder **decoder);

/** Rows y0..y1 of level 0, which must lie in the data window; `rows` is made to fit. */
cau_result exr_decoder_rows(
    ExrDecoder *decoder, size_t part, int32_t y0, int32_t y1, ExrRows *rows, CauError *err);

/** The chunks of rows y0..y1 of level 0 as they are in the file; the rows must be those of whole chunks. */
cau_result exr_decoder_packed(
    ExrDecoder *decoder, size_t part, int32_t y0, int32_t y1, ExrPacked *packed, CauError *err);

#endif
