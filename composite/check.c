/* SPDX-License-Identifier: Apache-2.0 */
/* Reads every pixel of every part. Faults: what cannot be read, values that are no numbers, a sum that is not
 * the sum of its lights, a render that was stopped, windows that do not belong together, a colour space that
 * is not said or said twice. */
#include "composite/report.h"
#include "composite/source.h"
#include "core/checked.h"
#include "core/ordered.h"
#include "image/exr_samples.h"

#include <inttypes.h>
#include <math.h>

/* What one thread works with, and what it found in its band. */
typedef struct Desk {
    Source source;
    uint64_t *bad; /* per channel of all parts */
    uint64_t wrong;
    double *lines; /* sum, magnitude and one layer, `width` each */
} Desk;

typedef struct Check {
    const Report *report;
    const char *file;
    Picture picture;
    Lights lights;
    uint64_t faults;
    bool *together;        /* per part: read beside the first, in the same bands */
    size_t *first_of;      /* per part: its first channel's place in `bad` */
    size_t channels;       /* of all parts */
    const ExrLayer *total; /* NULL: there is none to check */
    size_t summed;         /* light layers in it */
    size_t part;           /* that is being read, with those that go together */
    ExrBands bands;
    Desk *desks;
    uint64_t *bad, wrong;
} Check;

static void fault(Check *check, const char *text) {
    check->faults++;
    report_line(check->report, "\"%s\": %s", check->file, text);
}

static cau_result no_memory(CauError *err) {
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for checking a picture");
}

static bool is_light(const Check *check, size_t layer) {
    for (size_t i = 0; i < check->lights.count; i++)
        if (check->lights.lights[i].radiance == (int)layer || check->lights.lights[i].indirect == (int)layer)
            return true;
    return false;
}

/* An output of `add` holds the beauty where caustics hold their total. */
static void find_total(Check *check) {
    const ExrPart *first = &check->picture.header->parts[0];
    const ExrLayers *layers = &check->picture.layers;
    if (exr_attr_find(first, CAU_ATTRIBUTE_MERGE)) return;
    for (size_t i = 0; i < layers->count; i++) {
        const ExrLayer *l = &layers->layers[i];
        if (l->part == 0 && l->bare && exr_layer_is_rgb(l)) check->total = l;
        check->summed += is_light(check, i) && check->together[l->part];
    }
    if (!check->summed) check->total = NULL;
}

static void count_bad(const ExrPart *part, const ExrRows *rows, uint64_t *bad) {
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

/* In half every layer and the total are rounded; in float only the order of the sum differs. */
static uint64_t count_wrong(const Check *check, const Desk *desk, int64_t y) {
    const ExrPart *part = &check->picture.header->parts[0];
    size_t width = (size_t)exr_box_width(part->data_window);
    double *sum = desk->lines, *magnitude = sum + width, *in = magnitude + width;
    bool half = part->channels[check->total->rgb[0]].type == EXR_TYPE_HALF;
    double n = (double)check->summed, relative = half ? 0x1p-10 : n * 0x1p-23,
           absolute = half ? (n + 1) * 0x1p-25 : 1e-37;
    uint64_t wrong = 0;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < width; i++) sum[i] = magnitude[i] = 0;
        for (size_t k = 0; k < check->picture.layers.count; k++) {
            const ExrLayer *l = &check->picture.layers.layers[k];
            double sign = l == check->total ? -1 : 1;
            if (l != check->total && !(is_light(check, k) && check->together[l->part])) continue;
            source_row(&desk->source, l->part, l->rgb[c], y, part->data_window.x0, width, in);
            for (size_t i = 0; i < width; i++) {
                sum[i] += sign * in[i];
                magnitude[i] += fabs(in[i]);
            }
        }
        for (size_t i = 0; i < width; i++)
            if (fabs(sum[i]) > relative * magnitude[i] / 2 + absolute) wrong++;
    }
    return wrong;
}

static cau_result work(void *data, size_t index, unsigned slot, CauError *err) {
    const Check *check = data;
    Desk *desk = &check->desks[slot];
    int32_t y0, y1;
    exr_band_at(&check->bands, index, &y0, &y1);
    source_begin(&desk->source, y0, y1);
    for (size_t i = 0; i < check->picture.header->part_count; i++) {
        if (i != check->part && !(check->part == 0 && check->together[i])) continue;
        CAU_TRY(source_load(&desk->source, i, err));
        count_bad(&check->picture.header->parts[i], &desk->source.rows[i], desk->bad + check->first_of[i]);
    }
    for (int64_t y = y0; check->part == 0 && check->total && y <= y1; y++)
        desk->wrong += count_wrong(check, desk, y);
    return CAU_OK;
}

static cau_result take(void *data, size_t index, unsigned slot, CauError *err) {
    Check *check = data;
    Desk *desk = &check->desks[slot];
    (void)index;
    (void)err;
    for (size_t c = 0; c < check->channels; c++) {
        check->bad[c] += desk->bad[c];
        desk->bad[c] = 0;
    }
    check->wrong += desk->wrong;
    desk->wrong = 0;
    return CAU_OK;
}

/* As many as fit: a file may ask for much. */
static unsigned desk_count(const Check *check) {
    size_t memory = (size_t)256 << 20, each = 0;
    const ExrHeader *header = check->picture.header;
    for (size_t i = 0; i < header->part_count; i++)
        each += (size_t)exr_box_width(header->parts[i].data_window) *
                (size_t)exr_band_rows(&header->parts[i]) * exr_part_pixel_bytes(&header->parts[i]) * 3;
    unsigned count = ordered_processors() + 2;
    while (count > 1 && each > memory / count) count--;
    return count;
}

static cau_result create_desks(Check *check, unsigned count) {
    CauError *err = check->report->err;
    size_t width = (size_t)exr_box_width(check->picture.header->parts[0].data_window);
    check->desks = array_new(count, sizeof *check->desks);
    check->bad = array_new(check->channels, sizeof *check->bad);
    if (!check->desks || !check->bad) return no_memory(err);
    for (unsigned i = 0; i < count; i++) {
        Desk *desk = &check->desks[i];
        desk->bad = array_new(check->channels, sizeof *desk->bad);
        desk->lines = array_new(3 * width, sizeof *desk->lines);
        if (!desk->bad || !desk->lines) return no_memory(err);
        CAU_TRY(source_create(&desk->source, &check->picture, 0, 0, err));
    }
    return CAU_OK;
}

static void free_desks(Check *check, unsigned count) {
    for (unsigned i = 0; check->desks && i < count; i++) {
        source_free(&check->desks[i].source);
        free(check->desks[i].bad);
        free(check->desks[i].lines);
    }
    free(check->desks);
}

static cau_result read_all(Check *check) {
    const ExrHeader *header = check->picture.header;
    unsigned count = desk_count(check);
    int rows = 0;
    cau_result result = create_desks(check, count);
    for (size_t i = 0; i < header->part_count; i++)
        if (check->together[i] && exr_band_rows(&header->parts[i]) > rows)
            rows = exr_band_rows(&header->parts[i]);
    for (size_t i = 0; result == CAU_OK && i < header->part_count; i++) {
        if (i && check->together[i]) continue;
        check->part = i;
        check->bands = exr_bands(&header->parts[i], i ? exr_band_rows(&header->parts[i]) : rows);
        result = ordered_run(count > 2 ? count - 2 : 1, count, check->bands.count, work, take, NULL, check,
            check->report->err);
    }
    free_desks(check, count);
    return result;
}

static void tell_pixels(Check *check) {
    const ExrHeader *header = check->picture.header;
    for (size_t i = 0; i < header->part_count; i++)
        for (size_t c = 0; c < header->parts[i].channel_count; c++) {
            uint64_t bad = check->bad[check->first_of[i] + c];
            if (!bad) continue;
            check->faults++;
            report_line(check->report, "\"%s\": channel %s has %" PRIu64 " values that are NaN or infinite",
                check->file, header->parts[i].channels[c].name, bad);
        }
    if (!check->wrong) return;
    ExrBox w = header->parts[0].data_window;
    check->faults++;
    report_line(check->report,
        "\"%s\": the first part is not the sum of the %zu light layers in %" PRIu64 " of %" PRId64 " values",
        check->file, check->summed, check->wrong, 3 * exr_box_width(w) * exr_box_height(w));
}

static void check_tags(Check *check) {
    ColourTag tag;
    const ExrHeader *header = check->picture.header;
    size_t part = picture_colour_part(&check->picture, &check->lights);
    colour_tag_read(&tag, header, part);
    if (tag.source == COLOUR_TAG_NONE && check->lights.count)
        fault(check,
            "the colour space is not said (no colorInteropID), so nothing can be added without naming it");
    else if (tag.source == COLOUR_TAG_NONE)
        report_line(check->report, "\"%s\": note: the colour space is not said", check->file);
    ColourTag other;
    if (!colour_tag_other(&other, header, part, &tag)) return;
    check->faults++;
    report_line(check->report, "\"%s\": the colour space is said twice: %s by %s, %s by %s", check->file,
        tag.id, report_tag_source((int)tag.source), other.id, report_tag_source((int)other.source));
}

static void check_windows(Check *check) {
    const ExrHeader *header = check->picture.header;
    for (size_t i = 1; i < header->part_count; i++) {
        const ExrPart *part = &header->parts[i];
        if (!exr_box_equal(part->display_window, header->parts[0].display_window)) {
            check->faults++;
            report_line(
                check->report, "\"%s\": part %zu has another display window than the first", check->file, i);
        }
    }
    for (size_t k = 0; k < check->picture.layers.count; k++) {
        const ExrLayer *l = &check->picture.layers.layers[k];
        if (!check->lights.count || !is_light(check, k) || check->together[l->part] ||
            exr_attr_find(&header->parts[0], CAU_ATTRIBUTE_MERGE))
            continue;
        check->faults++;
        report_line(check->report, "\"%s\": layer %s has another data window than the first part",
            check->file, exr_layer_shown(l));
    }
}

static void check_complete(Check *check) {
    int32_t complete = 1;
    exr_attr_int32(exr_attr_find(&check->picture.header->parts[0], CAU_ATTRIBUTE_COMPLETE), &complete);
    if (!complete)
        fault(check, "the render was stopped before it was complete (" CAU_ATTRIBUTE_COMPLETE " is 0)");
}

static cau_result plan(Check *check) {
    const ExrHeader *header = check->picture.header;
    check->together = array_new(header->part_count, sizeof *check->together);
    check->first_of = array_new(header->part_count, sizeof *check->first_of);
    if (!check->together || !check->first_of) return no_memory(check->report->err);
    for (size_t i = 0; i < header->part_count; i++) {
        check->together[i] = exr_box_equal(header->parts[i].data_window, header->parts[0].data_window);
        check->first_of[i] = check->channels;
        check->channels += header->parts[i].channel_count;
    }
    return CAU_OK;
}

static cau_result check_open(Check *check) {
    CauError *err = check->report->err;
    CAU_TRY(picture_check_readable(&check->picture, err));
    CAU_TRY(lights_find(&check->lights, &check->picture, err));
    CAU_TRY(plan(check));
    find_total(check);
    check_tags(check);
    check_complete(check);
    check_windows(check);
    CAU_TRY(read_all(check));
    tell_pixels(check);
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
    free(check.together);
    free(check.first_of);
    free(check.bad);
    lights_free(&check.lights);
    picture_close(&check.picture);
    return result;
}
