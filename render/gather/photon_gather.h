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
    double radius_pixels; /**< kernel radius in pixel footprints, times that of the pixel in `radius` */
    double first_pixels;  /**< the same of the first pass, which tells wide kernels; 0: there are none */
    const float *radius;  /**< [pixel]; NULL: 1 everywhere */
    int step;             /**< every so many pixels along x and y alone; 0: all */
    const atomic_bool *cancel;
} GatherRun;

/** The radius of every eye point's kernel. What surface is under it is found when the first photon asks:
 * where no light is, most points never do. */
cau_result gather_supports(const GatherRun *run, TaskPool *pool, SupportRows *out, CauError *err);
void support_rows_free(SupportRows *rows);

/** What the kernels of one pass of one layer say about themselves, per pixel. */
typedef struct KernelImages {
    /** 3 channels: twice the estimate less that of radius r / sqrt(2) over the same photons. Where the light
     * is smooth a kernel's bias goes as the square of its radius, so this estimates it. */
    double *bias;
    double *cost; /**< 1 channel: deposits met by an eye point; where each asks for a ray, GATHER_RAY_COST */
} KernelImages;

/** A ray costs as much as this many deposits. */
#define GATHER_RAY_COST 2.0

/** One pass of one layer, per pixel (width * height * 3 doubles each). */
typedef struct PassImages {
    double *radiance; /**< what is added; NULL: not wanted */
    double *seen;     /**< the part that is seen through glass or in mirrors; NULL: not wanted */
    double *spread;   /**< 1 channel: of that part, the eye paths' squares (of their channels' mean), each as
                           a share of the pixel; NULL: not wanted */
    double *irradiance;    /**< at receivers that the camera hits first; NULL: not wanted */
    double *coverage;      /**< 1 channel: share of the pixel that such receivers cover; NULL: not wanted */
    KernelImages *kernels; /**< what the kernels say about themselves; NULL: not wanted */
    bool add;              /**< true: added to what is there (lights of one group), else overwritten */
} PassImages;

/** An eye point's radiance into `spread`. */
static inline void spread_add(double *spread, uint32_t pixel, Rgb radiance) {
    if (spread) spread[pixel] += square((radiance.r + radiance.g + radiance.b) / 3);
}

/** Sums the deposits in `tree` at every eye point; finds the supports that it needs, for further trees too.
 */
cau_result gather_photons(const GatherRun *run, SupportRows *supports, const PhotonTree *tree, TaskPool *pool,
    const PassImages *out, CauError *err);

#endif
