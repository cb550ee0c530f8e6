/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Eye paths of the photon estimator: E (S|G)* D. What each pixel sees, through glass and in mirrors too. */
#ifndef RENDER_TRACE_EYE_H
#define RENDER_TRACE_EYE_H

#include "core/tasks.h"
#include "render/trace/camera.h"
#include "render/trace/path.h"

#include <stdatomic.h>

/** A receiver that a pixel sees. */
typedef struct EyePoint {
    V3 position;
    float ng[3];     /**< unit, on the eye's side */
    float weight[3]; /**< radiance at the pixel per irradiance here: throughput * albedo / pi * exposure */
    float size;      /**< edge of the pixel's footprint, scene units */
    float share;     /**< of the eye path in its pixel: 1 / samples */
    float turn;      /**< a uniform number, for turning the places at which its surroundings are probed */
    int16_t from[2]; /**< direction it is seen from, as of normal_encode() */
    uint32_t pixel;
    int object;
    uint32_t primitive;
    uint8_t glossy, transmission; /**< scatterings between this receiver and the eye */
    bool straight;                /**< the camera hits it first: nothing in between */
} EyePoint;

/** The eye points of one pass, row by row. Zero-initialise. */
typedef struct EyePoints {
    struct EyeRow {
        EyePoint *items;
        size_t count, capacity;
        bool out_of_memory;
    } * rows;
    int height;
} EyePoints;

typedef struct EyeRun {
    const Scene *scene;
    const TraceScene *trace;
    const PixelFilter *filter;
    bool physical;
    uint64_t key;     /**< random stream of the whole render */
    uint32_t pass;    /**< pass * samples is the index in each pixel's low-discrepancy sequence */
    uint32_t samples; /**< eye paths per pixel */
    const bool
        *busy; /**< [pixel] the eye may see a receiver through glass or in a mirror there; NULL: not known */
    uint32_t samples_busy;   /**< eye paths of a busy pixel */
    const uint8_t *at_least; /**< [pixel] eye paths of each, if there are not more; NULL: no matter */
    const EyePoints *base; /**< of the same run without at_least: copied where they will do; with at_least */
    int x0, y0, x1, y1;    /**< region in pixels, x1 and y1 exclusive */
    const atomic_bool *cancel;
} EyeRun;

cau_result eye_trace(const EyeRun *run, TaskPool *pool, EyePoints *out, CauError *err);
void eye_points_free(EyePoints *points);

#endif
