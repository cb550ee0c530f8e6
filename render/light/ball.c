/* SPDX-License-Identifier: Apache-2.0 */
#include "render/light/ball.h"

cau_result ball_prepare(
    double power_w, double radius_m, double flux_scale, Light *out, const char *owner, CauError *err) {
    double r = radius_m * sqrt(flux_scale), intensity = power_w * flux_scale / (4.0 * CAU_PI);
    out->delta = !(r * r > 0.0);
    out->derived[BALL_RADIUS] = out->delta ? 0.0 : r;
    out->derived[BALL_VALUE] = out->delta ? intensity : intensity / (CAU_PI * r * r);
    return light_check(out, out->derived[BALL_VALUE], owner, err);
}

static Rgb value(const Light *l) { return rgb_scale(l->color, l->derived[BALL_VALUE]); }

/* From outside: 1 - cos of the half angle under which the ball is seen from a distance, from sin^2 = r^2 /
 * d^2. */
static double cone_height(double r, double d) {
    double s2 = square(r / d);
    return s2 / (1.0 + sqrt(1.0 - s2));
}

bool ball_hit(const Light *l, V3 p, V3 dir, LightSample *out) {
    double r = l->derived[BALL_RADIUS];
    V3 to = v3_sub(l->position, p);
    double d = v3_length(to), along = v3_dot(to, dir);
    if (l->delta || !(d > r) || !(along > 0.0)) return false;
    V3 miss = v3_mad(to, -along, dir); /* from the nearest point of the ray to the centre */
    double inside = r * r - v3_dot(miss, miss);
    if (!(inside >= 0.0)) return false;
    *out = (LightSample){dir, along - sqrt(inside), value(l), 1.0 / (2.0 * CAU_PI * cone_height(r, d))};
    return true;
}

static bool point_sample(const Light *l, V3 p, LightSample *out) {
    V3 to = v3_sub(l->position, p);
    double d = v3_length(to);
    if (!(d > 0.0)) return false;
    *out = (LightSample){v3_scale(to, 1.0 / d), d, rgb_scale(value(l), 1.0 / (d * d)), 1.0};
    return true;
}

bool ball_sample(const Light *l, V3 p, double u, double v, LightSample *out) {
    if (l->delta) return point_sample(l, p, out);
    double r = l->derived[BALL_RADIUS];
    V3 to = v3_sub(l->position, p);
    double d = v3_length(to);
    if (!(d > r)) return false;
    double height = cone_height(r, d);
    V3 local = sample_cone(height, u, v);
    /* Along the ray: d cos - sqrt(r^2 - d^2 sin^2). */
    double inside = r * r - d * d * (local.x * local.x + local.y * local.y);
    out->dir = about_axis(local, v3_scale(to, 1.0 / d));
    out->distance = d * local.z - sqrt(fmax(0.0, inside));
    out->value = value(l);
    out->pdf = 1.0 / (2.0 * CAU_PI * height);
    return true;
}

Rgb ball_emit(const Light *l, const EmitStart *start, V3 dir) {
    if (l->delta) return value(l);
    return rgb_scale(value(l), fmax(0.0, v3_dot(start->normal, dir)));
}
