/* SPDX-License-Identifier: Apache-2.0 */
/* Embree's tree of a scene, and its callbacks for exact surfaces. */
#include "render/trace/embree_internal.h"

#include "core/checked.h"

/* Rounded outwards: a small body far from the middle may be a few roundings of its coordinates large. */
static float below(double x) { return nextafterf((float)x, -INFINITY); }
static float above(double x) { return nextafterf((float)x, INFINITY); }

static void exact_bounds(const struct RTCBoundsFunctionArguments *a) {
    const Object *o = a->geometryUserPtr;
    double pad = 1e-5 * v3_length(v3_sub(o->bounds_max, o->bounds_min)) + 1e-30;
    *a->bounds_o = (struct RTCBounds){.lower_x = below(o->bounds_min.x - pad),
        .lower_y = below(o->bounds_min.y - pad),
        .lower_z = below(o->bounds_min.z - pad),
        .upper_x = above(o->bounds_max.x + pad),
        .upper_y = above(o->bounds_max.y + pad),
        .upper_z = above(o->bounds_max.z + pad)};
}

/* The true line against the surface in its local space; t stays the same under the affine map. */
static bool exact_hit(const Object *o, const Ray *ray, double t_max, ShapeHit *hit) {
    V3 origin = affine_point(&o->scene_to_local, ray->origin),
       dir = affine_vector(&o->scene_to_local, ray->dir);
    return o->shape->intersect(o->shape_data, origin, dir, ray->t_min, t_max, hit);
}

static void exact_intersect(const struct RTCIntersectFunctionNArguments *a) {
    if (!a->valid[0]) return;
    ExactQuery *q = (ExactQuery *)a->context;
    const Object *o = a->geometryUserPtr;
    struct RTCRayHit *rayhit = (struct RTCRayHit *)a->rayhit;
    ShapeHit hit;
    double t_far = (double)rayhit->ray.tfar;
    if (!exact_hit(o, q->ray, q->ray->t_max < t_far ? q->ray->t_max : t_far, &hit)) return;
    q->best = hit;
    q->geometry = a->geomID;
    rayhit->ray.tfar = (float)hit.t;
    rayhit->hit.geomID = a->geomID;
    rayhit->hit.primID = a->primID;
    rayhit->hit.u = rayhit->hit.v = 0;
    rayhit->hit.Ng_x = (float)hit.normal.x;
    rayhit->hit.Ng_y = (float)hit.normal.y;
    rayhit->hit.Ng_z = (float)hit.normal.z;
}

static void exact_occluded(const struct RTCOccludedFunctionNArguments *a) {
    if (!a->valid[0]) return;
    ExactQuery *q = (ExactQuery *)a->context;
    struct RTCRay *ray = (struct RTCRay *)a->ray;
    ShapeHit hit;
    if (exact_hit(a->geometryUserPtr, q->ray, q->ray->t_max, &hit)) ray->tfar = -INFINITY;
}

/* ---- building ---- */

static RTCGeometry exact_geometry(RTCDevice device, Object *o) {
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(g, 1);
    rtcSetGeometryUserData(g, o);
    rtcSetGeometryBoundsFunction(g, exact_bounds, NULL);
    rtcSetGeometryIntersectFunction(g, exact_intersect);
    rtcSetGeometryOccludedFunction(g, exact_occluded);
    return g;
}

/* Corners in single precision, triangle by triangle; NULL: out of memory. */
static float *corners_of(const Mesh *mesh, const float *vertices) {
    float *corners = array_new(3 * mesh->triangle_count, 3 * sizeof *corners);
    if (corners && vertices)
        for (size_t i = 0; i < 3 * mesh->triangle_count; i++)
            memcpy(&corners[3 * i], &vertices[3 * (size_t)mesh->triangles[i]], 3 * sizeof *corners);
    return corners;
}

static RTCGeometry mesh_geometry(RTCDevice device, const Mesh *mesh) {
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *vertices = rtcSetNewGeometryBuffer(
        g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh->vertex_count);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->triangles, 0,
        3 * sizeof(uint32_t), mesh->triangle_count);
    for (size_t i = 0; vertices && i < 3 * mesh->vertex_count; i++) vertices[i] = (float)mesh->positions[i];
    return g;
}

static cau_result device_check(const TraceScene *s, const char *what, CauError *err) {
    enum RTCError code = rtcGetDeviceError(s->device);
    if (code == RTC_ERROR_NONE) return CAU_OK;
    return error_set(err, CAU_ERROR_RESOURCE, "Embree failed (error %d) while %s; is there enough memory?",
        (int)code, what);
}

static RTCScene part_of(const TraceScene *s, bool casters) {
    RTCScene part = rtcNewScene(s->device);
    rtcSetSceneFlags(part, RTC_SCENE_FLAG_ROBUST);
    for (size_t i = 0; i < s->scene->object_count; i++)
        if (casters ? s->contacts[i].caster : s->contacts[i].receiver)
            rtcAttachGeometryByID(part, rtcGetGeometry(s->rtc, (unsigned)i), (unsigned)i);
    rtcCommitScene(part);
    return part;
}

/* What touches gets trees of its own: see nearest(). */
static void find_contacts(TraceScene *s) {
    if (!contacts_find(s, s->scene, s->contacts)) return;
    s->touched = part_of(s, false);
    s->standing = part_of(s, true);
}

/* False: out of memory. */
static bool build(TraceScene *s) {
    bool complete = true;
    s->rtc = rtcNewScene(s->device);
    rtcSetSceneFlags(s->rtc, RTC_SCENE_FLAG_ROBUST);
    for (size_t i = 0; i < s->scene->object_count; i++) {
        Object *o = &s->scene->objects[i];
        if (o->visibility != 31u) s->any_hidden = true;
        if (s->scene->materials[o->material].kind->transparency) s->any_transparent = true;
        if (!o->exact && o->mesh.triangle_count == 0) continue;
        RTCGeometry g = o->exact ? exact_geometry(s->device, o) : mesh_geometry(s->device, &o->mesh);
        if (!o->exact) {
            s->corners[i] = corners_of(&o->mesh, rtcGetGeometryBufferData(g, RTC_BUFFER_TYPE_VERTEX, 0));
            complete &= s->corners[i] != NULL;
        }
        rtcCommitGeometry(g);
        rtcAttachGeometryByID(s->rtc, g, (unsigned)i);
        rtcReleaseGeometry(g);
    }
    rtcCommitScene(s->rtc);
    if (complete) find_contacts(s);
    return complete;
}

cau_result trace_create(TraceScene **out, const Scene *scene, CauError *err) {
    *out = NULL;
    TraceScene *s = array_new(1, sizeof *s);
    if (!s) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the ray tracer");
    s->scene = scene;
    s->contacts = array_new(scene->object_count, sizeof *s->contacts);
    s->corners = array_new(scene->object_count, sizeof *s->corners);
    cau_result result = CAU_OK;
    if (!s->contacts || !s->corners)
        result = error_set(err, CAU_ERROR_RESOURCE, "out of memory for the ray tracer");
    if (result == CAU_OK && !(s->device = rtcNewDevice(NULL)))
        result = error_set(err, CAU_ERROR_RESOURCE, "Embree could not be started on this processor");
    if (result == CAU_OK)
        result = build(s) ? device_check(s, "building its tree", err)
                          : error_set(err, CAU_ERROR_RESOURCE, "out of memory for the ray tracer");
    if (result != CAU_OK)
        trace_destroy(&s);
    else
        *out = s;
    return result;
}

void trace_destroy(TraceScene **scene) {
    TraceScene *s = *scene;
    if (!s) return;
    if (s->touched) rtcReleaseScene(s->touched);
    if (s->standing) rtcReleaseScene(s->standing);
    if (s->rtc) rtcReleaseScene(s->rtc);
    if (s->device) rtcReleaseDevice(s->device);
    free(s->contacts);
    for (size_t i = 0; s->corners && i < s->scene->object_count; i++) free(s->corners[i]);
    free(s->corners);
    free(s);
    *scene = NULL;
}
