/* SPDX-License-Identifier: Apache-2.0 */
#include "render/scene/shape_common.h"

#include "core/checked.h"

cau_result mesh_sheet(
    Mesh *mesh, const double size[2], size_t nx, size_t ny, bool with_normals, CauError *err) {
    CAU_TRY(mesh_alloc(mesh, (nx + 1) * (ny + 1), 2 * nx * ny, with_normals, err));
    for (size_t j = 0; j <= ny; j++)
        for (size_t i = 0; i <= nx; i++)
            mesh_put_vertex(mesh, j * (nx + 1) + i,
                v3(((double)i / (double)nx - 0.5) * size[0], ((double)j / (double)ny - 0.5) * size[1], 0));
    for (size_t j = 0; j < ny; j++)
        for (size_t i = 0; i < nx; i++) {
            size_t a = j * (nx + 1) + i, cell = 2 * (j * nx + i);
            mesh_put_triangle(mesh, cell, a, a + 1, a + nx + 2);
            mesh_put_triangle(mesh, cell + 1, a, a + nx + 2, a + nx + 1);
        }
    return CAU_OK;
}

/* A revolution while it is made: where each ring of vertices begins, and the cosines and sines around. */
typedef struct Revolution {
    const Profile *profile;
    size_t segments, *ring, vertices, triangles;
    double *cosine, *sine, axis; /* radii up to `axis` lie on the axis */
    Mesh *mesh;
} Revolution;

static bool on_axis(const Revolution *r, size_t point) { return r->profile->points[point].r <= r->axis; }

static bool joined(const Profile *p) {
    const ProfilePoint *a = &p->points[0], *b = &p->points[p->count - 1];
    return p->count > 3 && a->r == b->r && a->z == b->z;
}

/* Triangles of the band between two points: none along the axis or where a point is repeated. */
static size_t band_triangles(const Revolution *r, size_t i) {
    const ProfilePoint *a = &r->profile->points[i], *b = a + 1;
    if ((a->r == b->r && a->z == b->z) || (on_axis(r, i) && on_axis(r, i + 1))) return 0;
    return (on_axis(r, i) || on_axis(r, i + 1) ? 1u : 2u) * r->segments;
}

static void number_rings(Revolution *r) {
    const Profile *p = r->profile;
    double widest = 0;
    for (size_t i = 0; i < p->count; i++) widest = fmax(widest, p->points[i].r);
    r->axis = 1e-12 * widest;
    for (size_t i = 0; i < p->count; i++) {
        bool again = i > 0 && p->points[i].r == p->points[i - 1].r && p->points[i].z == p->points[i - 1].z;
        r->ring[i] = again ? r->ring[i - 1] : r->vertices;
        if (i == p->count - 1 && joined(p))
            r->ring[i] = r->ring[0];
        else if (!again)
            r->vertices += on_axis(r, i) ? 1 : r->segments;
        if (i + 1 < p->count) r->triangles += band_triangles(r, i);
    }
}

static void put_rings(const Revolution *r) {
    for (size_t i = 0; i < r->profile->count; i++) {
        ProfilePoint p = r->profile->points[i];
        for (size_t j = 0; j < (on_axis(r, i) ? 1 : r->segments); j++)
            mesh_put_vertex(r->mesh, r->ring[i] + j,
                on_axis(r, i) ? v3(0, 0, p.z) : v3(p.r * r->cosine[j], p.r * r->sine[j], p.z));
    }
}

/* Corner `c` of triangle `t`: the start or the end of segment i, at angle j. */
static void put_normal(const Revolution *r, size_t t, int c, size_t i, bool end, size_t j) {
    if (!r->mesh->normals) return;
    ProfilePoint n = r->profile->normals[2 * i + end];
    bool axis = on_axis(r, i + end);
    V3 v = v3(n.r * r->cosine[j], n.r * r->sine[j], n.z);
    if (axis) v = v3(0, 0, n.z < 0 ? -1 : 1);
    mesh_put_normal(r->mesh, 3 * t + (size_t)c, v);
}

static void put_band(const Revolution *r, size_t i, size_t t) {
    bool a_pole = on_axis(r, i), b_pole = on_axis(r, i + 1);
    for (size_t j = 0; j < r->segments; j++) {
        size_t k = (j + 1) % r->segments, a = r->ring[i], b = r->ring[i + 1];
        if (!a_pole) {
            mesh_put_triangle(r->mesh, t, a + j, a + k, b_pole ? b : b + k);
            put_normal(r, t, 0, i, false, j);
            put_normal(r, t, 1, i, false, k);
            put_normal(r, t++, 2, i, true, k);
        }
        if (!b_pole) {
            mesh_put_triangle(r->mesh, t, a_pole ? a : a + j, b + k, b + j);
            put_normal(r, t, 0, i, false, j);
            put_normal(r, t, 1, i, true, k);
            put_normal(r, t++, 2, i, true, j);
        }
    }
}

static cau_result revolve(Revolution *r, CauError *err) {
    if (!r->ring || !r->cosine || !r->sine)
        return error_set(
            err, CAU_ERROR_RESOURCE, "out of memory for a profile of %zu points", r->profile->count);
    for (size_t j = 0; j < r->segments; j++) {
        double angle = 2 * CAU_PI * (double)j / (double)r->segments;
        r->cosine[j] = cos(angle);
        r->sine[j] = sin(angle);
    }
    number_rings(r);
    CAU_TRY(mesh_alloc(r->mesh, r->vertices, r->triangles, r->profile->normals != NULL, err));
    put_rings(r);
    size_t t = 0;
    for (size_t i = 0; i + 1 < r->profile->count; i++) {
        if (band_triangles(r, i)) put_band(r, i, t);
        t += band_triangles(r, i);
    }
    return CAU_OK;
}

cau_result mesh_revolve(const Profile *profile, size_t segments, Mesh *mesh, CauError *err) {
    Revolution r = {.profile = profile, .segments = segments, .mesh = mesh};
    r.ring = array_new(profile->count, sizeof *r.ring);
    r.cosine = array_new(segments, sizeof *r.cosine);
    r.sine = array_new(segments, sizeof *r.sine);
    cau_result result = revolve(&r, err);
    free(r.ring);
    free(r.cosine);
    free(r.sine);
    return result;
}
