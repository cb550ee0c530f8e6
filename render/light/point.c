/* SPDX-License-Identifier: Apache-2.0 */
/* A lamp that shines alike in all directions. */
#include "render/light/ball.h"

typedef struct PointParams {
    double color[3], power_w, radius_m, body;
} PointParams;

static const Param params[] = {
    LIGHT_COLOR,
    LIGHT_NUMBER(PointParams, power_w, "W", 10, 0, LIGHT_VALUE_MAX, PARAM_REQUIRED, "emitted flux"),
    LIGHT_NUMBER(PointParams, radius_m, "m", 0, 0, LIGHT_VALUE_MAX, 0, "of the luminous body; 0 is a point"),
    BALL_BODY(PointParams),
};

static cau_result prepare(const LightSource *source, const Affine *to_scene, double flux_scale, Light *out,
    const char *owner, CauError *err) {
    const PointParams *p = LIGHT_PARAMS(PointParams, source);
    CAU_TRY(light_place(source, to_scene, out, owner, err));
    return ball_prepare(p->power_w, p->radius_m, p->body, flux_scale, out, owner, err);
}

static void emit_start(const Light *l, double u, double v, EmitStart *out) {
    *out = (EmitStart){.position = l->position, .pdf = 1.0};
    if (!l->delta)
        ball_start(l, sample_sphere(u, v), 1.0 / (4.0 * CAU_PI * square(l->derived[BALL_RADIUS])), out);
}

static double emit_direction_pdf(const Light *l, const EmitStart *start, V3 dir) {
    if (l->delta) return 1.0 / (4.0 * CAU_PI);
    return fmax(0.0, v3_dot(start->normal, dir)) / CAU_PI;
}

static double emit_direction(const Light *l, const EmitStart *start, double u, double v, V3 *dir) {
    *dir = l->delta ? sample_sphere(u, v) : about_axis(sample_cosine_cone(1.0, u, v), start->normal);
    return emit_direction_pdf(l, start, *dir);
}

const LightKind light_point = {
    .name = "point",
    .help = "a lamp that shines alike in all directions",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(PointParams),
    .prepare = prepare,
    .sample = ball_sample,
    .hit = ball_hit,
    .starts = ball_starts,
    .emit_start = emit_start,
    .emit = ball_emit,
    .emit_direction = emit_direction,
    .emit_direction_pdf = emit_direction_pdf,
};
