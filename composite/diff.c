/* SPDX-License-Identifier: Apache-2.0 */
/* In what do two files differ? */
#include "composite/report.h"
#include "composite/source.h"
#include "image/exr_samples.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

typedef struct Diff {
    const Report *report;
    const char *names[2];
    Picture pictures[2];
    Source sources[2];
    uint64_t differences;
} Diff;

static bool same_attr(const ExrAttr *a, const ExrAttr *b) {
    return strcmp(a->type, b->type) == 0 && a->size == b->size && memcmp(a->data, b->data, a->size) == 0;
}

static const ExrPart *same_part(const ExrHeader *header, const ExrPart *part, size_t index) {
    for (size_t i = 0; part->name && i < header->part_count; i++)
        if (header->parts[i].name && strcmp(header->parts[i].name, part->name) == 0) return &header->parts[i];
    return index < header->part_count ? &header->parts[index] : NULL;
}

static void diff_attrs(Diff *d, const ExrPart *a, const ExrPart *b, bool values, const char *only) {
    for (size_t i = 0; i < a->attr_count; i++) {
        const ExrAttr *other = exr_attr_find(b, a->attrs[i].name);
        if (other && (!values || same_attr(&a->attrs[i], other))) continue;
        d->differences++;
        if (other)
            report_line(d->report, "attribute %s differs", a->attrs[i].name);
        else
            report_line(d->report, "attribute %s is in \"%s\" only", a->attrs[i].name, only);
    }
}

static void diff_parts(Diff *d) {
    const ExrHeader *a = d->pictures[0].header, *b = d->pictures[1].header;
    if (a->part_count != b->part_count) {
        d->differences++;
        report_line(d->report, "%zu parts against %zu", a->part_count, b->part_count);
    }
    for (size_t i = 0; i < a->part_count; i++) {
        const ExrPart *p = &a->parts[i], *q = same_part(b, p, i);
        if (!q) continue;
        diff_attrs(d, p, q, true, d->names[0]);
        diff_attrs(d, q, p, false, d->names[1]);
        bool windows = exr_box_equal(p->data_window, q->data_window) &&
                       exr_box_equal(p->display_window, q->display_window);
        if (windows && p->codec == q->codec && p->tiled == q->tiled && p->order == q->order) continue;
        d->differences++;
        report_line(d->report,
            "part %zu: data (%d,%d)-(%d,%d), %s, %s against data (%d,%d)-(%d,%d), %s, %s%s", i,
            p->data_window.x0, p->data_window.y0, p->data_window.x1, p->data_window.y1,
            exr_codec_name(p->codec), p->tiled ? "tiles" : "scan lines", q->data_window.x0, q->data_window.y0,
            q->data_window.x1, q->data_window.y1, exr_codec_name(q->codec), q->tiled ? "tiles" : "scan lines",
            windows ? "" : ", or other display windows");
    }
}

static bool find_in_part(const ExrPart *part, const char *name, size_t *channel) {
    for (*channel = 0; *channel < part->channel_count; ++*channel)
        if (strcmp(part->channels[*channel].name, name) == 0) return true;
    return false;
}

/* The channel of that name in the part that is the same as part `from` of `of`, else in any; false when there
 * is none. */
static bool find_channel(const ExrHeader *header, const ExrHeader *of, size_t from, const char *name,
    size_t *part, size_t *channel) {
    const ExrPart *same = same_part(header, &of->parts[from], from);
    *part = same ? (size_t)(same - header->parts) : 0;
    if (same && find_in_part(same, name, channel)) return true;
    for (*part = 0; *part < header->part_count; ++*part)
        if (find_in_part(&header->parts[*part], name, channel)) return true;
    return false;
}

/* Differing samples of one channel. */
typedef struct Count {
    uint64_t differing, samples;
    double largest;
    int64_t x, y;
} Count;

static void count_row(Count *count, const uint8_t *a, const uint8_t *b, size_t width, ExrPixelType type,
    int64_t x0, int64_t y) {
    size_t bytes = exr_type_bytes(type);
    count->samples += width;
    if (memcmp(a, b, width * bytes) == 0) return;
    for (size_t i = 0; i < width; i++) {
        if (memcmp(a + i * bytes, b + i * bytes, bytes) == 0) continue;
        double difference = fabs(exr_sample(a, i, type) - exr_sample(b, i, type));
        count->differing++;
        if (!(difference > count->largest) && count->differing > 1) continue;
        count->largest = difference;
        count->x = x0 + (int64_t)i;
        count->y = y;
    }
}

static void tell(Diff *d, const char *name, const Count *count) {
    if (!count->differing) return;
    d->differences++;
    report_line(d->report,
        "channel %s: %" PRIu64 " of %" PRIu64 " samples differ, by at most %g at (%" PRId64 ",%" PRId64 ")",
        name, count->differing, count->samples, count->largest, count->x, count->y);
}

/* All channels of part `part` of the first file that both have in the same type and window. */
static cau_result diff_pixels(Diff *d, size_t part) {
    const ExrPart *p = &d->pictures[0].header->parts[part];
    CauError *err = d->report->err;
    ExrBands bands = exr_bands(p, exr_band_rows(p));
    Count *counts = calloc(p->channel_count + 1, sizeof *counts);
    if (!counts)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu channels", p->channel_count);
    cau_result result = CAU_OK;
    for (size_t b = 0; result == CAU_OK && b < bands.count; b++) {
        int32_t y0, y1;
        exr_band_at(&bands, b, &y0, &y1);
        for (int k = 0; k < 2; k++) source_begin(&d->sources[k], y0, y1);
        result = source_load(&d->sources[0], part, err);
        for (size_t c = 0; result == CAU_OK && c < p->channel_count; c++) {
            size_t other, channel;
            if (!find_channel(d->pictures[1].header, d->pictures[0].header, part, p->channels[c].name, &other,
                    &channel))
                continue;
            const ExrPart *q = &d->pictures[1].header->parts[other];
            if (q->channels[channel].type != p->channels[c].type ||
                !exr_box_equal(p->data_window, q->data_window))
                continue;
            result = source_load(&d->sources[1], other, err);
            for (int64_t y = y0; result == CAU_OK && y <= y1; y++)
                count_row(&counts[c], exr_rows_at(&d->sources[0].rows[part], y, exr_channel_offset(p, c)),
                    exr_rows_at(&d->sources[1].rows[other], y, exr_channel_offset(q, channel)),
                    (size_t)exr_box_width(p->data_window), p->channels[c].type, p->data_window.x0, y);
        }
    }
    for (size_t c = 0; result == CAU_OK && c < p->channel_count; c++)
        tell(d, p->channels[c].name, &counts[c]);
    free(counts);
    return result;
}

static const char *type_name(ExrPixelType type) {
    return type == EXR_TYPE_HALF ? "half" : type == EXR_TYPE_FLOAT ? "float" : "uint";
}

/* Channels that one file lacks, or has in another type. */
static void diff_channels(Diff *d, int from) {
    const ExrHeader *a = d->pictures[from].header, *b = d->pictures[1 - from].header;
    for (size_t i = 0; i < a->part_count; i++)
        for (size_t c = 0; c < a->parts[i].channel_count; c++) {
            const ExrChannel *channel = &a->parts[i].channels[c];
            size_t part, at;
            if (!find_channel(b, a, i, channel->name, &part, &at)) {
                d->differences++;
                report_line(d->report, "channel %s is in \"%s\" only", channel->name, d->names[from]);
            } else if (!from && b->parts[part].channels[at].type != channel->type) {
                d->differences++;
                report_line(d->report, "channel %s: %s against %s", channel->name, type_name(channel->type),
                    type_name(b->parts[part].channels[at].type));
            }
        }
}

static cau_result diff_open(Diff *d) {
    CauError *err = d->report->err;
    for (int k = 0; k < 2; k++) {
        CAU_TRY(picture_open(&d->pictures[k], d->names[k], err));
        CAU_TRY(picture_check_readable(&d->pictures[k], err));
        CAU_TRY(source_create(&d->sources[k], &d->pictures[k], 0, 0, err));
    }
    diff_parts(d);
    diff_channels(d, 0);
    diff_channels(d, 1);
    for (size_t i = 0; i < d->pictures[0].header->part_count; i++) CAU_TRY(diff_pixels(d, i));
    if (!d->differences) {
        report_line(d->report, "no difference");
        return CAU_OK;
    }
    return error_set(err, CAU_ERROR_INPUT, "\"%s\" and \"%s\" differ in %" PRIu64 " place%s", d->names[0],
        d->names[1], d->differences, d->differences == 1 ? "" : "s");
}

cau_result report_diff(const Report *report, const char *a, const char *b) {
    Diff d = {.report = report, .names = {a, b}};
    cau_result result = diff_open(&d);
    for (int k = 0; k < 2; k++) {
        if (d.sources[k].picture) source_free(&d.sources[k]);
        picture_close(&d.pictures[k]);
    }
    return result;
}
