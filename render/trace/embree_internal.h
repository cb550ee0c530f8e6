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

struct TraceScene {
    const Scene *scene;
    RTCDevice device;
    RTCScene rtc;
    const float **vertices; /* [object] Embree's own copy of a mesh's; NULL: an exact surface */
    bool any_hidden;        /* some object is invisible to some kind of ray */
    bool any_transparent;   /* some object lets light straight through */
    Contact *contacts;      /* [object] where casters lie on receivers, face to face */
    RTCScene touched;       /* the receivers that casters lie on; NULL: none */
    RTCScene standing;      /* those casters */
};

/** What an exact surface needs beyond Embree's single precision. */
typedef struct ExactQuery {
    QueryContext base; /* first: Embree hands back a pointer to it */
    const TraceScene *trace;
    const Ray *ray;
    unsigned geometry; /* of the best exact hit so far */
    ShapeHit best;
} ExactQuery;

/** A corner as Embree has it. Not rounded from the scene's double: gcc 12 at -O3 leaves that out where it
 * makes vectors of it. */
static inline V3 embree_vertex(const float *vertices, uint32_t i) {
    const float *p = &vertices[3 * (size_t)i];
    return v3((double)p[0], (double)p[1], (double)p[2]);
}

static inline void embree_corners(
    const TraceScene *s, unsigned object, uint32_t primitive, V3 *a, V3 *b, V3 *c) {
    const uint32_t *index = &s->scene->objects[object].mesh.triangles[3 * (size_t)primitive];
    *a = embree_vertex(s->vertices[object], index[0]);
    *b = embree_vertex(s->vertices[object], index[1]);
    *c = embree_vertex(s->vertices[object], index[2]);
}

#endif
