/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  add and write, band by band: what makes the output's pixels out of the inputs'. */
#ifndef COMPOSITE_STREAM_H
#define COMPOSITE_STREAM_H

#include "composite/source.h"

/** What one thread works with. */
typedef struct Lane {
    Source beauty, caustics, mask;
    ExrEncoder *encoder;  /**< NULL when the writer takes rows only */
    ExrPacked packed;     /**< the band, ready for the file, unless... */
    const ExrRows *ready; /**< ...these rows are */
    ExrRows kept;         /**< of a layer that travels */
    double *lines;        /**< LANE_LINES lines of `width` numbers */
    size_t width;
    uint64_t repaired, clamped;
} Lane;

enum { LANE_LINES = 15 };

/** Whether the caustics change `target` in the band that was begun; loads what the answer needs. */
cau_result blend_needed(const Job *job, const Target *target, Lane *lane, bool *needed, CauError *err);
/** Adds to `target` in the loaded rows of its part. */
cau_result blend_band(const Job *job, const Target *target, Lane *lane, CauError *err);

/** Leaves what is added to row y of `target` in the first three lines, RGB; after blend_needed(). */
void blend_row(const Job *job, const Target *target, Lane *lane, int64_t y);
/** Memory for one band at a time, without an encoder. */
cau_result lane_create(Lane *lane, const Job *job, CauError *err);
void lane_free(Lane *lane);

/** Loads what holdout_row() reads. */
cau_result holdout_load(const Job *job, Lane *lane, CauError *err);
/** How much light is left at row y, 1 to 0; `id`, `coverage` are scratch. */
void holdout_row(const Job *job, const Lane *lane, int64_t y, int64_t x0, size_t count, double *left,
    double *id, double *coverage);

/** Makes rows y0..y1 of kept layer `index`: lane->packed, or rows when the writer takes those only. */
cau_result keep_band(
    const Job *job, const ExrHeader *header, size_t index, Lane *lane, int32_t y0, int32_t y1, CauError *err);

/** Writes all pixels of `header`, whose parts are the beauty's and the kept layers', to `writer`. */
cau_result stream_run(Job *job, const ExrHeader *header, ExrWriter *writer);

#endif
