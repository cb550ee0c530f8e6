/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  add and write, band by band: what makes the output's pixels out of the inputs'. */
#ifndef COMPOSITE_STREAM_H
#define COMPOSITE_STREAM_H

#include "composite/source.h"

/** What one thread works with. */
typedef struct Lane {
    Source beauty, caustics;
    ExrEncoder *encoder;  /**< NULL when the writer takes rows only */
    ExrPacked packed;     /**< the band, ready for the file, unless... */
    const ExrRows *ready; /**< ...these rows are */
    double *lines;        /**< LANE_LINES lines of `width` numbers */
    size_t width;
    uint64_t repaired, clamped;
} Lane;

enum { LANE_LINES = 9 };

/** Whether the caustics change `target` in the band that was begun; loads what the answer needs. */
cau_result blend_needed(const Job *job, const Target *target, Lane *lane, bool *needed, CauError *err);
/** Adds to `target` in the loaded rows of its part. */
cau_result blend_band(const Job *job, const Target *target, Lane *lane, CauError *err);

/** Writes all pixels of `header`, whose parts are the beauty's, to `writer`. */
cau_result stream_run(Job *job, const ExrHeader *header, ExrWriter *writer);

#endif
