/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Reads any flat EXR file in bands of rows, in the stored types; nothing a file says is believed unchecked.
 */
#ifndef IMAGE_EXR_READER_H
#define IMAGE_EXR_READER_H

#include "image/exr_header.h"

typedef struct ExrReader ExrReader;

/** Opens and checks the headers of all parts. */
cau_result exr_reader_open(ExrReader **out, const char *path, CauError *err);
/** NULL inside is allowed; *reader becomes NULL. */
void exr_reader_close(ExrReader **reader);

const ExrHeader *exr_reader_header(const ExrReader *reader);
const char *exr_reader_path(const ExrReader *reader);

/** Reads rows y0..y1 of level 0 into planes[c], one per channel of the part; a NULL plane is skipped. Same
 * layout and band boundaries as exr_writer_band(); see exr_band_rows(). */
cau_result exr_reader_band(
    ExrReader *reader, size_t part, int32_t y0, int32_t y1, void *const *planes, CauError *err);

/** What keeps a part from being read as pixels (deep, sub-sampled), as an error sentence; CAU_OK when
 * nothing. */
cau_result exr_reader_can_read(const ExrReader *reader, size_t part, CauError *err);

#endif
