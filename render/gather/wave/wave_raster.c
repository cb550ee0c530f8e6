/* SPDX-License-Identifier: Apache-2.0 */
/* Landed triangles drawn on the view by exact area coverage: in each row the edges leave their part of every
 * column that they pass, and the sum from the left is what is covered (the accumulation buffer of font
 * rasterisers: R. Levien, font-rs, 2016). */
#include "render/gather/wave/wave_internal.h"

#include <string.h>

enum { POLYGON_MAX = 8, STRIPS_PER_THREAD = 2 };

/* A triangle of less area than this (subpixels) is a point of light: the sums would lose its coverage to
 * rounding. */
#define POINT_AREA 1e-8
/* Normals this close are one plane. */
#define FLAT_COSINE (1 - 1e-9)

typedef struct Strip {
    const TraceScene *trace;
    WaveView *view;
    double *row; /* [width + 3] zero: coverage that begins in each column */
    int y0, y1;
} Strip;

/* ---- what is the triangle's receiver ---- */

void wave_plane(const Scene *scene, const WaveLanding *const l[3], WavePlane *out) {
    V3 n = v3_normalize(v3_add(l[0]->normal, v3_add(l[1]->normal, l[2]->normal)));
    V3 center = v3_scale(v3_add(l[0]->position, v3_add(l[1]->position, l[2]->position)), 1.0 / 3);
    V3 e1 = v3_sub(l[1]->position, l[0]->position), e2 = v3_sub(l[2]->position, l[0]->position);
    double cosine = fmin(v3_dot(n, l[0]->normal), fmin(v3_dot(n, l[1]->normal), v3_dot(n, l[2]->normal)));
    *out = (WavePlane){.normal = n,
        .center = center,
        .extent = fmax(v3_length(e1), v3_length(e2)),
        .flat = cosine > FLAT_COSINE};
    CameraView seen;
    if (camera_project(&scene->camera, center, &seen)) out->footprint = 1 / sqrt(seen.raster_per_area);
    out->reach = out->extent * (sqrt(fmax(0, 2 - 2 * cosine)) + WAVE_PLANE_OFF) +
                 out->footprint * (out->flat ? WAVE_FLAT_OFF : 1);
}

void wave_set_plane(const WaveLanding *const l[3], const WavePlane *plane, WaveTriangle *t) {
    V3 n = plane->normal, e1 = v3_sub(l[1]->position, l[0]->position),
       e2 = v3_sub(l[2]->position, l[0]->position);
    double area = 0.5 * v3_length(v3_cross(e1, e2));
    t->plane[0] = t->normal[0] = (float)n.x;
    t->plane[1] = t->normal[1] = (float)n.y;
    t->plane[2] = t->normal[2] = (float)n.z;
    t->plane[3] = (float)-v3_dot(n, plane->center);
    t->reach = (float)plane->reach;
    t->per_area = plane->flat && area > 0 && isfinite((float)(1 / area)) ? (float)(1 / area) : 0;
}

static inline float facing_of(const WaveSubpixel *p, const WaveTriangle *t) {
    return t->normal[0] * p->normal[0] + t->normal[1] * p->normal[1] + t->normal[2] * p->normal[2];
}

static inline bool shows(const WaveSubpixel *p, const WaveTriangle *t) {
    if (!wave_same_receiver(p->receiver, t->receiver)) return false;
    float off = t->plane[0] * p->position[0] + t->plane[1] * p->position[1] + t->plane[2] * p->position[2] +
                t->plane[3];
    return facing_of(p, t) >= (float)WAVE_FACING_COSINE && fabsf(off) <= t->reach;
}

/* The subpixel at a raster position within the view, or the part of a mixed one. */
static size_t subpixel_at(const WaveView *v, double px, double py) {
    int x = (int)px, y = (int)py;
    size_t at = (size_t)y * (size_t)v->width + (size_t)x;
    if (v->subpixels[at].receiver != WAVE_MIXED) return at;
    int i = (int)((px - x) * v->parts), j = (int)((py - y) * v->parts);
    return wave_block(v, &v->subpixels[at]) + (size_t)(j * v->parts + i);
}

bool wave_shows(
    const TraceScene *trace, const WaveView *v, const WaveTriangle *t, double x, double y, int *object) {
    if (!(x >= 0 && x < v->width && y >= 0 && y < v->height)) return true;
    const WaveSubpixel *p = &v->subpixels[subpixel_at(v, x, y)];
    if (!shows(p, t) || ((p->receiver & WAVE_CONTACT) && !wave_on_this_side(trace, v, p, x, y))) return false;
    *object = wave_object(p->receiver);
    return true;
}

/* ---- parts of triangles ---- */

typedef struct Polygon {
    double x[POLYGON_MAX], y[POLYGON_MAX];
    int count;
} Polygon;

/* Twice the signed area. */
static double area2(const Polygon *p) {
    double sum = 0;
    for (int i = 1; i + 1 < p->count; i++)
        sum += (p->x[i] - p->x[0]) * (p->y[i + 1] - p->y[0]) - (p->x[i + 1] - p->x[0]) * (p->y[i] - p->y[0]);
    return sum;
}

static void put(Polygon *p, double x, double y) {
    if (p->count == POLYGON_MAX) return;
    p->x[p->count] = x;
    p->y[p->count++] = y;
}

/* What lies above (sign 1) or below (-1) a coordinate (Sutherland and Hodgman 1974). */
static Polygon cut(const Polygon *in, bool by_x, double at, double sign) {
    Polygon out = {.count = 0};
    for (int i = 0; i < in->count; i++) {
        int k = i + 1 < in->count ? i + 1 : 0;
        double a = sign * ((by_x ? in->x[i] : in->y[i]) - at), b = sign * ((by_x ? in->x[k] : in->y[k]) - at);
        if (a >= 0) put(&out, in->x[i], in->y[i]);
        if ((a < 0 && b > 0) || (a > 0 && b < 0)) {
            double f = a / (a - b), x = in->x[i] + f * (in->x[k] - in->x[i]),
                   y = in->y[i] + f * (in->y[k] - in->y[i]);
            put(&out, by_x ? at : x, by_x ? y : at);
        }
    }
    return out;
}

static Polygon cut_between(const Polygon *in, bool by_x, double low, double high) {
    Polygon above = cut(in, by_x, low, 1);
    return cut(&above, by_x, high, -1);
}

/* ---- one subpixel ---- */

/* A square of the raster. */
typedef struct Square {
    double x, y, size;
} Square;

/* The middle of the triangle's part over a square is on the seen side of what stands there. */
static bool part_on_this_side(const Strip *s, const WaveTriangle *t, const WaveSubpixel *p, Square square) {
    Polygon part = {{t->x[0], t->x[1], t->x[2]}, {t->y[0], t->y[1], t->y[2]}, 3};
    part = cut_between(&part, false, square.y, square.y + square.size);
    part = cut_between(&part, true, square.x, square.x + square.size);
    double x = 0, y = 0;
    for (int i = 0; i < part.count; i++) {
        x += part.x[i] / part.count;
        y += part.y[i] / part.count;
    }
    return part.count == 0 || wave_on_this_side(s->trace, s->view, p, x, y);
}

/* `covered` is the area of the subpixel under the triangle, `share` that of the triangle over the subpixel.
 */
static inline void light(
    const Strip *s, const WaveTriangle *t, size_t at, double covered, double share, Square square) {
    const WaveSubpixel *p = &s->view->subpixels[at];
    if (!shows(p, t)) return;
    if ((p->receiver & WAVE_CONTACT) && !part_on_this_side(s, t, p, square)) return;
    /* What is slanted to the plane, as a tile's bevel, has more area for the same light. */
    double per_flux =
        t->per_area > 0 ? covered * (double)(t->per_area * facing_of(p, t)) : share * (double)p->per_flux;
    float *e = &s->view->irradiance[3 * at];
    for (int k = 0; k < 3; k++) e[k] += (float)(per_flux * (double)t->flux[k]);
}

/* Shares the light of subpixel (x, y) out to its parts. */
static void light_parts(const Strip *s, const WaveTriangle *t, int x, int y, double inverse) {
    WaveView *v = s->view;
    Polygon all = {{t->x[0], t->x[1], t->x[2]}, {t->y[0], t->y[1], t->y[2]}, 3};
    double step = 1.0 / v->parts, whole = (double)v->parts * v->parts;
    size_t at = wave_block(v, &v->subpixels[(size_t)y * (size_t)v->width + (size_t)x]);
    for (int j = 0; j < v->parts; j++) {
        Polygon row = cut_between(&all, false, y + j * step, y + (j + 1) * step);
        if (row.count < 3) continue;
        for (int i = 0; i < v->parts; i++) {
            Polygon part = cut_between(&row, true, x + i * step, x + (i + 1) * step);
            double area = part.count < 3 ? 0 : 0.5 * fabs(area2(&part));
            if (area > 0)
                light(s, t, at + (size_t)(j * v->parts + i), area * whole, area * inverse,
                    (Square){x + i * step, y + j * step, step});
        }
    }
}

/* All of the triangle lies in one subpixel. */
static void light_one(const Strip *s, const WaveTriangle *t, int x, int y, double area) {
    WaveView *v = s->view;
    size_t at = (size_t)y * (size_t)v->width + (size_t)x;
    const WaveSubpixel *p = &v->subpixels[at];
    v->lit[y] = 1;
    if (p->receiver != WAVE_MIXED)
        light(s, t, at, area, 1, (Square){x, y, 1});
    else
        light_parts(s, t, x, y, 1 / area);
}

static double least(const double v[3]) { return fmin(v[0], fmin(v[1], v[2])); }
static double most(const double v[3]) { return fmax(v[0], fmax(v[1], v[2])); }
static double middle(const double v[3]) { return (v[0] + v[1] + v[2]) / 3; }

static void light_point(const Strip *s, const WaveTriangle *t) {
    WaveView *v = s->view;
    double px = middle(t->x), py = middle(t->y);
    if (!(px >= 0 && px < v->width && py >= s->y0 && py < s->y1)) return;
    WaveTriangle point = *t;
    point.per_area = 0;
    v->lit[(int)py] = 1;
    light(s, &point, subpixel_at(v, px, py), 0, 1, (Square){floor(px), floor(py), 1});
}

/* ---- coverage ---- */

/* An edge, or a piece of one, within one row and the view's width: `down` is its height with its sign. What
 * lies to the right of it is covered. */
static void edge_within(double *row, double a, double b, double down) {
    double left = a < b ? a : b, right = a < b ? b : a;
    int first = (int)left;
    double from = left - first;
    if (right <= first + 1) {
        double outside = 0.5 * (from + right - first); /* of the first column, left of the edge */
        row[first] += down * (1 - outside);
        row[first + 1] += down * outside;
        return;
    }
    double slope = down / (right - left), covered = 0.5 * slope * (1 - from) * (1 - from), before = covered;
    row[first] += covered;
    int x = first + 1;
    for (; x + 1 < right; x++) { /* crossed from side to side: half of its own step, half of the last one's */
        covered = slope * (x + 0.5 - left);
        row[x] += covered - before;
        before = covered;
    }
    double rest = right - x;
    covered = down - 0.5 * slope * rest * rest;
    row[x] += covered - before;
    row[x + 1] += down - covered;
}

/* An edge within one row: what lies beyond the view's sides counts as if it lay on them. */
static void edge_row(double *row, double width, double a, double b, double down) {
    const double side[2] = {0, width};
    for (int k = 0; k < 2; k++) {
        if ((a - side[k]) * (b - side[k]) >= 0) continue;
        double part = (side[k] - a) / (b - a);
        edge_row(row, width, a, side[k], down * part);
        edge_row(row, width, side[k], b, down * (1 - part));
        return;
    }
    edge_within(row, clamp(a, 0, width), clamp(b, 0, width), down);
}

/* The three edges' parts in row y, and the columns that they pass. */
static void edges_row(const Strip *s, const WaveTriangle *t, int y, double turn, double range[2]) {
    range[0] = INFINITY;
    range[1] = -INFINITY;
    for (int k = 0; k < 3; k++) {
        int j = k < 2 ? k + 1 : 0;
        double y0 = t->y[k], y1 = t->y[j], top = y0 < y1 ? y0 : y1, bottom = y0 < y1 ? y1 : y0;
        if (bottom <= y || top >= y + 1 || !(top < bottom)) continue;
        double from = top > y ? top : y, to = bottom < y + 1 ? bottom : y + 1, down = to - from;
        double x0 = y0 < y1 ? t->x[k] : t->x[j], x1 = y0 < y1 ? t->x[j] : t->x[k];
        double slope = (x1 - x0) / (bottom - top);
        double a = top > y ? x0 : x0 + (y - top) * slope,
               b = bottom < y + 1 ? x1 : x0 + (y + 1 - top) * slope;
        edge_row(s->row, s->view->width, a, b, y1 > y0 ? turn * down : -turn * down);
        range[0] = fmin(range[0], fmin(a, b));
        range[1] = fmax(range[1], fmax(a, b));
    }
}

static void light_row(const Strip *s, const WaveTriangle *t, int y, const double range[2], double inverse) {
    WaveView *v = s->view;
    int first = (int)clamp(floor(range[0]), 0, v->width),
        last = (int)clamp(floor(range[1]), -1, v->width - 1);
    size_t at = (size_t)y * (size_t)v->width;
    double covered = 0;
    v->lit[y] = 1;
    for (int x = first; x <= last; x++) {
        covered += s->row[x];
        s->row[x] = 0;
        if (!(covered > 0)) continue;
        if (v->subpixels[at + (size_t)x].receiver == WAVE_MIXED)
            light_parts(s, t, x, y, inverse);
        else
            light(s, t, at + (size_t)x, covered, covered * inverse, (Square){x, y, 1});
    }
    s->row[last + 1] = s->row[last + 2] = 0;
}

static void light_triangle(const Strip *s, const WaveTriangle *t) {
    double top = least(t->y), bottom = most(t->y), left = least(t->x), right = most(t->x);
    int width = s->view->width;
    if (bottom < s->y0 || top >= s->y1 || right < 0 || left >= width) return;
    double turned = (t->x[1] - t->x[0]) * (t->y[2] - t->y[0]) - (t->x[2] - t->x[0]) * (t->y[1] - t->y[0]);
    double area = 0.5 * fabs(turned);
    if (!(area > POINT_AREA)) {
        light_point(s, t);
        return;
    }
    int x = (int)fmax(floor(left), -1), y = (int)fmax(floor(top), s->y0 - 1);
    if (right <= x + 1 && bottom <= y + 1) {
        if (x >= 0 && y >= s->y0) light_one(s, t, x, y, area);
        return;
    }
    int end = (int)fmin(floor(bottom), s->y1 - 1);
    for (y = y > s->y0 ? y : s->y0; y <= end; y++) {
        double range[2];
        edges_row(s, t, y, turned > 0 ? -1 : 1, range);
        if (range[0] <= range[1]) light_row(s, t, y, range, 1 / area);
    }
}

/* ---- all ---- */

typedef struct DrawJob {
    const TraceScene *trace;
    WaveView *view;
    const WaveBatch *batches;
    size_t count, strips;
} DrawJob;

static void draw_strip(void *data, size_t index, unsigned thread) {
    const DrawJob *job = data;
    size_t height = (size_t)job->view->height;
    double *row = job->view->columns + 6 * (size_t)thread * (size_t)job->view->width;
    Strip s = {job->trace, job->view, row, (int)(height * index / job->strips),
        (int)(height * (index + 1) / job->strips)};
    memset(row, 0, ((size_t)job->view->width + 3) * sizeof *row);
    for (size_t b = 0; b < job->count; b++) {
        const WaveBatch *batch = &job->batches[b];
        for (size_t i = 0; i < batch->count; i++) light_triangle(&s, &batch->triangles[i]);
        for (size_t i = 0; i < batch->splat_count; i++)
            wave_splat_draw(job->trace, job->view, &batch->splats[i], s.y0, s.y1);
    }
}

void wave_draw(
    const TraceScene *trace, WaveView *view, TaskPool *pool, const WaveBatch *batches, size_t batch_count) {
    DrawJob job = {trace, view, batches, batch_count, (size_t)tasks_threads(pool) * STRIPS_PER_THREAD};
    tasks_run(pool, job.strips, draw_strip, &job);
}
