/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_EXR_WRITER_PRIVATE_H
#define IMAGE_EXR_WRITER_PRIVATE_H

#include "bridge/exr_imf.h"
#include "image/exr_core.h"
#include "image/exr_writer.h"

struct ExrWriter {
    const ExrHeader *header;
    char *shown;
    exr_context_t context;
    ExrCoreFile file;
    ExrEncoder *encoder; /* for rows that are packed here; made when needed */
    ExrPacked packed;
    ImfWriter *imf; /* writes instead of all the above when the core cannot */
};

#endif
