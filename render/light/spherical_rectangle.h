/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Uniform sampling of the solid angle that a rectangle takes up: Urena, Fajardo and King 2013, "An
 *  Area-Preserving Parametrization for Spherical Rectangles", EGSR. */
#ifndef RENDER_LIGHT_SPHERICAL_RECTANGLE_H
#define RENDER_LIGHT_SPHERICAL_RECTANGLE_H

#include "core/vec.h"

typedef struct SphericalRectangle {
    V3 x, y, z;                /**< frame; the rectangle lies at z0 < 0 */
    double x0, x1, y0, y1, z0; /**< its sides seen from the origin p */
    double b0, b1, k, solid_angle;
} SphericalRectangle;

/** From p, a rectangle of centre c and orthogonal half axes u, v. */
void spherical_rectangle_make(V3 p, V3 c, V3 u, V3 v, SphericalRectangle *out);

/** The point of the rectangle, relative to p, for a point of the unit square. */
V3 spherical_rectangle_sample(const SphericalRectangle *r, double u, double v);

#endif
