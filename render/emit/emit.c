/* SPDX-License-Identifier: Apache-2.0 */
#include "render/emit/emit.h"

#include "core/rng.h"
#include "core/sampling.h"

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
static V3 sample_ball_cone(const Ball *b, V3 origin, double u, double v) {
    V3 oc = v3_sub(b->center, origin), s, t;
    double d2 = v3_dot(oc, oc), s2 = square(b->radius) / d2;
    double one_minus_cos = u * s2 / (1 + sqrt(1 - s2)), cosine = 1 - one_minus_cos;
    double sine = sqrt(fmax(0, one_minus_cos * (2 - one_minus_cos))), x, y;
    sincos_turn(v, &y, &x);
    V3 axis = v3_scale(oc, 1 / sqrt(d2));
    v3_frame(axis, &s, &t);
    return v3_from_frame(v3(sine * x, sine * y, cosine), s, t, axis);
}

/* Picks a ball with probability proportional to `share`, and gives the rest of u back as a new uniform. */
static size_t pick(const double *share, size_t count, double total, double *u) {
    double at = *u * total;
    size_t k = 0;
    while (k + 1 < count && at >= share[k]) at -= share[k++];
    *u = share[k] > 0 ? clamp(at / share[k], 0, 1 - 0x1p-53) : 0;
    return k;
}

/* Solid angles of all balls from a point; negative when it is inside one. */
static double solid_angles(const Aim *aim, V3 origin, double *share) {
    double total = 0;
    for (size_t k = 0; k < aim->count; k++) {
        V3 oc = v3_sub(aim->balls[k].center, origin);
        double d2 = v3_dot(oc, oc);
        if (d2 <= square(aim->balls[k].radius) * (1 + 1e-9)) return -1;
        double angle = ball_solid_angle(aim->balls[k].radius, d2);
        if (share) share[k] = angle;
        total += angle;
    }
    return total;
}

/* The ball is chosen by its solid angle: the mixture's density is then (balls in this direction) / (sum of
 * angles). */
bool aim_direction(const Aim *aim, V3 origin, double u, double v, V3 *dir, double *pdf) {
    double share[AIM_BALLS_MAX];
    share[0] = 0;
    double total = solid_angles(aim, origin, share);
    if (!(total > 0)) return false;
    size_t k = pick(share, aim->count, total, &u), hits = 0;
    *dir = sample_ball_cone(&aim->balls[k], origin, u, v);
    for (size_t j = 0; j < aim->count; j++) hits += j == k || ball_in_direction(&aim->balls[j], origin, *dir);
    *pdf = (double)hits / total;
    return true;
}

double aim_direction_pdf(const Aim *aim, V3 origin, V3 dir) {
    double total = solid_angles(aim, origin, NULL);
    if (!(total > 0)) return -1;
    size_t hits = 0;
    for (size_t j = 0; j < aim->count; j++) hits += ball_in_direction(&aim->balls[j], origin, dir);
    return (double)hits / total;
}

/* Which aim of the mix takes this photon; u is given back as a new uniform. */
static const Aim *choose_aim(const AimMix *mix, double *u, const Aim **other, double *share) {
    *other = mix->second;
    *share = mix->second ? mix->share : 1;
    if (*u < *share) {
        *u /= *share;
        return mix->first;
    }
    *u = (*u - *share) / (1 - *share);
    *other = mix->first;
    *share = 1 - *share;
    return mix->second;
}

/* ---- finite lights ---- */

/* Light may start within the lamp's body, and the body reaches into something that matters. */
static bool body_touches(const EmitStart *start, const Aim *aim) {
    double r = start->body_radius;
    V3 middle = emit_middle(start);
    for (size_t k = 0; r > 0 && k < aim->count; k++) {
        V3 oc = v3_sub(aim->balls[k].center, middle);
        if (v3_dot(oc, oc) <= square(aim->balls[k].radius + r)) return true;
    }
    return false;
}

/* The density of one aim in a direction; a lamp inside something that matters sends everything. */
static double finite_pdf(const Light *light, const EmitStart *start, const Aim *aim, V3 dir) {
    double pdf = body_touches(start, aim) ? -1 : aim_direction_pdf(aim, start->position, dir);
    return pdf < 0 ? light->kind->emit_direction_pdf(light, start, dir) : pdf;
}

static bool emit_finite(const Light *light, const AimMix *mix, double u[4], Photon *out) {
    EmitStart start;
    light->kind->emit_start(light, u[0], u[1], &start);
    const Aim *other;
    double share, pdf;
    const Aim *aim = choose_aim(mix, &u[2], &other, &share);
    if (body_touches(&start, aim) || !aim_direction(aim, start.position, u[2], u[3], &out->dir, &pdf)) {
        pdf = light->kind->emit_direction(light, &start, u[2], u[3], &out->dir);
        if (!(pdf > 0)) return false;
    }
    pdf *= share;
    if (other) pdf += (1 - share) * finite_pdf(light, &start, other, out->dir);
    out->origin = emit_origin(&start, out->dir);
    out->flux = rgb_scale(light->kind->emit(light, &start, out->dir), 1 / (start.pdf * pdf));
    return !rgb_black(out->flux);
}

/* ---- infinite lights ---- */

/* Density per area of lines in a direction that an aim would draw: balls that the line meets over the sum of
 * their disks. */
static double infinite_pdf(const Aim *aim, V3 p, V3 dir) {
    size_t hits = 0;
    for (size_t j = 0; j < aim->count; j++) {
        V3 oc = v3_sub(aim->balls[j].center, p);
        hits += v3_dot(oc, oc) - square(v3_dot(oc, dir)) <= square(aim->balls[j].radius) * (1 + 1e-9);
    }
    return (double)hits / (CAU_PI * aim->disks);
}

/* A point on the disk that faces the light in front of a ball, moved back out of the scene. */
static bool emit_infinite(const Light *light, const AimMix *mix, double u[4], Photon *out) {
    EmitStart start;
    light->kind->emit_start(light, u[0], u[1], &start);
    const Aim *other;
    double share, area[AIM_BALLS_MAX];
    area[0] = 0;
    const Aim *aim = choose_aim(mix, &u[2], &other, &share);
    for (size_t k = 0; k < aim->count; k++) area[k] = square(aim->balls[k].radius);
    size_t k = pick(area, aim->count, aim->disks, &u[2]);
    V3 s, t;
    v3_frame(start.dir, &s, &t);
    double r = aim->balls[k].radius * sqrt(u[2]), x, y;
    sincos_turn(u[3], &y, &x);
    V3 p = v3_add(aim->balls[k].center, v3_add(v3_scale(s, r * x), v3_scale(t, r * y)));
    double pdf = share * infinite_pdf(aim, p, start.dir);
    if (other) pdf += (1 - share) * infinite_pdf(other, p, start.dir);
    /* Back to where the line enters the ball around everything. */
    V3 oc = v3_sub(p, aim->around.center);
    double b = v3_dot(oc, start.dir), c = v3_dot(oc, oc) - square(aim->around.radius);
    double back = -b - sqrt(fmax(0, b * b - c));
    out->origin = v3_mad(p, fmin(back, 0), start.dir);
    out->dir = start.dir;
    out->flux = rgb_scale(light->kind->emit(light, &start, start.dir), 1 / (pdf * start.pdf));
    return !rgb_black(out->flux);
}

bool emit_photon(const Light *light, const AimMix *aim, uint32_t index, uint64_t key, Photon *out) {
    double p[SOBOL_DIMENSIONS];
    sobol_owen_point(index, key, p);
    /* A lamp without extent needs two numbers only: give it the best two dimensions. */
    unsigned first = light->delta ? 2 : 0;
    double u[4] = {p[first], p[first + 1], p[2 - first], p[3 - first]};
    return light->infinite ? emit_infinite(light, aim, u, out) : emit_finite(light, aim, u, out);
}
