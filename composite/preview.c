/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures for looking at: through the configuration's display and view to 8 bits. */
#include "composite/job.h"
#include "composite/png.h"
#include "core/checked.h"
#include "core/file_atomic.h"
#include "image/exr_samples.h"

#include <math.h>

static cau_result write_png(const char *path, const float *rgb, size_t width, size_t height, CauError *err) {
    uint8_t *bytes = array_new(width * height, 3);
    if (!bytes) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the preview");
    for (size_t i = 0; i < 3 * width * height; i++) {
        float v = rgb[i];
        bytes[i] = v > 0 ? (uint8_t)(v < 1 ? v * 255.0f + 0.5f : 255) : 0; /* NaN is not above 0 */
    }
    FileAtomic file;
    cau_result result = file_atomic_begin(&file, path, err);
    if (result == CAU_OK) {
        result = png_write(file.temp_path, path, bytes, width, height, err);
        if (result == CAU_OK)
            result = file_atomic_commit(&file, err);
        else
            file_atomic_abort(&file);
    }
    free(bytes);
    return result;
}

cau_result preview_open(Job *job) {
    const cau_merge_options *o = job->options;
    return colour_view_open(&job->view, job->colour, job->beauty_space, o->display, o->view, job->err);
}

static cau_result read_rgb(const Job *job, const Picture *picture, const ExrLayer *layer, float *rgb) {
    const ExrPart *part = &picture->header->parts[layer->part];
    ExrBands bands = exr_bands(part, exr_band_rows(part));
    size_t width = (size_t)exr_box_width(part->data_window);
    ExrDecoder *decoder = NULL;
    ExrRows rows = {0};
    cau_result result = exr_decoder_create(&decoder, picture->reader, job->err);
    for (size_t b = 0; result == CAU_OK && b < bands.count; b++) {
        int32_t y0, y1;
        exr_band_at(&bands, b, &y0, &y1);
        result = job_poll(job);
        if (result == CAU_OK) result = exr_decoder_rows(decoder, layer->part, y0, y1, &rows, job->err);
        for (int64_t y = y0; result == CAU_OK && y <= y1; y++)
            for (size_t c = 0; c < 3; c++) {
                size_t channel = (size_t)layer->rgb[c];
                const uint8_t *row = exr_rows_at(&rows, y, exr_channel_offset(part, channel));
                float *out = rgb + 3 * (size_t)(y - part->data_window.y0) * width + c;
                for (size_t i = 0; i < width; i++)
                    out[3 * i] = (float)exr_sample(row, i, part->channels[channel].type);
            }
    }
    exr_rows_free(&rows);
    exr_decoder_free(&decoder);
    return result;
}

cau_result preview_write(const Job *job, const Picture *picture, const ExrLayer *layer) {
    const ExrPart *part = &picture->header->parts[layer->part];
    size_t width = (size_t)exr_box_width(part->data_window),
           height = (size_t)exr_box_height(part->data_window);
    float *rgb = array_new(width * height, 3 * sizeof *rgb);
    if (!rgb)
        return error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for %zu x %zu pixels", width, height);
    cau_result result = read_rgb(job, picture, layer, rgb);
    if (result == CAU_OK) result = colour_view_apply(job->view, rgb, width, height, job->err);
    if (result == CAU_OK) result = write_png(job->options->preview, rgb, width, height, job->err);
    free(rgb);
    return result;
}

cau_result job_preview(Job *job) {
    const cau_merge_options *o = job->options;
    CAU_TRY(o->pass ? picture_find_layer(&job->target, &job->beauty, o->pass, "--layer", job->err)
                    : picture_default_layer(&job->target, &job->beauty, "--layer", job->err));
    CAU_TRY(space_find(&job->beauty_space, &job->beauty_tag, job, &job->beauty, job->target->part,
        o->beauty_space, "--beauty-space"));
    CAU_TRY(preview_open(job));
    return preview_write(job, &job->beauty, job->target);
}
