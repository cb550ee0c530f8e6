/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  ZIP compression of a chunk, in place of OpenEXRCore's own.
 *
 *  The Core encoder of OpenEXR up to 3.4 writes damaged chunks where deflate does not make the pixels smaller
 *  (openexr issue 2306: equal sizes; with 3.1.5 noisy float pictures lose whole blocks of rows). Ours stores
 * such chunks as they are, which is what the format asks for, and deflates with libdeflate. */
#ifndef IMAGE_EXR_ZIP_H
#define IMAGE_EXR_ZIP_H

#include <openexr.h>

/** An exr_encode_pipeline_t's compress_fn for ZIP and ZIPS. */
exr_result_t exr_zip_compress(exr_encode_pipeline_t *encode);

#endif
