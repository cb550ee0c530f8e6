/* SPDX-License-Identifier: Apache-2.0 */
/* The rectangles of light rays that cover a caster as a place on the light sees it. */
#include "render/gather/wave/wave_internal.h"

#include "core/rng.h"

#include <string.h>

/* A mesh of more vertices is bounded by its box: finding its outline anew for every place on a light would
 * cost more than rays that miss. */
enum { OUTLINE_VERTICES = 1 << 17 };

/* Half angle beyond which one flat rectangle would be stretched too far: its flux per area falls with the
 * cosine's cube. */
#define FLAT_COSINE 0.4

typedef struct Bounds {
    double lo[2], hi[2];
} Bounds;

static void include(Bounds *b, double u, double v) {
    b->lo[0] = fmin(b->lo[0], u);
    b->lo[1] = fmin(b->lo[1], v);
    b->hi[0] = fmax(b->hi[0], u);
    b->hi[1] = fmax(b->hi[1], v);
}

static size_t outline_count(const Object *o) {
    return o->exact || o->mesh.vertex_count > OUTLINE_VERTICES ? 8 : o->mesh.vertex_count;
}

static V3 outline_point(const Object *o, size_t i) {
    if (!o->exact && o->mesh.vertex_count <= OUTLINE_VERTICES) {
        const double *p = &o->mesh.positions[3 * i];
        return v3(p[0], p[1], p[2]);
    }
    return v3(i & 1 ? o->bounds_max.x : o->bounds_min.x, i & 2 ? o->bounds_max.y : o->bounds_min.y,
        i & 4 ? o->bounds_max.z : o->bounds_min.z);
}

static bool is_ball(const Object *o) {
    V3 size = v3_sub(o->bounds_max, o->bounds_min);
    return o->exact && strcmp(o->shape->name, "sphere") == 0 && fabs(size.x - size.y) < 1e-6 * size.x &&
           fabs(size.x - size.z) < 1e-6 * size.x;
}

static void set_rectangle(WaveFront *f, const Bounds *b) {
    for (int k = 0; k < 2; k++) {
        /* Embree's copy is single precision: a hair wider, so that nothing that could hit is missed. */
        double margin = 1e-5 * (b->hi[k] - b->lo[k]);
        f->lo[k] = b->lo[k] - margin;
        f->hi[k] = b->hi[k] + margin;
    }
}

/* ---- infinite lights ---- */

static int infinite_front(const WaveRun *run, const EmitStart *start, const Object *o, WaveFront *f) {
    f->axis = start->dir;
    v3_frame(f->axis, &f->s, &f->t);
    f->center = v3_scale(v3_add(o->bounds_min, o->bounds_max), 0.5);
    const Ball *all = &run->casters->around;
    f->back = 2 * all->radius + v3_length(v3_sub(f->center, all->center));
    Bounds b = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    if (is_ball(o)) {
        double r = 0.5 * (o->bounds_max.x - o->bounds_min.x);
        b = (Bounds){{-r, -r}, {r, r}};
    } else
        for (size_t i = 0; i < outline_count(o); i++) {
            V3 d = v3_sub(outline_point(o, i), f->center);
            include(&b, v3_dot(d, f->s), v3_dot(d, f->t));
        }
    set_rectangle(f, &b);
    return 1;
}

/* ---- finite lights: a plane at distance 1 ---- */

/* The lamp's body, within which light may start, reaches into the caster's box. */
static bool body_touches(const EmitStart *start, const Object *o) {
    double r = start->body_radius;
    V3 middle = emit_middle(start);
    V3 off = v3_sub(middle, v3_max(o->bounds_min, v3_min(middle, o->bounds_max)));
    return r > 0 && v3_dot(off, off) <= square(r);
}

/* One rectangle around the whole caster; false when it spreads too wide. */
static bool flat_front(const Object *o, WaveFront *f) {
    V3 from = f->start.position;
    V3 axis = v3_sub(v3_scale(v3_add(o->bounds_min, o->bounds_max), 0.5), from);
    double length = v3_length(axis);
    if (!(length > 0)) return false;
    f->axis = v3_scale(axis, 1 / length);
    v3_frame(f->axis, &f->s, &f->t);
    Bounds b = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    if (is_ball(o)) {
        double r = 0.5 * (o->bounds_max.x - o->bounds_min.x) / length, cosine = sqrt(fmax(0, 1 - r * r));
        if (!(cosine > FLAT_COSINE)) return false;
        b = (Bounds){{-r / cosine, -r / cosine}, {r / cosine, r / cosine}};
    } else
        for (size_t i = 0; i < outline_count(o); i++) {
            V3 d = v3_sub(outline_point(o, i), from);
            double z = v3_dot(d, f->axis);
            if (!(z > FLAT_COSINE * v3_length(d))) return false;
            include(&b, v3_dot(d, f->s) / z, v3_dot(d, f->t) / z);
        }
    set_rectangle(f, &b);
    return true;
}

/* The lamp is within the caster or close to it: the six faces of a cube, turned at random from replica to
 * replica, for rays along the scene's own axes meet its edges exactly. */
static int cube_fronts(const WaveRun *run, WaveFront *out) {
    uint64_t key = rng_combine(rng_combine(run->key, run->pass), 0x63756265u);
    V3 x, y, z;
    double cosine = 2 * rng_unit(rng_combine(key, 1)) - 1, turn = 2 * CAU_PI * rng_unit(rng_combine(key, 2));
    double sine = sqrt(fmax(0, 1 - square(cosine)));
    z = v3(sine * cos(turn), sine * sin(turn), cosine);
    v3_frame(z, &x, &y);
    for (int k = 0; k < 6; k++) {
        if (k) out[k] = out[0];
        double sign = k & 1 ? -1 : 1;
        out[k].axis = v3_scale(k / 2 == 0 ? x : (k / 2 == 1 ? y : z), sign);
        out[k].s = k / 2 == 0 ? y : x;
        out[k].t = k / 2 == 2 ? y : z;
        out[k].lo[0] = out[k].lo[1] = -1;
        out[k].hi[0] = out[k].hi[1] = 1;
        out[k].tiled = true;
    }
    return 6;
}

int wave_fronts(const WaveRun *run, const EmitStart *start, int object, WaveFront *out) {
    const Object *o = &run->scene->objects[object];
    out[0] = (WaveFront){
        .light = run->light, .start = *start, .object = object, .share = 1 / (start->pdf * run->places)};
    if (run->light->infinite) return infinite_front(run, start, o, &out[0]);
    if (!body_touches(start, o) && flat_front(o, &out[0])) return 1;
    return cube_fronts(run, out);
}

Ray wave_front_ray(const WaveFront *f, double u, double v, Rgb *weight) {
    V3 in_plane = v3_add(v3_scale(f->s, u), v3_scale(f->t, v));
    const LightKind *kind = f->light->kind;
    if (f->light->infinite) {
        *weight = rgb_scale(kind->emit(f->light, &f->start, f->axis), f->share);
        V3 origin = v3_mad(v3_add(f->center, in_plane), -f->back, f->axis);
        return ray_from_point(origin, f->axis, 0, INFINITY, VISIBLE_SHADOW);
    }
    V3 dir = v3_add(f->axis, in_plane);
    double cosine = 1 / v3_length(dir);
    dir = v3_scale(dir, cosine);
    /* Solid angle per area of the plane at distance 1 is the cosine's cube. */
    *weight = rgb_scale(kind->emit(f->light, &f->start, dir), f->share * cosine * cosine * cosine);
    return ray_from_point(emit_origin(&f->start, dir), dir, 0, INFINITY, VISIBLE_SHADOW);
}
