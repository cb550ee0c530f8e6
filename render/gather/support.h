/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The surface under a kernel: how much of the disk really is receiver, and what stands in it.
 *
 *  A density estimate divides by the area it looked at. At an edge part of the disk is air, at a corner part
 * of it is behind a wall; both would darken the rim, and the floor behind the wall would leak. So the kernel
 * is normalised by its integral over the triangles that are there (exact, closed form; where sheets lie over
 * one another, places on any of them are counted), and where something rises out of the disk, by probes that
 * test what is hidden from the point; photons are tested likewise. Where a caster lies on the surface nothing
 * is seen, and the surface ends there too.
 *
 * Dividing by the area alone keeps evenly lit surfaces right, but not the flux: of light on a straight edge
 * the points around gather ln 2 of it, 31 % too little (the integral of dF / F, F being the part of the
 * kernel that is on the surface, from 1/2 at the edge to 1). So where there are probes, photons count a
 * second time from where the edge mirrors them (the reflection method of density estimation; Silverman
 * 1986, 2.10): exact in flux and on even light for a straight edge and one radius.
 *
 * Where other sheets lie apart from the point's own (tiles over their grout), they are no part of it: kernels
 * that mixed them would give dark grout the light of its tiles. Of what lies below others only what the eye
 * sees counts, of area and of photons: then the mean over what a pixel sees there is right, however wide the
 * kernel. */
#ifndef RENDER_GATHER_SUPPORT_H
#define RENDER_GATHER_SUPPORT_H

#include "render/gather/sheets.h"

typedef struct Support {
    double radius;
    double integral; /**< of the kernel 1 - (d/r)^2 over the surface; pi r^2 / 2 on an open plane */
    double inner;    /**< the same of the kernel of radius r / sqrt(2), which tells the bias of the other */
    float edge[3];   /**< mixed: unit, towards the straight edge that what is missing is most like */
    float edge_distance; /**< of that edge, in radii; 1: none */
    bool mixed;          /**< something stands in the disk: photons must pass support_sees() */
    bool layered;        /**< one sheet may lie over another (tiles): photons must not be support_hidden() */
    float top;           /**< layered: height of the highest sheet over the point; 0: none is higher */
    float flat;          /**< layered: photons that lie deeper below `top` may be hidden by it */
    float along[3];      /**< layered: what is hidden is hidden from there, normal or eye; its height is 1 */
    float band;          /**< largest height over or under the tangent plane at which a deposit counts */
} Support;

/** False while only the radius is set. */
static inline bool support_found(const Support *support) { return support->integral > 0; }

void support_find(const TraceScene *trace, const EyePoint *point, double radius, Support *out);

/** True when nothing stands between the point and another place on its surface. */
bool support_sees(const TraceScene *trace, const EyePoint *point, const Support *support, V3 place);

/** True when another sheet hides a place, one that lies up to `depth` higher. */
bool support_hidden(const TraceScene *trace, const Support *support, V3 place, double depth);

/** Photons' weights by both kernels. */
typedef struct SupportKernels {
    double outer, inner;
} SupportKernels;

/** At the squared distance q from the point, in radii. */
static inline SupportKernels support_kernels(double q) {
    return (SupportKernels){positive(1 - q), positive(1 - 2 * q)};
}

/** Adds those of the mirror image of a place that is `along` radii towards the edge; of a mixed support. */
static inline void support_mirror(const Support *support, double q, double along, SupportKernels *sum) {
    double distance = (double)support->edge_distance;
    if (distance >= 1) return;
    SupportKernels mirrored = support_kernels(q + 4 * distance * positive(distance - along));
    sum->outer += mirrored.outer;
    sum->inner += mirrored.inner;
}

#endif
