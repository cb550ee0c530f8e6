/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Estimator W: a connected wavefront of light rays, whose flux is spread exactly over where it lands.
 *
 *  Light towards a caster is a grid of rays. Each ray is followed through every smooth reflection and
 *  refraction; a triangle of the grid whose three corners took the same path lands as a triangle on the
 *  receiver with the grid triangle's own flux (beam tracing: Heckbert and Hanrahan 1984; caustic polygons:
 *  Watt 1990; flux over area on an adaptively split grid of this kind is measured in docs/accuracy.md). No
 *  kernel, no random photon: folds stay finite because a pixel gets flux by area overlap.
 *
 *  What the corners of a triangle do not agree on is split, and at the finest level left to photons, which
 *  carry only paths that no triangle claimed: each path is in exactly one of the two. Paths with a rough
 *  scattering or a mirror whose normal is seen bent (bent.h), and light from diffuse surfaces, are estimator
 *  P's. */
#ifndef RENDER_GATHER_WAVE_WAVE_H
#define RENDER_GATHER_WAVE_WAVE_H

#include "render/gather/photon_gather.h"
#include "render/trace/camera.h"

/** The receivers that the camera sees directly, on a grid of subpixels; made once per render. Opaque. */
typedef struct WaveView WaveView;

typedef struct WaveViewRun {
    const Scene *scene;
    const TraceScene *trace;
    const PixelFilter *filter;
    int x0, y0, x1, y1;  /**< region in pixels, x1 and y1 exclusive */
    size_t memory_bytes; /**< what the view may take; fewer subpixels where it would take more */
    const atomic_bool *cancel;
} WaveViewRun;

cau_result wave_view_create(WaveView **out, const WaveViewRun *run, TaskPool *pool, CauError *err);
/** [picture's pixels] whether the camera meets something smooth or rough there first, through which it may
 * see receivers. Lives as long as the view. */
const bool *wave_view_busy(const WaveView *view);
/** Whether any is. */
bool wave_view_any_busy(const WaveView *view);
void wave_view_free(WaveView **view);

typedef struct WaveRun {
    const Scene *scene;
    const TraceScene *trace;
    const Aim *casters; /**< the ball around everything */
    const Light *light;
    const double *share; /**< [object] of the rays; NULL: even */
    const bool *waved;   /**< [object] smooth paths over such objects alone are ours */
    const BentSet *bent; /**< as PhotonRun.bent; paths over a bent mirror are not ours */
    bool physical;       /**< as PhotonRun.physical */
    int y0, y1;          /**< rows of the region */
    const EyePoints
        *points;   /**< of this pass; receivers seen through glass and in mirrors are found among them */
    uint64_t key;  /**< random stream of the light */
    uint32_t pass; /**< replica: shifts the grid, draws the places on the light */
    uint32_t rays; /**< about as many rays as this, for all casters and places together */
    double radius_pixels; /**< of the kernel of photons that receivers seen directly get, in footprints */
    uint32_t places;      /**< places on the light, at least 1; 1 for lights without extent */
    const atomic_bool *cancel;
} WaveRun;

/** What a small wavefront from one place on a light to one caster meets. */
typedef struct WaveProbe {
    double landed; /**< flux that lands by triangles */
    double left;   /**< flux that is left to photons */
    double noise; /**< variance of what single rays mend, in that of as many photons as there are triangles */
    uint64_t rays, corners;
    double looked, looked_flux, found; /**< sums that the noise is made of */
} WaveProbe;

/** Traces it; on the calling thread. Where a corner takes more than `enough` rays a part of it will do. */
cau_result wave_probe(const WaveRun *run, int object, double enough, WaveProbe *out, CauError *err);

/** One replica of a light's smooth direct caustics. Adds radiance and irradiance to the images; appends what
 *  photons must do to `rest`; adds to the account (emitted: what met a waved caster first). */
cau_result wave_pass(const WaveRun *run, WaveView *view, TaskPool *pool, const PassImages *images,
    DepositList *rest, FluxAccount *account, CauError *err);

#endif
