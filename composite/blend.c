/* SPDX-License-Identifier: Apache-2.0 */
/* The sum: all terms in double, one rounding to the stored type. */
#include "composite/stream.h"
#include "image/exr_samples.h"

#include <float.h>
#include <math.h>

/* The lines of a lane by their use, three of each. */
typedef struct Lines {
    double *sum[3], *in[3], *albedo[3], *divisor[3], *holdout[3];
} Lines;

static Lines lines_of(const Lane *lane) {
    Lines lines;
    for (size_t c = 0; c < 3; c++) {
        lines.sum[c] = lane->lines + c * lane->width;
        lines.in[c] = lane->lines + (3 + c) * lane->width;
        lines.albedo[c] = lane->lines + (6 + c) * lane->width;
        lines.divisor[c] = lane->lines + (9 + c) * lane->width;
        lines.holdout[c] = lane->lines + (12 + c) * lane->width;
    }
    return lines;
}

static const ExrPart *target_part(const Job *job, const Target *target) {
    return &job->beauty.header->parts[target->layer->part];
}

static const ExrLayer *layer_of(const Job *job, const Term *term) {
    return &job->caustics.layers.layers[term->layer];
}

static bool concerns(const Target *target, const Term *term) {
    return target->light < 0 || (size_t)target->light == term->light;
}

cau_result blend_needed(const Job *job, const Target *target, Lane *lane, bool *needed, CauError *err) {
    ExrBox window = target_part(job, target)->data_window;
    size_t width = (size_t)exr_box_width(window);
    *needed = false;
    for (size_t t = 0; t < job->term_count; t++) {
        const Term *term = &job->terms[t];
        if (!concerns(target, term)) continue;
        CAU_TRY(source_load(&lane->caustics, layer_of(job, term)->part, err));
        *needed = *needed || source_any(&lane->caustics, layer_of(job, term), window.x0, width);
    }
    if (!*needed) return CAU_OK;
    if (job->albedo) CAU_TRY(source_load(&lane->beauty, job->albedo->part, err));
    if (target->divisor) CAU_TRY(source_load(&lane->beauty, target->divisor->part, err));
    return holdout_load(job, lane, err);
}

/* What is no number becomes 0; their count. */
static uint64_t repair(double *line, size_t count) {
    uint64_t bad = 0;
    for (size_t i = 0; i < count; i++)
        if (!(fabs(line[i]) <= DBL_MAX)) {
            line[i] = 0;
            bad++;
        }
    return bad;
}

static void apply_matrix(const Term *term, const Lines *l, size_t count) {
    const double *m = term->matrix;
    for (size_t i = 0; i < count; i++) {
        double r = l->in[0][i], g = l->in[1][i], b = l->in[2][i];
        for (int c = 0; c < 3; c++) l->in[c][i] = m[3 * c] * r + m[3 * c + 1] * g + m[3 * c + 2] * b;
    }
}

static void add_term(const Term *term, const Lines *l, size_t count) {
    if (!term->diagonal) apply_matrix(term, l, count);
    for (int c = 0; c < 3; c++) {
        double *sum = l->sum[c];
        const double *in = l->in[c], *albedo = l->albedo[c], m = term->diagonal ? term->matrix[4 * c] : 1;
        if (term->times_albedo)
            for (size_t i = 0; i < count; i++) sum[i] += m * in[i] * albedo[i];
        else
            for (size_t i = 0; i < count; i++) sum[i] += m * in[i];
    }
}

/* Cycles' diffuse passes are divided by the diffuse colour; where that is black they can hold no light. */
static void divide_row(
    const ExrLayer *divisor, const Lane *lane, const Lines *l, int64_t y, int64_t x0, size_t width) {
    for (int c = 0; c < 3; c++) {
        source_row(&lane->beauty, divisor->part, divisor->rgb[c], y, x0, width, l->divisor[c]);
        for (size_t i = 0; i < width; i++) {
            double d = l->divisor[c][i];
            l->sum[c][i] = d > 0 && d <= DBL_MAX ? l->sum[c][i] / d : 0;
        }
    }
}

/* All terms over one row of the target. */
static void sum_row(const Job *job, const Target *target, Lane *lane, const Lines *l, ExrBox window,
    int64_t y, size_t width) {
    memset(l->sum[0], 0, 3 * lane->width * sizeof(double));
    if (job->albedo)
        for (int c = 0; c < 3; c++) {
            source_row(
                &lane->beauty, job->albedo->part, job->albedo->rgb[c], y, window.x0, width, l->albedo[c]);
            repair(l->albedo[c], width);
        }
    for (size_t t = 0; t < job->term_count; t++) {
        const Term *term = &job->terms[t];
        const ExrLayer *layer = layer_of(job, term);
        if (!concerns(target, term)) continue;
        for (int c = 0; c < 3; c++) {
            source_row(&lane->caustics, layer->part, layer->rgb[c], y, window.x0, width, l->in[c]);
            uint64_t bad = repair(l->in[c], width);
            if (target == job->targets)
                lane->repaired += bad; /* once, though it may go into several passes */
        }
        add_term(term, l, width);
    }
    if (holdout_any(&job->holdout)) {
        double *left = l->holdout[0];
        holdout_row(job, lane, y, window.x0, width, left, l->holdout[1], l->holdout[2]);
        for (int c = 0; c < 3; c++)
            for (size_t i = 0; i < width; i++) l->sum[c][i] *= left[i];
    }
    if (target->divisor) divide_row(target->divisor, lane, l, y, window.x0, width);
}

/* beauty + sum in the stored type. What is not changed keeps its bits: -0, NaN and infinities too. */
static uint64_t store_row(uint8_t *row, const double *sum, size_t count, ExrPixelType type) {
    bool half = type == EXR_TYPE_HALF;
    double largest = half ? (double)HALF_LARGEST : (double)FLT_MAX;
    uint64_t clamped = 0;
    for (size_t i = 0; i < count; i++) {
        double beauty = exr_sample(row, i, type), v = beauty + sum[i];
        if (sum[i] == 0 || !isfinite(beauty)) continue;
        if (fabs(v) > largest) {
            v = copysign(largest, v);
            clamped++;
        }
        uint16_t h = half ? half_from_double(v) : 0;
        float f = (float)v;
        if (half)
            memcpy(row + i * sizeof h, &h, sizeof h);
        else
            memcpy(row + i * sizeof f, &f, sizeof f);
    }
    return clamped;
}

void blend_row(const Job *job, const Target *target, Lane *lane, int64_t y) {
    Lines lines = lines_of(lane);
    ExrBox window = target_part(job, target)->data_window;
    sum_row(job, target, lane, &lines, window, y, (size_t)exr_box_width(window));
}

cau_result blend_band(const Job *job, const Target *target, Lane *lane, CauError *err) {
    const ExrPart *part = target_part(job, target);
    const ExrLayer *layer = target->layer;
    const ExrRows *rows = &lane->beauty.rows[layer->part];
    Lines lines = lines_of(lane);
    size_t width = (size_t)exr_box_width(part->data_window);
    if (width > lane->width)
        return error_set(err, CAU_ERROR_INTERNAL, "a row of %zu pixels does not fit", width);
    for (int64_t y = rows->y0; y <= rows->y1; y++) {
        sum_row(job, target, lane, &lines, part->data_window, y, width);
        for (int c = 0; c < 3; c++) {
            size_t channel = (size_t)layer->rgb[c];
            lane->clamped += store_row(exr_rows_at(rows, y, exr_channel_offset(part, channel)), lines.sum[c],
                width, part->channels[channel].type);
        }
    }
    return CAU_OK;
}
