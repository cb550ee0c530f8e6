/* SPDX-License-Identifier: Apache-2.0 */
/* What lies near a point. */
#include "render/trace/embree_internal.h"

typedef struct Collector {
    const TraceScene *trace;
    NearTriangle *out;
    size_t count, capacity;
    double radius;
} Collector;

static bool box_near(const Object *o, V3 p, double radius) {
    V3 gap = v3_max(v3_max(v3_sub(o->bounds_min, p), v3_sub(p, o->bounds_max)), v3(0, 0, 0));
    return v3_dot(gap, gap) <= radius * radius;
}

static bool collect(struct RTCPointQueryFunctionArguments *a) {
    Collector *c = a->userPtr;
    const Object *o = &c->trace->scene->objects[a->geomID];
    /* Embree hands over whole leaves: a large exact surface far away may be among them. */
    if (o->exact &&
        !box_near(o, v3((double)a->query->x, (double)a->query->y, (double)a->query->z), c->radius))
        return false;
    if (c->count == c->capacity) {
        c->count++;
        a->query->radius = 0; /* enough: end the search */
        return true;
    }
    if (c->count > c->capacity) return false;
    NearTriangle *t = &c->out[c->count++];
    *t = (NearTriangle){
        .object = (int)a->geomID, .primitive = a->primID, .exact = o->exact, .receives = o->receives};
    if (o->exact) return false;
    embree_corners(c->trace->corners[a->geomID], a->primID, &t->a, &t->b, &t->c);
    return false;
}

size_t trace_collect(const TraceScene *s, V3 center, double radius, NearTriangle *out, size_t capacity) {
    Collector c = {s, out, 0, capacity, radius};
    struct RTCPointQuery query = {
        .x = (float)center.x, .y = (float)center.y, .z = (float)center.z, .radius = (float)radius};
    struct RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(s->rtc, &query, &context, collect, &c);
    return c.count;
}
