/* SPDX-License-Identifier: Apache-2.0 */
/* Lambert's two-sided reflector. */
#include "core/sampling.h"
#include "render/material/shading.h"

typedef struct DiffuseParams {
    double color[3];
} DiffuseParams;

static const Param params[] = {
    MATERIAL_COLOR(DiffuseParams, color, 0.8, PARAM_REQUIRED, "albedo"),
    MATERIAL_COMMON,
};

static void prepare(Material *m) { m->lobes = LOBE_DIFFUSE; }

static bool sample(const Material *m, const ShadingFrame *f, V3 wi, const double u[3], unsigned lobes,
    bool from_light, ScatterSample *out) {
    (void)from_light;
    LocalFrame l;
    if (!(lobes & LOBE_DIFFUSE) || !frame_valid(f, wi, &l)) return false;
    V3 wo = sample_cosine_cone(1.0, u[0], u[1]);
    out->lobe = LOBE_DIFFUSE;
    out->weight = rgb_of(MATERIAL_PARAMS(DiffuseParams, m)->color);
    out->pdf = wo.z / CAU_PI;
    return sample_direction(f, &l, wo, false, out);
}

static Rgb eval(const Material *m, const ShadingFrame *f, V3 wi, V3 wo, unsigned lobes, double *pdf) {
    LocalFrame l;
    *pdf = 0.0;
    if (!(lobes & LOBE_DIFFUSE) || !frame_valid(f, wi, &l)) return rgb_grey(0.0);
    double cos_o = v3_dot(wo, l.n);
    if (!(cos_o > 0.0) || !(v3_dot(wo, f->ng) > 0.0)) return rgb_grey(0.0);
    *pdf = cos_o / CAU_PI;
    return rgb_scale(rgb_of(MATERIAL_PARAMS(DiffuseParams, m)->color), *pdf);
}

static Rgb albedo(const Material *m, const ShadingFrame *f, V3 eye) {
    if (!(v3_dot(eye, f->ng) > 0.0)) return rgb_grey(0.0);
    return rgb_of(MATERIAL_PARAMS(DiffuseParams, m)->color);
}

const MaterialKind material_diffuse = {
    .name = "diffuse",
    .help = "a matt surface, the same on both sides (Lambert)",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(DiffuseParams),
    .prepare = prepare,
    .sample = sample,
    .eval = eval,
    .albedo = albedo,
};

const Material material_black = {.kind = &material_diffuse};
