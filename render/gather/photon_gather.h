/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Estimator P: the density of photons at what each pixel sees (progressive photon mapping; Hachisuka et al.
 *  2008; the radius schedule without per-point statistics is Knaus and Zwicker 2011).
 *
 *  Gathered, not splatted: one pixel is summed by one thread in a fixed order, without atomics. */
#ifndef RENDER_GATHER_PHOTON_GATHER_H
#define RENDER_GATHER_PHOTON_GATHER_H

#include "render/gather/photon_tree.h"
#include "render/gather/support.h"

/** Supports of a pass's eye points at one radius, in the order of the points. Zero-initialise. */
typedef struct SupportRows {
    struct SupportRow {
        Support *items;
        size_t count, capacity;
        bool out_of_memory;
    } * rows;
    int height;
} SupportRows;

typedef struct GatherRun {
    const Scene *scene;
    const TraceScene *trace;
    const EyePoints *points;
    int y0, y1;
    double radius_pixels; /**< kernel radius in pixel footprints */
    const atomic_bool *cancel;
} GatherRun;

/** Finds the surface under every eye point's kernel. */
cau_result gather_supports(const GatherRun *run, TaskPool *pool, SupportRows *out, CauError *err);
void support_rows_free(SupportRows *rows);

/** One pass of one layer, per pixel (width * height * 3 doubles each). */
typedef struct PassImages {
    double *radiance;   /**< what is added */
    double *seen;       /**< the part that is seen through glass or in mirrors; NULL: not wanted */
    double *irradiance; /**< at receivers that the camera hits first; NULL: not wanted */
    double *coverage;   /**< 1 channel: share of the pixel that such receivers cover; NULL: not wanted */
    bool add;           /**< true: added to what is there (lights of one group), else overwritten */
    uint64_t *found;    /**< [height] deposits met by the kernels of each row */
} PassImages;

/** Sums the deposits in `tree` at every eye point. */
cau_result gather_photons(const GatherRun *run, const SupportRows *supports, const PhotonTree *tree,
    TaskPool *pool, const PassImages *out, CauError *err);

#endif
