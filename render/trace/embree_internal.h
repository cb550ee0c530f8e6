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

#endif
