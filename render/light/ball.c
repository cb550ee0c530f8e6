/* SPDX-License-Identifier: Apache-2.0 */
#include "render/light/ball.h"

const char *const ball_bodies[] = {"sphere", "disk", NULL};

cau_result ball_prepare(double power_w, double radius_m, double body, double flux_scale, Light *out,
    const char *owner, CauError *err) {
    double r = radius_m * sqrt(flux_scale), intensity = power_w * flux_scale / (4.0 * CAU_PI);
    out->delta = !(r * r > 0.0);
    out->derived[BALL_RADIUS] = out->delta ? 0.0 : r;
    out->derived[BALL_DISK] = body == BODY_DISK;
    out->derived[BALL_VALUE] = out->delta ? intensity : intensity / (CAU_PI * r * r);
    return light_check(out, out->derived[BALL_VALUE], owner, err);
}

static Rgb value(const Light *l) { return rgb_scale(l->color, l->derived[BALL_VALUE]); }

/* How the lamp looks from a place: the sine of its half angle is its radius over this distance. */
static double look_distance(const Light *l, double d) {
    return l->derived[BALL_DISK] > 0.0 ? hypot(d, l->derived[BALL_RADIUS]) : d;
}

/* 1 - cos of the half angle under which it is seen, from sin^2 = r^2 / d^2. */
static double cone_height(double r, double d) {
    double s2 = square(r / d);
    return s2 / (1.0 + sqrt(1.0 - s2));
}

/* What the nearest point of a ray may miss the middle by, squared, for the ray to meet the lamp. */
static double reach2(const Light *l, double d) {
    return square(l->derived[BALL_RADIUS] * d / look_distance(l, d));
}

/* Along a ray that meets it: to the sphere, or to the disk that faces the ray's origin. */
static double distance_along(const Light *l, double d, double along, double miss2) {
    if (l->derived[BALL_DISK] > 0.0) return d * d / along;
    return along - sqrt(fmax(0.0, square(l->derived[BALL_RADIUS]) - miss2));
}

bool ball_hit(const Light *l, V3 p, V3 dir, LightSample *out) {
    double r = l->derived[BALL_RADIUS];
    V3 to = v3_sub(l->position, p);
    double d = v3_length(to), seen = look_distance(l, d), along = v3_dot(to, dir);
    if (l->delta || !(seen > r) || !(along > 0.0)) return false;
    V3 miss = v3_mad(to, -along, dir); /* from the nearest point of the ray to the centre */
    double miss2 = v3_dot(miss, miss);
    if (!(miss2 <= reach2(l, d))) return false;
    *out = (LightSample){
        dir, distance_along(l, d, along, miss2), value(l), 1.0 / (2.0 * CAU_PI * cone_height(r, seen))};
    return true;
}

/* The disk that a place sees stands across the way to the lamp's middle: where it meets the line. */
double ball_starts(const Light *l, V3 dir, V3 place) {
    if (!(l->derived[BALL_DISK] > 0.0) || l->delta) return 0.0;
    V3 to = v3_sub(place, l->position);
    double d = v3_length(to), along = v3_dot(to, dir);
    V3 miss = v3_mad(to, -along, dir);
    if (!(along > 0.0)) return -1.0;
    return v3_dot(miss, miss) <= reach2(l, d) ? d * d / along : INFINITY;
}

void ball_start(const Light *l, V3 normal, double pdf, EmitStart *out) {
    double r = l->derived[BALL_RADIUS];
    *out = (EmitStart){.position = v3_mad(l->position, r, normal),
        .normal = normal,
        .pdf = pdf,
        .body_radius = l->derived[BALL_DISK] > 0.0 ? r : 0.0};
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
    double d = v3_length(to), seen = look_distance(l, d);
    if (!(seen > r) || !(d > 0.0)) return false;
    double height = cone_height(r, seen);
    V3 local = sample_cone(height, u, v);
    out->dir = about_axis(local, v3_scale(to, 1.0 / d));
    out->distance = distance_along(l, d, d * local.z, d * d * (local.x * local.x + local.y * local.y));
    out->value = value(l);
    out->pdf = 1.0 / (2.0 * CAU_PI * height);
    return true;
}

Rgb ball_emit(const Light *l, const EmitStart *start, V3 dir) {
    if (l->delta) return value(l);
    return rgb_scale(value(l), fmax(0.0, v3_dot(start->normal, dir)));
}
