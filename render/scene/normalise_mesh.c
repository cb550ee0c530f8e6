/* SPDX-License-Identifier: Apache-2.0 */
/* The geometry of one object: local mesh or exact shape, its bounds, its way into scene space. */
#include "render/scene/scene_internal.h"

#include "core/checked.h"

#include <stdio.h>

static cau_result copy_mesh(const Mesh *from, bool with_normals, Mesh *out, CauError *err) {
    CAU_TRY(mesh_alloc(out, from->vertex_count, from->triangle_count, with_normals, err));
    memcpy(out->positions, from->positions, 3 * sizeof *out->positions * from->vertex_count);
    memcpy(out->triangles, from->triangles, 3 * sizeof *out->triangles * from->triangle_count);
    if (with_normals) memcpy(out->normals, from->normals, 9 * sizeof *out->normals * from->triangle_count);
    return CAU_OK;
}

static cau_result local_mesh(const Object *source, const char *place, Object *out, CauError *err) {
    bool smooth = source->params.smooth != 0;
    if (!source->shape) {
        if (!source->mesh.positions)
            return error_set(err, CAU_ERROR_INPUT,
                "%s: object \"%s\" has neither \"shape\" nor \"file\"; give one", place, source->name);
        CAU_TRY(copy_mesh(&source->mesh, smooth && source->mesh.normals, &out->mesh, err));
        return smooth && !out->mesh.normals ? mesh_smooth_normals(&out->mesh, err) : CAU_OK;
    }
    char shape_place[PLACE_TEXT_MAX + 8];
    snprintf(shape_place, sizeof shape_place, "%s.shape", place);
    CAU_TRY(param_check_required(&source->shape->table, source->shape_data, shape_place, err));
    if (source->shape->check) CAU_TRY(source->shape->check(source->shape_data, shape_place, err));
    out->exact = source->shape->is_exact && source->shape->is_exact(source->shape_data);
    return out->exact ? CAU_OK : source->shape->tessellate(source->shape_data, smooth, &out->mesh, err);
}

static cau_result place_object(const Object *source, const char *place, Object *out, CauError *err) {
    const ObjectParams *p = &source->params;
    if (source->placed == PLACED_BY_MATRIX || source->placed == PLACED_BY_LOOK) {
        out->local_to_scene = affine_from_matrix(p->matrix);
        return CAU_OK;
    }
    for (int c = 0; c < 3; c++)
        if (p->scale[c] == 0)
            return error_set(err, CAU_ERROR_INPUT,
                "%s.scale is %g %g %g: the matrix of object \"%s\" is singular; no component may be 0", place,
                p->scale[0], p->scale[1], p->scale[2], source->name);
    out->local_to_scene = affine_from_parts(p->position, p->rotation_deg, p->scale);
    return CAU_OK;
}

cau_result normalise_shape(const Object *source, size_t index, Object *out, CauError *err) {
    char place[PLACE_TEXT_MAX];
    place_of_object(index, place);
    CAU_TRY(place_object(source, place, out, err));
    return local_mesh(source, place, out, err);
}

static V3 mesh_point(const Mesh *m, size_t i) {
    return v3(m->positions[3 * i], m->positions[3 * i + 1], m->positions[3 * i + 2]);
}

bool object_world_bounds(const Object *o, V3 *lo, V3 *hi) {
    V3 low, high;
    size_t count = o->exact ? 8 : o->mesh.vertex_count;
    if (o->exact) o->shape->bounds(o->shape_data, &low, &high);
    for (size_t i = 0; i < count; i++) {
        V3 p = o->exact ? v3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z)
                        : mesh_point(&o->mesh, i);
        p = affine_point(&o->local_to_scene, p);
        *lo = i ? v3_min(*lo, p) : p;
        *hi = i ? v3_max(*hi, p) : p;
    }
    return count > 0 && (o->exact || o->mesh.triangle_count > 0);
}

/* Sides so nearly in line that the triangle has no area left in double precision. */
static bool has_area(const Mesh *m, const uint32_t v[3]) {
    V3 a = mesh_point(m, v[0]), ab = v3_sub(mesh_point(m, v[1]), a), ac = v3_sub(mesh_point(m, v[2]), a);
    double longest = fmax(v3_dot(ab, ab), v3_dot(ac, ac));
    return v3_length(v3_cross(ab, ac)) > 1e-14 * longest;
}

static void drop_degenerate(Object *o, Warnings *warnings) {
    Mesh *m = &o->mesh;
    size_t kept = 0;
    for (size_t t = 0; t < m->triangle_count; t++) {
        if (!has_area(m, &m->triangles[3 * t])) continue;
        if (kept != t) {
            memcpy(&m->triangles[3 * kept], &m->triangles[3 * t], 3 * sizeof *m->triangles);
            if (m->normals) memcpy(&m->normals[9 * kept], &m->normals[9 * t], 9 * sizeof *m->normals);
        }
        kept++;
    }
    if (kept != m->triangle_count)
        warnings_add(warnings, "object \"%s\": %zu of %zu triangles have no area and were dropped", o->name,
            m->triangle_count - kept, m->triangle_count);
    m->triangle_count = kept;
}

/* A mirrored object keeps its front side, as in Cycles: the order of the corners turns. */
static void turn_winding(Mesh *m) {
    for (size_t t = 0; t < m->triangle_count; t++) {
        uint32_t *v = &m->triangles[3 * t], swap = v[1];
        v[1] = v[2];
        v[2] = swap;
        for (int c = 0; m->normals && c < 3; c++) {
            float *n = &m->normals[9 * t], keep = n[3 + c];
            n[3 + c] = n[6 + c];
            n[6 + c] = keep;
        }
    }
}

static V3 face_normal(const Mesh *m, size_t t) {
    const uint32_t *v = &m->triangles[3 * t];
    V3 a = mesh_point(m, v[0]);
    return v3_normalize(v3_cross(v3_sub(mesh_point(m, v[1]), a), v3_sub(mesh_point(m, v[2]), a)));
}

static void transform_normals(Object *o) {
    Mesh *m = &o->mesh;
    for (size_t corner = 0; corner < 3 * m->triangle_count; corner++) {
        float *f = &m->normals[3 * corner];
        V3 n = v3((double)f[0], (double)f[1], (double)f[2]);
        n = v3_dot(n, n) > 0 ? object_normal(o, n) : face_normal(m, corner / 3);
        f[0] = (float)n.x;
        f[1] = (float)n.y;
        f[2] = (float)n.z;
    }
}

cau_result normalise_mesh(Object *o, Warnings *warnings, CauError *err) {
    Mesh *m = &o->mesh;
    (void)err;
    for (size_t i = 0; i < m->vertex_count; i++) {
        V3 p = affine_point(&o->local_to_scene, mesh_point(m, i));
        m->positions[3 * i] = p.x;
        m->positions[3 * i + 1] = p.y;
        m->positions[3 * i + 2] = p.z;
    }
    if (o->mirrored) turn_winding(m);
    drop_degenerate(o, warnings);
    if (m->normals) transform_normals(o);
    return CAU_OK;
}
