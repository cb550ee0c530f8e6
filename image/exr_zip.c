/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_zip.h"

#include <libdeflate.h>
#include <stdlib.h>
#include <string.h>

enum { ZIP_LEVEL = 4 }; /* what OpenEXR itself uses */

/* The format's filter (OpenEXR technical introduction, "ZIP compression"): even bytes first, then odd ones,
 * then differences of neighbours, offset by 128. */
static void filter_bytes(const uint8_t *in, uint8_t *out, size_t count) {
    size_t half = (count + 1) / 2;
    for (size_t i = 0; i < count; i++) out[i % 2 ? half + i / 2 : i / 2] = in[i];
    for (size_t i = count; i-- > 1;) out[i] = (uint8_t)(out[i] - out[i - 1] + 128);
}

static exr_result_t reserve(exr_encode_pipeline_t *encode, size_t bytes) {
    if (encode->compressed_buffer && encode->compressed_alloc_size >= bytes) return EXR_ERR_SUCCESS;
    free(encode->compressed_buffer);
    encode->compressed_alloc_size = 0;
    encode->compressed_buffer = malloc(bytes);
    if (!encode->compressed_buffer) return EXR_ERR_OUT_OF_MEMORY;
    encode->compressed_alloc_size = bytes;
    return EXR_ERR_SUCCESS;
}

exr_result_t exr_zip_compress(exr_encode_pipeline_t *encode) {
    size_t count = (size_t)encode->packed_bytes;
    if (count == 0) {
        encode->compressed_bytes = 0;
        return EXR_ERR_SUCCESS;
    }
    if (reserve(encode, count) != EXR_ERR_SUCCESS) return EXR_ERR_OUT_OF_MEMORY;
    uint8_t *filtered = malloc(count);
    struct libdeflate_compressor *deflate = libdeflate_alloc_compressor(ZIP_LEVEL);
    exr_result_t result = filtered && deflate ? EXR_ERR_SUCCESS : EXR_ERR_OUT_OF_MEMORY;
    if (result == EXR_ERR_SUCCESS) {
        filter_bytes(encode->packed_buffer, filtered, count);
        /* One byte of room less: a reader takes a chunk of full size as stored pixels. */
        size_t size =
            libdeflate_zlib_compress(deflate, filtered, count, encode->compressed_buffer, count - 1);
        if (size == 0) {
            memcpy(encode->compressed_buffer, encode->packed_buffer, count);
            size = count;
        }
        encode->compressed_bytes = size;
    }
    if (deflate) libdeflate_free_compressor(deflate);
    free(filtered);
    return result;
}
