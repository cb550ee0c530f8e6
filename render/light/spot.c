/* SPDX-License-Identifier: Apache-2.0 */
/* A point light seen through a cone. The cone does not raise the intensity. The falloff is Cycles 3.4's
 * (kernel/light/spot.h, spot_light_attenuation): smoothstep over the blend zone times the cosine to the axis.
 * The cosine is no mistake: 100 W, radius 0.1 m seen at 7.125 degrees renders 251.35 where 253.30 cos gives
 * it. From Blender 4.2 on (4.0 and 4.1 were not measured) Cycles has none: falloff "none". */
#include "render/light/ball.h"

typedef struct SpotParams {
    double color[3], power_w, radius_m, cone_deg, blend, falloff, body;
} SpotParams;

enum {
    SPOT_HEIGHT = BALL_DERIVED,
    SPOT_SOFT,
    SPOT_CAP,
    SPOT_EVEN
}; /* h the half angle: 1 - cos h; blend zone; 1 + sin h; 1 without the cosine */

enum { FALLOFF_COSINE, FALLOFF_NONE };
static const char *const falloffs[] = {"cosine", "none", NULL};

static const Param params[] = {
    LIGHT_COLOR,
    LIGHT_NUMBER(SpotParams, power_w, "W", 10, 0, LIGHT_VALUE_MAX, PARAM_REQUIRED,
        "flux of the lamp without its cone"),
    LIGHT_NUMBER(SpotParams, radius_m, "m", 0, 0, LIGHT_VALUE_MAX, 0, "of the luminous body; 0 is a point"),
    LIGHT_NUMBER(SpotParams, cone_deg, "deg", 45, 0, 180, PARAM_REQUIRED | PARAM_MIN_EXCLUDED,
        "full angle of the cone"),
    LIGHT_NUMBER(SpotParams, blend, "", 0.15, 0, 1, 0, "share of the cone over which the edge is softened"),
    BALL_BODY(SpotParams),
    {.name = "falloff",
        .type = PARAM_CHOICE,
        .unit = "",
        .offset = offsetof(SpotParams, falloff),
        .max = 1,
        .choices = falloffs,
        .help =
            "within the cone: with the cosine to its axis, as in Blender 3.4, or none, as in 4.2 and later"},
};

static cau_result prepare(const LightSource *source, const Affine *to_scene, double flux_scale, Light *out,
    const char *owner, CauError *err) {
    const SpotParams *p = LIGHT_PARAMS(SpotParams, source);
    CAU_TRY(light_place(source, to_scene, out, owner, err));
    CAU_TRY(ball_prepare(p->power_w, p->radius_m, p->body, flux_scale, out, owner, err));
    double half = radians(0.5 * p->cone_deg);
    out->derived[SPOT_HEIGHT] = one_minus_cos(half);
    out->derived[SPOT_SOFT] = out->derived[SPOT_HEIGHT] * p->blend;
    out->derived[SPOT_CAP] = 1.0 + sin(half);
    out->derived[SPOT_EVEN] = p->falloff == FALLOFF_NONE;
    return CAU_OK;
}

/* Share of the lamp's light that leaves along the unit direction of travel. c - cos h is formed from two
 * small numbers, so that a narrow cone keeps its edge. */
static double attenuation(const Light *l, V3 travel) {
    V3 chord = v3_sub(travel, l->n);
    double inside = l->derived[SPOT_HEIGHT] - 0.5 * v3_dot(chord, chord), c = v3_dot(travel, l->n);
    if (!(inside > 0.0) || !(c > 0.0)) return 0.0;
    double t = inside < l->derived[SPOT_SOFT] ? inside / l->derived[SPOT_SOFT] : 1.0;
    return (l->derived[SPOT_EVEN] > 0.0 ? 1.0 : c) * t * t * (3.0 - 2.0 * t);
}

static bool attenuate(const Light *l, LightSample *out) {
    double a = attenuation(l, v3_neg(out->dir));
    out->value = rgb_scale(out->value, a);
    return a > 0.0;
}

static bool sample(const Light *l, V3 p, double u, double v, LightSample *out) {
    return ball_sample(l, p, u, v, out) && attenuate(l, out);
}

static bool hit(const Light *l, V3 p, V3 dir, LightSample *out) {
    return ball_hit(l, p, dir, out) && attenuate(l, out);
}

/* Only the part of the sphere from which some direction of the cone leaves: normals up to 90 degrees plus the
 * half angle from the axis, a cap of height 1 + sin h. */
static void emit_start(const Light *l, double u, double v, EmitStart *out) {
    *out = (EmitStart){.position = l->position, .pdf = 1.0};
    if (l->delta) return;
    double cap = 2.0 * CAU_PI * l->derived[SPOT_CAP] * square(l->derived[BALL_RADIUS]);
    ball_start(l, about_axis(sample_cone(l->derived[SPOT_CAP], u, v), l->n), 1.0 / cap, out);
}

static Rgb emit(const Light *l, const EmitStart *start, V3 dir) {
    return rgb_scale(ball_emit(l, start, dir), attenuation(l, dir));
}

static double emit_direction_pdf(const Light *l, const EmitStart *start, V3 dir) {
    (void)start;
    return attenuation(l, dir) > 0.0 ? 1.0 / (2.0 * CAU_PI * l->derived[SPOT_HEIGHT]) : 0.0;
}

static double emit_direction(const Light *l, const EmitStart *start, double u, double v, V3 *dir) {
    (void)start;
    *dir = about_axis(sample_cone(l->derived[SPOT_HEIGHT], u, v), l->n);
    return 1.0 / (2.0 * CAU_PI * l->derived[SPOT_HEIGHT]);
}

const LightKind light_spot = {
    .name = "spot",
    .help = "a lamp that shines into a cone",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(SpotParams),
    .prepare = prepare,
    .sample = sample,
    .hit = hit,
    .starts = ball_starts,
    .emit_start = emit_start,
    .emit = emit,
    .emit_direction = emit_direction,
    .emit_direction_pdf = emit_direction_pdf,
};
