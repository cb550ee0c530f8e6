/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The kernel 1 - (d/r)^2 over a polygon. */
#ifndef RENDER_GATHER_DISK_H
#define RENDER_GATHER_DISK_H

/** Integral of 1 - (d/r)^2 over the part of a triangle inside the disk of radius r around the origin, for a
 *  triangle given in the plane; signed by orientation. By signed wedges,
 *  one per edge, as seen from the centre. Closed form. */
double disk_triangle_integral(const double a[2], const double b[2], const double c[2], double radius);

#endif
