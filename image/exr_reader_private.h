/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_EXR_READER_PRIVATE_H
#define IMAGE_EXR_READER_PRIVATE_H

#include "image/exr_core.h"
#include "image/exr_reader.h"

/** Not changed once it is open, but for what OpenEXRCore guards by itself. */
struct ExrReader {
    char *path;
    ExrHeader header;
    exr_context_t context;
    ExrCoreFile file;
};

#endif
