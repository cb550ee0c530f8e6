/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  OpenEXR's C++ library, for what OpenEXRCore 3.1 lacks: DWA compression, and writing from the last row up.
 */
#ifndef BRIDGE_EXR_IMF_H
#define BRIDGE_EXR_IMF_H

#include "image/exr_header.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ImfReader ImfReader;
typedef struct ImfWriter ImfWriter;

cau_result imf_reader_open(ImfReader **out, const char *path, CauError *err);
void imf_reader_close(ImfReader **reader);
/** As exr_reader_band(); `description` is the part as the caller knows it. */
cau_result imf_reader_band(ImfReader *reader, size_t part, const ExrPart *description, int32_t y0, int32_t y1,
    void *const *planes, CauError *err);

/** As exr_writer_open() and its companions. */
cau_result imf_writer_open(
    ImfWriter **out, const char *path, const char *shown, const ExrHeader *header, CauError *err);
cau_result imf_writer_band(
    ImfWriter *writer, size_t part, int32_t y0, int32_t y1, const void *const *planes, CauError *err);
cau_result imf_writer_close(ImfWriter **writer, CauError *err);

#ifdef __cplusplus
}
#endif
#endif
