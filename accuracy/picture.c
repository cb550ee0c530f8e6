/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/picture.h"

#include "core/checked.h"
#include "core/file_atomic.h"

#include <math.h>
#include <openexr.h>
#include <png.h>
#include <stdint.h>

enum { SIDE_MAX = 65536 };

/* The sentence that follows says what is wrong. */
static void be_silent(exr_const_context_t file, exr_result_t code, const char *text) {
    (void)file, (void)code, (void)text;
}

static cau_result bad(CauError *err, const char *path, const char *why) {
    return error_set(err, CAU_ERROR_INPUT, "cannot read \"%s\": %s", path, why);
}

/* Points the decoder at the rows of a chunk; false when a colour is missing or not a number. */
static bool aim(exr_decode_pipeline_t *pipe, float *rows, int width) {
    unsigned found = 0;
    for (int c = 0; c < pipe->channel_count; c++) {
        exr_coding_channel_info_t *channel = &pipe->channels[c];
        const char *at = strchr("RGB", channel->channel_name[0]);
        channel->decode_to_ptr = NULL;
        if (!at || !*at || channel->channel_name[1] || channel->x_samples != 1 || channel->y_samples != 1 ||
            channel->data_type == EXR_PIXEL_UINT)
            continue;
        found |= 1u << (at - "RGB");
        channel->decode_to_ptr = (uint8_t *)(rows + (at[0] == 'G' ? 1 : at[0] == 'B' ? 2 : 0));
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 3 * sizeof(float);
        channel->user_line_stride = width * 3 * (int)sizeof(float);
    }
    return found == 7;
}

static cau_result read_rows(
    exr_context_t file, const char *path, exr_attr_box2i_t window, int width, float *rgb, CauError *err) {
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    int32_t lines = 0;
    bool begun = false;
    cau_result result = CAU_OK;
    if (exr_get_scanlines_per_chunk(file, 0, &lines) != EXR_ERR_SUCCESS || lines < 1)
        return bad(err, path, "its rows are not laid out as scan lines");
    for (int64_t y = window.min.y; result == CAU_OK && y <= window.max.y; y += lines) {
        exr_chunk_info_t chunk;
        bool ok = exr_read_scanline_chunk_info(file, 0, (int)y, &chunk) == EXR_ERR_SUCCESS;
        ok = ok && (begun ? exr_decoding_update(file, 0, &chunk, &pipe)
                          : exr_decoding_initialize(file, 0, &chunk, &pipe)) == EXR_ERR_SUCCESS;
        if (ok && !aim(&pipe, rgb + (size_t)(y - window.min.y) * (size_t)width * 3, width))
            result =
                bad(err, path, "its first part has no channels R, G and B; give a file of caustic-render");
        else if (!ok || (!begun && exr_decoding_choose_default_routines(file, 0, &pipe) != EXR_ERR_SUCCESS) ||
                 exr_decoding_run(file, 0, &pipe) != EXR_ERR_SUCCESS)
            result = bad(err, path, "its pixels are damaged; write it anew");
        begun = begun || ok;
    }
    if (begun) exr_decoding_destroy(file, &pipe);
    return result;
}

static cau_result read_open(
    exr_context_t file, const char *path, int *width, int *height, float **rgb, CauError *err) {
    exr_attr_box2i_t data, display;
    exr_storage_t storage;
    int32_t complete = 1;
    if (exr_get_storage(file, 0, &storage) != EXR_ERR_SUCCESS || storage != EXR_STORAGE_SCANLINE ||
        exr_get_data_window(file, 0, &data) != EXR_ERR_SUCCESS ||
        exr_get_display_window(file, 0, &display) != EXR_ERR_SUCCESS)
        return bad(err, path, "its first part is not a picture of scan lines; give a file of caustic-render");
    if (memcmp(&data, &display, sizeof data) != 0)
        return bad(err, path, "it holds a part of the picture; render it without --crop");
    if (exr_attr_get_int(file, 0, "caustics/complete", &complete) == EXR_ERR_SUCCESS && !complete)
        return bad(err, path, "its render was stopped; render it to the end");
    int64_t w = (int64_t)data.max.x - data.min.x + 1, h = (int64_t)data.max.y - data.min.y + 1;
    if (w < 1 || h < 1 || w > SIDE_MAX || h > SIDE_MAX)
        return bad(err, path, "its size is beyond 65536 pixels");
    *rgb = array_new((size_t)w * (size_t)h * 3, sizeof **rgb);
    if (!*rgb) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for \"%s\"", path);
    *width = (int)w;
    *height = (int)h;
    return read_rows(file, path, data, *width, *rgb, err);
}

cau_result picture_read(const char *path, int *width, int *height, float **rgb, CauError *err) {
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t file = NULL;
    *rgb = NULL;
    start.error_handler_fn = be_silent;
    start.max_image_width = start.max_image_height = SIDE_MAX;
    if (exr_start_read(&file, path, &start) != EXR_ERR_SUCCESS)
        return bad(err, path, "it is no whole EXR file");
    cau_result result = read_open(file, path, width, height, rgb, err);
    exr_finish(&file);
    if (result != CAU_OK) {
        free(*rgb);
        *rgb = NULL;
    }
    return result;
}

static int darker_first(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

double picture_gain(const float *rgb, int width, int height) {
    size_t n = (size_t)width * (size_t)height * 3;
    float *sorted = array_new(n, sizeof *sorted);
    if (!sorted) return 1;
    memcpy(sorted, rgb, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, darker_first);
    double white = (double)sorted[n - 1 - n / 100];
    if (!(white > 0)) white = (double)sorted[n - 1];
    free(sorted);
    return white > 0 ? 1 / white : 1;
}

/* IEC 61966-2-1. */
static uint8_t encode(double x) {
    if (!(x > 0)) return 0;
    if (x >= 1) return 255;
    return (uint8_t)lrint(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055));
}

cau_result picture_write_png(
    const char *path, const float *rgb, int width, int height, double gain, CauError *err) {
    size_t n = (size_t)width * (size_t)height * 3;
    png_image image = {.version = PNG_IMAGE_VERSION,
        .width = (png_uint_32)width,
        .height = (png_uint_32)height,
        .format = PNG_FORMAT_RGB};
    png_alloc_size_t bytes = 0;
    uint8_t *raw = array_new(n, 1), *packed = NULL;
    for (size_t i = 0; raw && i < n; i++) raw[i] = encode(gain * (double)rgb[i]);
    bool ok = raw && png_image_write_get_memory_size(image, bytes, 0, raw, 0, NULL);
    packed = ok ? array_new(bytes, 1) : NULL;
    ok = packed && png_image_write_to_memory(&image, packed, &bytes, 0, raw, 0, NULL);
    cau_result result = ok ? file_write_atomic(path, packed, bytes, err)
                           : error_set(err, CAU_ERROR_RESOURCE, "out of memory for \"%s\"", path);
    free(packed);
    free(raw);
    return result;
}
