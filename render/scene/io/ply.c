/* SPDX-License-Identifier: Apache-2.0 */
/* PLY (Turk 1994, "The PLY Polygon File Format"). Every count is checked against the bytes that are left
 * before anything is allocated for it, every read against the end of the file. */
#include "render/scene/io/ply.h"

#include "core/checked.h"
#include "core/vec.h"

#include <stdlib.h>

static cau_result cut_off(const Ply *p, const char *element, size_t index) {
    return error_set(p->reader->err, CAU_ERROR_INPUT, "%s: the file is cut off or damaged in %s %zu",
        p->place, element, index);
}

static bool read_binary(Ply *p, PlyType type, double *out) {
    size_t size = ply_type_size(type);
    unsigned char raw[8] = {0};
    if ((size_t)(p->end - p->at) < size) return false;
    for (size_t i = 0; i < size; i++) raw[p->format == PLY_BIG ? size - 1 - i : i] = (unsigned char)p->at[i];
    p->at += size;
    uint64_t bits = 0;
    for (size_t i = 0; i < size; i++) bits |= (uint64_t)raw[i] << (8 * i);
    uint32_t low = (uint32_t)bits;
    float single;
    switch (type) {
    case PLY_INT8:
        *out = (double)(int8_t)bits;
        break;
    case PLY_INT16:
        *out = (double)(int16_t)bits;
        break;
    case PLY_INT32:
        *out = (double)(int32_t)bits;
        break;
    case PLY_FLOAT:
        memcpy(&single, &low, sizeof single);
        *out = (double)single;
        break;
    case PLY_DOUBLE:
        memcpy(out, &bits, sizeof *out);
        break;
    default:
        *out = (double)bits;
        break;
    }
    return true;
}

/* The text ends with a zero byte, where strtod() stops. */
static bool read_number(Ply *p, PlyType type, double *out) {
    if (p->format != PLY_TEXT) return read_binary(p, type, out);
    char *end;
    *out = strtod_l(p->at, &end, p->reader->c_locale);
    if (end == p->at || end > p->end) return false;
    p->at = end;
    if (type == PLY_FLOAT) *out = (double)(float)*out;
    return true;
}

static bool is_index(double x, double limit) { return x >= 0 && x < limit && x == floor(x); }

static bool skip_list(Ply *p, const PlyProperty *property) {
    double count, ignored;
    if (!read_number(p, property->count_type, &count) || !is_index(count, 4294967296.0)) return false;
    for (size_t i = 0; i < (size_t)count; i++)
        if (!read_number(p, property->type, &ignored)) return false;
    return true;
}

/* ---- vertices ---- */

static int vertex_slot(const char *name) {
    static const char *const names[] = {"x", "y", "z", "nx", "ny", "nz"};
    for (int i = 0; i < 6; i++)
        if (strcmp(names[i], name) == 0) return i;
    return -1;
}

static cau_result read_vertices(Ply *p, const PlyElement *e, MeshTriangles *out) {
    unsigned present = 0;
    for (size_t k = 0; k < e->property_count; k++) {
        int slot = e->properties[k].list ? -1 : vertex_slot(e->properties[k].name);
        if (slot >= 0) present |= 1u << slot;
        if (slot >= 0 && slot < 3 && e->properties[k].type != PLY_FLOAT) out->doubles = true;
    }
    if ((present & 7u) != 7u)
        return error_set(p->reader->err, CAU_ERROR_INPUT, "%s: its vertices have no x, y and z", p->place);
    bool normals = (present & 56u) == 56u;
    out->vertex_count = e->count;
    out->positions = array_new(e->count, 3 * sizeof *out->positions);
    out->normals = normals ? array_new(e->count, 3 * sizeof *out->normals) : NULL;
    if (!out->positions || (normals && !out->normals))
        return error_set(
            p->reader->err, CAU_ERROR_RESOURCE, "%s: out of memory for %zu vertices", p->place, e->count);
    for (size_t i = 0; i < e->count; i++)
        for (size_t k = 0; k < e->property_count; k++) {
            const PlyProperty *property = &e->properties[k];
            int slot = property->list ? -1 : vertex_slot(property->name);
            double x = 0;
            if (property->list ? !skip_list(p, property) : !read_number(p, property->type, &x))
                return cut_off(p, "vertex", i);
            if (slot >= 0 && slot < 3) out->positions[3 * i + (size_t)slot] = x;
            if (slot >= 3 && normals) out->normals[3 * i + (size_t)slot - 3] = (float)x;
        }
    return CAU_OK;
}

/* ---- faces ---- */

static bool is_corner_list(const PlyProperty *p) {
    return p->list && (strcmp(p->name, "vertex_indices") == 0 || strcmp(p->name, "vertex_index") == 0);
}

static cau_result read_polygon(Ply *p, const PlyProperty *property, size_t face, MeshTriangles *out) {
    double count, corner;
    CauError *err = p->reader->err;
    if (!read_number(p, property->count_type, &count) || !is_index(count, 4294967296.0))
        return cut_off(p, "face", face);
    size_t n = (size_t)count, left = (size_t)(p->end - p->at);
    if (n < 3)
        return error_set(
            err, CAU_ERROR_INPUT, "%s: face %zu has %zu corners; it must have at least 3", p->place, face, n);
    if (n > left) return cut_off(p, "face", face);
    if (!array_reserve((void **)&p->corners, &p->corner_capacity, n, sizeof *p->corners) ||
        !array_reserve((void **)&out->indices, &p->index_capacity, 3 * (out->triangle_count + n - 2),
            sizeof *out->indices))
        return error_set(err, CAU_ERROR_RESOURCE, "%s: out of memory for face %zu", p->place, face);
    for (size_t i = 0; i < n; i++) {
        if (!read_number(p, property->type, &corner)) return cut_off(p, "face", face);
        if (!is_index(corner, (double)out->vertex_count))
            return error_set(err, CAU_ERROR_INPUT, "%s: face %zu uses vertex %g; there are %zu, from 0",
                p->place, face, corner, out->vertex_count);
        p->corners[i] = (uint32_t)corner;
    }
    CAU_TRY(polygon_triangulate(
        p->reader, p->place, out->positions, p->corners, n, out->indices + 3 * out->triangle_count));
    out->triangle_count += n - 2;
    return CAU_OK;
}

static cau_result read_faces(Ply *p, const PlyElement *e, MeshTriangles *out) {
    size_t lists = 0;
    double ignored;
    for (size_t k = 0; k < e->property_count; k++) lists += is_corner_list(&e->properties[k]);
    if (lists != 1 || !out->positions)
        return error_set(p->reader->err, CAU_ERROR_INPUT,
            "%s: its faces must come after the vertices and have one list \"vertex_indices\"", p->place);
    for (size_t i = 0; i < e->count; i++)
        for (size_t k = 0; k < e->property_count; k++) {
            const PlyProperty *property = &e->properties[k];
            if (is_corner_list(property))
                CAU_TRY(read_polygon(p, property, i, out));
            else if (property->list ? !skip_list(p, property) : !read_number(p, property->type, &ignored))
                return cut_off(p, "face", i);
        }
    return CAU_OK;
}

static cau_result skip_element(Ply *p, const PlyElement *e) {
    double ignored;
    for (size_t i = 0; i < e->count; i++)
        for (size_t k = 0; k < e->property_count; k++) {
            const PlyProperty *property = &e->properties[k];
            if (property->list ? !skip_list(p, property) : !read_number(p, property->type, &ignored))
                return cut_off(p, e->name, i);
        }
    return CAU_OK;
}

static cau_result read_elements(Ply *p, MeshTriangles *out) {
    CAU_TRY(ply_header(p));
    for (size_t i = 0; i < p->element_count; i++) {
        const PlyElement *e = &p->elements[i];
        if (strcmp(e->name, "vertex") == 0 && out->positions)
            return error_set(p->reader->err, CAU_ERROR_INPUT, "%s: has two elements \"vertex\"", p->place);
        if (strcmp(e->name, "vertex") == 0)
            CAU_TRY(read_vertices(p, e, out));
        else if (strcmp(e->name, "face") == 0)
            CAU_TRY(read_faces(p, e, out));
        else
            CAU_TRY(skip_element(p, e));
    }
    if (out->triangle_count == 0)
        return error_set(p->reader->err, CAU_ERROR_INPUT, "%s: holds no faces", p->place);
    return CAU_OK;
}

cau_result ply_read(Reader *r, const char *place, const char *data, size_t size, MeshTriangles *out) {
    Ply p = {.reader = r, .place = place, .begin = data, .at = data, .end = data + size};
    cau_result result = read_elements(&p, out);
    free(p.corners);
    return result;
}
