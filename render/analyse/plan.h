/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The analyse stage: which effects does this scene call for?
 *
 *  A pure function from the scene and a few thousand probes (which render.c sends) to a plan: what is
 * rendered for each light, what is left out, and what leaving it out can change. Decisions are relative to
 * each light's own contribution to the view, never to its strength: a layer may be gained up later. */
#ifndef RENDER_ANALYSE_PLAN_H
#define RENDER_ANALYSE_PLAN_H

#include "render/scene/scene.h"

/** What a small wavefront from one place on a light to one caster meets. */
typedef struct WaveCost {
    double rays;  /**< per corner of the grid; 0: not tried */
    double left;  /**< share of the flux that it leaves to photons */
    double noise; /**< variance, in that of as many photons as it has triangles */
} WaveCost;

/** Are wavefronts towards such a caster quicker to an error than photons are? */
bool plan_wave_pays(const WaveCost *cost);
/** Are they still, for a light whose extent spreads what the caster throws over so many pixels of a picture
 * so wide? */
bool plan_blur_pays(const WaveCost *cost, double blur_pixels, int width);

/** What the probes of one light saw. Means are over all pixels and channels of the probe picture. */
typedef struct LightProbe {
    double cycles_mean; /**< the light's picture without caustics: Cycles' own part */
    double direct_mean, indirect_mean;
    double direct_error, indirect_error; /**< standard errors of the two */
    uint64_t probes, caster_hits;        /**< rays towards casters, and those that met one first */
    uint64_t direct_deposits, indirect_deposits;
    double deep_share;  /**< of the direct deposits' flux: after more scatterings than estimator W follows */
    double bent_share;  /**< of the direct layer's landed flux: from photons that start at bent normals */
    double blur_pixels; /**< how wide the light's extent spreads what a caster throws, in pixels of the
                           picture */
    double photon_rays; /**< that a photon of the direct layer takes */
    uint64_t *object_hits; /**< [object] first hits of the rays towards casters */
    WaveCost *wave;        /**< [object] */
} LightProbe;

typedef struct LightPlan {
    bool direct, indirect;
    bool wave;     /**< smooth direct caustics by estimator W */
    bool chosen;   /**< so the plan chose; `wave` may change between rounds */
    bool may_wave; /**< they could be: the user leaves the choice open, and some caster is smooth */
    double *share; /**< [object] of estimator W's rays: by what of the light meets it first; 0: not waved */
    double wave_rays;      /**< of estimator W: per corner of its grid */
    double wave_noise;     /**< its variance, as WaveCost.noise */
    double places;         /**< of estimator W: places on the light that all replicas together should have */
    bool photons;          /**< direct caustics by estimator P: all, or what W leaves to it */
    bool photons_beside;   /**< W leaves some to it */
    double blur_pixels;    /**< as LightProbe.blur_pixels */
    double photon_rays;    /**< as LightProbe.photon_rays */
    double bent;           /**< without them: photons that start at bent normals, per ray of W */
    double left_out_share; /**< upper bound (95 %) of what is left out, relative to the light's own
                              contribution */
} LightPlan;

typedef struct Plan {
    LightPlan *lights;
    size_t light_count;
    char *text; /**< sentences, one a line */
} Plan;

enum { PLAN_INDIRECT_AUTO, PLAN_INDIRECT_ON, PLAN_INDIRECT_OFF };

/** The share of a light's own contribution below which an effect is left out. */
#define PLAN_LEAVE_OUT (1.0 / 500)

/** Where a corner of a wavefront takes so many times the rays of a photon the light is estimator P's: of as
 *  much time photons have made less error then. */
#define PLAN_WAVE_DEAR 16.0

enum { PLAN_ESTIMATOR_AUTO, PLAN_ESTIMATOR_P, PLAN_ESTIMATOR_W };

/** What the user asked for. */
typedef struct PlanChoice {
    int indirect;      /**< PLAN_INDIRECT_* */
    int estimator;     /**< PLAN_ESTIMATOR_* */
    const bool *waved; /**< [object] estimator W can follow its smooth paths */
    bool rounds;       /**< the render has rounds: what photons tell in the first may be all there is to do */
} PlanChoice;

cau_result plan_make(
    Plan *out, const Scene *scene, const LightProbe *probes, const PlanChoice *choice, CauError *err);
void plan_free(Plan *plan);

/** Gives a light that may have either estimator W, or P. */
void plan_use(LightPlan *plan, bool wave);

/** Does anything in the scene cast, and does anything receive? Without both there is nothing to probe. */
bool plan_scene_can_have_caustics(const Scene *scene);

#endif
