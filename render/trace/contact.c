/* SPDX-License-Identifier: Apache-2.0 */
#include "render/trace/contact.h"

enum { CONTACT_TRIANGLES_MAX = 20000, CONTACT_NEAR = 32, FACE_POINTS = 5 };

/* The box grows by this part of its diagonal: of a mesh with more triangles only some were looked at. */
#define BOX_GROWTH 0.02

typedef struct Search {
    const TraceScene *trace;
    const Scene *scene;
    Contact *contacts;
    size_t caster;
} Search;

static bool faces_touch(const NearTriangle *n, V3 p, V3 normal) {
    V3 m = v3_cross(v3_sub(n->b, n->a), v3_sub(n->c, n->a));
    double length = v3_length(m);
    return length > 0 && fabs(v3_dot(m, normal)) > 0.9999 * length &&
           fabs(v3_dot(m, v3_sub(p, n->a))) < CONTACT_DISTANCE * length;
}

static V3 corner(const Mesh *m, uint32_t i) {
    const double *p = &m->positions[3 * (size_t)i];
    return v3((float)p[0], (float)p[1], (float)p[2]); /* as Embree has it */
}

/* Does the caster's face at p lie on a receiver? Marks the receivers that it lies on. */
static bool touches(const Search *s, V3 p, V3 normal) {
    NearTriangle found[CONTACT_NEAR];
    size_t count = trace_collect(s->trace, p, 2 * CONTACT_DISTANCE, found, CONTACT_NEAR);
    bool any = false;
    for (size_t i = 0; i < count && i < CONTACT_NEAR; i++) {
        unsigned lobes = s->scene->materials[s->scene->objects[found[i].object].material].lobes;
        if (found[i].exact || (lobes & LOBE_CASTING) || !faces_touch(&found[i], p, normal)) continue;
        s->contacts[found[i].object].receiver = any = true;
        s->contacts[s->caster].on = found[i].object;
    }
    return any;
}

static void enclose(const Search *s, V3 p) {
    Contact *c = &s->contacts[s->caster];
    if (!c->caster) c->lo = c->hi = p;
    c->caster = true;
    c->lo = v3_min(c->lo, p);
    c->hi = v3_max(c->hi, p);
}

static void find_on_mesh(const Search *s, const Mesh *m) {
    size_t step = m->triangle_count / CONTACT_TRIANGLES_MAX + 1;
    for (size_t t = 0; t < m->triangle_count; t += step) {
        const uint32_t *index = &m->triangles[3 * t];
        V3 a = corner(m, index[0]), b = corner(m, index[1]), c = corner(m, index[2]);
        V3 n = v3_cross(v3_sub(b, a), v3_sub(c, a));
        double length = v3_length(n);
        if (!(length > 0) || !touches(s, v3_scale(v3_add(a, v3_add(b, c)), 1.0 / 3), v3_scale(n, 1 / length)))
            continue;
        enclose(s, a);
        enclose(s, b);
        enclose(s, c);
    }
}

static V3 axis_vector(int axis, double x, double y, double z) {
    return axis == 0 ? v3(z, x, y) : (axis == 1 ? v3(y, z, x) : v3(x, y, z));
}

/* An exact surface has flat faces, if any, on the sides of its local box (the ends of a cylinder): looked at
 * from outside, along one axis. */
static void find_on_side(const Search *s, const Object *o, V3 middle, V3 half, int axis, double side) {
    for (int i = 0; i < FACE_POINTS * FACE_POINTS; i++) {
        double x = (2 * (i % FACE_POINTS) + 1.0) / FACE_POINTS - 1;
        double y = (2 * (i / FACE_POINTS % FACE_POINTS) + 1.0) / FACE_POINTS - 1;
        V3 from = v3_add(middle, v3_mul(half, axis_vector(axis, x, y, 2 * side)));
        V3 dir = v3_mul(half, axis_vector(axis, 0, 0, -side));
        ShapeHit hit;
        if (!o->shape->intersect(o->shape_data, from, dir, 0, INFINITY, &hit) || fabs(hit.t - 1) > 1e-9)
            continue;
        if (!touches(s, affine_point(&o->local_to_scene, hit.position), object_normal(o, hit.normal)))
            continue;
        for (int k = 0; k < 4; k++) /* the whole side */
            enclose(s,
                affine_point(&o->local_to_scene,
                    v3_add(middle, v3_mul(half, axis_vector(axis, k & 1 ? 1 : -1, k & 2 ? 1 : -1, side)))));
        return;
    }
}

static void find_on_exact(const Search *s, const Object *o) {
    V3 lo, hi;
    o->shape->bounds(o->shape_data, &lo, &hi);
    V3 middle = v3_scale(v3_add(lo, hi), 0.5), half = v3_scale(v3_sub(hi, lo), 0.5);
    for (int side = 0; side < 6; side++) find_on_side(s, o, middle, half, side / 2, side % 2 ? 1 : -1);
}

bool contacts_find(const TraceScene *trace, const Scene *scene, Contact *contacts) {
    bool any = false;
    for (size_t i = 0; i < scene->object_count; i++) {
        const Object *o = &scene->objects[i];
        if (!(scene->materials[o->material].lobes & LOBE_CASTING)) continue;
        Search s = {trace, scene, contacts, i};
        if (o->exact)
            find_on_exact(&s, o);
        else
            find_on_mesh(&s, &o->mesh);
        Contact *c = &contacts[i];
        if (!c->caster) continue;
        double growth = BOX_GROWTH * v3_length(v3_sub(c->hi, c->lo)) + 4 * CONTACT_DISTANCE;
        c->lo = v3_sub(c->lo, v3(growth, growth, growth));
        c->hi = v3_add(c->hi, v3(growth, growth, growth));
        any = true;
    }
    return any;
}
