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
 * 1986, 2.10): exact in flux and on even light for a straight edge and one radius. */
#ifndef RENDER_GATHER_SUPPORT_H
#define RENDER_GATHER_SUPPORT_H

#include "render/trace/eye.h"

typedef struct Support {
    double radius;
    double integral; /**< of the kernel 1 - (d/r)^2 over the surface; pi r^2 / 2 on an open plane */
    double inner;    /**< the same of the kernel of radius r / sqrt(2), which tells the bias of the other */
    float edge[3];   /**< mixed: unit, towards the straight edge that what is missing is most like */
    float edge_distance; /**< of that edge, in radii; 1: none */
    bool mixed;          /**< something stands in the disk: photons must pass support_sees() */
    bool layered; /**< one sheet may lie over another (tiles): lower photons must not be support_hidden() */
} Support;

/** False while only the radius is set. */
static inline bool support_found(const Support *support) { return support->integral > 0; }

void support_find(const TraceScene *trace, const EyePoint *point, double radius, Support *out);

/** True when nothing stands between the point and another place on its surface. */
bool support_sees(const TraceScene *trace, const EyePoint *point, const Support *support, V3 place);

/** True when another sheet lies between the plane of the point's surface and a place `depth` below it. */
bool support_hidden(
    const TraceScene *trace, const EyePoint *point, const Support *support, V3 place, double depth);

/** Largest height over the tangent plane, in radii, at which a deposit still counts as on the same surface.
 */
#define SUPPORT_HEIGHT 0.25
/** Smallest cosine between its normal and the point's. */
#define SUPPORT_COSINE 0.5

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

/** Integral of 1 - (d/r)^2 over the part of a triangle inside the disk of radius r around the origin, for a
 *  triangle given in the plane; signed by orientation. Exposed for its test. */
double disk_triangle_integral(const double a[2], const double b[2], const double c[2], double radius);

#endif
