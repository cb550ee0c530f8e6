/* SPDX-License-Identifier: Apache-2.0 */
/* Polygons to triangles. Quads are split as Blender splits them; larger ones by cutting off ears (Meisters
 * 1975, "Polygons Have Ears") in the plane of their mean normal. */
#include "render/scene/io/mesh_source.h"

#include "core/checked.h"
#include "core/vec.h"

typedef struct Point2 {
    double x, y;
} Point2;

static V3 point(const double *positions, uint32_t i) {
    const double *p = &positions[3 * (size_t)i];
    return v3(p[0], p[1], p[2]);
}

static void put(uint32_t *out, uint32_t a, uint32_t b, uint32_t c) {
    out[0] = a;
    out[1] = b;
    out[2] = c;
}

/* From corner 0 to 2, unless the quad folds over that diagonal. */
static void split_quad(const double *positions, const uint32_t *i, uint32_t *out) {
    V3 a = point(positions, i[0]), diagonal = v3_sub(point(positions, i[2]), a);
    V3 one = v3_cross(v3_sub(point(positions, i[1]), a), diagonal);
    V3 other = v3_cross(v3_sub(point(positions, i[3]), a), diagonal);
    bool folds = v3_dot(one, other) > 0;
    put(out, i[0], i[1], folds ? i[3] : i[2]);
    put(out + 3, folds ? i[1] : i[0], i[2], i[3]);
}

/* Twice the signed area; positive when counter-clockwise. */
static double turn(Point2 a, Point2 b, Point2 c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static void flatten(const double *positions, const uint32_t *corners, size_t n, Point2 *out) {
    V3 normal = v3(0, 0, 0), first = point(positions, corners[0]), s, t;
    for (size_t i = 1; i + 1 < n; i++)
        normal = v3_add(normal, v3_cross(v3_sub(point(positions, corners[i]), first),
                                    v3_sub(point(positions, corners[i + 1]), first)));
    double length = v3_length(normal);
    normal = length > 0 ? v3_scale(normal, 1 / length) : v3(0, 0, 1);
    v3_frame(normal, &s, &t);
    for (size_t i = 0; i < n; i++) {
        V3 d = v3_sub(point(positions, corners[i]), first);
        out[i] = (Point2){v3_dot(d, s), v3_dot(d, t)};
    }
}

/* Positions i - 1, i, i + 1 of `left` make a convex corner that holds no other vertex. */
static bool is_ear(const Point2 *p, const size_t *left, size_t count, size_t i) {
    size_t a = left[(i + count - 1) % count], b = left[i], c = left[(i + 1) % count];
    if (!(turn(p[a], p[b], p[c]) > 0)) return false;
    for (size_t k = 0; k < count; k++) {
        size_t q = left[k];
        if (q == a || q == b || q == c) continue;
        if (turn(p[a], p[b], p[q]) >= 0 && turn(p[b], p[c], p[q]) >= 0 && turn(p[c], p[a], p[q]) >= 0)
            return false;
    }
    return true;
}

static bool is_convex(const Point2 *p, size_t n) {
    for (size_t i = 0; i < n; i++)
        if (turn(p[i], p[(i + 1) % n], p[(i + 2) % n]) < 0) return false;
    return true;
}

static void cut_ears(const Point2 *p, const uint32_t *corners, size_t n, size_t *left, uint32_t *out) {
    for (size_t i = 0; i < n; i++) left[i] = i;
    for (size_t count = n, at = 0; count > 2; count--) {
        size_t tries = 0;
        while (tries < count && !is_ear(p, left, count, at % count)) {
            at++;
            tries++;
        }
        at %= count; /* no ear: the polygon crosses itself, any corner will do */
        put(out, corners[left[(at + count - 1) % count]], corners[left[at]], corners[left[(at + 1) % count]]);
        out += 3;
        memmove(left + at, left + at + 1, (count - at - 1) * sizeof *left);
    }
}

cau_result polygon_triangulate(
    Reader *r, const char *place, const double *positions, const uint32_t *corners, size_t n, uint32_t *out) {
    if (n == 3) put(out, corners[0], corners[1], corners[2]);
    if (n == 4) split_quad(positions, corners, out);
    if (n <= 4) return CAU_OK;
    Point2 *flat = array_new(n, sizeof *flat);
    size_t *left = array_new(n, sizeof *left);
    cau_result result = CAU_OK;
    if (!flat || !left)
        result =
            error_set(r->err, CAU_ERROR_RESOURCE, "%s: out of memory for a face of %zu corners", place, n);
    else {
        flatten(positions, corners, n, flat);
        if (is_convex(flat, n))
            for (size_t i = 1; i + 1 < n; i++) put(out + 3 * (i - 1), corners[0], corners[i], corners[i + 1]);
        else if (n <= POLYGON_CORNERS_MAX)
            cut_ears(flat, corners, n, left, out);
        else
            result = error_set(r->err, CAU_ERROR_INPUT,
                "%s: a face that is not convex has %zu corners; the limit is %d: triangulate it", place, n,
                POLYGON_CORNERS_MAX);
    }
    free(flat);
    free(left);
    return result;
}
