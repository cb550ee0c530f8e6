/* SPDX-License-Identifier: Apache-2.0 */
/* A sphere about the origin, exact unless `segments` asks for facets. */
#include "render/scene/shape_common.h"

#include "core/checked.h"

typedef struct SphereParams {
    double radius, segments;
} SphereParams;

static const Param params[] = {
    SHAPE_LENGTH(SphereParams, radius, "about the origin"),
    SHAPE_SEGMENTS(
        SphereParams, 0, 3, 4096, "facets around, half as many from pole to pole; without it: exact"),
};

static bool is_exact(const void *data) { return ((const SphereParams *)data)->segments == 0; }

static void fill_meridian(const SphereParams *p, size_t rings, ProfilePoint *points, ProfilePoint *normals) {
    for (size_t i = 0; i <= rings; i++) {
        double angle = CAU_PI * (double)i / (double)rings;
        ProfilePoint n = {
            i == 0 || i == rings ? 0 : sin(angle), i == 0 ? -1 : (i == rings ? 1 : -cos(angle))};
        points[i] = (ProfilePoint){p->radius * n.r, p->radius * n.z};
        if (i < rings) normals[2 * i] = n;
        if (i > 0) normals[2 * i - 1] = n;
    }
}

static cau_result tessellate(const void *data, bool smooth, Mesh *out, CauError *err) {
    const SphereParams *p = data;
    size_t segments = (size_t)p->segments, rings = segments / 2 < 2 ? 2 : segments / 2;
    ProfilePoint *points = array_new(rings + 1, sizeof *points),
                 *normals = array_new(2 * rings, sizeof *normals);
    cau_result result = CAU_ERROR_RESOURCE;
    if (points && normals) {
        fill_meridian(p, rings, points, normals);
        result = mesh_revolve(&(Profile){points, smooth ? normals : NULL, rings + 1}, segments, out, err);
    } else
        error_set(err, result, "out of memory for a sphere of %zu segments", segments);
    free(points);
    free(normals);
    return result;
}

/* The discriminant from the distance of the line to the centre keeps its digits for far rays (Haines et al.
 * 2019, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, chapter 7). */
static bool intersect(const void *data, V3 origin, V3 direction, double t_min, double t_max, ShapeHit *hit) {
    double r = ((const SphereParams *)data)->radius;
    double a = v3_dot(direction, direction), b = -v3_dot(origin, direction);
    V3 nearest = v3_mad(origin, b / a, direction);
    double distance = v3_length(nearest), inside = (r - distance) * (r + distance);
    if (!(inside >= 0)) return false;
    double length = v3_length(origin), c = (length - r) * (length + r);
    double q = b + copysign(sqrt(a * inside), b);
    double t0 = q != 0 ? c / q : 0, t1 = q / a;
    if (t0 > t1) {
        double swap = t0;
        t0 = t1;
        t1 = swap;
    }
    double t = t0 > t_min ? t0 : t1;
    if (!(t > t_min && t < t_max)) return false;
    hit->t = t;
    hit->normal = v3_normalize(v3_mad(origin, t, direction));
    hit->position = v3_scale(hit->normal, r);
    return true;
}

static void bounds(const void *data, V3 *lo, V3 *hi) {
    double r = ((const SphereParams *)data)->radius;
    *lo = v3(-r, -r, -r);
    *hi = v3(r, r, r);
}

const ShapeKind shape_sphere = {
    .name = "sphere",
    .help = "a sphere about the origin",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(SphereParams),
    .is_exact = is_exact,
    .tessellate = tessellate,
    .intersect = intersect,
    .bounds = bounds,
};
