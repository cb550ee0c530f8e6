/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What the files of embree.h share: embree_build.c makes the tree, embree.c sends rays, embree_near.c
 * collects what lies near a point. */
#ifndef RENDER_TRACE_EMBREE_INTERNAL_H
#define RENDER_TRACE_EMBREE_INTERNAL_H

#include "render/trace/contact.h"
#include "render/trace/embree.h"

#if CAUSTICS_EMBREE >= 4
#include <embree4/rtcore.h>
typedef struct RTCRayQueryContext QueryContext;
#else
#include <embree3/rtcore.h>
typedef struct RTCIntersectContext QueryContext;
#endif

/** gamma(7) of PBR: seven roundings in Embree's hit point at most. The absolute part (scene space: casters
 * are about 1 in size) is for surfaces through the origin, whose coordinates are exactly 0. */
#define ERROR_GAMMA 4.2e-7
#define ERROR_ABSOLUTE 5e-8

struct TraceScene {
    const Scene *scene;
    RTCDevice device;
    RTCScene rtc;
    float **corners;      /* [object] nine numbers a triangle, as Embree has them; NULL: no mesh */
    bool any_hidden;      /* some object is invisible to some kind of ray */
    bool any_transparent; /* some object lets light straight through */
    Contact *contacts;    /* [object] where casters lie on receivers, face to face */
    RTCScene touched;     /* the receivers that casters lie on; NULL: none */
    RTCScene standing;    /* those casters */
};

/** What an exact surface needs beyond Embree's single precision. */
typedef struct ExactQuery {
    QueryContext base; /* first: Embree hands back a pointer to it */
    const TraceScene *trace;
    const Ray *ray;
    unsigned geometry; /* of the best exact hit so far */
    ShapeHit best;
} ExactQuery;

/** The corners of a triangle as Embree has them. They lie together: a hit waits for memory once. Not rounded
 * here from the scene's double: gcc 12 at -O3 leaves that out where it makes vectors of it. */
static inline void embree_corners(const float *corners, uint32_t primitive, V3 *a, V3 *b, V3 *c) {
    const float *p = &corners[9 * (size_t)primitive];
    *a = v3((double)p[0], (double)p[1], (double)p[2]);
    *b = v3((double)p[3], (double)p[4], (double)p[5]);
    *c = v3((double)p[6], (double)p[7], (double)p[8]);
}

/** A triangle as Embree has it: corners in single precision, everything else in double. */
typedef struct Triangle {
    V3 a, b, c, ab, ac;
    V3 n; /* ab x ac */
    double nn;
} Triangle;

static inline Triangle triangle_of(const float *corners, uint32_t primitive) {
    Triangle t;
    embree_corners(corners, primitive, &t.a, &t.b, &t.c);
    t.ab = v3_sub(t.b, t.a);
    t.ac = v3_sub(t.c, t.a);
    t.n = v3_cross(t.ab, t.ac);
    t.nn = v3_dot(t.n, t.n);
    return t;
}

/* ---- edges: embree_edge.c ---- */

/** Whether barycentrics v, w may lie within `width` of an edge, with some false alarms: of the longest edge
 * only a bound is known. `across2`: squared, twice the triangle's area, or what a line sees of it, for a line
 * that passes so near. */
static inline bool edge_near(const Triangle *t, double v, double w, double width, double across2) {
    double u = 1 - v - w, least = v < w ? v : w;
    least = u < least ? u : least;
    return least * least * across2 < 2 * width * width * (v3_dot(t->ab, t->ab) + v3_dot(t->ac, t->ac));
}

/** From the point at v, w to one that is `width` from all edges, if the triangle has such a point near by. */
V3 edge_inward(const Triangle *t, double v, double w, double width);

typedef enum EdgeVerdict {
    EDGE_AS_FOUND, /**< the hit stands */
    EDGE_MET,      /**< the line meets this triangle first */
    EDGE_PASSED    /**< the line passes by the body's outline */
} EdgeVerdict;

typedef struct EdgeMet {
    int object;
    uint32_t primitive;
    double t;
} EdgeMet;

/** Which triangle Embree's line meets near a hit with a reach, in double precision. */
EdgeVerdict edge_settle(const TraceScene *s, const Ray *line, const Hit *hit, EdgeMet *met);

#endif
