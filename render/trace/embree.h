/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Rays through Embree 3 or 4: only the files behind this header know which.
 *
 *  Embree finds the primitive in single precision (robust mode); the hit is then computed again in double
 *  precision from the ray's true line, so that a path's positions carry no single-precision error. A ray that
 *  leaves a surface starts outside an error box around the point (Pharr, Jakob, Humphreys, PBR 3rd
 * ed. 3.9.5), on the side of the new direction; at edges: embree_edge.c. */
#ifndef RENDER_TRACE_EMBREE_H
#define RENDER_TRACE_EMBREE_H

#include "render/scene/scene.h"

typedef struct TraceScene TraceScene;

cau_result trace_create(TraceScene **out, const Scene *scene, CauError *err);
void trace_destroy(TraceScene **scene);

typedef struct Ray {
    V3 origin, dir;      /**< true line, dir unit */
    V3 offset;           /**< where Embree starts, relative to origin: 0, or out of the error box */
    double t_min, t_max; /**< along dir */
    unsigned visibility; /**< VISIBLE_*: objects without this bit are passed through; 0: all are seen */
} Ray;

typedef struct Hit {
    V3 position;
    V3 ng, ns;    /**< unit, front side; ns is the interpolated normal, in ng's hemisphere */
    V3 error;     /**< half size of the box that holds the exact point in single precision */
    V3 inward;    /**< 0; of a point at a triangle's edge, the way off it, over the triangle */
    double reach; /**< 0; where the line all but meets an edge, how far off other triangles may meet it */
    double
        slack; /**< along the normal: how near the next hit may be before it is this exact surface itself */
    double t;
    int object;
    uint32_t primitive;
    const Material *material;
} Hit;

/** The nearest hit, or false. */
bool trace_nearest(const TraceScene *scene, const Ray *ray, Hit *hit);

/** The point of a mesh's triangle at barycentrics v, w (of its second and third corner), as if a ray had hit
 * it. */
void trace_triangle_point(
    const TraceScene *scene, int object, uint32_t primitive, double v, double w, Hit *hit);

/** The receiver on which a caster lies, face to face (the first found), or -1. */
int trace_lies_on(const TraceScene *scene, int object);

/** Whether casters lie on a receiver, face to face, and one of them covers it at a place on its surface:
 * nothing is seen there (contact.h). `normal` is unit, the receiver's. */
bool trace_carries(const TraceScene *scene, int receiver);
bool trace_covered(const TraceScene *scene, int receiver, V3 place, V3 normal);

/** Fraction of light that gets along the ray: 0 where something opaque is in between, else the product of the
 *  transparent materials' colours. */
Rgb trace_transmittance(const TraceScene *scene, const Ray *ray);

/** True when anything at all, transparent or not, lies between. */
bool trace_anything_between(const TraceScene *scene, const Ray *ray);

/** True when nothing lies between two places on a surface, looked at from `lift` (scene units) over it.
 * `normal` is unit. */
bool trace_sees_along(const TraceScene *scene, V3 from, V3 to, V3 normal, double lift);

/** A ray from a point in space (camera, lamp). */
Ray ray_from_point(V3 origin, V3 dir, double t_min, double t_max, unsigned visibility);
/** A ray that leaves a surface. */
Ray ray_from_hit(const Hit *hit, V3 dir, double t_max, unsigned visibility);

/** A triangle near a point, in scene space. `exact` surfaces have no corners. */
typedef struct NearTriangle {
    V3 a, b, c;
    int object;
    uint32_t primitive;
    bool exact;
    bool receives; /**< caustic light that falls on its object is kept */
} NearTriangle;

/** Collects the primitives whose box overlaps the ball, at most `capacity`. Returns how many were found;
 *  capacity + 1 when there are more. */
size_t trace_collect(const TraceScene *scene, V3 center, double radius, NearTriangle *out, size_t capacity);

#endif
