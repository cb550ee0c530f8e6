/* SPDX-License-Identifier: Apache-2.0 */
#include "composite/job.h"

/* Chromaticity of a black body: the cubic splines of Kim et al. 2002 (US patent 7024034, expired), as in
 * "Design of Advanced Color Temperature Control System for HDTV Applications", J. Korean Phys. Soc. 41. */
static void locus(double kelvin, double *x, double *y) {
    double t = 1000 / kelvin;
    *x = kelvin <= 4000 ? ((-0.2661239 * t - 0.2343589) * t + 0.8776956) * t + 0.179910
                        : ((-3.0258469 * t + 2.1070379) * t + 0.2226347) * t + 0.240390;
    double v = *x;
    *y = kelvin <= 2222   ? ((-1.1063814 * v - 1.34811020) * v + 2.18555832) * v - 0.20219683
         : kelvin <= 4000 ? ((-0.9549476 * v - 1.37418593) * v + 2.09137015) * v - 0.16748867
                          : ((3.0817580 * v - 5.87338670) * v + 3.75112997) * v - 0.37001483;
}

/* Luminance 1. The matrix is that of IEC 61966-2-1. */
static void rec709_of(double kelvin, double rgb[3]) {
    static const double from_xyz[9] = {3.2404542, -1.5371385, -0.4985314, -0.9692660, 1.8760108, 0.0415560,
        0.0556434, -0.2040259, 1.0572252};
    double x, y;
    locus(kelvin, &x, &y);
    double xyz[3] = {x / y, 1, (1 - x - y) / y};
    for (int i = 0; i < 3; i++)
        rgb[i] = from_xyz[3 * i] * xyz[0] + from_xyz[3 * i + 1] * xyz[1] + from_xyz[3 * i + 2] * xyz[2];
}

bool black_body_rgb(double rgb[3], double kelvin) {
    double neutral[3];
    if (!(kelvin >= 1667 && kelvin <= 25000)) return false;
    rec709_of(kelvin, rgb);
    rec709_of(6500, neutral);
    for (int i = 0; i < 3; i++) rgb[i] = rgb[i] > 0 ? rgb[i] / neutral[i] : 0;
    return true;
}
