/* SPDX-License-Identifier: Apache-2.0 */
#include "render/emit/emit.h"

#include "core/rng.h"

/* Solid angle 2 pi (1 - cos) of a ball seen from outside at squared distance d2; stable for small balls. */
static double ball_solid_angle(double radius, double d2) {
    double s2 = square(radius) / d2;
    return 2 * CAU_PI * s2 / (1 + sqrt(1 - s2));
}

static bool ball_in_direction(const Ball *b, V3 origin, V3 dir) {
    V3 oc = v3_sub(b->center, origin);
    double along = v3_dot(oc, dir);
    return along > 0 && v3_dot(oc, oc) - square(along) <= square(b->radius);
}

/* Uniform direction in the cone that a ball subtends. */
static V3 sample_cone(const Ball *b, V3 origin, double u, double v) {
    V3 oc = v3_sub(b->center, origin), s, t;
    double d2 = v3_dot(oc, oc), s2 = square(b->radius) / d2;
    double one_minus_cos = u * s2 / (1 + sqrt(1 - s2)), cosine = 1 - one_minus_cos;
    double sine = sqrt(fmax(0, one_minus_cos * (2 - one_minus_cos))), phi = 2 * CAU_PI * v;
    V3 axis = v3_scale(oc, 1 / sqrt(d2));
    v3_frame(axis, &s, &t);
    return v3_from_frame(v3(sine * cos(phi), sine * sin(phi), cosine), s, t, axis);
}

/* Picks a ball with probability proportional to `share`, and gives the rest of u back as a new uniform. */
static size_t pick(const double *share, size_t count, double total, double *u) {
    double at = *u * total;
    size_t k = 0;
    while (k + 1 < count && at >= share[k]) at -= share[k++];
    *u = share[k] > 0 ? clamp(at / share[k], 0, 1 - 0x1p-53) : 0;
    return k;
}

/* Chooses the ball by solid angle: the mixture's density is then (balls in this direction) / (sum of angles).
 */
static bool aim_from_point(const Aim *aim, V3 origin, double u, double v, V3 *dir, double *pdf) {
    double total = 0, share[AIM_BALLS_MAX];
    share[0] = 0;
    size_t n = aim->count;
    for (size_t k = 0; k < n; k++) {
        V3 oc = v3_sub(aim->balls[k].center, origin);
        double d2 = v3_dot(oc, oc);
        if (d2 <= square(aim->balls[k].radius) * (1 + 1e-9)) return false; /* inside: no cone */
        share[k] = ball_solid_angle(aim->balls[k].radius, d2);
        total += share[k];
    }
    size_t k = pick(share, n, total, &u);
    *dir = sample_cone(&aim->balls[k], origin, u, v);
    size_t hits = 0;
    for (size_t j = 0; j < n; j++) hits += j == k || ball_in_direction(&aim->balls[j], origin, *dir);
    *pdf = (double)hits / total;
    return true;
}

static bool emit_finite(const Light *light, const Aim *aim, const double u[4], Photon *out) {
    EmitStart start;
    light->kind->emit_start(light, u[0], u[1], &start);
    double pdf;
    if (!aim_from_point(aim, start.position, u[2], u[3], &out->dir, &pdf)) {
        /* The lamp is inside something that matters: everything that leaves it matters. */
        pdf = light->kind->emit_direction(light, &start, u[2], u[3], &out->dir);
        if (!(pdf > 0)) return false;
    }
    out->origin = start.position;
    out->flux = rgb_scale(light->kind->emit(light, &start, out->dir), 1 / (start.pdf * pdf));
    return !rgb_black(out->flux);
}

/* A point on the disk that faces the light in front of a ball, moved back out of the scene. */
static bool emit_infinite(const Light *light, const Aim *aim, const double u[4], Photon *out) {
    EmitStart start;
    light->kind->emit_start(light, u[0], u[1], &start);
    double total = 0, share[AIM_BALLS_MAX], up = u[2];
    share[0] = 0;
    size_t n = aim->count;
    for (size_t k = 0; k < n; k++) total += share[k] = square(aim->balls[k].radius);
    size_t k = pick(share, n, total, &up);
    V3 s, t;
    v3_frame(start.dir, &s, &t);
    double r = aim->balls[k].radius * sqrt(up), phi = 2 * CAU_PI * u[3];
    V3 p = v3_add(aim->balls[k].center, v3_add(v3_scale(s, r * cos(phi)), v3_scale(t, r * sin(phi))));
    size_t hits = 0;
    for (size_t j = 0; j < n; j++) {
        V3 oc = v3_sub(aim->balls[j].center, p);
        hits += j == k || v3_dot(oc, oc) - square(v3_dot(oc, start.dir)) <= square(aim->balls[j].radius);
    }
    /* Back to where the line enters the ball around everything. */
    V3 oc = v3_sub(p, aim->around.center);
    double b = v3_dot(oc, start.dir), c = v3_dot(oc, oc) - square(aim->around.radius);
    double back = -b - sqrt(fmax(0, b * b - c));
    out->origin = v3_mad(p, fmin(back, 0), start.dir);
    out->dir = start.dir;
    out->flux =
        rgb_scale(light->kind->emit(light, &start, start.dir), CAU_PI * total / ((double)hits * start.pdf));
    return !rgb_black(out->flux);
}

bool emit_photon(const Light *light, const Aim *aim, uint32_t index, uint64_t key, Photon *out) {
    double u[4];
    /* A lamp without extent needs two numbers only: give it the best two dimensions. */
    for (unsigned d = 0; d < 4; d++) u[d] = sobol_owen(index, light->delta ? (d + 2) % 4 : d, key);
    return light->infinite ? emit_infinite(light, aim, u, out) : emit_finite(light, aim, u, out);
}
