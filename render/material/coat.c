/* SPDX-License-Identifier: Apache-2.0 */
#include "render/material/coat.h"

#include "render/material/fresnel.h"
#include "render/material/microfacet.h"

/* Points per axis of the quadrature over visible normals: the albedo is then within 1e-4 of the limit (a test
 * holds it to that). Half the circle is enough by symmetry. */
enum { QUAD_RADIUS = 40, QUAD_ANGLE = 24 };

/* E(wi) = integral of f cos = mean over visible normals of F(wi.h) G1(wo), light below the horizon lost. */
static double albedo_quadrature(double f0, double alpha, double cos_i) {
    V3 wi = v3(sqrt(1.0 - cos_i * cos_i), 0.0, cos_i);
    double sum = 0.0;
    for (int i = 0; i < QUAD_RADIUS; i++)
        for (int j = 0; j < QUAD_ANGLE; j++) {
            double r = (i + 0.5) / QUAD_RADIUS;
            /* With wi in the xz plane the circle's y axis is the plane's: v in [-1/4, 1/4] covers one half.
             */
            V3 h = ggx_sample(wi, alpha, r * r, 0.5 * (j + 0.5) / QUAD_ANGLE - 0.25);
            double c = v3_dot(wi, h);
            V3 wo = reflect_about(wi, h, c);
            if (wo.z > 0.0) sum += 2.0 * r * schlick(f0, c) * ggx_g1(wo, alpha);
        }
    return sum / (QUAD_RADIUS * QUAD_ANGLE);
}

void coat_prepare(Coat *coat, double f0, double alpha) {
    coat->f0 = f0;
    coat->alpha = alpha;
    if (!(alpha > 0.0)) return;
    for (int i = 0; i < COAT_NODES; i++)
        coat->albedo[i] = albedo_quadrature(f0, alpha, square(i / (COAT_NODES - 1.0)));
}

/* Catmull-Rom in the square root of the cosine, which spreads the nodes towards grazing angles where the
 * albedo bends; the ends are continued in a line. */
double coat_albedo(const Coat *coat, double cos_i) {
    double c = clamp(cos_i, 0.0, 1.0);
    if (!(coat->alpha > 0.0)) return schlick(coat->f0, c);
    double x = sqrt(c) * (COAT_NODES - 1);
    int i = (int)x < COAT_NODES - 2 ? (int)x : COAT_NODES - 2;
    double t = x - i, b = coat->albedo[i], d = coat->albedo[i + 1];
    double a = i > 0 ? coat->albedo[i - 1] : 2.0 * b - d;
    double e = i + 2 < COAT_NODES ? coat->albedo[i + 2] : 2.0 * d - b;
    double y =
        b + 0.5 * t * ((d - a) + t * ((2.0 * a - 5.0 * b + 4.0 * d - e) + t * (3.0 * (b - d) + e - a)));
    return clamp(y, 0.0, 1.0);
}
