/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gather/sheets.h"

#include "render/gather/disk.h"

#include <float.h>
#include <string.h>

enum { OVERLAP_PLACES = 24 };

/* Of the golden angle, the other way round: 2 pi times 0.618. */
#define GOLDEN_COSINE (-0.7373688780783199)
#define GOLDEN_SINE (-0.6754902942615236)

/* Sheets this near to the point's plane, in radii, lie in it. */
#define IN_PLANE 1e-3

/* Of a deposit's coordinates, which are floats, as a share of the largest. */
#define DEPOSIT_ROUNDING (4 * FLT_EPSILON)

/* ---- one triangle ---- */

static V3 on_plane(const Plane *plane, V3 p) {
    return v3_to_frame(v3_sub(p, plane->origin), plane->s, plane->t, plane->n);
}

/* Cheap test: does the box of the local triangle come near the ball? */
static bool overlaps(const V3 *q, double r) {
    double lo[3] = {q[0].x, q[0].y, q[0].z}, hi[3] = {q[0].x, q[0].y, q[0].z};
    for (int k = 1; k < 3; k++) {
        double p[3] = {q[k].x, q[k].y, q[k].z};
        for (int i = 0; i < 3; i++) {
            if (p[i] < lo[i]) lo[i] = p[i];
            if (p[i] > hi[i]) hi[i] = p[i];
        }
    }
    double d2 = 0;
    for (int i = 0; i < 3; i++) d2 += lo[i] > 0 ? square(lo[i]) : (hi[i] < 0 ? square(hi[i]) : 0);
    return d2 <= r * r;
}

static double lowest_of(const Patch *p) { return fmin(p->corner[0].z, fmin(p->corner[1].z, p->corner[2].z)); }

static double highest_of(const Patch *p) {
    return fmax(p->corner[0].z, fmax(p->corner[1].z, p->corner[2].z));
}

/* Same sheet of surface: faces the same way and passes the point within tolerance. */
static bool same_sheet(const Patch *p, V3 normal, double r) {
    if (p->cosine < SUPPORT_COSINE) return false;
    /* Height of the triangle's plane where it is nearest to the axis, but not beyond the disk. */
    double height = v3_dot(normal, p->corner[0]) / normal.z;
    double slope = sqrt(fmax(0, 1 - square(normal.z))) / normal.z;
    return fabs(height) <= SUPPORT_HEIGHT * r + slope * r;
}

double patch_integral(const Patch *p, double r) {
    double q[3][2];
    for (int k = 0; k < 3; k++) {
        q[k][0] = p->corner[k].x;
        q[k][1] = p->corner[k].y;
    }
    return fabs(disk_triangle_integral(q[0], q[1], q[2], r));
}

/* ---- what lies near ---- */

static void sort_out(const NearTriangle *found, size_t count, const Plane *plane, const EyePoint *point,
    double facing, double r, bool carries, Near *near) {
    for (size_t i = 0; i < count; i++) {
        const NearTriangle *f = &found[i];
        if (f->exact) { /* an exact surface has no triangles: its own disk counts as full */
            if (f->object == point->object)
                near->full = true;
            else
                near->blockers = true;
            continue;
        }
        Patch p = {.corner = {on_plane(plane, f->a), on_plane(plane, f->b), on_plane(plane, f->c)},
            .object = f->object};
        if (!overlaps(p.corner, r)) continue;
        V3 n = v3_cross(v3_sub(p.corner[1], p.corner[0]), v3_sub(p.corner[2], p.corner[0]));
        double length = v3_length(n);
        if (!(length > 0)) continue;
        n = v3_scale(n, facing / length);
        p.cosine = n.z;
        bool own = f->object == point->object && f->primitive == point->primitive;
        if (own || same_sheet(&p, n, r)) {
            if (!f->receives) continue;
            p.integral = patch_integral(&p, r);
            near->sheet[near->sheets++] = p;
            if (lowest_of(&p) > 0) near->top = fmax(near->top, highest_of(&p));
            continue;
        }
        if (highest_of(&p) > near->flat || (carries && f->object != point->object)) near->blockers = true;
    }
}

/* Which way the winding of the point's own triangle faces, so that the far side of a thin wall is another
 * sheet even where it lies within the tolerance. */
static double facing_of(const NearTriangle *found, size_t count, const EyePoint *point, V3 normal) {
    for (size_t i = 0; i < count; i++)
        if (!found[i].exact && found[i].object == point->object && found[i].primitive == point->primitive) {
            V3 n = v3_cross(v3_sub(found[i].b, found[i].a), v3_sub(found[i].c, found[i].a));
            return v3_dot(n, normal) >= 0 ? 1 : -1;
        }
    return 1;
}

Plane plane_at(const EyePoint *point) {
    Plane plane = {
        .origin = point->position, .n = v3((double)point->ng[0], (double)point->ng[1], (double)point->ng[2])};
    V3 s, t;
    v3_frame(plane.n, &s, &t);
    double cosine = cos(2 * CAU_PI * (double)point->turn), sine = sin(2 * CAU_PI * (double)point->turn);
    plane.s = v3_add(v3_scale(s, cosine), v3_scale(t, sine));
    plane.t = v3_sub(v3_scale(t, cosine), v3_scale(s, sine));
    return plane;
}

void near_find(const TraceScene *trace, const EyePoint *point, const Plane *plane, double radius, Near *out) {
    NearTriangle found[NEAR_MAX];
    size_t count = trace_collect(trace, point->position, radius, found, NEAR_MAX);
    /* Not zeroed as a whole: the list is large, and mostly empty. */
    out->sheets = out->above = out->below = 0;
    V3 p = plane->origin;
    out->flat = fmax(IN_PLANE * radius, DEPOSIT_ROUNDING * fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))));
    out->top = 0;
    out->blockers = out->full = false;
    out->dense = count > NEAR_MAX;
    if (out->dense) return;
    sort_out(found, count, plane, point, facing_of(found, count, point, plane->n), radius,
        trace_carries(trace, point->object), out);
}

/* ---- set apart ---- */

static void swap_patches(Patch *a, Patch *b) {
    Patch swap = *a;
    *a = *b;
    *b = swap;
}

/* Those that are on one side of a height last; returns how many. */
static size_t put_last(Patch *patches, size_t count, bool (*goes)(const Patch *, double), double height) {
    size_t first = 0, last = count;
    while (first < last)
        if (goes(&patches[first], height))
            swap_patches(&patches[first], &patches[--last]);
        else
            first++;
    return count - last;
}

static bool lies_over(const Patch *p, double height) { return lowest_of(p) > height; }
static bool lies_under(const Patch *p, double depth) { return highest_of(p) < -depth; }

double near_set_apart(Near *near) {
    double flat = near->flat, nearest = INFINITY;
    for (size_t i = 0; i < near->sheets; i++) {
        double lowest = lowest_of(&near->sheet[i]), highest = highest_of(&near->sheet[i]);
        if (lowest >= -flat && highest <= flat) continue;
        double distance = fmax(lowest, -highest);
        if (distance < 2 * flat) return 0;
        nearest = fmin(nearest, distance);
    }
    if (nearest == INFINITY) return 0;
    near->below = put_last(near->sheet, near->sheets, lies_under, flat);
    near->above = put_last(near->sheet, near->sheets - near->below, lies_over, flat);
    return nearest / 2;
}

double near_look_along(Near *near, double radius, V3 *from) {
    Patch *above = near->sheet + sheets_own(near).count;
    double highest = 0, slope = hypot(from->x, from->y) / from->z;
    for (size_t i = 0; i < near->above; i++) highest = fmax(highest, highest_of(&above[i]));
    double taken = fmin(slope, radius / (2 * highest)), scale = slope > 0 ? taken / slope / from->z : 0;
    *from = v3(from->x * scale, from->y * scale, 1);
    for (size_t i = 0; i < near->above; i++)
        for (int k = 0; k < 3; k++) {
            V3 *corner = &above[i].corner[k];
            *corner = v3_mad(*corner, -corner->z, v3(from->x, from->y, 0));
        }
    radius -= highest * taken;
    for (size_t i = 0; i < near->sheets; i++)
        near->sheet[i].integral = patch_integral(&near->sheet[i], radius);
    return radius;
}

/* ---- some of them ---- */

static bool of_sheets(const Sheets *s, size_t i) {
    return s->object == ALL_OBJECTS || s->patch[i].object == s->object;
}

double sheets_sum(const Sheets *s) {
    double sum = 0;
    for (size_t i = 0; i < s->count; i++)
        if (of_sheets(s, i)) sum += s->patch[i].integral;
    return sum;
}

/* An edge of a triangle that is on its left, in radii: positive on that side. */
typedef struct Side {
    float x, y, offset;
} Side;

static Side side_of(const V3 *a, const V3 *b, double left, double r) {
    double x = left * (b->x - a->x) / r, y = left * (b->y - a->y) / r;
    return (Side){(float)-y, (float)x, (float)((y * a->x - x * a->y) / r)};
}

void sheets_count(const Sheets *s, const Places *places, double r, int32_t *found) {
    int count = places->count; /* of its own, for `found` might be where that one is */
    memset(found, 0, (size_t)count * sizeof *found);
    for (size_t i = 0; i < s->count; i++) {
        if (!of_sheets(s, i)) continue;
        const V3 *q = s->patch[i].corner;
        double area = (q[1].x - q[0].x) * (q[2].y - q[0].y) - (q[1].y - q[0].y) * (q[2].x - q[0].x);
        double left = area < 0 ? -1 : 1;
        Side a = side_of(&q[0], &q[1], left, r), b = side_of(&q[1], &q[2], left, r),
             c = side_of(&q[2], &q[0], left, r);
        /* Without a branch and by the least distance from a side, so that compilers take several at a time.
         */
        for (int k = 0; k < count; k++) {
            float x = places->x[k], y = places->y[k];
            float from_a = a.x * x + a.y * y + a.offset, from_b = b.x * x + b.y * y + b.offset,
                  from_c = c.x * x + c.y * y + c.offset;
            float least = from_a < from_b ? from_a : from_b;
            least = least < from_c ? least : from_c;
            found[k] += least > 0 ? 1 : 0;
        }
    }
}

/* A spiral of golden-angle steps. The kernel's cumulative is c(q) = 2 q - q^2 with q = (d/r)^2, so
 * q = 1 - sqrt(1 - u). */
void places_spread(int count, Places *places) {
    double cosine = 1, sine = 0;
    places->count = count;
    for (int i = 0; i < count; i++) {
        double q = 1 - sqrt(1 - (i + 0.5) / count), d = sqrt(q);
        places->x[i] = (float)(d * cosine);
        places->y[i] = (float)(d * sine);
        places->q[i] = (float)q;
        double turned = cosine * GOLDEN_COSINE - sine * GOLDEN_SINE;
        sine = sine * GOLDEN_COSINE + cosine * GOLDEN_SINE;
        cosine = turned;
    }
}

bool sheets_overlap(const Sheets *sheets, double r) {
    if (sheets->count < 2) return false;
    Places places;
    places_spread(OVERLAP_PLACES, &places);
    int32_t found[OVERLAP_PLACES], most = 0;
    sheets_count(sheets, &places, r, found);
    for (int i = 0; i < OVERLAP_PLACES; i++) most = found[i] > most ? found[i] : most;
    return most > 1;
}
