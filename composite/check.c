/* SPDX-License-Identifier: Apache-2.0 */
/* Reads every pixel. Faults: what cannot be read, values that are no numbers, a sum that is not the sum of
 * its lights, a render that was stopped, a colour space that is not said. */
#include "composite/job.h"
#include "composite/report.h"
#include "core/checked.h"
#include "image/exr_samples.h"

#include <inttypes.h>
#include <math.h>

typedef struct Check {
    const Report *report;
    const char *file;
    Picture picture;
    Lights lights;
    uint64_t faults;
    double *sum,
        *magnitude; /* of all light layers, and of their absolute values, RGB over the first data window */
    size_t summed;  /* light layers in it */
} Check;

static void fault(Check *check, const char *text) {
    check->faults++;
    report_line(check->report, "\"%s\": %s", check->file, text);
}

static void check_values(const ExrPart *part, const ExrRows *rows, uint64_t *bad) {
    size_t width = (size_t)exr_box_width(part->data_window);
    for (size_t c = 0; c < part->channel_count; c++) {
        ExrPixelType type = part->channels[c].type;
        size_t offset = exr_channel_offset(part, c);
        if (type == EXR_TYPE_UINT) continue;
        for (int64_t y = rows->y0; y <= rows->y1; y++) {
            const uint8_t *row = exr_rows_at(rows, y, offset);
            for (size_t i = 0; i < width; i++)
                if (!isfinite(exr_sample(row, i, type))) bad[c]++;
        }
    }
}

static bool is_light(const Check *check, size_t layer) {
    for (size_t i = 0; i < check->lights.count; i++)
        if (check->lights.lights[i].radiance == (int)layer || check->lights.lights[i].indirect == (int)layer)
            return true;
    return false;
}

/* `sign` +1 for a light layer, -1 for the total. */
static void sum_layer(
    Check *check, const ExrPart *part, const ExrLayer *layer, const ExrRows *rows, double sign) {
    size_t width = (size_t)exr_box_width(part->data_window);
    for (size_t c = 0; c < 3; c++) {
        size_t channel = (size_t)layer->rgb[c], offset = exr_channel_offset(part, channel);
        for (int64_t y = rows->y0; y <= rows->y1; y++) {
            const uint8_t *row = exr_rows_at(rows, y, offset);
            size_t first = 3 * (size_t)(y - part->data_window.y0) * width + c;
            for (size_t i = 0; i < width; i++) {
                double v = exr_sample(row, i, part->channels[channel].type);
                check->sum[first + 3 * i] += sign * v;
                check->magnitude[first + 3 * i] += fabs(v);
            }
        }
    }
}

static void sum_band(Check *check, size_t index, const ExrRows *rows) {
    const ExrPart *part = &check->picture.header->parts[index];
    if (!check->sum || !exr_box_equal(part->data_window, check->picture.header->parts[0].data_window)) return;
    for (size_t i = 0; i < check->picture.layers.count; i++) {
        const ExrLayer *layer = &check->picture.layers.layers[i];
        if (layer->part != index || !exr_layer_is_rgb(layer)) continue;
        bool total = index == 0 && layer->bare;
        if (total || is_light(check, i)) sum_layer(check, part, layer, rows, total ? -1 : 1);
        if (!total && is_light(check, i) && rows->y0 == part->data_window.y0) check->summed++;
    }
}

static cau_result check_part(Check *check, size_t index) {
    const ExrPart *part = &check->picture.header->parts[index];
    ExrBands bands = exr_bands(part, exr_band_rows(part));
    ExrDecoder *decoder = NULL;
    ExrRows rows = {0};
    uint64_t *bad = array_new(part->channel_count, sizeof *bad);
    if (!bad)
        return error_set(check->report->err, CAU_ERROR_RESOURCE, "out of memory for a list of channels");
    cau_result result = exr_decoder_create(&decoder, check->picture.reader, check->report->err);
    for (size_t b = 0; result == CAU_OK && b < bands.count; b++) {
        int32_t y0, y1;
        exr_band_at(&bands, b, &y0, &y1);
        result = exr_decoder_rows(decoder, index, y0, y1, &rows, check->report->err);
        if (result != CAU_OK) break;
        check_values(part, &rows, bad);
        sum_band(check, index, &rows);
    }
    for (size_t c = 0; result == CAU_OK && c < part->channel_count; c++) {
        if (!bad[c]) continue;
        check->faults++;
        report_line(check->report, "\"%s\": channel %s has %" PRIu64 " values that are NaN or infinite",
            check->file, part->channels[c].name, bad[c]);
    }
    exr_rows_free(&rows);
    exr_decoder_free(&decoder);
    free(bad);
    return result;
}

/* In half every layer and the total are rounded; in float only the order of the sum differs. */
static void check_sum(Check *check) {
    const ExrPart *part = &check->picture.header->parts[0];
    if (!check->sum || !check->summed) return;
    bool half = part->channels[0].type == EXR_TYPE_HALF;
    double n = (double)check->summed, relative = half ? 0x1p-10 : n * 0x1p-23,
           absolute = half ? (n + 1) * 0x1p-25 : 1e-37;
    size_t values = 3 * (size_t)exr_box_width(part->data_window) * (size_t)exr_box_height(part->data_window),
           wrong = 0;
    for (size_t i = 0; i < values; i++)
        if (fabs(check->sum[i]) > relative * check->magnitude[i] / 2 + absolute) wrong++;
    if (!wrong) return;
    check->faults++;
    report_line(check->report,
        "\"%s\": the first part is not the sum of the %zu light layers in %zu of %zu values", check->file,
        check->summed, wrong, values);
}

static void create_sums(Check *check) {
    const ExrPart *part = &check->picture.header->parts[0];
    const ExrLayer *first = check->picture.layers.count ? &check->picture.layers.layers[0] : NULL;
    if (!check->lights.count || !first || !first->bare || !exr_layer_is_rgb(first) ||
        exr_attr_find(part, CAU_ATTRIBUTE_MERGE))
        return; /* there is no total: an output of `add` holds the beauty there */
    size_t pixels = (size_t)exr_box_width(part->data_window) * (size_t)exr_box_height(part->data_window);
    check->sum = array_new(pixels, 3 * sizeof(double));
    check->magnitude = array_new(pixels, 3 * sizeof(double));
    if (check->sum && check->magnitude) return;
    free(check->sum);
    check->sum = NULL;
    fault(check, "too large for this machine to check the sum of the lights");
}

static void check_header(Check *check) {
    ColourTag tag;
    int32_t complete = 1;
    colour_tag_read(&tag, check->picture.header, 0);
    if (tag.source == COLOUR_TAG_NONE && check->lights.count)
        fault(check,
            "the colour space is not said (no colorInteropID), so nothing can be added without naming it");
    else if (tag.source == COLOUR_TAG_NONE)
        report_line(check->report, "\"%s\": note: the colour space is not said", check->file);
    exr_attr_int32(exr_attr_find(&check->picture.header->parts[0], CAU_ATTRIBUTE_COMPLETE), &complete);
    if (!complete)
        fault(check, "the render was stopped before it was complete (" CAU_ATTRIBUTE_COMPLETE " is 0)");
}

static cau_result check_open(Check *check) {
    CauError *err = check->report->err;
    CAU_TRY(picture_check_readable(&check->picture, err));
    CAU_TRY(lights_find(&check->lights, &check->picture, err));
    check_header(check);
    create_sums(check);
    for (size_t i = 0; i < check->picture.header->part_count; i++) CAU_TRY(check_part(check, i));
    check_sum(check);
    if (!check->faults) {
        report_line(check->report, "\"%s\": no fault found, %zu light%s", check->file, check->lights.count,
            check->lights.count == 1 ? "" : "s");
        return CAU_OK;
    }
    return error_set(err, CAU_ERROR_INPUT, "\"%s\": %" PRIu64 " fault%s found", check->file, check->faults,
        check->faults == 1 ? "" : "s");
}

cau_result report_check(const Report *report, const char *file) {
    Check check = {.report = report, .file = file};
    cau_result result = picture_open(&check.picture, file, report->err);
    if (result == CAU_OK) result = check_open(&check);
    free(check.sum);
    free(check.magnitude);
    lights_free(&check.lights);
    picture_close(&check.picture);
    return result;
}
