/* SPDX-License-Identifier: Apache-2.0 */
/* Balls around surfaces: an object's primitives are split along the longest axis as long as the balls get
 * clearly smaller together; fewer misses, and still few enough that a photon can test them all. */
#include "render/emit/emit.h"

#include "core/checked.h"

enum { BALLS_PER_OBJECT = 16, BALLS_WANTED = 96, BOX_SAMPLES = 4 };

typedef struct Splitter {
    const Mesh *mesh;
    uint32_t *order; /* triangle numbers */
    Aim *aim;
    size_t capacity, left; /* balls this object may still add */
    CauError *err;
} Splitter;

static V3 corner(const Mesh *m, uint32_t triangle, int k) {
    const double *p = &m->positions[3 * (size_t)m->triangles[3 * (size_t)triangle + (size_t)k]];
    return v3(p[0], p[1], p[2]);
}

static Ball ball_of(const Mesh *m, const uint32_t *order, size_t count) {
    V3 lo = v3(INFINITY, INFINITY, INFINITY), hi = v3_neg(lo);
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            V3 p = corner(m, order[i], k);
            lo = v3_min(lo, p);
            hi = v3_max(hi, p);
        }
    Ball b = {v3_scale(v3_add(lo, hi), 0.5), 0};
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            V3 d = v3_sub(corner(m, order[i], k), b.center);
            b.radius = fmax(b.radius, v3_dot(d, d));
        }
    /* Embree's copy is single precision: a hair larger, so that no photon that could hit is missed. */
    b.radius = sqrt(b.radius) * (1 + 1e-5);
    return b;
}

static double coordinate(V3 p, int axis) { return axis == 0 ? p.x : (axis == 1 ? p.y : p.z); }

static double middle(const Mesh *m, uint32_t t, int axis) {
    return coordinate(corner(m, t, 0), axis) + coordinate(corner(m, t, 1), axis) +
           coordinate(corner(m, t, 2), axis);
}

/* Partitions by the middle of the bounding box along its longest axis; returns the size of the first part. */
static size_t partition(const Mesh *m, uint32_t *order, size_t count) {
    V3 lo = v3(INFINITY, INFINITY, INFINITY), hi = v3_neg(lo);
    for (size_t i = 0; i < count; i++) {
        V3 p = v3(middle(m, order[i], 0), middle(m, order[i], 1), middle(m, order[i], 2));
        lo = v3_min(lo, p);
        hi = v3_max(hi, p);
    }
    V3 size = v3_sub(hi, lo);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    double cut = 0.5 * (coordinate(lo, axis) + coordinate(hi, axis));
    size_t first = 0;
    for (size_t i = 0; i < count; i++)
        if (middle(m, order[i], axis) < cut) {
            uint32_t t = order[i];
            order[i] = order[first];
            order[first++] = t;
        }
    return first;
}

static cau_result add_ball(Splitter *s, Ball b) {
    if (!array_reserve((void **)&s->aim->balls, &s->capacity, s->aim->count + 1, sizeof b))
        return error_set(s->err, CAU_ERROR_RESOURCE, "out of memory while aiming at the casters");
    s->aim->balls[s->aim->count++] = b;
    return CAU_OK;
}

static cau_result split(Splitter *s, uint32_t *order, size_t count, size_t may_add) {
    Ball whole = ball_of(s->mesh, order, count);
    if (may_add < 2 || count < 2) return add_ball(s, whole);
    size_t first = partition(s->mesh, order, count);
    if (first == 0 || first == count) return add_ball(s, whole);
    Ball a = ball_of(s->mesh, order, first), b = ball_of(s->mesh, order + first, count - first);
    if (square(a.radius) + square(b.radius) > 0.8 * square(whole.radius)) return add_ball(s, whole);
    CAU_TRY(split(s, order, first, may_add / 2));
    return split(s, order + first, count - first, may_add - may_add / 2);
}

static cau_result add_mesh(Splitter *s, const Object *o, size_t may_add) {
    if (o->mesh.triangle_count == 0) return CAU_OK;
    s->mesh = &o->mesh;
    s->order = array_new(o->mesh.triangle_count, sizeof *s->order);
    if (!s->order)
        return error_set(s->err, CAU_ERROR_RESOURCE, "out of memory while aiming at \"%s\"", o->name);
    for (size_t i = 0; i < o->mesh.triangle_count; i++) s->order[i] = (uint32_t)i;
    cau_result result = split(s, s->order, o->mesh.triangle_count, may_add);
    free(s->order);
    return result;
}

/* An exact surface: a sphere under a similarity is its own ball, anything else is cut like a box. */
static cau_result add_exact(Splitter *s, const Object *o) {
    V3 size = v3_sub(o->bounds_max, o->bounds_min), c = v3_scale(v3_add(o->bounds_max, o->bounds_min), 0.5);
    double longest = fmax(size.x, fmax(size.y, size.z)), shortest = fmin(size.x, fmin(size.y, size.z));
    if (strcmp(o->shape->name, "sphere") == 0 && longest - shortest < 1e-6 * longest)
        return add_ball(s, (Ball){c, 0.5 * longest * (1 + 1e-5)});
    int n[3] = {1, 1, 1};
    double cell = fmax(longest / BOX_SAMPLES, shortest);
    n[0] = (int)clamp(ceil(size.x / cell), 1, BOX_SAMPLES);
    n[1] = (int)clamp(ceil(size.y / cell), 1, BOX_SAMPLES);
    n[2] = (int)clamp(ceil(size.z / cell), 1, BOX_SAMPLES);
    V3 step = v3(size.x / n[0], size.y / n[1], size.z / n[2]);
    for (int i = 0; i < n[0] * n[1] * n[2]; i++) {
        V3 at =
            v3((i % n[0] + 0.5) * step.x, (i / n[0] % n[1] + 0.5) * step.y, (i / n[0] / n[1] + 0.5) * step.z);
        CAU_TRY(add_ball(s, (Ball){v3_add(o->bounds_min, at), 0.5 * v3_length(step) * (1 + 1e-5)}));
    }
    return CAU_OK;
}

static bool wanted(const Scene *scene, const Object *o, AimAt at) {
    if (!o->exact && o->mesh.triangle_count == 0) return false;
    return at == AIM_SURFACES || (o->casts && (scene->materials[o->material].lobes & LOBE_CASTING));
}

cau_result aim_create(Aim *out, const Scene *scene, AimAt at, CauError *err) {
    *out = (Aim){0};
    V3 half = v3_scale(v3_sub(scene->bounds_max, scene->bounds_min), 0.5);
    out->around = (Ball){v3_add(scene->bounds_min, half), v3_length(half) * (1 + 1e-5)};
    size_t objects = 0;
    for (size_t i = 0; i < scene->object_count; i++) objects += wanted(scene, &scene->objects[i], at);
    size_t each = objects ? BALLS_WANTED / objects : 0;
    if (each > BALLS_PER_OBJECT) each = BALLS_PER_OBJECT;
    if (each < 1) each = 1;
    Splitter s = {.aim = out, .err = err};
    for (size_t i = 0; i < scene->object_count; i++) {
        const Object *o = &scene->objects[i];
        if (!wanted(scene, o, at)) continue;
        cau_result result = o->exact ? add_exact(&s, o) : add_mesh(&s, o, each);
        if (result != CAU_OK) {
            aim_free(out);
            return result;
        }
    }
    /* Hundreds of casters: testing every ball would cost more than the misses of one ball around them all. */
    if (out->count > AIM_BALLS_MAX) {
        out->balls[0] = out->around;
        out->count = 1;
    }
    for (size_t k = 0; k < out->count; k++) out->disks += square(out->balls[k].radius);
    return CAU_OK;
}

void aim_free(Aim *aim) {
    free(aim->balls);
    *aim = (Aim){0};
}
