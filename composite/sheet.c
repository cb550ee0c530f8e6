/* SPDX-License-Identifier: Apache-2.0 */
/* The contact sheet: before, what each light adds, their sum, after; small, side by side, with names. */
#include "composite/picture_file.h"
#include "composite/preview.h"
#include "composite/stream.h"
#include "core/checked.h"
#include "image/exr_samples.h"

#include <math.h>
#include <stdio.h>

enum { LARGEST_CELL = 480, BORDER = 4, BAR = LABEL_HEIGHT + 8 };

typedef struct Sheet {
    const Job *job;
    size_t cells;         /* before, the lights, sum, after */
    size_t width, height; /* of a cell's picture */
    size_t columns, rows; /* of cells */
    size_t shrink;        /* pixels of the picture per pixel of the cell */
    double *sums;         /* cell by cell, interleaved RGB */
    Lane lane;
} Sheet;

static cau_result no_memory(const Sheet *s) {
    return error_set(
        s->job->err, CAU_ERROR_RESOURCE, "out of memory for a contact sheet of %zu pictures", s->cells);
}

static const ExrPart *part_of(const Sheet *s) { return &s->job->beauty.header->parts[s->job->target->part]; }

static cau_result plan(Sheet *s) {
    size_t width = (size_t)exr_box_width(part_of(s)->data_window),
           height = (size_t)exr_box_height(part_of(s)->data_window),
           longest = width > height ? width : height;
    s->cells = s->job->lights.count + 3;
    s->shrink = (longest + LARGEST_CELL - 1) / LARGEST_CELL;
    s->width = (width + s->shrink - 1) / s->shrink;
    s->height = (height + s->shrink - 1) / s->shrink;
    s->columns = 1;
    while (s->columns * s->columns < s->cells) s->columns++;
    s->rows = (s->cells + s->columns - 1) / s->columns;
    s->sums = array_new(s->cells * s->width * s->height, 3 * sizeof *s->sums);
    if (!s->sums) return no_memory(s);
    return lane_create(&s->lane, s->job, s->job->err);
}

static void collect(Sheet *s, size_t cell, int64_t y, const double *const rgb[3]) {
    ExrBox window = part_of(s)->data_window;
    size_t width = (size_t)exr_box_width(window), row = (size_t)(y - window.y0) / s->shrink;
    double *out = s->sums + 3 * (cell * s->width * s->height + row * s->width);
    for (size_t i = 0; i < width; i++)
        for (size_t c = 0; c < 3; c++)
            if (isfinite(rgb[c][i])) out[3 * (i / s->shrink) + c] += rgb[c][i];
}

/* Lines 0 to 2 of the lane hold a sum, lines 3 to 5 are free after it. */
static cau_result collect_band(Sheet *s, int64_t y0, int64_t y1) {
    const Job *job = s->job;
    Lane *lane = &s->lane;
    size_t part = job->target->part, width = (size_t)exr_box_width(part_of(s)->data_window);
    const double *sum[3], *in[3];
    for (size_t c = 0; c < 3; c++) {
        sum[c] = lane->lines + c * lane->width;
        in[c] = lane->lines + (3 + c) * lane->width;
    }
    source_begin(&lane->beauty, y0, y1);
    source_begin(&lane->caustics, y0, y1);
    if (lane->mask.decoder) source_begin(&lane->mask, y0, y1);
    CAU_TRY(source_load(&lane->beauty, part, job->err));
    for (size_t cell = 0; cell < s->cells - 1; cell++) {
        bool last = cell == s->cells - 2, first = cell == 0, any = false;
        Target target = {.layer = job->target, .light = last ? -1 : (int)cell - 1};
        if (!first) CAU_TRY(blend_needed(job, &target, lane, &any, job->err));
        for (int64_t y = y0; y <= y1; y++) {
            if (any) {
                blend_row(job, &target, lane, y);
                collect(s, cell, y, sum);
                if (last) collect(s, cell + 1, y, sum);
            }
            if (!first) continue;
            for (int c = 0; c < 3; c++)
                source_row(&lane->beauty, part, job->target->rgb[c], y, part_of(s)->data_window.x0, width,
                    lane->lines + (3 + (size_t)c) * lane->width);
            collect(s, 0, y, in);
            collect(s, s->cells - 1, y, in);
        }
    }
    return CAU_OK;
}

static const char *name_of(const Sheet *s, size_t cell) {
    if (cell == 0) return "before";
    if (cell == s->cells - 1) return "after";
    if (cell == s->cells - 2) return "sum";
    return s->job->lights.lights[cell - 1].name;
}

/* Averages of the pixels that fell into each. */
static void fill_cell(const Sheet *s, size_t cell, float *out) {
    size_t width = (size_t)exr_box_width(part_of(s)->data_window),
           height = (size_t)exr_box_height(part_of(s)->data_window);
    const double *sums = s->sums + 3 * cell * s->width * s->height;
    for (size_t y = 0; y < s->height; y++)
        for (size_t x = 0; x < s->width; x++) {
            size_t w = width - x * s->shrink, h = height - y * s->shrink;
            double count = (double)((w < s->shrink ? w : s->shrink) * (h < s->shrink ? h : s->shrink));
            for (size_t c = 0; c < 3; c++)
                out[3 * (y * s->width + x) + c] = (float)(sums[3 * (y * s->width + x) + c] / count);
        }
}

static cau_result draw(const Sheet *s) {
    size_t step_x = s->width + BORDER, step_y = s->height + BAR + BORDER;
    size_t width = s->columns * step_x + BORDER, height = s->rows * step_y + BORDER;
    uint8_t *page = array_new(width * height, 3), *shown = array_new(s->width * s->height, 3);
    float *cell_rgb = array_new(s->width * s->height, 3 * sizeof *cell_rgb);
    cau_result result = page && shown && cell_rgb ? CAU_OK : no_memory(s);
    if (result == CAU_OK) memset(page, 32, 3 * width * height);
    for (size_t cell = 0; result == CAU_OK && cell < s->cells; cell++) {
        size_t x = BORDER + cell % s->columns * step_x, y = BORDER + cell / s->columns * step_y;
        fill_cell(s, cell, cell_rgb);
        result = preview_show(s->job, cell_rgb, s->width, s->height, shown);
        for (size_t row = 0; row < s->height; row++)
            memcpy(page + 3 * ((y + row) * width + x), shown + 3 * row * s->width, 3 * s->width);
        char name[LARGEST_CELL / LABEL_STEP + 1];
        snprintf(name, s->width / LABEL_STEP + 1, "%s", name_of(s, cell));
        label_draw(page, width, height, x, y + s->height + 4, name);
    }
    if (result == CAU_OK)
        result = preview_save(s->job->options->contact_sheet, page, width, height, s->job->err);
    free(page);
    free(shown);
    free(cell_rgb);
    return result;
}

cau_result sheet_write(const Job *job) {
    Sheet s = {.job = job};
    cau_result result = plan(&s);
    ExrBands bands = exr_bands(part_of(&s), exr_band_rows(part_of(&s)));
    for (size_t b = 0; result == CAU_OK && b < bands.count; b++) {
        int32_t y0, y1;
        exr_band_at(&bands, b, &y0, &y1);
        result = job_poll(job);
        if (result == CAU_OK) result = collect_band(&s, y0, y1);
    }
    if (result == CAU_OK) result = draw(&s);
    lane_free(&s.lane);
    free(s.sums);
    return result;
}
