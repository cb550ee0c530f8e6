/* SPDX-License-Identifier: Apache-2.0 */
/* What is likely a mistake in a mesh: glass that is open or inside out, vertices with too few digits. */
#include "render/scene/scene_internal.h"

#include "core/checked.h"
#include "core/rng.h"

/* Fewer digits than these (2^-16 of the object's size) show as facets in a caustic. */
#define DIGITS_KEPT 0x1p-16

static void warn_of_digits(const Object *o, const Mesh *local, Warnings *warnings) {
    if (!o->mesh_from_floats || local->vertex_count == 0) return;
    double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY}, far = 0,
           size = 0;
    for (size_t i = 0; i < 3 * local->vertex_count; i++) {
        lo[i % 3] = fmin(lo[i % 3], local->positions[i]);
        hi[i % 3] = fmax(hi[i % 3], local->positions[i]);
        far = fmax(far, fabs(local->positions[i]));
    }
    for (int c = 0; c < 3; c++) size = fmax(size, hi[c] - lo[c]);
    if (size > 0 && far * 0x1p-24 > size * DIGITS_KEPT)
        warnings_add(warnings,
            "object \"%s\" is %g m large but its single-precision vertices lie %g m from its origin, which "
            "leaves %.1f "
            "decimal digits; move its origin to it",
            o->name, size, far, log10(size / (far * 0x1p-24)));
}

/* Vertices at the same place count as one: hosts split them at seams. `same[i]` is the first of them. */
static bool weld(const Mesh *m, uint32_t *same) {
    size_t capacity = 16;
    while (capacity < 2 * m->vertex_count) capacity *= 2;
    uint32_t *table = array_new(capacity, sizeof *table); /* index + 1; 0 is empty */
    if (!table) return false;
    for (size_t i = 0; i < m->vertex_count; i++) {
        const double *p = &m->positions[3 * i];
        uint64_t bits[3], key = 0;
        for (int c = 0; c < 3; c++) {
            double x = p[c] + 0.0; /* -0 and 0 are one place */
            memcpy(&bits[c], &x, sizeof x);
            key = rng_combine(key, bits[c]);
        }
        size_t slot = (size_t)key & (capacity - 1);
        while (table[slot]) {
            const double *q = &m->positions[3 * (size_t)(table[slot] - 1)];
            if (p[0] == q[0] && p[1] == q[1] && p[2] == q[2]) break;
            slot = (slot + 1) & (capacity - 1);
        }
        if (!table[slot]) table[slot] = (uint32_t)i + 1;
        same[i] = table[slot] - 1;
    }
    free(table);
    return true;
}

static int compare_edges(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Edges that do not run once each way. SIZE_MAX: out of memory. */
static size_t open_edges(const Mesh *m) {
    size_t count = 3 * m->triangle_count, open = 0;
    uint32_t *same = array_new(m->vertex_count, sizeof *same);
    uint64_t *there = array_new(2 * count, sizeof *there), *back = there ? there + count : NULL;
    if (!same || !there || !weld(m, same)) {
        free(same);
        free(there);
        return SIZE_MAX;
    }
    for (size_t i = 0; i < count; i++) {
        uint64_t a = same[m->triangles[i]], b = same[m->triangles[i % 3 == 2 ? i - 2 : i + 1]];
        there[i] = a << 32 | b;
        back[i] = b << 32 | a;
    }
    qsort(there, count, sizeof *there, compare_edges);
    qsort(back, count, sizeof *back, compare_edges);
    for (size_t i = 0, j = 0; i < count || j < count;) {
        if (i < count && j < count && there[i] == back[j]) {
            i++;
            j++;
        } else if (j >= count || (i < count && there[i] < back[j])) {
            i++;
            open++;
        } else
            j++; /* seen from the other direction it is counted as open there */
    }
    free(same);
    free(there);
    return open;
}

static double signed_volume(const Mesh *m) {
    double six = 0;
    for (size_t t = 0; t < m->triangle_count; t++) {
        V3 p[3];
        for (int c = 0; c < 3; c++) {
            const double *q = &m->positions[3 * (size_t)m->triangles[3 * t + (size_t)c]];
            p[c] = v3(q[0], q[1], q[2]);
        }
        six += v3_dot(p[0], v3_cross(p[1], p[2]));
    }
    return six / 6;
}

cau_result mesh_warn(
    const Object *o, const Mesh *local, const Material *material, Warnings *warnings, CauError *err) {
    if (!o->shape) warn_of_digits(o, local, warnings);
    bool has_inside = param_find(&material->kind->table, "ior") != NULL;
    if (!has_inside || o->mesh.triangle_count == 0 || (o->shape && o->shape->sheet)) return CAU_OK;
    size_t open = open_edges(&o->mesh);
    if (open == SIZE_MAX)
        return error_set(
            err, CAU_ERROR_RESOURCE, "out of memory while checking the mesh of object \"%s\"", o->name);
    if (open)
        warnings_add(warnings,
            "object \"%s\" is of glass but not closed: %zu edges are open; light that enters may leave "
            "through the hole",
            o->name, open);
    else if (signed_volume(&o->mesh) < 0)
        warnings_add(warnings,
            "object \"%s\" is of glass and inside out; it is rendered as Cycles does, with glass around it "
            "and air "
            "within: flip its normals if that is not meant",
            o->name);
    return CAU_OK;
}
