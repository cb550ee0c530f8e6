/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_zip.h"

#include <libdeflate.h>
#include <stdlib.h>
#include <string.h>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

enum { ZIP_LEVEL = 4 }; /* what OpenEXR itself uses */

struct ExrZip {
    struct libdeflate_compressor *deflate;
    struct libdeflate_decompressor *inflate;
    uint8_t *work; /* twice `capacity` */
    size_t capacity;
};

ExrZip *exr_zip_create(void) { return calloc(1, sizeof(ExrZip)); }

void exr_zip_free(ExrZip *zip) {
    if (!zip) return;
    if (zip->deflate) libdeflate_free_compressor(zip->deflate);
    if (zip->inflate) libdeflate_free_decompressor(zip->inflate);
    free(zip->work);
    free(zip);
}

static bool reserve(ExrZip *zip, size_t count) {
    if (count <= zip->capacity) return true;
    free(zip->work);
    zip->capacity = 0;
    zip->work = count < SIZE_MAX / 2 ? malloc(2 * count) : NULL;
    if (!zip->work) return false;
    zip->capacity = count;
    return true;
}

/* The format's filter (OpenEXR technical introduction, "ZIP compression"): even bytes first, then odd ones,
 * then differences of neighbours, offset by 128. */
static void filter_bytes(const uint8_t *in, uint8_t *halves, uint8_t *out, size_t count) {
    uint8_t *even = halves, *odd = halves + (count + 1) / 2;
    for (size_t i = 0; i < count / 2; i++) {
        even[i] = in[2 * i];
        odd[i] = in[2 * i + 1];
    }
    if (count % 2) even[count / 2] = in[count - 1];
    out[0] = halves[0];
    for (size_t i = 1; i < count; i++) out[i] = (uint8_t)(halves[i] - halves[i - 1] + 128);
}

/* Running sums of the differences. Sixteen bytes at a time where the processor can: sums of 2, 4, 8 and 16
 * neighbours by shifting. */
static void sum_bytes(uint8_t *bytes, size_t count) {
    size_t i = 1;
#if defined(__SSE2__)
    bytes[0] ^= 128; /* undone by the offset that every byte is given below */
    __m128i carry = _mm_setzero_si128(), offset = _mm_set1_epi8((char)-128);
    for (i = 0; i + 16 <= count; i += 16) {
        __m128i v = _mm_xor_si128(_mm_loadu_si128((const __m128i *)(const void *)(bytes + i)), offset);
        v = _mm_add_epi8(v, _mm_slli_si128(v, 1));
        v = _mm_add_epi8(v, _mm_slli_si128(v, 2));
        v = _mm_add_epi8(v, _mm_slli_si128(v, 4));
        v = _mm_add_epi8(v, _mm_slli_si128(v, 8));
        v = _mm_add_epi8(v, carry);
        _mm_storeu_si128((__m128i *)(void *)(bytes + i), v);
        carry = _mm_set1_epi8((char)bytes[i + 15]);
    }
    if (i == 0) {
        bytes[0] ^= 128;
        i = 1;
    }
#endif
    for (; i < count; i++) bytes[i] = (uint8_t)(bytes[i - 1] + bytes[i] - 128);
}

static void join_halves(const uint8_t *halves, uint8_t *out, size_t count) {
    const uint8_t *even = halves, *odd = halves + (count + 1) / 2;
    size_t i = 0;
#if defined(__SSE2__)
    for (; i + 16 <= count / 2; i += 16) {
        __m128i a = _mm_loadu_si128((const __m128i *)(const void *)(even + i));
        __m128i b = _mm_loadu_si128((const __m128i *)(const void *)(odd + i));
        _mm_storeu_si128((__m128i *)(void *)(out + 2 * i), _mm_unpacklo_epi8(a, b));
        _mm_storeu_si128((__m128i *)(void *)(out + 2 * i + 16), _mm_unpackhi_epi8(a, b));
    }
#endif
    for (; i < count / 2; i++) {
        out[2 * i] = even[i];
        out[2 * i + 1] = odd[i];
    }
    if (count % 2) out[count - 1] = even[count / 2];
}

size_t exr_zip_pack(ExrZip *zip, const uint8_t *pixels, size_t count, uint8_t *out) {
    if (!zip->deflate) zip->deflate = libdeflate_alloc_compressor(ZIP_LEVEL);
    if (!zip->deflate || count == 0 || !reserve(zip, count)) return 0;
    filter_bytes(pixels, zip->work, zip->work + zip->capacity, count);
    /* One byte of room less: a reader takes a chunk of full size as stored pixels. */
    size_t size = libdeflate_zlib_compress(zip->deflate, zip->work + zip->capacity, count, out, count - 1);
    if (size) return size;
    memcpy(out, pixels, count);
    return count;
}

bool exr_zip_unpack(ExrZip *zip, const uint8_t *packed, size_t packed_count, uint8_t *pixels, size_t count) {
    if (packed_count == count) {
        memcpy(pixels, packed, count);
        return true;
    }
    if (!zip->inflate) zip->inflate = libdeflate_alloc_decompressor();
    if (!zip->inflate || packed_count > count || !reserve(zip, count)) return false;
    if (libdeflate_zlib_decompress(zip->inflate, packed, packed_count, zip->work, count, NULL) !=
        LIBDEFLATE_SUCCESS)
        return false;
    sum_bytes(zip->work, count);
    join_halves(zip->work, pixels, count);
    return true;
}
