/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures for looking at: through the configuration's display and view to 8 bits. */
#include "composite/preview.h"
#include "composite/picture_file.h"
#include "core/checked.h"
#include "core/file_atomic.h"
#include "image/exr_samples.h"

#include <math.h>
#include <strings.h>

cau_result preview_check_name(const char *path, CauError *err) {
    const char *dot = path ? strrchr(path, '.') : NULL;
    if (!path || (dot && (strcasecmp(dot, ".png") == 0 || strcasecmp(dot, ".jpg") == 0 ||
                             strcasecmp(dot, ".jpeg") == 0)))
        return CAU_OK;
    return error_set(err, CAU_ERROR_USAGE, "\"%s\": a preview is a .png, .jpg or .jpeg file", path);
}

cau_result preview_save(const char *path, const uint8_t *rgb, size_t width, size_t height, CauError *err) {
    FileAtomic file;
    bool png = strcasecmp(strrchr(path, '.'), ".png") == 0;
    CAU_TRY(file_atomic_begin(&file, path, err));
    cau_result result = png ? png_write(file.temp_path, path, rgb, width, height, err)
                            : jpeg_write(file.temp_path, path, rgb, width, height, err);
    if (result == CAU_OK) return file_atomic_commit(&file, err);
    file_atomic_abort(&file);
    return result;
}

cau_result preview_open(Job *job) {
    const cau_merge_options *o = job->options;
    CAU_TRY(preview_check_name(o->preview, job->err));
    CAU_TRY(preview_check_name(o->contact_sheet, job->err));
    return colour_view_open(
        &job->view, job->colour, job->beauty_space, o->display, o->view, o->look, job->err);
}

cau_result preview_show(const Job *job, float *rgb, size_t width, size_t height, uint8_t *out) {
    float scale = (float)exp2(job->options->preview_ev);
    for (size_t i = 0; scale != 1 && i < 3 * width * height; i++) rgb[i] *= scale;
    CAU_TRY(colour_view_apply(job->view, rgb, width, height, job->err));
    for (size_t i = 0; i < 3 * width * height; i++) {
        float v = rgb[i];
        out[i] = v > 0 ? (uint8_t)(v < 1 ? v * 255.0f + 0.5f : 255) : 0; /* NaN is not above 0 */
    }
    return CAU_OK;
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
    uint8_t *bytes = array_new(width * height, 3);
    cau_result result = CAU_OK;
    if (!rgb || !bytes)
        result = error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for %zu x %zu pixels", width, height);
    if (result == CAU_OK) result = read_rgb(job, picture, layer, rgb);
    if (result == CAU_OK) result = preview_show(job, rgb, width, height, bytes);
    if (result == CAU_OK) result = preview_save(job->options->preview, bytes, width, height, job->err);
    free(rgb);
    free(bytes);
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
