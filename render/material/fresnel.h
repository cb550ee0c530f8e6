/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Fresnel reflectance: unpolarised dielectric, and Schlick 1994. */
#ifndef RENDER_MATERIAL_FRESNEL_H
#define RENDER_MATERIAL_FRESNEL_H

#include "core/vec.h"

/** What one evaluation decides for a direction and an interface: callers carry it on and never decide total
 *  reflection a second time, so that reflection and transmission always add up. */
typedef struct Fresnel {
    double reflectance; /**< 1 under total reflection, exactly */
    double cos_t;       /**< cosine of the refracted direction; 0 under total reflection */
    double eta_cos_t;   /**< eta cos_t = sqrt(cos_i^2 + eta^2 - 1) */
} Fresnel;

/** cos_i >= 0, eta = n(other side) / n(this side).
 *
 *  The radicand is cos^2 + (eta - 1)(eta + 1) rather than 1 - sin^2 / eta^2: exact at eta = 1, where the
 * usual form reports total reflection at grazing angles. With s = eta cos_t the amplitudes are (c - s) / (c +
 * s) and (eta^2 c - s) / (eta^2 c + s): Born and Wolf, "Principles of Optics", 1.5.2. */
static inline Fresnel fresnel_dielectric(double cos_i, double eta) {
    double g = cos_i * cos_i + (eta - 1.0) * (eta + 1.0);
    if (!(g > 0.0)) return (Fresnel){1.0, 0.0, 0.0};
    double s = sqrt(g), e2c = eta * eta * cos_i;
    double rs = (cos_i - s) / (cos_i + s), rp = (e2c - s) / (e2c + s);
    return (Fresnel){0.5 * (rs * rs + rp * rp), s / eta, s};
}

/** (1 - cos)^5 */
static inline double schlick_weight(double cos_i) {
    double m = clamp(1.0 - cos_i, 0.0, 1.0), m2 = m * m;
    return m2 * m2 * m;
}

static inline double schlick(double f0, double cos_i) { return f0 + (1.0 - f0) * schlick_weight(cos_i); }

/** Directions in a frame whose +z is on wi's side of the (micro)surface normal m; c = wi.m, f for that c. */
static inline V3 reflect_about(V3 wi, V3 m, double c) { return v3_sub(v3_scale(m, 2.0 * c), wi); }

static inline V3 refract_about(V3 wi, V3 m, double c, double eta, const Fresnel *f) {
    V3 tangential = v3_scale(v3_mad(wi, -c, m), -1.0 / eta);
    return v3_normalize(v3_mad(tangential, -f->cos_t, m));
}

#endif
