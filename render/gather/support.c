/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gather/support.h"

/* Meshes so fine that a disk holds more triangles are looked at by rays alone. */
enum { NEAR_MAX = 192, PROBES = 24, UNION_PLACES = 96, SLAB_HITS = 16 };

/* Of the golden angle, the other way round: 2 pi times 0.618. */
#define GOLDEN_COSINE (-0.7373688780783199)
#define GOLDEN_SINE (-0.6754902942615236)

/* Lift of visibility tests over the surface, in radii. */
#define LIFT 0.02

/* Of the integrals, as a share of the disk. */
#define ROUNDING 1e-6

/* ---- the kernel over a polygon: one signed wedge per edge, as seen from the centre ---- */

/* Wedge of angle phi bounded by the circle: integral of (1 - rho^2/r^2) rho drho dphi = phi r^2 / 4. */
static double wedge_circle(double angle, double r) { return angle * r * r / 4; }

/* Wedge bounded by a line at distance h, between the angles p and q from the line's foot:
 * integral of h^2 / (2 cos^2) - h^4 / (4 r^2 cos^4). */
static double wedge_line(double h, double p, double q, double r) {
    double tp = tan(p), tq = tan(q);
    double second = tq - tp, fourth = second + (tq * tq * tq - tp * tp * tp) / 3;
    return h * h / 2 * second - square(h * h) / (4 * r * r) * fourth;
}

static double edge_integral(const double a[2], const double b[2], double r) {
    double dx = b[0] - a[0], dy = b[1] - a[1], length = hypot(dx, dy);
    double cross = a[0] * b[1] - a[1] * b[0];
    if (length == 0 || cross == 0) return 0;
    double h = fabs(cross) / length;
    /* Angles of the end points from the foot of the perpendicular, along the edge. */
    double pa = atan2((a[0] * dx + a[1] * dy) / length, h), pb = atan2((b[0] * dx + b[1] * dy) / length, h);
    double integral;
    if (h >= r) {
        integral = wedge_circle(pb - pa, r);
    } else {
        double in = acos(h / r); /* the line is inside the circle between -in and in */
        double p = clamp(pa, -in, in), q = clamp(pb, -in, in);
        integral = wedge_line(h, p, q, r) + wedge_circle((pb - pa) - (q - p), r);
    }
    return cross > 0 ? integral : -integral;
}

/* On which side of the line the whole disk lies: left 1, right -1; 0 where the line cuts it. */
static int side_of(const double a[2], const double b[2], double r) {
    double cross = a[0] * b[1] - a[1] * b[0], length2 = square(b[0] - a[0]) + square(b[1] - a[1]);
    if (square(cross) < square(r) * length2) return 0;
    return (cross > 0) - (cross < 0);
}

double disk_triangle_integral(const double a[2], const double b[2], const double c[2], double radius) {
    /* Most disks lie within one triangle or beside it, which takes no angles. */
    double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    int inward = (area > 0) - (area < 0),
        side[3] = {side_of(a, b, radius), side_of(b, c, radius), side_of(c, a, radius)};
    if (side[0] == -inward || side[1] == -inward || side[2] == -inward) return 0;
    if (side[0] == inward && side[1] == inward && side[2] == inward)
        return inward * wedge_circle(2 * CAU_PI, radius);
    return edge_integral(a, b, radius) + edge_integral(b, c, radius) + edge_integral(c, a, radius);
}

/* ---- triangles near the point ---- */

typedef struct Plane {
    V3 origin, s, t, n;
} Plane;

static V3 on_plane(const Plane *plane, V3 p) {
    return v3_to_frame(v3_sub(p, plane->origin), plane->s, plane->t, plane->n);
}

static bool inside(const V3 *q, double x, double y) {
    double d[3];
    for (int k = 0; k < 3; k++) {
        const V3 *a = &q[k], *b = &q[(k + 1) % 3];
        d[k] = (b->x - a->x) * (y - a->y) - (b->y - a->y) * (x - a->x);
    }
    return (d[0] >= 0 && d[1] >= 0 && d[2] >= 0) || (d[0] <= 0 && d[1] <= 0 && d[2] <= 0);
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

typedef struct Patch {
    V3 corner[3]; /* plane coordinates */
    double cosine;
    double integral; /* of the kernel, as seen along the plane's normal */
    int object;
} Patch;

/* Same sheet of surface: faces the same way and passes the point within tolerance. */
static bool same_sheet(const Patch *p, V3 normal, double r) {
    if (p->cosine < SUPPORT_COSINE) return false;
    /* Height of the triangle's plane where it is nearest to the axis, but not beyond the disk. */
    double height = v3_dot(normal, p->corner[0]) / normal.z;
    double slope = sqrt(fmax(0, 1 - square(normal.z))) / normal.z;
    return fabs(height) <= SUPPORT_HEIGHT * r + slope * r;
}

static double patch_integral(const Patch *p, double r) {
    double q[3][2];
    for (int k = 0; k < 3; k++) {
        q[k][0] = p->corner[k].x;
        q[k][1] = p->corner[k].y;
    }
    return fabs(disk_triangle_integral(q[0], q[1], q[2], r));
}

typedef struct Near {
    Patch sheet[NEAR_MAX];
    size_t sheets;
    bool blockers;
    bool full;  /* an exact surface of the point's own object */
    bool dense; /* more triangles than `sheet` holds: none is listed */
} Near;

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
        Patch p = {{on_plane(plane, f->a), on_plane(plane, f->b), on_plane(plane, f->c)}, 0, 0, f->object};
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
            continue;
        }
        double top = fmax(p.corner[0].z, fmax(p.corner[1].z, p.corner[2].z));
        if (top > 1e-3 * r || (carries && f->object != point->object)) near->blockers = true;
    }
}

/* Of one object's sheets, or of all. */
enum { ALL_OBJECTS = -1 };
static bool of_object(const Patch *p, int object) { return object == ALL_OBJECTS || p->object == object; }

static double sheets_sum(const Near *near, int object) {
    double sum = 0;
    for (size_t i = 0; i < near->sheets; i++)
        if (of_object(&near->sheet[i], object)) sum += near->sheet[i].integral;
    return sum;
}

/* On how many sheets a place of the plane is; 2 stands for more, too. */
static int sheets_at(const Near *near, int object, double x, double y) {
    if (near->full) return 1;
    int count = 0;
    for (size_t i = 0; i < near->sheets && count < 2; i++)
        count += of_object(&near->sheet[i], object) && inside(near->sheet[i].corner, x, y);
    return count;
}

/* ---- places spread like the kernel ---- */

typedef struct Place {
    double x, y, q; /* in radii, and its squared distance */
} Place;

/* A spiral of golden-angle steps, turned at random for each point. The kernel's cumulative is c(q) = 2 q -
 * q^2 with q = (d/r)^2, so q = 1 - sqrt(1 - u). */
static void places_spread(const EyePoint *point, int count, Place *places) {
    double cosine = cos(2 * CAU_PI * (double)point->turn), sine = sin(2 * CAU_PI * (double)point->turn);
    for (int i = 0; i < count; i++) {
        double q = 1 - sqrt(1 - (i + 0.5) / count), d = sqrt(q);
        places[i] = (Place){d * cosine, d * sine, q};
        double turned = cosine * GOLDEN_COSINE - sine * GOLDEN_SINE;
        sine = sine * GOLDEN_COSINE + cosine * GOLDEN_SINE;
        cosine = turned;
    }
}

/* The narrow kernel's density over the wide one's, by which the places are spread. */
static double inner_weight(double q) {
    SupportKernels k = support_kernels(q);
    return k.inner / k.outer;
}

bool support_sees(const TraceScene *trace, const EyePoint *point, const Support *support, V3 place) {
    V3 n = v3((double)point->ng[0], (double)point->ng[1], (double)point->ng[2]);
    return trace_sees_along(trace, point->position, place, n, LIFT * support->radius);
}

bool support_hidden(
    const TraceScene *trace, const EyePoint *point, const Support *support, V3 place, double depth) {
    V3 n = v3((double)point->ng[0], (double)point->ng[1], (double)point->ng[2]);
    double off = 0.01 * depth;
    Ray ray = ray_from_point(v3_mad(place, off, n), n, 0, depth - off + LIFT * support->radius, 0);
    return trace_anything_between(trace, &ray);
}

/* The same by a ray along the normal, through the slab in which deposits count and whatever else lies in it:
 * what hides the place is support_sees()'s to say. */
static bool above_sheet(
    const TraceScene *trace, const EyePoint *point, const Plane *plane, V3 place, double r) {
    double left = 2 * SUPPORT_HEIGHT * r;
    Ray ray = ray_from_point(v3_mad(place, left / 2, plane->n), v3_neg(plane->n), 0, left, 0);
    Hit hit;
    for (int i = 0; i < SLAB_HITS && trace_nearest(trace, &ray, &hit); i++) {
        if (hit.object == point->object && fabs(v3_dot(hit.ng, plane->n)) >= SUPPORT_COSINE) return true;
        left -= hit.t;
        ray = ray_from_hit(&hit, ray.dir, left, 0);
    }
    return false;
}

/* Which places can be seen from the point. */
static void probes_send(const TraceScene *trace, const EyePoint *point, const Support *support,
    const Plane *plane, const Near *near, const Place *places, bool *seen) {
    double r = support->radius;
    for (int i = 0; i < PROBES; i++) {
        double x = r * places[i].x, y = r * places[i].y;
        V3 place = v3_add(plane->origin, v3_add(v3_scale(plane->s, x), v3_scale(plane->t, y)));
        bool sheet =
            near->dense ? above_sheet(trace, point, plane, place, r) : sheets_at(near, ALL_OBJECTS, x, y) > 0;
        /* Nothing is seen where a caster lies on the surface, so light that a kernel put there would be lost.
         */
        seen[i] = sheet && !trace_covered(trace, point->object, place, plane->n) &&
                  support_sees(trace, point, support, place);
    }
}

/* A disk cut by a straight line at distance t keeps a kernel whose centre of mass lies 8 / (15 pi) (1 -
 * t^2)^(5/2) of the whole kernel's mass from the middle. What is missing on all sides has none, and no line.
 */
static void find_edge(Support *support, const Plane *plane, const Place *places, const bool *seen) {
    double x = 0, y = 0;
    for (int i = 0; i < PROBES; i++)
        if (!seen[i]) {
            x += places[i].x / PROBES;
            y += places[i].y / PROBES;
        }
    double moment = hypot(x, y);
    if (moment == 0) return;
    support->edge_distance = (float)sqrt(positive(1 - pow(15 * CAU_PI / 8 * moment, 0.4)));
    V3 edge = v3_scale(v3_add(v3_scale(plane->s, x), v3_scale(plane->t, y)), 1 / moment);
    support->edge[0] = (float)edge.x;
    support->edge[1] = (float)edge.y;
    support->edge[2] = (float)edge.z;
}

static void probe_integral(
    const TraceScene *trace, const EyePoint *point, Support *support, const Plane *plane, const Near *near) {
    Place places[PROBES];
    bool seen[PROBES];
    places_spread(point, PROBES, places);
    probes_send(trace, point, support, plane, near, places, seen);
    find_edge(support, plane, places, seen);
    V3 edge = v3((double)support->edge[0], (double)support->edge[1], (double)support->edge[2]);
    double ex = v3_dot(edge, plane->s), ey = v3_dot(edge, plane->t), outer = 0, inner = 0, inner_all = 0;
    for (int i = 0; i < PROBES; i++) {
        const Place *p = &places[i];
        double density = 1 - p->q;
        inner_all += inner_weight(p->q);
        if (!seen[i]) continue;
        SupportKernels k = support_kernels(p->q);
        support_mirror(support, p->q, p->x * ex + p->y * ey, &k);
        outer += k.outer / density;
        inner += k.inner / density;
    }
    double open = CAU_PI * square(support->radius) / 2;
    support->integral = open * fmax(outer, 1) / PROBES;
    support->inner = open / 2 * fmax(inner, 1) / inner_all;
}

/* ---- nothing rises out of the disk ---- */

static bool sheets_overlap(const EyePoint *point, const Near *near, int object, double r) {
    Place places[PROBES];
    places_spread(point, PROBES, places);
    for (int i = 0; i < PROBES; i++)
        if (sheets_at(near, object, r * places[i].x, r * places[i].y) > 1) return true;
    return false;
}

/* Does one object's surface fill the disk, whatever lies on it? */
static bool one_fills(const EyePoint *point, const Near *near, double r) {
    double open = CAU_PI * square(r) / 2;
    for (size_t i = 0; i < near->sheets; i++) {
        int object = near->sheet[i].object;
        size_t first = 0;
        while (near->sheet[first].object != object) first++;
        if (first == i && fabs(sheets_sum(near, object) - open) <= ROUNDING * open &&
            !sheets_overlap(point, near, object, r))
            return true;
    }
    return false;
}

/* Where one sheet lies over another (grout behind tiles, a block flush with its wall), their areas would
 * count twice what is seen once: the places that are on any of them are counted instead. */
static void union_integral(const EyePoint *point, Support *support, const Near *near) {
    Place places[UNION_PLACES];
    places_spread(point, UNION_PLACES, places);
    double outer = 0, inner = 0, inner_all = 0, r = support->radius, open = CAU_PI * square(r) / 2;
    for (int i = 0; i < UNION_PLACES; i++) {
        double weight = inner_weight(places[i].q);
        inner_all += weight;
        if (sheets_at(near, ALL_OBJECTS, r * places[i].x, r * places[i].y) == 0) continue;
        outer++;
        inner += weight;
    }
    support->integral = open * fmax(outer, 1) / UNION_PLACES;
    support->inner = open / 2 * fmax(inner, 1) / inner_all;
}

/* A sheet that is bent away from the plane has more surface than is seen along the normal. */
static void sheets_integral(Support *support, const Near *near) {
    double r = support->radius, open = CAU_PI * square(r) / 2, outer = 0, inner = 0;
    for (size_t i = 0; i < near->sheets; i++)
        outer += near->sheet[i].integral / fmax(near->sheet[i].cosine, SUPPORT_COSINE);
    support->integral = clamp(outer, 0.02 * open, open);
    if (outer >= (1 - 1e-9) * open) return;
    for (size_t i = 0; i < near->sheets; i++)
        inner += patch_integral(&near->sheet[i], r * sqrt(0.5)) / fmax(near->sheet[i].cosine, SUPPORT_COSINE);
    support->inner = clamp(inner, 0.01 * open, open / 2);
}

void support_find(const TraceScene *trace, const EyePoint *point, double radius, Support *out) {
    double open = CAU_PI * radius * radius / 2;
    *out = (Support){.radius = radius, .integral = open, .inner = open / 2, .edge_distance = 1};
    NearTriangle found[NEAR_MAX];
    size_t count = trace_collect(trace, point->position, radius, found, NEAR_MAX);
    Plane plane = {
        .origin = point->position, .n = v3((double)point->ng[0], (double)point->ng[1], (double)point->ng[2])};
    v3_frame(plane.n, &plane.s, &plane.t);
    /* Which way the winding of the point's own triangle faces, so that the far side of a thin wall is another
     * sheet even where it lies within the tolerance. */
    double facing = 1;
    Near near; /* not zeroed: its list is large, and mostly empty */
    near.sheets = 0;
    near.blockers = near.full = false;
    near.dense = count > NEAR_MAX;
    for (size_t i = 0; i < count && !near.dense; i++)
        if (!found[i].exact && found[i].object == point->object && found[i].primitive == point->primitive) {
            V3 n = v3_cross(v3_sub(found[i].b, found[i].a), v3_sub(found[i].c, found[i].a));
            facing = v3_dot(n, plane.n) >= 0 ? 1 : -1;
        }
    if (!near.dense)
        sort_out(found, count, &plane, point, facing, radius, trace_carries(trace, point->object), &near);
    out->mixed = near.blockers || near.dense;
    double seen = near.dense || near.full ? open : sheets_sum(&near, ALL_OBJECTS);
    bool overlap = fabs(seen - open) > ROUNDING * open && sheets_overlap(point, &near, ALL_OBJECTS, radius);
    out->layered = near.dense || overlap || seen > (1 + ROUNDING) * open;
    if (out->mixed)
        probe_integral(trace, point, out, &plane, &near);
    else if (!overlap && !near.full)
        sheets_integral(out, &near);
    else if (overlap && !one_fills(point, &near, radius))
        union_integral(point, out, &near);
}
