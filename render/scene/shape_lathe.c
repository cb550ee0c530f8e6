/* SPDX-License-Identifier: Apache-2.0 */
/* A profile revolved about Z. The front side is on the right of the walk along the profile: outside, when an
 * outline climbs. Smooth normals are those that Blender gives the same mesh of quads: the normals of the
 * faces around a vertex, weighted by their angles there. A repeated point makes a crease. */
#include "render/scene/shape_common.h"

#include "core/checked.h"

typedef struct LatheParams {
    ParamList profile;
    double segments;
} LatheParams;

static const char *const point_names[] = {"r", "z", NULL};

static const Param params[] = {
    {.name = "profile",
        .type = PARAM_LIST,
        .unit = "m",
        .offset = offsetof(LatheParams, profile),
        .min = -SHAPE_SIZE_MAX,
        .max = SHAPE_SIZE_MAX,
        .flags = PARAM_REQUIRED,
        .choices = point_names,
        .tuple = 2,
        .help = "points [r, z] from the bottom up the outside; r = 0 lies on the axis"},
    SHAPE_SEGMENTS(LatheParams, 128, 3, 16384, "facets around"),
};

static cau_result check(const void *data, const char *owner, CauError *err) {
    const LatheParams *p = data;
    if (p->profile.count < 2)
        return error_set(err, CAU_ERROR_INPUT, "%s.profile has %zu points; it must have at least 2", owner,
            p->profile.count);
    double widest = 0;
    for (size_t i = 0; i < p->profile.count; i++) {
        double r = p->profile.values[2 * i];
        if (r < 0)
            return error_set(err, CAU_ERROR_INPUT,
                "%s.profile[%zu] has the radius %g m; it must be at least 0", owner, i, r);
        widest = fmax(widest, r);
    }
    if (widest == 0)
        return error_set(
            err, CAU_ERROR_INPUT, "%s.profile lies on the axis; some radius must be greater than 0", owner);
    if ((double)p->profile.count * p->segments > 3e7)
        return error_set(err, CAU_ERROR_INPUT, "%s has %zu points times %g segments; the limit is 3e7", owner,
            p->profile.count, p->segments);
    return CAU_OK;
}

static V3 on_ring(ProfilePoint p, double angle) { return v3(p.r * cos(angle), p.r * sin(angle), p.z); }

/* What the faces of the band from `at` to `other` add to the normal at `at`, in (r, z). `forward`: `other`
 * comes after `at` on the profile. By symmetry the left and the right face add the same. */
static ProfilePoint band_share(ProfilePoint at, ProfilePoint other, bool forward, double step) {
    ProfilePoint a = forward ? at : other, b = forward ? other : at;
    double half = cos(0.5 * step);
    ProfilePoint n = {b.z - a.z, -(b.r - a.r) * half}; /* of the face, in the plane through its middle */
    double length = hypot(n.r, n.z);
    if (!(length > 0)) return (ProfilePoint){0, 0};
    V3 here = on_ring(at, 0), along = v3_sub(on_ring(other, 0), here),
       around = v3_sub(on_ring(at, step), here);
    if (at.r == 0) around = v3_sub(on_ring(other, step), here);
    double angle = atan2(v3_length(v3_cross(along, around)), v3_dot(along, around));
    return (ProfilePoint){n.r * half * angle / length, n.z * angle / length};
}

static ProfilePoint vertex_normal(const Profile *p, size_t i, double step) {
    const ProfilePoint *q = p->points;
    bool ring = p->count > 3 && q[0].r == q[p->count - 1].r && q[0].z == q[p->count - 1].z;
    ProfilePoint sum = {0, 0};
    for (int side = 0; side < 2; side++) {
        bool forward = side == 1;
        size_t last = p->count - 1, other = forward ? i + 1 : i - 1;
        if (forward && i == last) {
            if (!ring) continue;
            other = 1;
        }
        if (!forward && i == 0) {
            if (!ring) continue;
            other = last - 1;
        }
        ProfilePoint share = band_share(q[i], q[other], forward, step);
        sum.r += share.r;
        sum.z += share.z;
    }
    double length = hypot(sum.r, sum.z);
    return length > 0 ? (ProfilePoint){sum.r / length, sum.z / length} : sum;
}

static cau_result tessellate(const void *data, bool smooth, Mesh *out, CauError *err) {
    const LatheParams *p = data;
    size_t count = p->profile.count;
    ProfilePoint *points = array_new(count, sizeof *points), *normals = array_new(2 * count, sizeof *normals);
    cau_result result = CAU_ERROR_RESOURCE;
    if (points && normals) {
        for (size_t i = 0; i < count; i++)
            points[i] = (ProfilePoint){p->profile.values[2 * i], p->profile.values[2 * i + 1]};
        Profile profile = {points, smooth ? normals : NULL, count};
        for (size_t i = 0; smooth && i < count; i++) {
            ProfilePoint n = vertex_normal(&profile, i, 2 * CAU_PI / p->segments);
            normals[2 * i] = n;
            if (i > 0) normals[2 * i - 1] = n;
        }
        result = mesh_revolve(&profile, (size_t)p->segments, out, err);
    } else
        error_set(err, result, "out of memory for a profile of %zu points", count);
    free(points);
    free(normals);
    return result;
}

const ShapeKind shape_lathe = {
    .name = "lathe",
    .help = "a profile revolved about Z",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(LatheParams),
    .check = check,
    .tessellate = tessellate,
};
