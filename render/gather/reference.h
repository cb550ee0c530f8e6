/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Estimator R: the unbiased reference that the others are tested against.
 *
 *  Path tracing from the camera for everything a path can find (next-event estimation and BSDF sampling,
 * power heuristic's simpler sibling, the balance heuristic: Veach and Guibas 1995), and light tracing into
 * pixels for lights without extent whose first surface is specular, which no camera path can find. What is
 * still out of reach - such light seen through a specular surface - is missing and said so by the plan. From
 * narrow suns a camera path finds such light so rarely that its error hides: where no normal is interpolated
 * (by which Cycles would bend what the eye sees) it is traced from the light too, all but what is seen
 * through a specular surface.
 *
 *  R splits every path by chain_owner(): the beauty that Cycles renders with caustics off, and per light the
 *  direct and the indirect caustics. */
#ifndef RENDER_GATHER_REFERENCE_H
#define RENDER_GATHER_REFERENCE_H

#include "core/tasks.h"
#include "render/emit/emit.h"
#include "render/trace/camera.h"
#include "render/trace/path.h"

#include <stdatomic.h>

/** Images of one pass, width * height * 3 doubles each, of all lights together or of each light. */
typedef struct ReferenceImages {
    double *beauty;    /**< E (S|G)* D* L of all lights; NULL: not wanted */
    double **cycles;   /**< the same of each light, when `beauty` is NULL; NULL: not wanted */
    double **direct;   /**< [light]; NULL: no caustics are wanted */
    double **indirect; /**< [light] */
} ReferenceImages;

typedef struct ReferenceRun {
    const Scene *scene;
    const TraceScene *trace;
    const PixelFilter *filter;
    const Aim *casters;
    bool physical;
    uint64_t key;
    uint32_t pass;
    uint32_t light_paths; /**< light tracing: paths in this pass, of each light that is traced from */
    int x0, y0, x1, y1;
    const atomic_bool *cancel;
} ReferenceRun;

/** Whether light of it that is specular next to it, and that the eye sees on a surface that is not, is traced
 * from the light and left out of camera paths. */
bool reference_from_light(const ReferenceRun *run, const Light *light);

/** One camera sample per pixel, and light_paths light paths per light that is traced from. Images are
 * overwritten.
 */
cau_result reference_pass(const ReferenceRun *run, TaskPool *pool, const ReferenceImages *out, CauError *err);

/** The light tracing half; called by reference_pass(). Adds to the images. */
cau_result reference_light_paths(
    const ReferenceRun *run, TaskPool *pool, const ReferenceImages *out, CauError *err);

/** The image that owns a path of a light, or NULL. */
static inline double *reference_image(const ReferenceImages *out, PathOwner owner, size_t light) {
    if (owner == OWNER_CYCLES) return out->beauty ? out->beauty : (out->cycles ? out->cycles[light] : NULL);
    if (!out->direct) return NULL;
    return owner == OWNER_DIRECT ? out->direct[light] : out->indirect[light];
}

#endif
