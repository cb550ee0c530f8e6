/* SPDX-License-Identifier: Apache-2.0 */
/* The same radiance from every direction. Made by the scene stage from its world, not by cau_add_light(). */
#include "render/light/light_common.h"

typedef struct WorldLightParams {
    double color[3], strength;
} WorldLightParams;

static const Param params[] = {
    LIGHT_COLOR,
    LIGHT_NUMBER(WorldLightParams, strength, "W/m2/sr", 1, 0, LIGHT_VALUE_MAX, 0, "radiance"),
};

static cau_result prepare(const LightSource *source, const Affine *to_scene, double flux_scale, Light *out,
    const char *owner, CauError *err) {
    (void)flux_scale;
    CAU_TRY(light_place(source, to_scene, out, owner, err));
    out->infinite = true;
    out->derived[0] = LIGHT_PARAMS(WorldLightParams, source)->strength;
    return CAU_OK;
}

static const double density = 1.0 / (4.0 * CAU_PI);

static bool hit(const Light *l, V3 p, V3 dir, LightSample *out) {
    (void)p;
    *out = (LightSample){dir, INFINITY, rgb_scale(l->color, l->derived[0]), density};
    return true;
}

static bool sample(const Light *l, V3 p, double u, double v, LightSample *out) {
    return hit(l, p, sample_sphere(u, v), out);
}

static void emit_start(const Light *l, double u, double v, EmitStart *out) {
    (void)l;
    *out = (EmitStart){.dir = sample_sphere(u, v), .pdf = density};
}

static Rgb emit(const Light *l, const EmitStart *start, V3 dir) {
    (void)start;
    (void)dir;
    return rgb_scale(l->color, l->derived[0]);
}

const LightKind light_world = {
    .name = "world",
    .help = "the same light from all around",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(WorldLightParams),
    .prepare = prepare,
    .sample = sample,
    .hit = hit,
    .emit_start = emit_start,
    .emit = emit,
};
