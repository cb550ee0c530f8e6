/* SPDX-License-Identifier: Apache-2.0 */
/* Lines that all but meet an edge.
 *
 * Two things go wrong there in single precision, some once in a million rays, and light then leaves a body
 * that it has not entered. A ray starts off its surface by the error box and by rounding: at a corner of a
 * box that is on or beyond the next face. So it starts a little way off the edge too, over its triangle. And
 * Embree may meet the two triangles of an outline in the wrong order, or the back one only. So the triangles
 * around are asked in double precision, about Embree's line and not the true one: of lines that are both in
 * and out of a body as often, any is right, but not half of one and half of the other. */
#include "render/trace/embree_internal.h"

V3 edge_inward(const Triangle *t, double v, double w, double width) {
    double u = 1 - v - w, bc = v3_length(v3_sub(t->ac, t->ab)), ca = v3_length(t->ac), ab = v3_length(t->ab);
    double area2 = sqrt(t->nn), round = bc + ca + ab, inradius = area2 / round;
    double least = fmin(u * area2 / bc, fmin(v * area2 / ca, w * area2 / ab));
    if (!(least < width)) return v3(0, 0, 0);
    /* From the first corner: the middle of the inscribed circle less the point. */
    V3 way = v3_add(v3_scale(t->ab, ca / round - v), v3_scale(t->ac, ab / round - w));
    double share = inradius > width ? (width - least) / (inradius - least) : 1;
    /* A sliver's middle may be far away. */
    return v3_scale(way, fmin(share, 4 * width / v3_length(way)));
}

/* On which side of the line from a to b the ray passes. The two triangles of an edge ask from either end: the
 * same numbers are taken for both, so that no line passes between them. */
static double side(V3 a, V3 b, const Ray *ray) {
    bool turned = a.x != b.x ? a.x > b.x : a.y != b.y ? a.y > b.y : a.z > b.z;
    V3 p = v3_sub(turned ? b : a, ray->origin), q = v3_sub(turned ? a : b, ray->origin);
    double d = v3_dot(v3_cross(p, q), ray->dir);
    return turned ? -d : d;
}

/* Bit k: the line passes outside of the edge from corner k on. 0: the line meets the triangle. */
static unsigned sides_outside(const NearTriangle *n, const Ray *ray, double facing) {
    double way = facing < 0 ? -1 : 1;
    bool ab = side(n->a, n->b, ray) * way < 0, bc = side(n->b, n->c, ray) * way < 0,
         ca = side(n->c, n->a, ray) * way < 0;
    return (ab ? 1u : 0u) | (bc ? 2u : 0u) | (ca ? 4u : 0u);
}

static double facing_of(const NearTriangle *n, const Ray *ray, double *t) {
    V3 normal = v3_cross(v3_sub(n->b, n->a), v3_sub(n->c, n->a));
    double facing = v3_dot(normal, ray->dir);
    *t = v3_dot(normal, v3_sub(n->a, ray->origin)) / facing;
    return facing;
}

static bool same(V3 a, V3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
static bool has_corner(const NearTriangle *n, V3 p) {
    return same(n->a, p) || same(n->b, p) || same(n->c, p);
}

/* Does the line pass by a body's outline, beyond an edge whose two triangles face opposite ways? */
static bool passes_outline(
    const NearTriangle *found, const NearTriangle *around, size_t count, const Ray *ray) {
    double t, facing = facing_of(found, ray, &t);
    unsigned outside = sides_outside(found, ray, facing);
    const V3 corner[4] = {found->a, found->b, found->c, found->a};
    for (size_t i = 0; i < count; i++)
        for (unsigned k = 0; k < 3; k++)
            if (outside >> k & 1 && has_corner(&around[i], corner[k]) &&
                has_corner(&around[i], corner[k + 1]) && facing_of(&around[i], ray, &t) * facing < 0)
                return true;
    return false;
}

enum { AROUND_MAX = 128 };

EdgeVerdict edge_settle(const TraceScene *s, const Ray *line, const Hit *hit, EdgeMet *met) {
    NearTriangle around[AROUND_MAX];
    size_t count = trace_collect(s, hit->position, hit->reach, around, AROUND_MAX);
    if (count > AROUND_MAX) return EDGE_AS_FOUND;
    const NearTriangle *found = NULL;
    *met = (EdgeMet){.object = -1, .t = fmin(line->t_max, hit->t + hit->reach)};
    for (size_t i = 0; i < count; i++) {
        const NearTriangle *n = &around[i];
        if (n->exact) return EDGE_AS_FOUND;
        if (n->object == hit->object && n->primitive == hit->primitive) found = n;
        double t, facing = facing_of(n, line, &t);
        if (t > line->t_min && t < met->t && sides_outside(n, line, facing) == 0)
            *met = (EdgeMet){n->object, n->primitive, t};
    }
    if (met->object >= 0) return EDGE_MET;
    return found && passes_outline(found, around, count, line) ? EDGE_PASSED : EDGE_AS_FOUND;
}
