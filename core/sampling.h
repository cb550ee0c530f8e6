/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Maps from the unit square to the sets that materials and lights draw from, all area preserving and
 * continuous but for the sphere's seam, so that low-discrepancy points stay well spread. Directions are about
 * +z. */
#ifndef CORE_SAMPLING_H
#define CORE_SAMPLING_H

#include "core/vec.h"

/** Uniform on the unit disk. Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square". */
static inline void sample_disk(double u, double v, double *x, double *y) {
    double a = 2.0 * u - 1.0, b = 2.0 * v - 1.0, r, phi;
    if (a == 0.0 && b == 0.0) {
        *x = *y = 0.0;
        return;
    }
    if (fabs(a) > fabs(b)) {
        r = a;
        phi = (CAU_PI / 4.0) * (b / a);
    } else {
        r = b;
        phi = CAU_PI / 2.0 - (CAU_PI / 4.0) * (a / b);
    }
    *x = r * cos(phi);
    *y = r * sin(phi);
}

/** Cosine-weighted inside the cone whose half angle has sin^2 = sin2_max (1: the hemisphere);
 *  density cos / (pi sin2_max). */
static inline V3 sample_cosine_cone(double sin2_max, double u, double v) {
    double x, y, s = sqrt(sin2_max);
    sample_disk(u, v, &x, &y);
    x *= s;
    y *= s;
    return v3(x, y, sqrt(fmax(0.0, 1.0 - x * x - y * y)));
}

/** Uniform in solid angle inside a cone; `height` = 1 - cos(half angle), which the caller computes without
 *  cancellation (2 sin^2(a / 2)); density 1 / (2 pi height). */
static inline V3 sample_cone(double height, double u, double v) {
    double x, y;
    sample_disk(u, v, &x, &y);
    double h = height * (x * x + y * y), s = sqrt(fmax(0.0, height * (2.0 - h)));
    return v3(s * x, s * y, 1.0 - h);
}

/** Uniform on the unit sphere; density 1 / (4 pi). */
static inline V3 sample_sphere(double u, double v) {
    double z = 1.0 - 2.0 * u, s = 2.0 * sqrt(fmax(0.0, u * (1.0 - u))), phi = 2.0 * CAU_PI * v;
    return v3(s * cos(phi), s * sin(phi), z);
}

#endif
