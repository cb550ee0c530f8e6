/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  One picture as the rows of a band of the beauty see it: aligned by pixel coordinate, 0 outside. */
#ifndef COMPOSITE_SOURCE_H
#define COMPOSITE_SOURCE_H

#include "composite/job.h"

typedef struct Source {
    const Picture *picture;
    ExrDecoder *decoder;
    ExrRows *rows;            /**< per part */
    bool *loaded;             /**< per part, for the present band; false too where the band lies outside */
    int64_t shift_x, shift_y; /**< its pixel = the beauty's pixel + shift */
    int64_t y0, y1;           /**< the band, in the beauty's pixels */
} Source;

cau_result source_create(
    Source *out, const Picture *picture, int64_t shift_x, int64_t shift_y, CauError *err);
/** Safe on a zeroed source. */
void source_free(Source *source);

/** Begins with rows y0..y1 of the beauty: nothing of them is loaded yet. */
void source_begin(Source *source, int64_t y0, int64_t y1);
/** Reads the band's rows of a part, unless they are there already. */
cau_result source_load(Source *source, size_t part, CauError *err);
/** Samples of a loaded channel at row y over columns x0.. of the beauty; 0 outside its window. */
void source_row(
    const Source *source, size_t part, int channel, int64_t y, int64_t x0, size_t count, double *out);
/** Whether any bit of the layer's R, G, B is set in the loaded band within columns x0.. of the beauty. */
bool source_any(const Source *source, const ExrLayer *layer, int64_t x0, size_t count);

#endif
