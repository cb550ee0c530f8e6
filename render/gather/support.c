/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gather/support.h"

#include "render/gather/sheets.h"
#include "render/trace/photons.h"

enum { PROBES = 24, SLAB_HITS = 16 };

/* Lift of visibility tests over the surface, in radii. */
#define LIFT 0.02

/* Of the integrals, as a share of the disk. */
#define ROUNDING 1e-6

/* Least share of the disk that is taken for seen: slits that are finer hold no light to speak of. */
#define SEEN_LEAST 1e-3

/* The narrow kernel's density over the wide one's, by which places are spread. */
static double inner_weight(double q) {
    SupportKernels k = support_kernels(q);
    return k.inner / k.outer;
}

/* ---- rays ---- */

bool support_sees(const TraceScene *trace, const EyePoint *point, const Support *support, V3 place) {
    V3 n = v3((double)point->ng[0], (double)point->ng[1], (double)point->ng[2]);
    return trace_sees_along(trace, point->position, place, n, LIFT * support->radius);
}

bool support_hidden(const TraceScene *trace, const Support *support, V3 place, double depth) {
    V3 along = v3((double)support->along[0], (double)support->along[1], (double)support->along[2]);
    double off = 0.01 * depth, length = v3_length(along);
    Ray ray = ray_from_point(v3_mad(place, off, along), v3_scale(along, 1 / length), 0,
        (depth - off + LIFT * support->radius) * length, 0);
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
    const Plane *plane, const Near *near, const Places *places, bool *seen) {
    double r = support->radius;
    Sheets all = sheets_all(near);
    int32_t on[PROBES];
    sheets_count(&all, places, r, on);
    for (int i = 0; i < PROBES; i++) {
        V3 place = v3_mad(
            v3_mad(plane->origin, r * (double)places->x[i], plane->s), r * (double)places->y[i], plane->t);
        bool sheet = near->full || (near->dense ? above_sheet(trace, point, plane, place, r) : on[i] > 0);
        /* Nothing is seen where a caster lies on the surface, so light that a kernel put there would be lost.
         */
        seen[i] = sheet && !trace_covered(trace, point->object, place, plane->n) &&
                  support_sees(trace, point, support, place);
    }
}

/* A disk cut by a straight line at distance t keeps a kernel whose centre of mass lies 8 / (15 pi) (1 -
 * t^2)^(5/2) of the whole kernel's mass from the middle. What is missing on all sides has none, and no line.
 */
static void find_edge(Support *support, const Plane *plane, const Places *places, const bool *seen) {
    double x = 0, y = 0;
    for (int i = 0; i < PROBES; i++)
        if (!seen[i]) {
            x += (double)places->x[i] / PROBES;
            y += (double)places->y[i] / PROBES;
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
    Places places;
    bool seen[PROBES];
    places_spread(PROBES, &places);
    probes_send(trace, point, support, plane, near, &places, seen);
    find_edge(support, plane, &places, seen);
    V3 edge = v3((double)support->edge[0], (double)support->edge[1], (double)support->edge[2]);
    double ex = v3_dot(edge, plane->s), ey = v3_dot(edge, plane->t), outer = 0, inner = 0, inner_all = 0;
    for (int i = 0; i < PROBES; i++) {
        double x = (double)places.x[i], y = (double)places.y[i], q = (double)places.q[i], density = 1 - q;
        inner_all += inner_weight(q);
        if (!seen[i]) continue;
        SupportKernels k = support_kernels(q);
        support_mirror(support, q, x * ex + y * ey, &k);
        outer += k.outer / density;
        inner += k.inner / density;
    }
    double open = CAU_PI * square(support->radius) / 2;
    support->integral = open * fmax(outer, 1) / PROBES;
    support->inner = open / 2 * fmax(inner, 1) / inner_all;
}

/* ---- sheets ---- */

/* Integrals of both kernels, over what is seen of the own sheets and over any sheet. */
typedef struct Seen {
    double outer, inner, outer_any;
} Seen;

static bool fills(const Sheets *sheets, double r) {
    double open = CAU_PI * square(r) / 2;
    return fabs(sheets_sum(sheets) - open) <= ROUNDING * open && !sheets_overlap(sheets, r);
}

/* Does one object's surface fill the disk, whatever lies on it? */
static bool one_fills(const Sheets *sheets, double r) {
    for (size_t i = 0; i < sheets->count; i++) {
        Sheets one = {sheets->patch, sheets->count, sheets->patch[i].object};
        size_t first = 0;
        while (sheets->patch[first].object != one.object) first++;
        if (first == i && fills(&one, r)) return true;
    }
    return false;
}

/* Where one sheet lies over another (a block flush with its wall), their areas would count twice what is seen
 * once: the places that are on any of them, and under none of those above, are counted instead. */
static Seen seen_by_places(const Near *near, double r) {
    Sheets own = sheets_own(near), above = sheets_above(near), below = sheets_below(near);
    Places places;
    int32_t on_own[PLACES_MAX], on_above[PLACES_MAX], on_below[PLACES_MAX];
    places_spread(PLACES_MAX, &places);
    sheets_count(&own, &places, r, on_own);
    sheets_count(&above, &places, r, on_above);
    sheets_count(&below, &places, r, on_below);
    double outer = 0, inner = 0, inner_all = 0, any = 0, open = CAU_PI * square(r) / 2;
    for (int i = 0; i < PLACES_MAX; i++) {
        double weight = inner_weight((double)places.q[i]);
        inner_all += weight;
        any += on_own[i] || on_above[i] || on_below[i];
        if (!on_own[i] || on_above[i]) continue;
        outer++;
        inner += weight;
    }
    return (Seen){open * fmax(outer, 1) / PLACES_MAX, open / 2 * fmax(inner, 1) / inner_all,
        open * fmax(any, 1) / PLACES_MAX};
}

/* Do all that lie above lie over the own sheets, none of them over another? */
static bool above_own_alone(const Near *near, double r) {
    Sheets own = sheets_own(near), above = sheets_above(near);
    if (near->below || sheets_overlap(&own, r) || sheets_overlap(&above, r)) return false;
    Places places;
    int32_t on_own[PROBES], on_above[PROBES];
    places_spread(PROBES, &places);
    sheets_count(&own, &places, r, on_own);
    sheets_count(&above, &places, r, on_above);
    for (int i = 0; i < PROBES; i++)
        if (on_above[i] && !on_own[i]) return false;
    return true;
}

/* What those above leave of the own sheets: slits may be far finer than the places lie. */
static Seen seen_between(const Near *near, double r) {
    if (!above_own_alone(near, r)) return seen_by_places(near, r);
    Sheets own = sheets_own(near), above = sheets_above(near);
    double outer_any = sheets_sum(&own), outer = outer_any - sheets_sum(&above), inner = 0, inner_any = 0;
    for (size_t i = 0; i < own.count; i++) inner_any += patch_integral(&own.patch[i], r * sqrt(0.5));
    for (size_t i = 0; i < above.count; i++) inner += patch_integral(&above.patch[i], r * sqrt(0.5));
    return (Seen){
        fmax(outer, SEEN_LEAST * outer_any), fmax(inner_any - inner, SEEN_LEAST * inner_any), outer_any};
}

/* A sheet that is bent away from the plane has more surface than is seen along the normal. */
static Seen seen_once(const Sheets *sheets, double r) {
    double open = CAU_PI * square(r) / 2, outer = 0, inner = 0;
    for (size_t i = 0; i < sheets->count; i++)
        outer += sheets->patch[i].integral / fmax(sheets->patch[i].cosine, SUPPORT_COSINE);
    if (outer >= (1 - 1e-9) * open) return (Seen){open, open / 2, open};
    for (size_t i = 0; i < sheets->count; i++)
        inner +=
            patch_integral(&sheets->patch[i], r * sqrt(0.5)) / fmax(sheets->patch[i].cosine, SUPPORT_COSINE);
    return (Seen){clamp(outer, 0.02 * open, open), clamp(inner, 0.01 * open, open / 2), open};
}

/* Sheets above are looked between as the eye does, for a slanted look meets the shade behind their edges. */
static void set_apart(const EyePoint *point, const Plane *plane, Near *near, Support *out) {
    double band = near_set_apart(near);
    if (band == 0) return;
    if (near->above > 0) {
        V3 from = v3_to_frame(normal_decode(point->from), plane->s, plane->t, plane->n);
        from.z = fmax(from.z, 1e-3);
        out->radius = near_look_along(near, out->radius, &from);
        V3 along = v3_from_frame(from, plane->s, plane->t, plane->n);
        out->along[0] = (float)along.x;
        out->along[1] = (float)along.y;
        out->along[2] = (float)along.z;
    }
    out->band = (float)fmin(band, SUPPORT_HEIGHT * out->radius);
}

/* Probes tell what is hidden by what rises out of the disk, of all sheets: this is the own sheets' share. */
static void take_share(const Near *near, Support *out) {
    Seen seen = seen_between(near, out->radius);
    double share = fmin(seen.outer / seen.outer_any, 1);
    out->integral *= share;
    out->inner *= share;
}

static void sheets_find(
    const TraceScene *trace, const EyePoint *point, const Plane *plane, Near *near, Support *out) {
    set_apart(point, plane, near, out);
    double r = out->radius, open = CAU_PI * square(r) / 2;
    Sheets own = sheets_own(near);
    double sum = sheets_sum(&own);
    bool apart = near->above + near->below > 0,
         overlap = fabs(sum - open) > ROUNDING * open && sheets_overlap(&own, r);
    out->layered = near->above > 0 || (!apart && (overlap || sum > (1 + ROUNDING) * open));
    if (out->mixed) {
        probe_integral(trace, point, out, plane, near);
        if (apart) take_share(near, out);
        return;
    }
    Seen seen = {open, open / 2, open};
    if (near->above > 0)
        seen = seen_between(near, r);
    else if (!overlap)
        seen = seen_once(&own, r);
    else if (!one_fills(&own, r))
        seen = seen_by_places(near, r);
    out->integral = seen.outer;
    out->inner = seen.inner;
}

void support_find(const TraceScene *trace, const EyePoint *point, double radius, Support *out) {
    double open = CAU_PI * radius * radius / 2;
    *out = (Support){.radius = radius,
        .integral = open,
        .inner = open / 2,
        .edge_distance = 1,
        .along = {point->ng[0], point->ng[1], point->ng[2]},
        .band = (float)(SUPPORT_HEIGHT * radius)};
    Plane plane = plane_at(point);
    Near near;
    near_find(trace, point, &plane, radius, &near);
    out->mixed = near.blockers || near.dense;
    out->layered = near.dense;
    out->flat = (float)near.flat;
    out->top = (float)fmin(near.top, SUPPORT_HEIGHT * radius);
    if (!near.dense && !near.full)
        sheets_find(trace, point, &plane, &near, out);
    else if (out->mixed)
        probe_integral(trace, point, out, &plane, &near);
}
