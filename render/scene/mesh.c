/* SPDX-License-Identifier: Apache-2.0 */
/* Triangle meshes: memory, smooth normals, and taking one over from the caller. */
#include "render/scene/scene_internal.h"

#include "core/checked.h"

void mesh_free(Mesh *mesh) {
    free(mesh->positions);
    free(mesh->triangles);
    free(mesh->normals);
    *mesh = (Mesh){0};
}

cau_result mesh_alloc(Mesh *mesh, size_t vertices, size_t triangles, bool with_normals, CauError *err) {
    size_t corners, numbers;
    *mesh = (Mesh){0};
    if (vertices > UINT32_MAX || triangles > UINT32_MAX)
        return error_set(err, CAU_ERROR_INPUT,
            "a mesh of %zu vertices and %zu triangles is too large; the limit is 4294967295 of each",
            vertices, triangles);
    bool ok = checked_mul(triangles, 3, &corners) && checked_mul(corners, 3, &numbers) &&
              (mesh->positions = array_new(vertices, 3 * sizeof(double))) &&
              (mesh->triangles = array_new(corners, sizeof(uint32_t))) &&
              (!with_normals || (mesh->normals = array_new(numbers, sizeof(float))));
    if (!ok) {
        mesh_free(mesh);
        return error_set(err, CAU_ERROR_RESOURCE,
            "out of memory for a mesh of %zu vertices and %zu triangles", vertices, triangles);
    }
    mesh->vertex_count = vertices;
    mesh->triangle_count = triangles;
    return CAU_OK;
}

static V3 vertex(const Mesh *m, uint32_t i) {
    const double *p = &m->positions[3 * (size_t)i];
    return v3(p[0], p[1], p[2]);
}

/* atan2 of cross and dot keeps its digits for slivers, where acos loses them. */
static double corner_angle(V3 a, V3 b) { return atan2(v3_length(v3_cross(a, b)), v3_dot(a, b)); }

static void add_face_normals(const Mesh *m, double *sums) {
    for (size_t t = 0; t < m->triangle_count; t++) {
        const uint32_t *v = &m->triangles[3 * t];
        V3 p[3] = {vertex(m, v[0]), vertex(m, v[1]), vertex(m, v[2])};
        V3 n = v3_cross(v3_sub(p[1], p[0]), v3_sub(p[2], p[0]));
        double length = v3_length(n);
        if (!(length > 0)) continue;
        for (int c = 0; c < 3; c++) {
            double weight = corner_angle(v3_sub(p[(c + 1) % 3], p[c]), v3_sub(p[(c + 2) % 3], p[c])) / length;
            double *sum = &sums[3 * (size_t)v[c]];
            sum[0] += n.x * weight;
            sum[1] += n.y * weight;
            sum[2] += n.z * weight;
        }
    }
}

static void store_normal(float *out, V3 n) {
    out[0] = (float)n.x;
    out[1] = (float)n.y;
    out[2] = (float)n.z;
}

cau_result mesh_smooth_normals(Mesh *mesh, CauError *err) {
    double *sums = array_new(mesh->vertex_count, 3 * sizeof *sums);
    float *normals = array_new(mesh->triangle_count, 9 * sizeof *normals);
    if (!sums || !normals) {
        free(sums);
        free(normals);
        return error_set(
            err, CAU_ERROR_RESOURCE, "out of memory for the normals of %zu triangles", mesh->triangle_count);
    }
    add_face_normals(mesh, sums);
    for (size_t corner = 0; corner < 3 * mesh->triangle_count; corner++) {
        const double *sum = &sums[3 * (size_t)mesh->triangles[corner]];
        V3 n = v3(sum[0], sum[1], sum[2]);
        double length = v3_length(n);
        /* Opposite faces cancel at some vertices; the face's own normal takes over when it is normalised. */
        store_normal(&normals[3 * corner], length > 0 ? v3_scale(n, 1 / length) : v3(0, 0, 0));
    }
    free(sums);
    free(mesh->normals);
    mesh->normals = normals;
    return CAU_OK;
}
