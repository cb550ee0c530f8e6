/* SPDX-License-Identifier: Apache-2.0 */
/* Light passes straight through, dimmed: cards and blockers. Not a scattering. */
#include "render/material/shading.h"

typedef struct TransparentParams {
    double color[3];
} TransparentParams;

static const Param params[] = {
    MATERIAL_COLOR(TransparentParams, color, 1.0, PARAM_REQUIRED, "share of the light that passes"),
    MATERIAL_COMMON,
};

static void prepare(Material *m) { m->lobes = LOBE_TRANSPARENT; }

static Rgb transparency(const Material *m) { return rgb_of(MATERIAL_PARAMS(TransparentParams, m)->color); }

static bool sample(const Material *m, const ShadingFrame *f, V3 wi, const double u[3], unsigned lobes,
    bool from_light, ScatterSample *out) {
    (void)f;
    (void)u;
    (void)from_light;
    if (!(lobes & LOBE_TRANSPARENT)) return false;
    *out = (ScatterSample){v3_neg(wi), transparency(m), 0.0, LOBE_TRANSPARENT, true, 1.0};
    return true;
}

const MaterialKind material_transparent = {
    .name = "transparent",
    .help = "lets light straight through",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(TransparentParams),
    .prepare = prepare,
    .sample = sample,
    .transparency = transparency,
};
