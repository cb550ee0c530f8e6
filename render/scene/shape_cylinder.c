/* SPDX-License-Identifier: Apache-2.0 */
/* The side of a cylinder about Z, from z = 0 up, with or without its ends; exact unless `segments` asks for
 * facets. The front side is outside. */
#include "render/scene/shape_common.h"

typedef struct CylinderParams {
    double radius, height, caps, segments;
} CylinderParams;

static const Param params[] = {
    SHAPE_LENGTH(CylinderParams, radius, "about Z"),
    SHAPE_LENGTH(CylinderParams, height, "from z = 0 up"),
    {.name = "caps",
        .type = PARAM_BOOL,
        .unit = "",
        .offset = offsetof(CylinderParams, caps),
        .max = 1,
        .help = "closed by a disk at each end"},
    SHAPE_SEGMENTS(CylinderParams, 0, 3, 65536, "facets around; without it: exact"),
};

static bool is_exact(const void *data) { return ((const CylinderParams *)data)->segments == 0; }

static cau_result tessellate(const void *data, bool smooth, Mesh *out, CauError *err) {
    const CylinderParams *p = data;
    double r = p->radius, h = p->height;
    const ProfilePoint points[4] = {{0, 0}, {r, 0}, {r, h}, {0, h}};
    const ProfilePoint normals[6] = {{0, -1}, {0, -1}, {1, 0}, {1, 0}, {0, 1}, {0, 1}};
    size_t first = p->caps != 0 ? 0 : 1;
    Profile profile = {points + first, smooth ? normals + 2 * first : NULL, p->caps != 0 ? 4 : 2};
    return mesh_revolve(&profile, (size_t)p->segments, out, err);
}

/* Takes t as the hit when it is the nearest so far. */
static bool nearer(double t, double t_min, double t_max, const ShapeHit *hit, bool found) {
    return t > t_min && t < t_max && (!found || t < hit->t);
}

static bool intersect_side(
    const CylinderParams *p, V3 origin, V3 d, double t_min, double t_max, ShapeHit *hit, bool found) {
    double a = d.x * d.x + d.y * d.y, b = -(origin.x * d.x + origin.y * d.y);
    if (!(a > 0)) return found;
    double nx = origin.x + b / a * d.x, ny = origin.y + b / a * d.y;
    double distance = sqrt(nx * nx + ny * ny), inside = (p->radius - distance) * (p->radius + distance);
    if (!(inside >= 0)) return found;
    double length = sqrt(origin.x * origin.x + origin.y * origin.y),
           c = (length - p->radius) * (length + p->radius);
    double q = b + copysign(sqrt(a * inside), b);
    const double roots[2] = {q != 0 ? c / q : 0, q / a};
    for (int i = 0; i < 2; i++) {
        V3 at = v3_mad(origin, roots[i], d);
        if (!(at.z >= 0 && at.z <= p->height) || !nearer(roots[i], t_min, t_max, hit, found)) continue;
        V3 n = v3_normalize(v3(at.x, at.y, 0));
        *hit = (ShapeHit){roots[i], v3(n.x * p->radius, n.y * p->radius, at.z), n};
        found = true;
    }
    return found;
}

static bool intersect(const void *data, V3 origin, V3 direction, double t_min, double t_max, ShapeHit *hit) {
    const CylinderParams *p = data;
    bool found = intersect_side(p, origin, direction, t_min, t_max, hit, false);
    for (int end = 0; p->caps != 0 && direction.z != 0 && end < 2; end++) {
        double z = end ? p->height : 0, t = (z - origin.z) / direction.z;
        V3 at = v3_mad(origin, t, direction);
        if (!(at.x * at.x + at.y * at.y <= p->radius * p->radius) || !nearer(t, t_min, t_max, hit, found))
            continue;
        *hit = (ShapeHit){t, v3(at.x, at.y, z), v3(0, 0, end ? 1 : -1)};
        found = true;
    }
    return found;
}

static void bounds(const void *data, V3 *lo, V3 *hi) {
    const CylinderParams *p = data;
    *lo = v3(-p->radius, -p->radius, 0);
    *hi = v3(p->radius, p->radius, p->height);
}

const ShapeKind shape_cylinder = {
    .name = "cylinder",
    .help = "the side of a cylinder about Z, from z = 0 up; its ends with `caps`",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(CylinderParams),
    .is_exact = is_exact,
    .tessellate = tessellate,
    .intersect = intersect,
    .bounds = bounds,
};
