/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Maps from the unit square to the sets that materials and lights draw from, all area preserving and
 * continuous but for the sphere's seam, so that low-discrepancy points stay well spread. Directions are about
 * +z. */
#ifndef CORE_SAMPLING_H
#define CORE_SAMPLING_H

#include "core/vec.h"

/** Sine and cosine for |x| <= pi / 4, to the last bit but one: Taylor's series, in half the time of the C
 *  library's, which must first find out how large its argument is. */
static inline void sincos_octant(double x, double *sine, double *cosine) {
    double z = x * x;
    *sine = x + x * z *
                    (-1.0 / 6 +
                        z * (1.0 / 120 +
                                z * (-1.0 / 5040 +
                                        z * (1.0 / 362880 + z * (-1.0 / 39916800 +
                                                                    z * (1.0 / 6227020800.0 -
                                                                            (1.0 / 1307674368000.0) * z))))));
    *cosine =
        1.0 - 0.5 * z +
        z * z *
            (1.0 / 24 + z * (-1.0 / 720 +
                                z * (1.0 / 40320 + z * (-1.0 / 3628800 +
                                                           z * (1.0 / 479001600.0 +
                                                                   z * (-1.0 / 87178291200.0 +
                                                                           (1.0 / 20922789888000.0) * z))))));
}

/** Sine and cosine of u turns, u >= 0. */
static inline void sincos_turn(double u, double *sine, double *cosine) {
    int quarter = (int)(4.0 * u + 0.5);
    double s, c;
    sincos_octant(2.0 * CAU_PI * (u - 0.25 * quarter), &s, &c);
    double x = quarter & 1 ? s : c, y = quarter & 1 ? c : s;
    *cosine = (quarter + 1) & 2 ? -x : x;
    *sine = quarter & 2 ? -y : y;
}

/** Uniform on the unit disk. Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square". */
static inline void sample_disk(double u, double v, double *x, double *y) {
    double a = 2.0 * u - 1.0, b = 2.0 * v - 1.0, sine, cosine;
    bool wide = fabs(a) > fabs(b); /* in the eighths of the square around the x axis */
    double r = wide ? a : b, other = wide ? b : a;
    sincos_octant(r != 0.0 ? (CAU_PI / 4.0) * (other / r) : 0.0, &sine, &cosine);
    *x = r * (wide ? cosine : sine);
    *y = r * (wide ? sine : cosine);
}

/** Cosine-weighted inside the cone whose half angle has sin^2 = sin2_max (1: the hemisphere);
 *  density cos / (pi sin2_max). */
static inline V3 sample_cosine_cone(double sin2_max, double u, double v) {
    double x, y, s = sqrt(sin2_max);
    sample_disk(u, v, &x, &y);
    x *= s;
    y *= s;
    return v3(x, y, sqrt(positive(1.0 - x * x - y * y)));
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
    double z = 1.0 - 2.0 * u, s = 2.0 * sqrt(fmax(0.0, u * (1.0 - u))), x, y;
    sincos_turn(v, &y, &x);
    return v3(s * x, s * y, z);
}

#endif
