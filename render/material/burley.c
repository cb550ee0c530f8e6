/* SPDX-License-Identifier: Apache-2.0 */
/* With RR = r (1 + a.b), which is 2 r cos^2 of the angle to the half vector, and F = (1 - cos)^5 Burley's
 * lobe is (1 - F_a / 2) (1 - F_b / 2) + RR (F_a + F_b + F_a F_b (RR - 1)). Its integrals over b are
 * polynomials in the cosine of a: around the normal a.b has the mean z_a z_b and the variance (1 - z_a^2) (1
 * - z_b^2) / 2. */
#include "render/material/burley.h"

#include "core/sampling.h"

#include <math.h>

/* Integrals over z in [0, 1] of 2 z^(1 + k) (1 - z)^5: beta functions. */
static const double moment[3] = {1.0 / 21, 1.0 / 84, 1.0 / 252};

static double fifth(double cos_a) {
    double m = clamp(1.0 - cos_a, 0.0, 1.0);
    return square(m * m) * m;
}

double burley_lobe(double roughness, V3 a, V3 b) {
    double fa = fifth(a.z), fb = fifth(b.z), rr = roughness * (1.0 + v3_dot(a, b));
    return (1.0 - 0.5 * fa) * (1.0 - 0.5 * fb) + rr * (fa + fb + fa * fb * (rr - 1.0));
}

double burley_albedo(double roughness, double cos_a) {
    double z = clamp(cos_a, 0.0, 1.0), f = fifth(z), r = roughness;
    double once = moment[0] + z * moment[1];
    double twice =
        moment[0] + 2.0 * z * moment[1] + z * z * moment[2] + 0.5 * (1.0 - z * z) * (moment[0] - moment[2]);
    return (1.0 - 0.5 * f) * (1.0 - 0.5 * moment[0]) + r * (f * (1.0 + 2.0 / 3.0 * z) + once) +
           f * (r * r * twice - r * once);
}

double burley_mean_albedo(double roughness) {
    /* The integrand is a polynomial of degree 8 in the cosine: five points are exact (Gauss and Legendre). */
    static const double x[5] = {
        0.04691007703066800, 0.23076534494715846, 0.5, 0.76923465505284154, 0.95308992296933200};
    static const double w[5] = {0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
        0.23931433524968324, 0.11846344252809454};
    double sum = 0.0;
    for (int i = 0; i < 5; i++) sum += 2.0 * x[i] * w[i] * burley_albedo(roughness, x[i]);
    return sum;
}
