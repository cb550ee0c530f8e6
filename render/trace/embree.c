/* SPDX-License-Identifier: Apache-2.0 */
#include "render/trace/embree_internal.h"

#include <float.h>
#include <string.h>

static void query_init(ExactQuery *q, const TraceScene *trace, const Ray *ray) {
#if RTC_VERSION_MAJOR >= 4
    rtcInitRayQueryContext(&q->base);
#else
    rtcInitIntersectContext(&q->base);
#endif
    q->trace = trace;
    q->ray = ray;
    q->geometry = RTC_INVALID_GEOMETRY_ID;
}

static void rtc_intersect(RTCScene scene, ExactQuery *q, struct RTCRayHit *rayhit) {
#if RTC_VERSION_MAJOR >= 4
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &q->base;
    rtcIntersect1(scene, rayhit, &arguments);
#else
    rtcIntersect1(scene, &q->base, rayhit);
#endif
}

static void rtc_occluded(const TraceScene *s, ExactQuery *q, struct RTCRay *ray) {
#if RTC_VERSION_MAJOR >= 4
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &q->base;
    rtcOccluded1(s->rtc, ray, &arguments);
#else
    rtcOccluded1(s->rtc, &q->base, ray);
#endif
}

Ray ray_from_point(V3 origin, V3 dir, double t_min, double t_max, unsigned visibility) {
    return (Ray){.origin = origin, .dir = dir, .t_min = t_min, .t_max = t_max, .visibility = visibility};
}

Ray ray_from_hit(const Hit *hit, V3 dir, double t_max, unsigned visibility) {
    double d =
        fabs(hit->ng.x) * hit->error.x + fabs(hit->ng.y) * hit->error.y + fabs(hit->ng.z) * hit->error.z;
    if (v3_dot(dir, hit->ng) < 0) d = -d;
    return (Ray){.origin = hit->position,
        .dir = dir,
        .offset = v3_mad(hit->inward, d, hit->ng),
        .t_min = hit->slack / fmax(fabs(v3_dot(dir, hit->ng)), 1e-3),
        .t_max = t_max,
        .visibility = visibility};
}

/* The next float away from zero offset: the rounding must not undo the offset. As nextafterf(), without
 * branches, whose way no processor foresees. */
static float start_coordinate(double p, double offset) {
    const uint32_t sign = 0x80000000u;
    float f = (float)(p + offset), next;
    uint32_t bits, mirror = offset < 0 ? sign : 0;
    memcpy(&bits, &f, sizeof bits);
    bits ^= mirror; /* now the way is up */
    bits = bits == sign ? 0 : bits;
    bits += 1 - 2 * (bits >> 31);
    bits ^= mirror;
    memcpy(&next, &bits, sizeof next);
    return offset != 0 ? next : f;
}

static float limit(double t) { return t < (double)FLT_MAX ? (float)t : INFINITY; }

static struct RTCRay rtc_ray(const Ray *ray) {
    bool leaves_surface = ray->offset.x != 0 || ray->offset.y != 0 || ray->offset.z != 0;
    return (struct RTCRay){.org_x = start_coordinate(ray->origin.x, ray->offset.x),
        .org_y = start_coordinate(ray->origin.y, ray->offset.y),
        .org_z = start_coordinate(ray->origin.z, ray->offset.z),
        .dir_x = (float)ray->dir.x,
        .dir_y = (float)ray->dir.y,
        .dir_z = (float)ray->dir.z,
        .tnear = leaves_surface ? 0 : (float)ray->t_min,
        .tfar = limit(ray->t_max),
        .mask = 0xffffffffu};
}

static V3 absolute(V3 p, double s) { return v3(fabs(s * p.x), fabs(s * p.y), fabs(s * p.z)); }
static double sum(V3 p) { return p.x + p.y + p.z; }

/* The surface at barycentrics v, w. */
static void triangle_point(
    const Mesh *m, const Triangle *t, uint32_t primitive, double v, double w, Hit *hit) {
    double u = 1 - v - w;
    hit->primitive = primitive;
    hit->position = v3_add(v3_scale(t->a, u), v3_add(v3_scale(t->b, v), v3_scale(t->c, w)));
    hit->ng = v3_scale(t->n, 1 / sqrt(t->nn));
    hit->error =
        v3_scale(v3_add(absolute(t->a, u), v3_add(absolute(t->b, v), absolute(t->c, w))), ERROR_GAMMA);
    hit->error = v3_add(hit->error, v3(ERROR_ABSOLUTE, ERROR_ABSOLUTE, ERROR_ABSOLUTE));
    hit->slack = hit->reach = 0;
    hit->inward = v3(0, 0, 0);
    hit->ns = hit->ng;
    if (m->normals) {
        const float *k = &m->normals[9 * (size_t)primitive];
        V3 ns = v3(u * (double)k[0] + v * (double)k[3] + w * (double)k[6],
            u * (double)k[1] + v * (double)k[4] + w * (double)k[7],
            u * (double)k[2] + v * (double)k[5] + w * (double)k[8]);
        double length = v3_length(ns);
        if (length > 1e-6) hit->ns = v3_scale(ns, 1 / length);
        if (v3_dot(hit->ns, hit->ng) <= 0) hit->ns = hit->ng;
    }
}

/* Where the true line meets the triangle's plane; false: too far from where Embree met the triangle, and *out
 * is Embree's point along the line. */
static bool plane_distance(const Triangle *t, const Ray *ray, double t_found, double facing, double *out) {
    double exact = v3_dot(t->n, v3_sub(t->a, ray->origin)) / facing;
    /* Embree's ray started off the surface: the same plane is that much nearer or farther for it. */
    double off = fabs(exact - (t_found + v3_dot(t->n, ray->offset) / facing));
    /* A sliver seen edge-on may send the double solution away: then Embree's own is the safer one. The
     * triangle's size, and the rounding of the start, allow for more, but are seldom asked. */
    bool near = off < 1e-3 * t_found || off < 1e-3 * (t_found + v3_length(t->ab) + v3_length(t->ac)) +
                                                  ERROR_GAMMA * (fabs(t->a.x) + fabs(t->a.y) + fabs(t->a.z));
    near = near && isfinite(exact);
    *out = near ? exact : t_found + v3_dot(ray->offset, ray->dir);
    return near;
}

/* The hit of the true line with the triangle that Embree found: plane and barycentrics in double. */
static void triangle_hit(
    const TraceScene *s, const Ray *ray, double t_found, unsigned object, uint32_t primitive, Hit *hit) {
    const Mesh *m = &s->scene->objects[object].mesh;
    if (m->normals) { /* fetched while the rest is computed; nine floats lie on two lines at most */
        __builtin_prefetch(&m->normals[9 * (size_t)primitive]);
        __builtin_prefetch(&m->normals[9 * (size_t)primitive + 8]);
    }
    Triangle t = triangle_of(s->corners[object], primitive);
    double facing = v3_dot(t.n, ray->dir);
    bool met = plane_distance(&t, ray, t_found, facing, &hit->t);
    V3 p = v3_mad(ray->origin, hit->t, ray->dir), ap = v3_sub(p, t.a);
    double v = v3_dot(v3_cross(ap, t.ac), t.n) / t.nn, w = v3_dot(v3_cross(t.ab, ap), t.n) / t.nn;
    double v_inside = clamp(v, 0, 1), w_inside = clamp(w, 0, 1 - v_inside);
    triangle_point(m, &t, primitive, v_inside, w_inside, hit);
    /* Embree's single-precision ray met this triangle, the true line meets its plane beside it: near a convex
     * edge that point is off the body, so the nearest one on the triangle is taken. As it is where the line
     * was not met in its plane: the next ray must not start off it. */
    if (met && v_inside == v && w_inside == w) hit->position = p;
    double width = 2 * sum(hit->error) + ERROR_GAMMA * sum(absolute(ray->origin, 1));
    if (edge_near(&t, v_inside, w_inside, width, facing * facing)) {
        hit->inward = edge_inward(&t, v_inside, w_inside, 2 * sum(hit->error));
        hit->reach = 2 * (width + v3_length(ray->offset)) / fmax(fabs(facing) / sqrt(t.nn), 0.05);
    }
}

static void exact_surface_hit(const Object *o, const ExactQuery *q, Hit *hit) {
    hit->t = q->best.t;
    hit->position = affine_point(&o->local_to_scene, q->best.position);
    hit->ng = hit->ns = object_normal(o, q->best.normal);
    V3 p = hit->position;
    double size = 1e-3 * v3_length(v3_sub(o->bounds_max, o->bounds_min));
    hit->error = v3_scale(v3(fabs(p.x) + size, fabs(p.y) + size, fabs(p.z) + size), ERROR_GAMMA);
    /* The surface itself is intersected in double precision: a few roundings of its coordinates. */
    hit->slack = 1e-13 * (v3_length(p) + 1e3 * size);
    hit->reach = 0;
    hit->inward = v3(0, 0, 0);
}

static void found(const TraceScene *s, unsigned object, uint32_t primitive, Hit *hit) {
    hit->object = (int)object;
    hit->primitive = primitive;
    hit->material = &s->scene->materials[s->scene->objects[object].material];
}

/* The nearest hit of a part of the scene between two distances, as single numbers; objects are not filtered
 * by visibility. */
static bool query(const TraceScene *s, RTCScene part, const Ray *ray, float t_near, float t_far, Hit *hit) {
    ExactQuery q;
    query_init(&q, s, ray);
    struct RTCRayHit rayhit = {.ray = rtc_ray(ray)};
    if (t_near > rayhit.ray.tnear) rayhit.ray.tnear = t_near;
    if (t_far < rayhit.ray.tfar) rayhit.ray.tfar = t_far;
    rayhit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayhit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtc_intersect(part, &q, &rayhit);
    if (rayhit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    found(s, rayhit.hit.geomID, rayhit.hit.primID, hit);
    if (s->scene->objects[hit->object].exact)
        exact_surface_hit(&s->scene->objects[hit->object], &q, hit);
    else
        triangle_hit(s, ray, (double)rayhit.ray.tfar, rayhit.hit.geomID, rayhit.hit.primID, hit);
    return true;
}

/* The line that Embree follows. */
static Ray single_precision_line(const Ray *ray, double from) {
    struct RTCRay r = rtc_ray(ray);
    return ray_from_point(v3((double)r.org_x, (double)r.org_y, (double)r.org_z),
        v3((double)r.dir_x, (double)r.dir_y, (double)r.dir_z), fmax(from, (double)r.tnear), (double)r.tfar,
        0);
}

enum { EDGES_MAX = 64 };

/* The nearest hit. Where the line all but meets an edge, single precision has not the say. */
static bool settled(const TraceScene *s, const Ray *ray, Hit *hit) {
    float from = 0;
    for (int pass = 0; query(s, s->rtc, ray, from, INFINITY, hit); pass++) {
        if (hit->reach == 0 || pass == EDGES_MAX) return true;
        Ray line = single_precision_line(ray, (double)from);
        EdgeMet met;
        EdgeVerdict verdict = edge_settle(s, &line, hit, &met);
        if (verdict == EDGE_MET) {
            found(s, (unsigned)met.object, met.primitive, hit);
            triangle_hit(s, ray, met.t, (unsigned)met.object, met.primitive, hit);
        }
        if (verdict != EDGE_PASSED) return true;
        from = nextafterf((float)(hit->t + hit->reach), INFINITY);
    }
    return false;
}

/* Is there a face of `part` where the hit is? */
static bool coincides(const TraceScene *s, RTCScene part, const Ray *ray, const Hit *hit) {
    double width = 4 * CONTACT_DISTANCE + 1e-6 * hit->t;
    Hit other;
    return query(s, part, ray, (float)(hit->t - width), (float)(hit->t + width), &other);
}

/* Where a caster lies on a receiver, face to face, the light stays between the two, as in Cycles: contact.h.
 */
static bool nearest(const TraceScene *s, const Ray *ray, Hit *hit) {
    if (!settled(s, ray, hit)) return false;
    if (!s->touched || !contacts_near(s->contacts, s->scene->object_count, hit->position)) return true;
    const Contact *met = &s->contacts[hit->object];
    if ((met->caster && coincides(s, s->touched, ray, hit)) ||
        (met->receiver && coincides(s, s->standing, ray, hit)))
        hit->material = &material_black;
    return true;
}

int trace_lies_on(const TraceScene *s, int object) {
    return s->contacts[object].caster ? s->contacts[object].on : -1;
}

bool trace_carries(const TraceScene *s, int receiver) { return s->contacts[receiver].receiver; }

bool trace_covered(const TraceScene *s, int receiver, V3 place, V3 normal) {
    if (!trace_carries(s, receiver) || !contacts_near(s->contacts, s->scene->object_count, place))
        return false;
    double width = 4 * CONTACT_DISTANCE;
    Ray ray = ray_from_point(v3_mad(place, width, normal), v3_neg(normal), 0, 2 * width, 0);
    Hit hit;
    return query(s, s->standing, &ray, 0, (float)(2 * width), &hit);
}

void trace_triangle_point(const TraceScene *s, int object, uint32_t primitive, double v, double w, Hit *hit) {
    const Object *o = &s->scene->objects[object];
    Triangle t = triangle_of(s->corners[object], primitive);
    triangle_point(&o->mesh, &t, primitive, v, w, hit);
    if (edge_near(&t, v, w, 2 * sum(hit->error), t.nn))
        hit->inward = edge_inward(&t, v, w, 2 * sum(hit->error));
    hit->t = 0;
    hit->object = object;
    hit->material = &s->scene->materials[o->material];
}

enum { PASSES_MAX = 4096 };

bool trace_nearest(const TraceScene *s, const Ray *ray, Hit *hit) {
    if (!s->any_hidden || ray->visibility == 0) return nearest(s, ray, hit);
    Ray rest = *ray;
    double travelled = 0;
    for (int pass = 0; pass < PASSES_MAX; pass++) {
        if (!nearest(s, &rest, hit)) return false;
        hit->t += travelled;
        if (s->scene->objects[hit->object].visibility & ray->visibility) return true;
        travelled = hit->t;
        rest = ray_from_hit(hit, ray->dir, ray->t_max - travelled, ray->visibility);
    }
    return false;
}

bool trace_anything_between(const TraceScene *s, const Ray *ray) {
    ExactQuery q;
    query_init(&q, s, ray);
    struct RTCRay r = rtc_ray(ray);
    rtc_occluded(s, &q, &r);
    return r.tfar < 0;
}

bool trace_sees_along(const TraceScene *s, V3 from, V3 to, V3 normal, double lift) {
    V3 d = v3_sub(to, from);
    double length = v3_length(d);
    if (!(length > 0)) return true;
    Ray ray = ray_from_point(v3_mad(from, lift, normal), v3_scale(d, 1 / length), 0, length, 0);
    return !trace_anything_between(s, &ray);
}

Rgb trace_transmittance(const TraceScene *s, const Ray *ray) {
    if (!s->any_hidden && !s->any_transparent) return rgb_grey(trace_anything_between(s, ray) ? 0 : 1);
    Rgb through = rgb_grey(1);
    Ray rest = *ray;
    for (int pass = 0; pass < PASSES_MAX; pass++) {
        Hit hit;
        if (!trace_nearest(s, &rest, &hit)) return through;
        if (!hit.material->kind->transparency) break;
        through = rgb_mul(through, hit.material->kind->transparency(hit.material));
        if (rgb_black(through)) break;
        rest = ray_from_hit(&hit, ray->dir, rest.t_max - hit.t, ray->visibility);
    }
    return rgb_grey(0);
}
