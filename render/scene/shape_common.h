/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What several shapes share: rows of their tables, writing meshes, surfaces of revolution. */
#ifndef RENDER_SCENE_SHAPE_COMMON_H
#define RENDER_SCENE_SHAPE_COMMON_H

#include "render/scene/shape.h"

/** Sizes in metres: a shape that is larger or smaller has lost its meaning in double precision. */
#define SHAPE_SIZE_MAX 1e12

#define SHAPE_LENGTH(struct_type, field, help_)                                                              \
    {                                                                                                        \
        .name = #field, .type = PARAM_NUMBER, .unit = "m", .offset = offsetof(struct_type, field),           \
        .max = SHAPE_SIZE_MAX, .flags = PARAM_REQUIRED | PARAM_MIN_EXCLUDED, .help = (help_)                 \
    }

#define SHAPE_SIZE(struct_type, type_, help_)                                                                \
    {                                                                                                        \
        .name = "size", .type = (type_), .unit = "m", .offset = offsetof(struct_type, size),                 \
        .max = SHAPE_SIZE_MAX, .flags = PARAM_REQUIRED | PARAM_MIN_EXCLUDED, .help = (help_)                 \
    }

/** Where facets are asked for; 0 (the default, which cannot be set): exact. */
#define SHAPE_SEGMENTS(struct_type, default_, min_, max_, help_)                                             \
    {                                                                                                        \
        .name = "segments", .type = PARAM_NUMBER, .unit = "", .offset = offsetof(struct_type, segments),     \
        .def = {default_}, .min = (min_), .max = (max_), .flags = PARAM_POSITIVE_INT, .help = (help_)        \
    }

static inline void mesh_put_vertex(Mesh *m, size_t i, V3 p) {
    m->positions[3 * i] = p.x;
    m->positions[3 * i + 1] = p.y;
    m->positions[3 * i + 2] = p.z;
}

static inline V3 mesh_get_vertex(const Mesh *m, size_t i) {
    return v3(m->positions[3 * i], m->positions[3 * i + 1], m->positions[3 * i + 2]);
}

static inline void mesh_put_normal(Mesh *m, size_t corner, V3 n) {
    m->normals[3 * corner] = (float)n.x;
    m->normals[3 * corner + 1] = (float)n.y;
    m->normals[3 * corner + 2] = (float)n.z;
}

static inline void mesh_put_triangle(Mesh *m, size_t t, size_t a, size_t b, size_t c) {
    m->triangles[3 * t] = (uint32_t)a;
    m->triangles[3 * t + 1] = (uint32_t)b;
    m->triangles[3 * t + 2] = (uint32_t)c;
}

/** A sheet of nx by ny cells over a rectangle centred at the origin, facing +Z, every vertex at z = 0: vertex
 *  (i, j) has index j (nx + 1) + i, x grows with i and y with j. Cells are split as Blender splits quads. */
cau_result mesh_sheet(
    Mesh *mesh, const double size[2], size_t nx, size_t ny, bool with_normals, CauError *err);

/** A point (r, z) of a profile. */
typedef struct ProfilePoint {
    double r, z;
} ProfilePoint;

/** A profile to revolve about Z. `normals` holds two (r, z) unit normals per segment, at its start and its
 * end, or is NULL for flat faces. The front side is on the right of the walk along the profile. */
typedef struct Profile {
    const ProfilePoint *points, *normals;
    size_t count;
} Profile;

/** Points on the axis become one vertex, a profile that ends where it began is joined. */
cau_result mesh_revolve(const Profile *profile, size_t segments, Mesh *mesh, CauError *err);

#endif
