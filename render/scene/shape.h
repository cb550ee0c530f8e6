/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Shapes: parametric surfaces that become triangles, or are intersected exactly in double precision.
 *
 *  A shape is one file with a ShapeKind and one line in shapes.def. */
#ifndef RENDER_SCENE_SHAPE_H
#define RENDER_SCENE_SHAPE_H

#include "core/error.h"
#include "core/param.h"
#include "core/vec.h"

#include <stddef.h>
#include <stdint.h>

/** A triangle mesh, owned. */
typedef struct Mesh {
    double *positions; /**< vertex_count * 3, local space until normalised, then scene space */
    size_t vertex_count;
    uint32_t *triangles; /**< triangle_count * 3, counter-clockwise seen from the front */
    size_t triangle_count;
    float *normals; /**< 3 * triangle_count * 3 unit normals, one per corner, or NULL where flat */
} Mesh;

void mesh_free(Mesh *mesh);
/** Allocates an empty mesh of the given size, normals per corner if `with_normals`. */
cau_result mesh_alloc(Mesh *mesh, size_t vertices, size_t triangles, bool with_normals, CauError *err);

/** A hit of an exact surface, in the shape's local space. */
typedef struct ShapeHit {
    double t;            /**< ray parameter, in units of the (unnormalised) direction */
    V3 position, normal; /**< normal: unit, towards the front side */
} ShapeHit;

typedef struct ShapeKind {
    const char *name, *help;
    ParamTable table;
    size_t data_size;
    bool sheet; /**< open by nature: no warning when it is of glass */
    /** Validates what a table cannot say (e.g. profiles); may be NULL. `owner` is the place,
     *  e.g. "objects[2].shape". */
    cau_result (*check)(const void *data, const char *owner, CauError *err);
    /** True when this instance is to be intersected exactly (no `segments` asked for). NULL: never. */
    bool (*is_exact)(const void *data);
    /** Triangles in local space, front side outward / up; `smooth` asks for the surface's own normals where
     * it is curved. NULL for shapes that are always exact. */
    cau_result (*tessellate)(const void *data, bool smooth, Mesh *out, CauError *err);
    /** The nearest hit with t in (t_min, t_max), or false. Double precision throughout. Local space. The
     * position lies on the surface to a few units in the last place of the shape's size, whatever the
     * distance. */
    bool (*intersect)(const void *data, V3 origin, V3 direction, double t_min, double t_max, ShapeHit *hit);
    /** Local bounding box. Only for exact shapes. */
    void (*bounds)(const void *data, V3 *lo, V3 *hi);
} ShapeKind;

const ShapeKind *shape_find(const char *name);
/** All kinds, in the order of shapes.def; *count receives how many. */
const ShapeKind *const *shape_kinds(size_t *count);

/** Corner normals for smooth shading where the file gave none: face normals averaged per vertex with the
 *  corner angle as weight, as Blender does. */
cau_result mesh_smooth_normals(Mesh *mesh, CauError *err);

#endif
