/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Inside bent.h: the normals from a face's own to the interpolated one, through which Cycles bends. */
#ifndef RENDER_TRACE_BENT_BETWEEN_H
#define RENDER_TRACE_BENT_BETWEEN_H

#include "core/vec.h"

/** Normals between ng and ns, both unit and on one side of the face. */
typedef struct Between {
    V3 ng, side; /**< side: unit, across ng, towards ns */
    double tilt; /**< angle from ng to ns, radians */
} Between;

/** False: they are the same. */
static inline bool between(V3 ng, V3 ns, Between *out) {
    double cosine = v3_dot(ns, ng);
    V3 side = v3_mad(ns, -cosine, ng);
    double sine = v3_length(side);
    if (!(sine > 1e-6)) return false;
    *out = (Between){ng, v3_scale(side, 1 / sine), atan2(sine, cosine)};
    return true;
}

/** The normal t radians from ng. */
static inline V3 normal_between(const Between *b, double t) {
    return v3_add(v3_scale(b->side, sin(t)), v3_scale(b->ng, cos(t)));
}

#endif
