/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The emit stage: photons that start on a light and fly towards what matters.
 *
 *  Targets are balls. A photon's density is that of the whole mixture over the balls (Veach and Guibas 1995,
 *  balance heuristic with one sample), so overlapping balls and balls behind each other are right by
 *  construction. Points are Owen-scrambled Sobol: (key, index) alone decide a photon. */
#ifndef RENDER_EMIT_EMIT_H
#define RENDER_EMIT_EMIT_H

#include "render/scene/scene.h"

typedef struct Ball {
    V3 center;
    double radius;
} Ball;

enum { AIM_BALLS_MAX = 192 };

/** What photons are aimed at: at most AIM_BALLS_MAX balls. */
typedef struct Aim {
    Ball *balls;
    size_t count;
    double disks; /**< sum of their squared radii */
    Ball around;  /**< the whole scene: where photons of infinite lights start */
} Aim;

typedef enum AimAt { AIM_CASTERS, AIM_SURFACES } AimAt;

/** Balls around all casters, or around all surfaces. A scene without any gives count 0. */
cau_result aim_create(Aim *out, const Scene *scene, AimAt at, CauError *err);
void aim_free(Aim *aim);

/** Draws a direction from a point towards the balls; its density is that of the whole mixture. False when the
 *  point is inside a ball: then every direction matters. */
bool aim_direction(const Aim *aim, V3 origin, double u, double v, V3 *dir, double *pdf);
/** Density with which aim_direction() would draw `dir`; negative inside a ball. */
double aim_direction_pdf(const Aim *aim, V3 origin, V3 dir);

/** What a run's photons are aimed at: `share` of them at `first`, the rest at `second` (NULL: all at
 * `first`). */
typedef struct AimMix {
    const Aim *first, *second;
    double share;
} AimMix;

typedef struct Photon {
    V3 origin, dir;
    Rgb flux; /**< scene flux units, of this one photon; the caller divides by the number of photons */
} Photon;

/** Photon `index` of sequence `key`. False: nothing leaves in the direction drawn (flux 0); it still counts.
 */
bool emit_photon(const Light *light, const AimMix *aim, uint32_t index, uint64_t key, Photon *out);

#endif
