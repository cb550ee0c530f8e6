/* SPDX-License-Identifier: Apache-2.0 */
/* A metal: a mirror, or GGX when rough, tinted by Schlick's Fresnel term from `color` to `edge_color`. With
 * both equal it is Cycles' Glossy BSDF. Both sides reflect alike. */
#include "render/material/fresnel.h"
#include "render/material/microfacet.h"
#include "render/material/shading.h"

typedef struct MetalParams {
    double color[3], edge_color[3], roughness;
} MetalParams;

typedef struct MetalDerived {
    double alpha; /* 0: mirror */
} MetalDerived;

static const Param params[] = {
    MATERIAL_COLOR(MetalParams, color, 0.8, PARAM_REQUIRED, "reflectance seen straight on"),
    MATERIAL_COLOR(MetalParams, edge_color, 1.0, 0, "reflectance at grazing angles"),
    MATERIAL_NUMBER(MetalParams, roughness, 0.0, 0, 1, "0 is a mirror; GGX with alpha = roughness squared"),
    MATERIAL_COMMON,
};

static void prepare(Material *m) {
    MetalDerived *d = MATERIAL_DERIVED_MUTABLE(MetalDerived, m);
    d->alpha = ggx_alpha(MATERIAL_PARAMS(MetalParams, m)->roughness);
    m->lobes = d->alpha > 0.0 ? LOBE_GLOSSY : LOBE_SPECULAR;
}

static Rgb reflectance(const Material *m, double cos_i) {
    const MetalParams *p = MATERIAL_PARAMS(MetalParams, m);
    Rgb color = rgb_of(p->color), edge = rgb_of(p->edge_color);
    return rgb_add(color, rgb_scale(rgb_sub(edge, color), schlick_weight(cos_i)));
}

static bool sample(const Material *m, const ShadingFrame *f, V3 wi, const double u[3], unsigned lobes,
    bool from_light, ScatterSample *out) {
    (void)from_light;
    LocalFrame l;
    if (!(lobes & m->lobes) || !frame_valid(f, wi, &l)) return false;
    double alpha = MATERIAL_DERIVED(MetalDerived, m)->alpha;
    V3 h = alpha > 0.0 ? ggx_sample(l.wi, alpha, u[0], u[1]) : v3(0.0, 0.0, 1.0);
    double c = v3_dot(l.wi, h);
    V3 wo = reflect_about(l.wi, h, c);
    out->lobe = m->lobes;
    out->weight = reflectance(m, c);
    out->pdf = 0.0;
    if (alpha > 0.0) {
        out->weight = rgb_scale(out->weight, ggx_g1(wo, alpha));
        out->pdf = ggx_reflect_pdf(l.wi, h, alpha);
    }
    return sample_direction(f, &l, wo, false, out);
}

static Rgb eval(const Material *m, const ShadingFrame *f, V3 wi, V3 wo, unsigned lobes, double *pdf) {
    LocalFrame l;
    *pdf = 0.0;
    if (!(lobes & m->lobes & LOBE_GLOSSY) || !frame_valid(f, wi, &l)) return rgb_grey(0.0);
    V3 o = frame_to_local(&l, wo);
    if (!(o.z > 0.0) || !(v3_dot(wo, f->ng) > 0.0)) return rgb_grey(0.0);
    double alpha = MATERIAL_DERIVED(MetalDerived, m)->alpha;
    V3 h = v3_normalize(v3_add(l.wi, o));
    *pdf = ggx_reflect_pdf(l.wi, h, alpha);
    return rgb_scale(reflectance(m, v3_dot(l.wi, h)), ggx_g1(o, alpha) * *pdf);
}

const MaterialKind material_metal = {
    .name = "metal",
    .help = "a mirror or a rough metal",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(MetalParams),
    .prepare = prepare,
    .sample = sample,
    .eval = eval,
};
