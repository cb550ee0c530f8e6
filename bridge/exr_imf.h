/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  OpenEXR's C++ library, for what OpenEXRCore 3.1 lacks: DWA compression, and writing from the last row up.
 */
#ifndef BRIDGE_EXR_IMF_H
#define BRIDGE_EXR_IMF_H

#include "image/exr_rows.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ImfReader ImfReader;
typedef struct ImfWriter ImfWriter;

cau_result imf_reader_open(ImfReader **out, const char *path, CauError *err);
void imf_reader_close(ImfReader **reader);
/** Fills `rows`, which has been reserved; `description` is the part as the caller knows it. */
cau_result imf_reader_rows(
    ImfReader *reader, size_t part, const ExrPart *description, const ExrRows *rows, CauError *err);

/** As exr_writer_open() and its companions. */
cau_result imf_writer_open(
    ImfWriter **out, const char *path, const char *shown, const ExrHeader *header, CauError *err);
cau_result imf_writer_rows(ImfWriter *writer, size_t part, const ExrRows *rows, CauError *err);
cau_result imf_writer_close(ImfWriter **writer, CauError *err);

#ifdef __cplusplus
}
#endif
#endif
