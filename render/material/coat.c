/* SPDX-License-Identifier: Apache-2.0 */
#include "render/material/coat.h"

#include "render/material/cosine_table.h"
#include "render/material/fresnel.h"
#include "render/material/microfacet.h"

/* A Fibonacci lattice: the integrand has a kink where the reflection dips below the horizon, which costs a
 * regular grid of as many points ten times the error. The albedo is then within 1e-3 (a test holds it to
 * that). */
enum { LATTICE_POINTS = 1597, LATTICE_STEP = 987 };

/* E(wi) = integral of f cos = mean over visible normals of F(wi.h) G1(wo), light below the horizon lost. */
static double albedo_quadrature(const Coat *coat, double cos_i) {
    V3 wi = v3(sqrt(1.0 - cos_i * cos_i), 0.0, cos_i);
    double sum = 0.0, alpha = coat->alpha;
    for (int i = 0; i < LATTICE_POINTS; i++) {
        /* The wi-z plane mirrors: with the disk's y axis in it, v in [3/4, 5/4] covers one half. */
        double u = (i + 0.5) / LATTICE_POINTS,
               v = (double)(i * LATTICE_STEP % LATTICE_POINTS) / LATTICE_POINTS;
        V3 h = ggx_sample(wi, alpha, u, 0.5 * v + 0.75);
        double c = v3_dot(wi, h);
        V3 wo = reflect_about(wi, h, c);
        if (wo.z > 0.0) sum += coat_fresnel(coat, c) * ggx_g1(wo, alpha);
    }
    return sum / LATTICE_POINTS;
}

double coat_fresnel(const Coat *coat, double cos_i) {
    return coat->eta > 0.0 ? fresnel_dielectric(cos_i, coat->eta).reflectance : schlick(coat->f0, cos_i);
}

/* f0 = ((eta - 1) / (eta + 1))^2 */
static double eta_of(double f0) { return (1.0 + sqrt(f0)) / (1.0 - sqrt(f0)); }

void coat_prepare(Coat *coat, double f0, bool dielectric, double alpha) {
    coat->f0 = f0;
    coat->eta = dielectric ? eta_of(f0) : 0.0;
    coat->alpha = alpha;
    if (!(alpha > 0.0)) return;
    for (int i = 0; i < COAT_NODES; i++)
        coat->albedo[i] = albedo_quadrature(coat, cosine_table_node(i, COAT_NODES));
}

double coat_albedo(const Coat *coat, double cos_i) {
    if (!(coat->alpha > 0.0)) return coat_fresnel(coat, clamp(cos_i, 0.0, 1.0));
    return cosine_table_at(coat->albedo, COAT_NODES, cos_i);
}
