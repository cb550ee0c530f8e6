/* SPDX-License-Identifier: Apache-2.0 */
/* A rectangle or an ellipse that shines to one side. Radiance is P / (4 area), as measured in Cycles 3.4: the
 * flux that leaves is pi / 4 of `power_w`, whatever the spread. Under a shearing matrix the area is the true
 * one. */
#include "render/light/light_common.h"
#include "render/light/spherical_rectangle.h"

typedef struct AreaParams {
    double color[3], shape, size[2], power_w, spread_deg;
} AreaParams;

/* tan a and 1 / (tan a - a) for the half spread a; an infinite tan a stands for no spread. */
enum { AREA_RADIANCE, AREA_AREA, AREA_ROUND, AREA_SKEWED, AREA_TAN, AREA_SPREAD_SCALE, AREA_SIN2 };

/* Solid angles below this are sampled by area: there both are alike and the angle of a spherical rectangle,
 * a difference of sums near 2 pi, would lose digits. */
#define SOLID_ANGLE_MIN 1e-3

static const char *const shapes[] = {"rectangle", "disk", NULL};

static const Param params[] = {
    LIGHT_COLOR,
    {.name = "shape",
        .type = PARAM_CHOICE,
        .unit = "",
        .offset = offsetof(AreaParams, shape),
        .def = {0},
        .max = 1,
        .flags = PARAM_REQUIRED,
        .choices = shapes,
        .help = "outline; a disk of two diameters is an ellipse"},
    {.name = "size",
        .type = PARAM_VEC2,
        .unit = "m",
        .offset = offsetof(AreaParams, size),
        .def = {1, 1},
        .min = 0,
        .max = LIGHT_VALUE_MAX,
        .flags = PARAM_REQUIRED | PARAM_MIN_EXCLUDED | PARAM_BROADCAST,
        .help = "full sides, or diameters"},
    LIGHT_NUMBER(AreaParams, power_w, "W", 10, 0, LIGHT_VALUE_MAX, PARAM_REQUIRED,
        "Blender's power: 4 / pi of the emitted flux"),
    LIGHT_NUMBER(AreaParams, spread_deg, "deg", 180, 0, 180, PARAM_MIN_EXCLUDED,
        "full angle to which the light is narrowed"),
};

/* tan a - a without cancellation for small a. */
static double tan_minus(double a) {
    if (a > 0.05) return tan(a) - a;
    double a2 = a * a;
    return a * a2 *
           (1.0 / 3.0 +
               a2 * (2.0 / 15.0 + a2 * (17.0 / 315.0 + a2 * (62.0 / 2835.0 + a2 * 1382.0 / 155925.0))));
}

static void prepare_spread(double spread_deg, Light *out) {
    double a = radians(0.5 * spread_deg);
    bool full = spread_deg >= 180.0;
    out->derived[AREA_TAN] = full ? INFINITY : tan(a);
    out->derived[AREA_SPREAD_SCALE] = full ? 0.0 : 1.0 / tan_minus(a);
    out->derived[AREA_SIN2] = full ? 1.0 : square(sin(a));
}

static cau_result prepare(const LightSource *source, const Affine *to_scene, double flux_scale, Light *out,
    const char *owner, CauError *err) {
    const AreaParams *p = LIGHT_PARAMS(AreaParams, source);
    CAU_TRY(light_place(source, to_scene, out, owner, err));
    out->u = v3_scale(affine_column(to_scene, 0), 0.5 * p->size[0]);
    out->v = v3_scale(affine_column(to_scene, 1), 0.5 * p->size[1]);
    V3 normal = v3_cross(out->u, out->v);
    double area = v3_length(normal) * (p->shape == 0.0 ? 4.0 : CAU_PI);
    if (!(area > 0.0) || !isfinite(area))
        return error_set(
            err, CAU_ERROR_INPUT, "%s: its area is %g; it must be greater than 0 and finite", owner, area);
    /* The face that shines is the one towards local -Z, whatever the handedness of the matrix. */
    normal = v3_normalize(normal);
    out->n = v3_dot(normal, out->n) < 0.0 ? v3_neg(normal) : normal;
    out->derived[AREA_RADIANCE] = p->power_w * flux_scale / (4.0 * area);
    out->derived[AREA_AREA] = area;
    out->derived[AREA_ROUND] = p->shape;
    out->derived[AREA_SKEWED] = fabs(v3_dot(out->u, out->v)) > 1e-9 * v3_length(out->u) * v3_length(out->v);
    prepare_spread(p->spread_deg, out);
    return light_check(
        out, out->derived[AREA_RADIANCE] * fmax(1.0, out->derived[AREA_SPREAD_SCALE]), owner, err);
}

/* Radiance leaving with cosine c to the normal. Cycles 3.4 (kernel/light/area.h,
 * area_light_spread_attenuation): a linear falloff in the tangent, with the flux kept. */
static Rgb radiance(const Light *l, double c) {
    if (!(c > 0.0)) return rgb_grey(0.0);
    double tan_a = l->derived[AREA_TAN], k = 1.0;
    if (isfinite(tan_a)) {
        double tan_t = sqrt(fmax(0.0, (1.0 - c) * (1.0 + c))) / c;
        k = fmax(0.0, tan_a - tan_t) * l->derived[AREA_SPREAD_SCALE];
    }
    return rgb_scale(l->color, l->derived[AREA_RADIANCE] * k);
}

/* A point of the area, relative to its centre. */
static V3 area_point(const Light *l, double u, double v) {
    double x = 2.0 * u - 1.0, y = 2.0 * v - 1.0;
    if (l->derived[AREA_ROUND] != 0.0) sample_disk(u, v, &x, &y);
    return v3_add(v3_scale(l->u, x), v3_scale(l->v, y));
}

/* True where directions are drawn by solid angle, with the rectangle as seen from p. */
static bool by_solid_angle(const Light *l, V3 p, SphericalRectangle *rect) {
    if (l->derived[AREA_ROUND] != 0.0 || l->derived[AREA_SKEWED] != 0.0) return false;
    V3 to = v3_sub(l->position, p);
    double h = -v3_dot(to, l->n), d2 = v3_dot(to, to), reach2 = v3_dot(l->u, l->u) + v3_dot(l->v, l->v);
    /* Too far for the limit even if it faced p: not worth the trigonometry. */
    if (!(h > 0.0) || d2 > 4.0 * reach2 + l->derived[AREA_AREA] * 2.0 / SOLID_ANGLE_MIN) return false;
    spherical_rectangle_make(p, l->position, l->u, l->v, rect);
    return rect->solid_angle > SOLID_ANGLE_MIN;
}

static bool fill(const Light *l, V3 dir, double distance, const SphericalRectangle *rect, LightSample *out) {
    double c = -v3_dot(dir, l->n);
    if (!(c > 0.0) || !(distance > 0.0)) return false;
    double pdf = rect ? 1.0 / rect->solid_angle : distance * distance / (c * l->derived[AREA_AREA]);
    *out = (LightSample){dir, distance, radiance(l, c), pdf};
    return isfinite(pdf);
}

static bool sample(const Light *l, V3 p, double u, double v, LightSample *out) {
    SphericalRectangle rect;
    if (!(v3_dot(v3_sub(p, l->position), l->n) > 0.0)) return false;
    bool angular = by_solid_angle(l, p, &rect);
    V3 to = angular ? spherical_rectangle_sample(&rect, u, v)
                    : v3_add(v3_sub(l->position, p), area_point(l, u, v));
    double d = v3_length(to);
    return d > 0.0 && fill(l, v3_scale(to, 1.0 / d), d, angular ? &rect : NULL, out);
}

/* Whether a point of the plane, relative to the centre, lies on the area; u and v need not be orthogonal. */
static bool inside(const Light *l, V3 q) {
    double uu = v3_dot(l->u, l->u), vv = v3_dot(l->v, l->v), uv = v3_dot(l->u, l->v), det = uu * vv - uv * uv;
    double qu = v3_dot(q, l->u), qv = v3_dot(q, l->v);
    double x = (qu * vv - qv * uv) / det, y = (qv * uu - qu * uv) / det;
    return l->derived[AREA_ROUND] != 0.0 ? x * x + y * y <= 1.0 : fabs(x) <= 1.0 && fabs(y) <= 1.0;
}

static bool hit(const Light *l, V3 p, V3 dir, LightSample *out) {
    V3 from = v3_sub(p, l->position);
    double h = v3_dot(from, l->n), c = -v3_dot(dir, l->n);
    if (!(h > 0.0) || !(c > 0.0)) return false;
    double t = h / c;
    if (!isfinite(t) || !inside(l, v3_mad(from, t, dir))) return false;
    SphericalRectangle rect;
    return fill(l, dir, t, by_solid_angle(l, p, &rect) ? &rect : NULL, out);
}

static void emit_start(const Light *l, double u, double v, EmitStart *out) {
    *out = (EmitStart){.position = v3_add(l->position, area_point(l, u, v)),
        .normal = l->n,
        .pdf = 1.0 / l->derived[AREA_AREA]};
}

static Rgb emit(const Light *l, const EmitStart *start, V3 dir) {
    (void)start;
    double c = v3_dot(dir, l->n);
    return rgb_scale(radiance(l, c), fmax(0.0, c));
}

static double emit_direction_pdf(const Light *l, const EmitStart *start, V3 dir) {
    (void)start;
    double c = v3_dot(dir, l->n), s2 = l->derived[AREA_SIN2];
    return c > 0.0 && (1.0 - c) * (1.0 + c) <= s2 ? c / (CAU_PI * s2) : 0.0;
}

static double emit_direction(const Light *l, const EmitStart *start, double u, double v, V3 *dir) {
    (void)start;
    *dir = about_axis(sample_cosine_cone(l->derived[AREA_SIN2], u, v), l->n);
    return fmax(0.0, v3_dot(*dir, l->n)) / (CAU_PI * l->derived[AREA_SIN2]);
}

const LightKind light_area = {
    .name = "area",
    .help = "a rectangle or disk that shines to one side",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(AreaParams),
    .prepare = prepare,
    .sample = sample,
    .hit = hit,
    .emit_start = emit_start,
    .emit = emit,
    .emit_direction = emit_direction,
    .emit_direction_pdf = emit_direction_pdf,
};
