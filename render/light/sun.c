/* SPDX-License-Identifier: Apache-2.0 */
/* A uniform disk in the sky. `strength` is the irradiance on a surface facing it, so over the cone of half
 * angle a the radiance is E / (pi sin^2 a). (Cycles 3.4 divides by tan^2 and cos^3: the same for small
 * angles; later versions are uniform.) */
#include "render/light/light_common.h"

typedef struct SunParams {
    double color[3], strength, angle_deg;
} SunParams;

enum { SUN_VALUE, SUN_HEIGHT, SUN_CHORD2 }; /* radiance or irradiance; 1 - cos a; (2 sin(a / 2))^2 */

static const Param params[] = {
    LIGHT_COLOR,
    LIGHT_NUMBER(SunParams, strength, "W/m2", 1, 0, LIGHT_VALUE_MAX, PARAM_REQUIRED,
        "irradiance on a surface facing it"),
    LIGHT_NUMBER(SunParams, angle_deg, "deg", 0.526, 0, 180, PARAM_REQUIRED,
        "angular diameter; 0 is a point at infinity"),
};

static cau_result prepare(const LightSource *source, const Affine *to_scene, double flux_scale, Light *out,
    const char *owner, CauError *err) {
    (void)flux_scale; /* irradiance is the same in every unit of length */
    const SunParams *p = LIGHT_PARAMS(SunParams, source);
    CAU_TRY(light_place(source, to_scene, out, owner, err));
    double a = radians(0.5 * p->angle_deg);
    out->infinite = true;
    out->delta = p->angle_deg == 0.0;
    out->derived[SUN_VALUE] = out->delta ? p->strength : p->strength / (CAU_PI * square(sin(a)));
    out->derived[SUN_HEIGHT] = one_minus_cos(a);
    out->derived[SUN_CHORD2] = 2.0 * out->derived[SUN_HEIGHT];
    return light_check(out, out->derived[SUN_VALUE], owner, err);
}

static Rgb value(const Light *l) { return rgb_scale(l->color, l->derived[SUN_VALUE]); }

static double density(const Light *l) {
    return l->delta ? 1.0 : 1.0 / (2.0 * CAU_PI * l->derived[SUN_HEIGHT]);
}

static V3 travel(const Light *l, double u, double v) {
    return l->delta ? l->n : about_axis(sample_cone(l->derived[SUN_HEIGHT], u, v), l->n);
}

static bool sample(const Light *l, V3 p, double u, double v, LightSample *out) {
    (void)p;
    *out = (LightSample){v3_neg(travel(l, u, v)), INFINITY, value(l), density(l)};
    return true;
}

/* The chord between the directions, not the cosine, tells small angles apart. */
static bool hit(const Light *l, V3 p, V3 dir, LightSample *out) {
    (void)p;
    V3 chord = v3_add(dir, l->n);
    if (l->delta || !(v3_dot(chord, chord) <= l->derived[SUN_CHORD2])) return false;
    *out = (LightSample){dir, INFINITY, value(l), density(l)};
    return true;
}

static void emit_start(const Light *l, double u, double v, EmitStart *out) {
    *out = (EmitStart){.dir = travel(l, u, v), .pdf = density(l)};
}

static Rgb emit(const Light *l, const EmitStart *start, V3 dir) {
    (void)start;
    (void)dir;
    return value(l);
}

const LightKind light_sun = {
    .name = "sun",
    .help = "parallel light, or from a disk in the sky",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(SunParams),
    .prepare = prepare,
    .sample = sample,
    .hit = hit,
    .emit_start = emit_start,
    .emit = emit,
};
