/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  ZIP compression of a chunk, in place of OpenEXRCore's own.
 *
 *  The Core encoder of OpenEXR up to 3.4 writes damaged chunks where deflate does not make the pixels smaller
 *  (openexr issue 2306: equal sizes; with 3.1.5 noisy float pictures lose whole blocks of rows). Ours stores
 *  such chunks as they are, which is what the format asks for, and uses libdeflate, which takes half the
 * time. A coder serves one thread at a time. */
#ifndef IMAGE_EXR_ZIP_H
#define IMAGE_EXR_ZIP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ExrZip ExrZip;

/** NULL when out of memory. */
ExrZip *exr_zip_create(void);
/** NULL is allowed. */
void exr_zip_free(ExrZip *zip);

/** Packs `count` bytes of pixels into `out`, which has room for `count`; never more come out. 0 when out of
 * memory. */
size_t exr_zip_pack(ExrZip *zip, const uint8_t *pixels, size_t count, uint8_t *out);

/** Unpacks to exactly `count` bytes; false when the data are damaged (or memory is out). */
bool exr_zip_unpack(ExrZip *zip, const uint8_t *packed, size_t packed_count, uint8_t *pixels, size_t count);

#endif
