/* SPDX-License-Identifier: Apache-2.0 */
/* Dielectric interface, smooth or GGX. `ior` is relative to whatever surrounds, the front side is outside.
 *
 * Weights carry no square of the index in either direction. For photons that is physics: a photon's flux is
 * split, not compressed. For eye paths it is Cycles' convention. Both are the same numbers: physical radiance
 * is f_r(b to a) |b.n| = eval(a, b) (n_a / n_b)^2, and eval / (|cos| n_o^2) is symmetric (Veach 1997,
 * section 5.2; Walter 2007, equation 21), so the photon's f_r(a to b) |b.n| comes out as eval(a, b) itself.
 * What facets give back (facets.h) belongs to the eye's side alone, so a photon takes it at its wo.
 */
#include "render/material/facets.h"
#include "render/material/fresnel.h"
#include "render/material/microfacet.h"
#include "render/material/shading.h"

typedef struct GlassParams {
    double color[3], ior, roughness, facets;
} GlassParams;

typedef struct GlassDerived {
    double alpha;    /* 0: smooth */
    double straight; /* 1: too close to ior 1 to bend light */
    Facets side[2];  /* behind, in front; filled where facets give light back */
} GlassDerived;

_Static_assert(sizeof(GlassDerived) <= MATERIAL_DERIVED_MAX * sizeof(double), "it must fit Material.derived");

enum { FACETS_SINGLE, FACETS_MULTIPLE };
static const char *const facet_words[] = {"single", "multiple", NULL};

/* Within this of 1 Cycles lets light straight through too; beyond it the half vector of a refraction is
 * resolved to 1e-12. */
#define IOR_STRAIGHT 1e-4

static const Param params[] = {
    MATERIAL_COLOR(GlassParams, color, 1.0, PARAM_REQUIRED, "tint, once per interface"),
    MATERIAL_NUMBER(
        GlassParams, ior, 1.5, 0.1, 10, "index of refraction at the d line, relative to what surrounds"),
    MATERIAL_NUMBER(GlassParams, roughness, 0.0, 0, 1, "0 is smooth; GGX with alpha = roughness squared"),
    {.name = "facets",
        .type = PARAM_CHOICE,
        .unit = "",
        .offset = offsetof(GlassParams, facets),
        .max = 1,
        .choices = facet_words,
        .help = "light that meets a second facet of rough glass: lost; or given back (as in Multiscatter GGX "
                "from Blender 4.0 on)"},
    MATERIAL_UNSUPPORTED("abbe", PARAM_NUMBER, "dispersion, the Abbe number V_d"),
    MATERIAL_UNSUPPORTED("absorption", PARAM_COLOR, "colour left after a distance in the glass"),
    MATERIAL_UNSUPPORTED("priority", PARAM_NUMBER, "which of two overlapping bodies owns the overlap"),
    MATERIAL_COMMON,
};

static void prepare(Material *m) {
    const GlassParams *p = MATERIAL_PARAMS(GlassParams, m);
    GlassDerived *d = MATERIAL_DERIVED_MUTABLE(GlassDerived, m);
    d->straight = fabs(p->ior - 1.0) < IOR_STRAIGHT;
    d->alpha = d->straight != 0.0 ? 0.0 : ggx_alpha(p->roughness);
    m->lobes = d->alpha > 0.0 ? LOBE_GLOSSY : LOBE_SPECULAR;
    if (!(d->alpha > 0.0) || p->facets != FACETS_MULTIPLE) return;
    for (int front = 0; front < 2; front++)
        facets_prepare(&d->side[front], d->alpha, front ? p->ior : 1.0 / p->ior);
}

/* The tint of rough glass seen from a side at a cosine. */
static Rgb rough_tint(const Material *m, bool front, double cos_eye) {
    const GlassParams *p = MATERIAL_PARAMS(GlassParams, m);
    Rgb color = rgb_of(p->color);
    if (p->facets != FACETS_MULTIPLE) return color;
    return rgb_mul(color, facets_gain(&MATERIAL_DERIVED(GlassDerived, m)->side[front], color, fabs(cos_eye)));
}

/* n(other side) / n(this side) as seen from wi. */
static double relative_ior(const Material *m, const ShadingFrame *f) {
    double ior = MATERIAL_PARAMS(GlassParams, m)->ior;
    return f->front ? ior : 1.0 / ior;
}

/* Density of the refracted direction, per chosen refraction: that of its half vector times Walter 2007's
 * Jacobian (equation 17) eta^2 cos_t / (c - eta cos_t)^2, where c - eta cos_t = (1 - eta^2) / (c + eta cos_t)
 * does not cancel as eta approaches 1. */
static double refract_pdf(V3 wi, V3 h, double c, double eta, const Fresnel *f, double alpha) {
    double q = (c + f->eta_cos_t) * eta / ((eta - 1.0) * (eta + 1.0));
    return ggx_visible(wi, h, alpha) * c * f->cos_t * q * q;
}

static bool pass_straight(Rgb color, V3 wi, ScatterSample *out) {
    *out = (ScatterSample){v3_neg(wi), color, 0.0, LOBE_SPECULAR, true, 1.0};
    return true;
}

static bool sample(const Material *m, const ShadingFrame *f, V3 wi, const double u[3], unsigned lobes,
    bool from_light, ScatterSample *out) {
    const GlassDerived *d = MATERIAL_DERIVED(GlassDerived, m);
    Rgb color = rgb_of(MATERIAL_PARAMS(GlassParams, m)->color);
    LocalFrame l;
    if (!(lobes & m->lobes)) return false;
    if (d->straight != 0.0) return pass_straight(color, wi, out);
    if (!frame_valid(f, wi, &l)) return false;
    bool rough = d->alpha > 0.0;
    double eta = relative_ior(m, f);
    V3 h = rough ? ggx_sample(l.wi, d->alpha, u[0], u[1]) : v3(0.0, 0.0, 1.0);
    double c = v3_dot(l.wi, h);
    Fresnel fr = fresnel_dielectric(c, eta);
    bool transmit = !(u[2] < fr.reflectance);
    V3 wo = transmit ? refract_about(l.wi, h, c, eta, &fr) : reflect_about(l.wi, h, c);
    if (!sample_direction(f, &l, wo, transmit, out)) return false;
    out->lobe = m->lobes;
    out->eta = transmit ? eta : 1.0;
    out->weight = color;
    out->pdf = 0.0;
    if (!rough) return true;
    Rgb tint = from_light ? rough_tint(m, f->front != transmit, wo.z) : rough_tint(m, f->front, l.wi.z);
    out->weight = rgb_scale(tint, ggx_g1(wo, d->alpha));
    out->pdf = transmit ? (1.0 - fr.reflectance) * refract_pdf(l.wi, h, c, eta, &fr, d->alpha)
                        : fr.reflectance * ggx_reflect_pdf(l.wi, h, d->alpha);
    return true;
}

static double reflected(const Material *m, const ShadingFrame *f, V3 wi) {
    LocalFrame l;
    if (MATERIAL_DERIVED(GlassDerived, m)->straight != 0.0 || !frame_valid(f, wi, &l)) return 0.0;
    return fresnel_dielectric(l.wi.z, relative_ior(m, f)).reflectance;
}

/* The half vector of wi and wo (local), or false where no microfacet connects them. */
static bool half_vector(V3 wi, V3 wo, double eta, V3 *h) {
    V3 sum = wo.z > 0.0 ? v3_add(wi, wo) : v3_mad(wi, eta, wo);
    *h = v3_normalize(sum.z < 0.0 ? v3_neg(sum) : sum);
    return h->z > 0.0 && v3_dot(wi, *h) > 0.0 && v3_dot(wo, *h) * wo.z > 0.0;
}

static Rgb eval(const Material *m, const ShadingFrame *f, V3 wi, V3 wo, unsigned lobes, double *pdf) {
    LocalFrame l;
    *pdf = 0.0;
    if (!(lobes & m->lobes & LOBE_GLOSSY) || !frame_valid(f, wi, &l)) return rgb_grey(0.0);
    V3 o = frame_to_local(&l, wo), h;
    double eta = relative_ior(m, f), alpha = MATERIAL_DERIVED(GlassDerived, m)->alpha;
    if (!(o.z * v3_dot(wo, f->ng) > 0.0) || !half_vector(l.wi, o, eta, &h)) return rgb_grey(0.0);
    double c = v3_dot(l.wi, h);
    Fresnel fr = fresnel_dielectric(c, eta);
    *pdf = o.z > 0.0 ? fr.reflectance * ggx_reflect_pdf(l.wi, h, alpha)
                     : (1.0 - fr.reflectance) * refract_pdf(l.wi, h, c, eta, &fr, alpha);
    return rgb_scale(rough_tint(m, f->front, l.wi.z), ggx_g1(o, alpha) * *pdf);
}

const MaterialKind material_glass = {
    .name = "glass",
    .help = "a smooth or rough dielectric, reflecting and refracting",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(GlassParams),
    .prepare = prepare,
    .sample = sample,
    .reflected = reflected,
    .eval = eval,
};
