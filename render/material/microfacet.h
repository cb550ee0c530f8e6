/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The GGX microfacet distribution with separable Smith masking (Walter et al. 2007, "Microfacet Models for
 *  Refraction through Rough Surfaces"), shared by metal, glass and plastic. Vectors are in the frame of the
 *  shading normal, +z on wi's side. */
#ifndef RENDER_MATERIAL_MICROFACET_H
#define RENDER_MATERIAL_MICROFACET_H

#include "core/vec.h"

/** Below this alpha a surface is perfectly smooth: the lobe is narrower than any pixel or light resolves, and
 *  its density passes 1e7 per steradian. */
#define GGX_ALPHA_MIN 1e-4

/** Blender's roughness is the square root of alpha; 0 stands for a smooth surface. */
static inline double ggx_alpha(double roughness) {
    double alpha = roughness * roughness;
    return alpha < GGX_ALPHA_MIN ? 0.0 : alpha;
}

/** D(h), Walter 2007 equation 33 in slopes: no division by cos^4, so it stays finite at alpha = 1e-4. */
static inline double ggx_d(V3 h, double alpha) {
    double a2 = alpha * alpha, e = (h.x * h.x + h.y * h.y) / a2 + h.z * h.z;
    return 1.0 / (CAU_PI * a2 * e * e);
}

/** G1(w) / |cos w|, Walter 2007 equation 34: finite at grazing angles, where the quotient is what counts. */
static inline double ggx_g1_over_cos(V3 w, double alpha) {
    return 2.0 / (fabs(w.z) + sqrt(w.z * w.z + alpha * alpha * (w.x * w.x + w.y * w.y)));
}

static inline double ggx_g1(V3 w, double alpha) { return fabs(w.z) * ggx_g1_over_cos(w, alpha); }

/** Density per steradian of the normals that ggx_sample() draws, divided by wi.h. */
static inline double ggx_visible(V3 wi, V3 h, double alpha) {
    return ggx_g1_over_cos(wi, alpha) * ggx_d(h, alpha);
}

/** Draws a normal visible from wi (wi.z >= 0), with density G1(wi) (wi.h) D(h) / wi.z. */
V3 ggx_sample(V3 wi, double alpha, double u, double v);

/** Mirror density of a reflected direction: that of its half vector over 4 wi.h. */
static inline double ggx_reflect_pdf(V3 wi, V3 h, double alpha) { return 0.25 * ggx_visible(wi, h, alpha); }

#endif
