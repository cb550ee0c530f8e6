/* SPDX-License-Identifier: Apache-2.0 */
/* The sum: all terms in double, one rounding to the stored type. */
#include "composite/band.h"
#include "composite/job.h"
#include "core/checked.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <unistd.h>

/* Over the target's data window, pixel by pixel. */
typedef struct Sums {
    double *rgb;
    float *albedo; /* NULL without --albedo */
    size_t width, height;
    ExrBox window;
} Sums;

static const ExrPart *part_of(const Picture *p, const ExrLayer *layer) {
    return &p->header->parts[layer->part];
}

static cau_result create_sums(Job *job, Sums *out) {
    const ExrPart *part = part_of(&job->beauty, job->target);
    out->window = part->data_window;
    out->width = (size_t)exr_box_width(part->data_window);
    out->height = (size_t)exr_box_height(part->data_window);
    size_t pixels = out->width * out->height, each = 3 * sizeof(double) + (job->albedo ? 12 : 0) + 12;
    uint64_t memory = (uint64_t)sysconf(_SC_PHYS_PAGES) * (uint64_t)sysconf(_SC_PAGESIZE);
    if (pixels > memory / each)
        return error_set(job->err, CAU_ERROR_RESOURCE,
            "%zu x %zu pixels need %zu MB of memory, this machine has %" PRIu64 " MB", out->width,
            out->height, pixels / 1000000 * each, memory / 1000000);
    out->rgb = array_new(pixels, 3 * sizeof *out->rgb);
    out->albedo = job->albedo ? array_new(pixels, 3 * sizeof *out->albedo) : NULL;
    bool fits = out->rgb && (out->albedo || !job->albedo);
    for (int c = 0; c < 3; c++) {
        job->result[c] = array_new(pixels, exr_type_bytes(part->channels[job->target->rgb[c]].type));
        fits = fits && job->result[c];
    }
    return fits ? CAU_OK
                : error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for %zu x %zu pixels", out->width,
                      out->height);
}

typedef void BandFunction(
    Job *job, Sums *sums, const ExrPart *part, size_t index, const Band *band, int32_t y0, int32_t y1);

/* Calls f with every band of part `index`, reading the wanted channels. */
static cau_result for_bands(
    Job *job, Sums *sums, const Picture *picture, size_t index, const bool *wanted, BandFunction *f) {
    const ExrPart *part = &picture->header->parts[index];
    Band band;
    CAU_TRY(band_create(&band, part, wanted, job->err));
    cau_result result = CAU_OK;
    for (size_t b = 0; result == CAU_OK && b < exr_band_count(part); b++) {
        int32_t y0, y1;
        exr_band_at(part, b, &y0, &y1);
        result = job_poll(job);
        if (result == CAU_OK) result = exr_reader_band(picture->reader, index, y0, y1, band.planes, job->err);
        if (result == CAU_OK) f(job, sums, part, index, &band, y0, y1);
    }
    band_free(&band);
    return result;
}

/* One layer over some pixels of one row: `from` in the band, `to` in the sums. */
static void add_row(Job *job, Sums *sums, const Term *term, const ExrPart *part, const ExrLayer *layer,
    const Band *band, size_t from, size_t to, size_t count) {
    const double *m = term->matrix;
    for (size_t i = 0; i < count; i++) {
        double in[3], *sum = &sums->rgb[3 * (to + i)];
        for (int c = 0; c < 3; c++) {
            in[c] = sample_get(band->planes[layer->rgb[c]], from + i, part->channels[layer->rgb[c]].type);
            if (isfinite(in[c])) continue;
            in[c] = 0;
            job->repaired++;
        }
        for (int c = 0; c < 3; c++) {
            double v = term->diagonal ? m[4 * c] * in[c]
                                      : m[3 * c] * in[0] + m[3 * c + 1] * in[1] + m[3 * c + 2] * in[2];
            sum[c] += term->times_albedo ? v * (double)sums->albedo[3 * (to + i) + (size_t)c] : v;
        }
    }
}

static void add_band(
    Job *job, Sums *sums, const ExrPart *part, size_t index, const Band *band, int32_t y0, int32_t y1) {
    ExrBox from = part->data_window, to = sums->window;
    int64_t x0 = (int64_t)from.x0 - job->shift_x,
            x1 = (int64_t)from.x1 - job->shift_x; /* in the beauty's pixels */
    if (x0 < to.x0) x0 = to.x0;
    if (x1 > to.x1) x1 = to.x1;
    if (x0 > x1) return;
    size_t width = (size_t)exr_box_width(from);
    for (size_t t = 0; t < job->term_count; t++) {
        const ExrLayer *layer = &job->caustics.layers.layers[job->terms[t].layer];
        if (layer->part != index) continue;
        for (int64_t y = y0; y <= y1; y++) {
            int64_t row = y - job->shift_y;
            if (row < to.y0 || row > to.y1) continue;
            size_t source = (size_t)(y - y0) * width + (size_t)(x0 + job->shift_x - from.x0);
            size_t target = (size_t)(row - to.y0) * sums->width + (size_t)(x0 - to.x0);
            add_row(job, sums, &job->terms[t], part, layer, band, source, target, (size_t)(x1 - x0 + 1));
        }
    }
}

static cau_result add_terms(Job *job, Sums *sums) {
    for (size_t index = 0; index < job->caustics.header->part_count; index++) {
        const ExrPart *part = &job->caustics.header->parts[index];
        bool *wanted = array_new(part->channel_count, sizeof *wanted), any = false;
        if (!wanted) return error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for the list of channels");
        for (size_t t = 0; t < job->term_count; t++) {
            const ExrLayer *layer = &job->caustics.layers.layers[job->terms[t].layer];
            for (int c = 0; layer->part == index && c < 3; c++) any = wanted[layer->rgb[c]] = true;
        }
        cau_result result = any ? for_bands(job, sums, &job->caustics, index, wanted, add_band) : CAU_OK;
        free(wanted);
        CAU_TRY(result);
    }
    return CAU_OK;
}

static void keep_albedo(
    Job *job, Sums *sums, const ExrPart *part, size_t index, const Band *band, int32_t y0, int32_t y1) {
    (void)index;
    ExrBox from = part->data_window, to = sums->window;
    size_t width = (size_t)exr_box_width(from);
    for (int64_t y = y0; y <= y1; y++)
        for (int64_t x = from.x0; x <= from.x1; x++) {
            if (x < to.x0 || x > to.x1 || y < to.y0 || y > to.y1) continue;
            size_t at = (size_t)(y - to.y0) * sums->width + (size_t)(x - to.x0);
            for (int c = 0; c < 3; c++) {
                int channel = job->albedo->rgb[c];
                size_t sample = (size_t)(y - y0) * width + (size_t)(x - from.x0);
                double v = sample_get(band->planes[channel], sample, part->channels[channel].type);
                sums->albedo[3 * at + (size_t)c] = isfinite(v) ? (float)v : 0;
            }
        }
}

/* beauty + sum in the stored type. What is not changed keeps its bits: -0, NaN and infinities too. */
static void store(
    Job *job, void *out, const void *in, size_t to, size_t from, ExrPixelType type, double sum) {
    double beauty = sample_get(in, from, type), v = beauty + sum;
    bool half = type == EXR_TYPE_HALF;
    double largest = half ? (double)HALF_LARGEST : (double)FLT_MAX;
    size_t bytes = exr_type_bytes(type);
    if (sum == 0 || !isfinite(beauty)) {
        memcpy((char *)out + to * bytes, (const char *)in + from * bytes, bytes);
        return;
    }
    if (fabs(v) > largest) {
        v = copysign(largest, v);
        job->clamped++;
    }
    if (half)
        ((uint16_t *)out)[to] = half_from_double(v);
    else
        ((float *)out)[to] = (float)v;
}

static void finish_band(
    Job *job, Sums *sums, const ExrPart *part, size_t index, const Band *band, int32_t y0, int32_t y1) {
    (void)index;
    size_t first = (size_t)((int64_t)y0 - sums->window.y0) * sums->width;
    size_t count = (size_t)((int64_t)y1 - y0 + 1) * sums->width;
    for (int c = 0; c < 3; c++) {
        int channel = job->target->rgb[c];
        for (size_t i = 0; i < count; i++)
            store(job, job->result[c], band->planes[channel], first + i, i, part->channels[channel].type,
                sums->rgb[3 * (first + i) + (size_t)c]);
    }
}

static cau_result read_layer(Job *job, Sums *sums, const ExrLayer *layer, BandFunction *f) {
    const ExrPart *part = part_of(&job->beauty, layer);
    bool *wanted = array_new(part->channel_count, sizeof *wanted);
    if (!wanted) return error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for the list of channels");
    for (int c = 0; c < 3; c++) wanted[layer->rgb[c]] = true;
    cau_result result = for_bands(job, sums, &job->beauty, layer->part, wanted, f);
    free(wanted);
    return result;
}

cau_result job_add(Job *job) {
    Sums sums = {0};
    cau_result result = create_sums(job, &sums);
    if (result == CAU_OK && job->albedo) result = read_layer(job, &sums, job->albedo, keep_albedo);
    if (result == CAU_OK) result = add_terms(job, &sums);
    if (result == CAU_OK) result = read_layer(job, &sums, job->target, finish_band);
    free(sums.rgb);
    free(sums.albedo);
    if (result == CAU_OK && job->repaired)
        job_notice(job, "%" PRIu64 " NaN or infinite values of the caustics became 0", job->repaired);
    if (result == CAU_OK && job->clamped)
        job_notice(job, "%" PRIu64 " values were too large for the beauty's type and were cut", job->clamped);
    return result;
}
