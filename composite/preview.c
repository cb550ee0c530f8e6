/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures for looking at: through the configuration's display and view to 8 bits. */
#include "composite/band.h"
#include "composite/job.h"
#include "composite/png.h"
#include "core/checked.h"
#include "core/file_atomic.h"

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

cau_result preview_write(const Job *job, float *rgb, size_t width, size_t height) {
    CAU_TRY(colour_view_apply(job->view, rgb, width, height, job->err));
    return write_png(job->options->preview, rgb, width, height, job->err);
}

static cau_result read_rgb(const Job *job, const ExrPart *part, float *rgb) {
    const ExrLayer *layer = job->target;
    size_t width = (size_t)exr_box_width(part->data_window);
    Band band;
    CAU_TRY(band_create(&band, part, NULL, job->err));
    cau_result result = CAU_OK;
    for (size_t b = 0; result == CAU_OK && b < exr_band_count(part); b++) {
        int32_t y0, y1;
        exr_band_at(part, b, &y0, &y1);
        result = job_poll(job);
        if (result == CAU_OK)
            result = exr_reader_band(job->beauty.reader, layer->part, y0, y1, band.planes, job->err);
        size_t first = (size_t)((int64_t)y0 - part->data_window.y0) * width;
        for (size_t i = 0; result == CAU_OK && i < (size_t)((int64_t)y1 - y0 + 1) * width; i++)
            for (int c = 0; c < 3; c++)
                rgb[3 * (first + i) + (size_t)c] =
                    (float)sample_get(band.planes[layer->rgb[c]], i, part->channels[layer->rgb[c]].type);
    }
    band_free(&band);
    return result;
}

cau_result job_preview(Job *job) {
    const cau_merge_options *o = job->options;
    CAU_TRY(o->pass ? picture_find_layer(&job->target, &job->beauty, o->pass, "--layer", job->err)
                    : picture_default_layer(&job->target, &job->beauty, "--layer", job->err));
    CAU_TRY(space_find(&job->beauty_space, &job->beauty_tag, job, &job->beauty, job->target->part,
        o->beauty_space, "--beauty-space"));
    CAU_TRY(preview_open(job));
    const ExrPart *part = &job->beauty.header->parts[job->target->part];
    size_t width = (size_t)exr_box_width(part->data_window),
           height = (size_t)exr_box_height(part->data_window);
    float *rgb = array_new(width * height, 3 * sizeof *rgb);
    if (!rgb)
        return error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for %zu x %zu pixels", width, height);
    cau_result result = read_rgb(job, part, rgb);
    if (result == CAU_OK) result = preview_write(job, rgb, width, height);
    free(rgb);
    return result;
}
