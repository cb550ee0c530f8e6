/* SPDX-License-Identifier: Apache-2.0 */
/* Landed triangles drawn on the view by exact area coverage. */
#include "render/gather/wave/wave_internal.h"

enum { POLYGON_MAX = 8, STRIPS_PER_THREAD = 2 };

/* A triangle of less area than this (subpixels) is a point of light. */
#define POINT_AREA 1e-12
/* Facing test between the triangle's receiver and what a subpixel sees. */
#define FACING_COSINE 0.7

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

/* Sutherland and Hodgman 1974, both halves of an axis-aligned cut: a coordinate below `at` goes to *low,
 * above to *high (either may be NULL). */
static void put(Polygon *p, double x, double y) {
    if (!p || p->count == POLYGON_MAX) return;
    p->x[p->count] = x;
    p->y[p->count++] = y;
}

static void cut(const Polygon *in, bool by_x, double at, Polygon *low, Polygon *high) {
    if (low) low->count = 0;
    if (high) high->count = 0;
    for (int i = 0; i < in->count; i++) {
        int k = i + 1 < in->count ? i + 1 : 0;
        double a = (by_x ? in->x[i] : in->y[i]) - at, b = (by_x ? in->x[k] : in->y[k]) - at;
        if (a <= 0) put(low, in->x[i], in->y[i]);
        if (a >= 0) put(high, in->x[i], in->y[i]);
        if ((a < 0 && b > 0) || (a > 0 && b < 0)) {
            double f = a / (a - b), x = in->x[i] + f * (in->x[k] - in->x[i]),
                   y = in->y[i] + f * (in->y[k] - in->y[i]);
            put(low, by_x ? at : x, by_x ? y : at);
            put(high, by_x ? at : x, by_x ? y : at);
        }
    }
}

static void range(const double *v, int count, double *lo, double *hi) {
    *lo = *hi = v[0];
    for (int i = 1; i < count; i++) {
        if (v[i] < *lo) *lo = v[i];
        if (v[i] > *hi) *hi = v[i];
    }
}

/* ---- one subpixel ---- */

typedef struct Strip {
    WaveView *view;
    int y0, y1;
} Strip;

/* `covered` is the area of the subpixel under the triangle, `share` that of the triangle over the subpixel.
 */
static void light(const Strip *s, const WaveTriangle *t, int x, int y, double covered, double share) {
    size_t at = (size_t)y * (size_t)s->view->width + (size_t)x;
    const WaveSubpixel *p = &s->view->subpixels[at];
    if (p->object != t->object) return;
    float facing = t->normal[0] * p->normal[0] + t->normal[1] * p->normal[1] + t->normal[2] * p->normal[2];
    if (facing < (float)FACING_COSINE) return;
    float off = t->plane[0] * p->position[0] + t->plane[1] * p->position[1] + t->plane[2] * p->position[2] +
                t->plane[3];
    if (fabsf(off) > t->reach) return;
    double per_flux = t->per_area > 0 ? covered * (double)t->per_area : share * (double)p->per_flux;
    float *e = &s->view->irradiance[3 * at];
    for (int k = 0; k < 3; k++) e[k] += (float)(per_flux * (double)t->flux[k]);
}

static int column(const Strip *s, double x) { return (int)clamp(floor(x), 0, s->view->width - 1); }

/* Columns [from, to) of a polygon that lies in one row, each by its exact part. */
static void light_columns(
    const Strip *s, const WaveTriangle *t, const Polygon *row, int from, int to, int y, double inverse) {
    Polygon p = *row, cell, rest;
    double lo, hi;
    if (p.count < 3) return;
    range(p.x, p.count, &lo, &hi);
    if (lo < from) {
        cut(&p, true, from, NULL, &rest);
        p = rest;
    }
    for (int x = lo > from ? column(s, lo) : from; x < to && p.count >= 3; x++) {
        bool last = hi <= x + 1;
        if (!last) cut(&p, true, x + 1, &cell, &rest);
        double area = 0.5 * fabs(area2(last ? &p : &cell));
        if (area > 0) light(s, t, x, y, area, area * inverse);
        if (last) return;
        p = rest;
    }
}

/* Where the triangle's outline meets a horizontal line: false when it does not. */
static bool crossing(const WaveTriangle *t, double y, double *lo, double *hi) {
    *lo = INFINITY;
    *hi = -INFINITY;
    for (int i = 0; i < 3; i++) {
        int k = i < 2 ? i + 1 : 0;
        double a = t->y[i] - y, b = t->y[k] - y;
        if ((a < 0 && b < 0) || (a > 0 && b > 0) || a == b) continue;
        double x = t->x[i] + a / (a - b) * (t->x[k] - t->x[i]);
        if (x < *lo) *lo = x;
        if (x > *hi) *hi = x;
    }
    return *lo <= *hi;
}

/* The part of the triangle in one row of subpixels. The outline bulges outwards, so what lies within it above
 * and below is covered between, and needs no cutting. */
static void light_row(const Strip *s, const WaveTriangle *t, const Polygon *p, int y, double inverse) {
    double lo, hi, lo2, hi2;
    int width = s->view->width, from = 0, to = 0;
    if (crossing(t, y, &lo, &hi) && crossing(t, y + 1, &lo2, &hi2)) {
        from = (int)clamp(ceil(fmax(lo, lo2)), 0, width);
        to = (int)clamp(floor(fmin(hi, hi2)), 0, width);
    }
    if (to <= from) {
        light_columns(s, t, p, 0, width, y, inverse);
        return;
    }
    light_columns(s, t, p, 0, from, y, inverse);
    for (int x = from; x < to; x++) light(s, t, x, y, 1, inverse);
    light_columns(s, t, p, to, width, y, inverse);
}

static void light_point(const Strip *s, const WaveTriangle *t) {
    double x = (t->x[0] + t->x[1] + t->x[2]) / 3, y = (t->y[0] + t->y[1] + t->y[2]) / 3;
    if (!(x >= 0 && x < s->view->width && y >= s->y0 && y < s->y1)) return;
    WaveTriangle point = *t;
    point.per_area = 0;
    light(s, &point, (int)x, (int)y, 0, 1);
}

static void light_triangle(const Strip *s, const WaveTriangle *t) {
    double lo, hi;
    range(t->y, 3, &lo, &hi);
    if (hi < s->y0 || lo >= s->y1) return;
    Polygon p = {{t->x[0], t->x[1], t->x[2]}, {t->y[0], t->y[1], t->y[2]}, 3}, row, rest;
    double area = 0.5 * fabs(area2(&p));
    if (!(area > POINT_AREA)) {
        light_point(s, t);
        return;
    }
    if (lo < s->y0) {
        cut(&p, false, s->y0, NULL, &rest);
        p = rest;
    }
    int first = (int)floor(fmax(lo, s->y0)), last = (int)floor(fmin(hi, s->y1 - 1));
    for (int y = first; y <= last && p.count >= 3; y++) {
        s->view->lit[y] = 1;
        if (hi <= y + 1) {
            light_row(s, t, &p, y, 1 / area);
            break;
        }
        cut(&p, false, y + 1, &row, &rest);
        light_row(s, t, &row, y, 1 / area);
        p = rest;
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
    (void)thread;
    const DrawJob *job = data;
    size_t height = (size_t)job->view->height;
    Strip s = {job->view, (int)(height * index / job->strips), (int)(height * (index + 1) / job->strips)};
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
