/* SPDX-License-Identifier: Apache-2.0 */
#include "render/material/facets.h"

#include "render/material/cosine_table.h"
#include "render/material/fresnel.h"
#include "render/material/microfacet.h"

enum { LATTICE_POINTS = 1597, LATTICE_STEP = 987, MEAN_POINTS = 64 }; /* as coat.c has it */

/* Of the light that meets a facet with normal h: what leaves the surface at once. */
static double leaves(V3 wi, V3 h, double alpha, double eta) {
    double c = v3_dot(wi, h);
    Fresnel f = fresnel_dielectric(c, eta);
    V3 up = reflect_about(wi, h, c);
    double sum = up.z > 0.0 ? f.reflectance * ggx_g1(up, alpha) : 0.0;
    if (!(f.reflectance < 1.0)) return sum;
    V3 down = refract_about(wi, h, c, eta, &f);
    return down.z < 0.0 ? sum + (1.0 - f.reflectance) * ggx_g1(down, alpha) : sum;
}

static double albedo_quadrature(double cos_i, double alpha, double eta) {
    V3 wi = v3(sqrt(1.0 - cos_i * cos_i), 0.0, cos_i);
    double sum = 0.0;
    for (int i = 0; i < LATTICE_POINTS; i++) {
        double u = (i + 0.5) / LATTICE_POINTS,
               v = (double)(i * LATTICE_STEP % LATTICE_POINTS) / LATTICE_POINTS;
        sum += leaves(wi, ggx_sample(wi, alpha, u, 0.5 * v + 0.75), alpha, eta);
    }
    return sum / LATTICE_POINTS;
}

void facets_prepare(Facets *facets, double alpha, double eta) {
    for (int i = 0; i < FACETS_NODES; i++)
        facets->albedo[i] = albedo_quadrature(cosine_table_node(i, FACETS_NODES), alpha, eta);
    facets->mean = 0.0;
    for (int i = 0; i < MEAN_POINTS; i++) {
        double c = (i + 0.5) / MEAN_POINTS;
        facets->mean += facets_albedo(facets, c) * 2.0 * c / MEAN_POINTS;
    }
}

double facets_albedo(const Facets *facets, double cos_eye) {
    return cosine_table_at(facets->albedo, FACETS_NODES, cos_eye);
}

/* Of light that meets facets more than once: what is left when it leaves. */
static double left(double color, double mean) { return color * mean / (1.0 - color * (1.0 - mean)); }

Rgb facets_gain(const Facets *facets, Rgb color, double cos_eye) {
    double e = facets_albedo(facets, cos_eye), lost = (1.0 - e) / e;
    return rgb(1.0 + lost * left(color.r, facets->mean), 1.0 + lost * left(color.g, facets->mean),
        1.0 + lost * left(color.b, facets->mean));
}
