/* SPDX-License-Identifier: Apache-2.0 */
/* cau_set_mesh(): the caller's arrays are checked and copied once. */
#include "render/scene/scene_internal.h"

#include "core/checked.h"

typedef struct MeshRequest {
    struct cau_scene *scene;
    const cau_mesh *mesh;
    ItemView view;
    size_t position_stride, triangle_stride, normal_stride;
} MeshRequest;

static cau_result bad_mesh(const MeshRequest *r, const char *what, size_t value, const char *limit) {
    return error_set(&r->scene->context->error, CAU_ERROR_INPUT,
        "%s: the mesh of object \"%s\" has %s %zu; %s", r->view.place, r->scene->objects[r->view.index].name,
        what, value, limit);
}

static cau_result check_counts(MeshRequest *r) {
    const cau_mesh *m = r->mesh;
    size_t position = m->positions_are_double ? 3 * sizeof(double) : 3 * sizeof(float);
    size_t triangle = 3 * sizeof(uint32_t), normal = 3 * sizeof(float);
    r->position_stride = m->position_stride ? m->position_stride : position;
    r->triangle_stride = m->triangle_stride ? m->triangle_stride : triangle;
    r->normal_stride = m->normal_stride ? m->normal_stride : normal;
    if (r->position_stride < position)
        return bad_mesh(r, "a position stride of", r->position_stride, "it is too small");
    if (r->triangle_stride < triangle)
        return bad_mesh(r, "a triangle stride of", r->triangle_stride, "it is too small");
    if (r->normal_stride < normal)
        return bad_mesh(r, "a normal stride of", r->normal_stride, "it is too small");
    if (m->vertex_count && !m->positions)
        return bad_mesh(r, "no positions for a vertex_count of", m->vertex_count, "give both");
    if (m->triangle_count && !m->triangles)
        return bad_mesh(r, "no indices for a triangle_count of", m->triangle_count, "give both");
    return CAU_OK;
}

/* Strides need not keep numbers aligned, hence memcpy. */
static cau_result copy_positions(const MeshRequest *r, Mesh *out) {
    for (size_t i = 0; i < out->vertex_count; i++) {
        const char *from = (const char *)r->mesh->positions + i * r->position_stride;
        double *to = &out->positions[3 * i];
        if (r->mesh->positions_are_double)
            memcpy(to, from, 3 * sizeof *to);
        else {
            float f[3];
            memcpy(f, from, sizeof f);
            for (int c = 0; c < 3; c++) to[c] = (double)f[c];
        }
        for (int c = 0; c < 3; c++)
            if (!(fabs(to[c]) <= 1e12))
                return bad_mesh(
                    r, "a coordinate that is not finite or beyond 1e12 m in vertex", i, "mend the mesh");
    }
    return CAU_OK;
}

static cau_result copy_triangles(const MeshRequest *r, Mesh *out) {
    for (size_t t = 0; t < out->triangle_count; t++) {
        uint32_t *to = &out->triangles[3 * t];
        memcpy(to, (const char *)r->mesh->triangles + t * r->triangle_stride, 3 * sizeof *to);
        for (int c = 0; c < 3; c++)
            if (to[c] >= out->vertex_count)
                return error_set(&r->scene->context->error, CAU_ERROR_INPUT,
                    "%s: triangle %zu of the mesh of object \"%s\" uses vertex %u; there are only %zu",
                    r->view.place, t, r->scene->objects[r->view.index].name, to[c], out->vertex_count);
    }
    return CAU_OK;
}

static cau_result copy_normals(const MeshRequest *r, Mesh *out) {
    for (size_t corner = 0; corner < 3 * out->triangle_count; corner++) {
        size_t i = r->mesh->normals_are_per_corner ? corner : out->triangles[corner];
        float n[3];
        memcpy(n, (const char *)r->mesh->normals + i * r->normal_stride, sizeof n);
        V3 v = v3((double)n[0], (double)n[1], (double)n[2]);
        if (!v3_finite(v)) return bad_mesh(r, "a normal that is not finite, number", i, "mend the mesh");
        double length = v3_length(v);
        if (length > 0) v = v3_scale(v, 1 / length);
        out->normals[3 * corner] = (float)v.x; /* zero: the face's normal takes over */
        out->normals[3 * corner + 1] = (float)v.y;
        out->normals[3 * corner + 2] = (float)v.z;
    }
    return CAU_OK;
}

static cau_result copy_mesh(const MeshRequest *r, Mesh *out) {
    const cau_mesh *m = r->mesh;
    CAU_TRY(
        mesh_alloc(out, m->vertex_count, m->triangle_count, m->normals != NULL, &r->scene->context->error));
    CAU_TRY(copy_positions(r, out));
    CAU_TRY(copy_triangles(r, out));
    return m->normals ? copy_normals(r, out) : CAU_OK;
}

cau_result cau_set_mesh(cau_scene *scene, cau_item object, const cau_mesh *mesh) {
    if (!scene || !mesh) return CAU_ERROR_USAGE;
    CauError *err = &scene->context->error;
    MeshRequest r = {.scene = scene, .mesh = mesh};
    CAU_TRY(item_view(scene, object, &r.view));
    if (r.view.kind != ITEM_OBJECT)
        return error_set(err, CAU_ERROR_USAGE, "%s: cau_set_mesh() needs an object", r.view.place);
    if (mesh->size != sizeof *mesh)
        return error_set(err, CAU_ERROR_USAGE,
            "%s: cau_mesh.size is %zu; it must be %zu, the size of this library's struct", r.view.place,
            mesh->size, sizeof *mesh);
    Object *o = &scene->objects[r.view.index];
    if (o->shape)
        return error_set(
            err, CAU_ERROR_INPUT, "%s: object \"%s\" has a shape already; give one", r.view.place, o->name);
    CAU_TRY(check_counts(&r));
    Mesh copy;
    cau_result result = copy_mesh(&r, &copy);
    if (result != CAU_OK) {
        mesh_free(&copy);
        return result;
    }
    mesh_free(&o->mesh); /* a mesh may be replaced: an animation does */
    o->mesh = copy;
    o->mesh_from_floats = !mesh->positions_are_double;
    return CAU_OK;
}
