/* SPDX-License-Identifier: Apache-2.0 */
/* An object's shape: parametric, or a mesh written out in the file; and files of heights. */
#include "render/scene/io/reader.h"

#include "core/checked.h"
#include "core/param.h"

#include <math.h>

#define HEIGHTS_BYTES_MAX ((size_t)256 << 20)

/* Rows of three numbers from a key of an inline mesh. */
typedef struct Rows {
    double *values;
    size_t count;
} Rows;

static cau_result read_rows(Reader *r, const char *place, const json_t *mesh, const char *key, Rows *out) {
    const json_t *list = json_object_get(mesh, key);
    char row[READER_PLACE_MAX];
    *out = (Rows){0};
    if (!list) return error_set(r->err, CAU_ERROR_INPUT, "%s: \"%s\" is missing", place, key);
    if (!json_is_array(list)) return reader_wrong_type(r, place, key, "a list of lists of 3 numbers", list);
    out->count = json_array_size(list);
    out->values = array_new(out->count, 3 * sizeof *out->values);
    if (!out->values)
        return error_set(r->err, CAU_ERROR_RESOURCE, "%s: out of memory for \"%s\"", place, key);
    for (size_t i = 0; i < out->count; i++) {
        snprintf(row, sizeof row, "%.200s[%zu]", key, i);
        CAU_TRY(reader_numbers(r, place, row, json_array_get(list, i), 3, out->values + 3 * i));
    }
    return CAU_OK;
}

typedef struct InlineMesh {
    Rows vertices, triangles, normals;
    uint32_t *indices;
    float *directions;
} InlineMesh;

static cau_result read_indices(Reader *r, const char *place, InlineMesh *m) {
    size_t count = 3 * m->triangles.count;
    m->indices = array_new(count, sizeof *m->indices);
    if (!m->indices)
        return error_set(r->err, CAU_ERROR_RESOURCE, "%s: out of memory for \"triangles\"", place);
    for (size_t i = 0; i < count; i++) {
        double x = m->triangles.values[i];
        if (!(x >= 0 && x < (double)m->vertices.count) || x != floor(x))
            return error_set(r->err, CAU_ERROR_INPUT,
                "%s.triangles[%zu] holds %g; it must be three vertex numbers from 0, less than the %zu "
                "vertices",
                place, i / 3, x, m->vertices.count);
        m->indices[i] = (uint32_t)x;
    }
    return CAU_OK;
}

static cau_result read_normals(Reader *r, const char *place, const json_t *shape, InlineMesh *m) {
    CAU_TRY(read_rows(r, place, shape, "normals", &m->normals));
    size_t count = m->normals.count;
    if (count != m->vertices.count && count != 3 * m->triangles.count)
        return error_set(r->err, CAU_ERROR_INPUT,
            "%s.normals has %zu entries; it must have one per vertex (%zu) or per corner (%zu)", place, count,
            m->vertices.count, 3 * m->triangles.count);
    m->directions = array_new(count, 3 * sizeof *m->directions);
    if (!m->directions)
        return error_set(r->err, CAU_ERROR_RESOURCE, "%s: out of memory for \"normals\"", place);
    for (size_t i = 0; i < count; i++) { /* unit length first: it may not fit a float as it is */
        const double *n = m->normals.values + 3 * i;
        double length = hypot(hypot(n[0], n[1]), n[2]);
        for (size_t c = 0; c < 3 && length > 0; c++) m->directions[3 * i + c] = (float)(n[c] / length);
    }
    return CAU_OK;
}

static cau_result read_inline(
    Reader *r, cau_item object, const char *place, const json_t *shape, InlineMesh *m) {
    static const char *const known[] = {"type", "vertices", "triangles", "normals", "uvs"};
    const size_t count = sizeof known / sizeof known[0];
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)shape, key, value) {
        size_t i = 0;
        while (i < count && strcmp(known[i], key) != 0) i++;
        if (i == count) return param_unknown(place, "key", key, known, count, r->err);
    } /* uvs are let pass: without textures they mean nothing */
    CAU_TRY(read_rows(r, place, shape, "vertices", &m->vertices));
    CAU_TRY(read_rows(r, place, shape, "triangles", &m->triangles));
    CAU_TRY(read_indices(r, place, m));
    if (json_object_get(shape, "normals")) CAU_TRY(read_normals(r, place, shape, m));
    cau_mesh mesh = {.size = sizeof mesh,
        .positions = m->vertices.values,
        .positions_are_double = 1,
        .vertex_count = m->vertices.count,
        .triangles = m->indices,
        .triangle_count = m->triangles.count,
        .normals = m->directions,
        .normals_are_per_corner = m->normals.count != m->vertices.count};
    return cau_set_mesh(r->scene, object, &mesh);
}

static cau_result inline_mesh(Reader *r, cau_item object, const char *place, const json_t *shape) {
    InlineMesh m = {0};
    cau_result result = read_inline(r, object, place, shape, &m);
    free(m.vertices.values);
    free(m.triangles.values);
    free(m.normals.values);
    free(m.indices);
    free(m.directions);
    return result;
}

cau_result reader_shape(Reader *r, cau_item object, const char *place, const json_t *shape) {
    char here[READER_PLACE_MAX];
    const char *type, *key;
    json_t *value;
    cau_item item;
    snprintf(here, sizeof here, "%s.shape", place);
    if (!json_is_object(shape)) return reader_wrong_type(r, here, "", "an object {...}", shape);
    CAU_TRY(reader_text(r, here, shape, "type", &type));
    if (strcmp(type, "mesh") == 0) return inline_mesh(r, object, here, shape);
    CAU_TRY(cau_add_shape(r->scene, object, type, &item));
    json_object_foreach((json_t *)(uintptr_t)shape, key, value) if (strcmp(key, "type") != 0)
        CAU_TRY(reader_value(r, item, here, key, value));
    return CAU_OK;
}

/* Numbers of a text, row by row; '#' begins a comment. */
typedef struct Heights {
    double *values;
    size_t count, capacity, columns, line;
} Heights;

static cau_result read_row(Reader *r, const char *place, char *text, Heights *h) {
    size_t before = h->count;
    h->line++;
    for (char *at = text;;) {
        at += strspn(at, " \t\r,");
        if (*at == '\0') break;
        char *end;
        double x = strtod_l(at, &end, r->c_locale);
        if (end == at || !isfinite(x) || (*end && !strchr(" \t\r,", *end)))
            return error_set(r->err, CAU_ERROR_INPUT, "%s, line %zu: \"%.20s\" is not a finite number", place,
                h->line, at);
        if (!array_reserve((void **)&h->values, &h->capacity, h->count + 1, sizeof x))
            return error_set(r->err, CAU_ERROR_RESOURCE, "%s: out of memory", place);
        h->values[h->count++] = x;
        at = end;
    }
    size_t columns = h->count - before;
    if (columns == 0) return CAU_OK;
    if (!h->columns) h->columns = columns;
    if (columns != h->columns)
        return error_set(r->err, CAU_ERROR_INPUT, "%s, line %zu has %zu numbers; the first row has %zu",
            place, h->line, columns, h->columns);
    return CAU_OK;
}

static cau_result read_heights(Reader *r, const char *place, char *text, Heights *h) {
    while (text) {
        char *next = strchr(text, '\n');
        if (next) *next++ = '\0';
        text[strcspn(text, "#")] = '\0';
        CAU_TRY(read_row(r, place, text, h));
        text = next;
    }
    return CAU_OK;
}

cau_result reader_heights(Reader *r, cau_item shape, const char *place, const char *key, const char *name) {
    char *path, *text = NULL, here[READER_PLACE_MAX];
    size_t size = 0;
    Heights h = {0};
    CAU_TRY(reader_resolve(r, place, key, name, &path));
    snprintf(here, sizeof here, "%s.%s \"%.200s\"", place, key, name);
    cau_result result = file_read(path, HEIGHTS_BYTES_MAX, here, &text, &size, r->err);
    if (result == CAU_OK && memchr(text, '\0', size))
        result = error_set(r->err, CAU_ERROR_INPUT, "%s: not a text file", here);
    if (result == CAU_OK) result = read_heights(r, here, text, &h);
    double columns = (double)h.columns;
    if (result == CAU_OK && h.count == 0)
        result = error_set(r->err, CAU_ERROR_INPUT, "%s: holds no number", here);
    if (result == CAU_OK) result = cau_set(r->scene, shape, "columns", &columns, 1);
    if (result == CAU_OK) result = cau_set(r->scene, shape, key, h.values, h.count);
    free(path);
    free(text);
    free(h.values);
    return result;
}
