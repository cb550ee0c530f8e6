/* SPDX-License-Identifier: Apache-2.0 */
/* The triangles of a front: what three corners agree on lands as a triangle, what they do not is split, and
 * left to photons in the end. */
#include "render/gather/wave/wave_internal.h"

#include "core/checked.h"
#include "core/rng.h"

#include <string.h>

/* A triangle is wide from this many pixels on, and this many edges of the triangles of an even spread.
 * Measured at a ball's focus (docs/benchmarks.md): half of either costs as much time as it saves error. */
#define WIDE_PIXELS 4
#define WIDE_EVEN 4

enum { SPLITS_MAX = 2 };

/* A triangle is split while more than this share of its light is not agreed on. */
#define SPLIT_SHARE 0.1
/* Or while the flux of a path differs by more than this share of the light between the corners. */
#define SPLIT_VARIATION 0.1
/* Neighbouring normals of one sheet of a receiver, and how steep a step between them may be. */
#define SHEET_COSINE 0.8
#define SHEET_SLOPE 0.3

/* ---- one triangle on the receiver ---- */

static bool one_sheet(const WaveLanding *a, const WaveLanding *b) {
    if (v3_dot(a->normal, b->normal) < SHEET_COSINE) return false;
    V3 edge = v3_sub(b->position, a->position), mean = v3_normalize(v3_add(a->normal, b->normal));
    return fabs(v3_dot(edge, mean)) <= SHEET_SLOPE * v3_length(edge);
}

static bool outside(const WaveView *view, const WaveTriangle *t) {
    double w = view->width, h = view->height;
    return (t->x[0] < 0 && t->x[1] < 0 && t->x[2] < 0) || (t->x[0] > w && t->x[1] > w && t->x[2] > w) ||
           (t->y[0] < 0 && t->y[1] < 0 && t->y[2] < 0) || (t->y[0] > h && t->y[1] > h && t->y[2] > h);
}

static bool put_triangle(WaveCells *c, const WaveTriangle *t) {
    WaveBatch *b = c->out;
    if (!array_reserve((void **)&b->triangles, &b->capacity, b->count + 1, sizeof *b->triangles)) {
        b->out_of_memory = true;
        return false;
    }
    b->triangles[b->count++] = *t;
    return true;
}

/* A step in the receiver, as from a tile to the grout: what lies so far off the triangle's plane would show
 * none of its light. */
static bool one_plane(const WavePlane *plane, const WaveLanding *const l[3]) {
    for (int k = 0; k < 3; k++)
        if (fabs(v3_dot(v3_sub(l[k]->position, plane->center), plane->normal)) > plane->reach) return false;
    return true;
}

/* The same triangle for eye points behind glass and in mirrors. */
static void put_seen(WaveCells *c, const WaveLanding *const l[3], const WavePlane *plane, Rgb flux) {
    WaveBatch *b = c->out;
    if (!array_reserve((void **)&b->seen, &b->seen_capacity, b->seen_count + 1, sizeof *b->seen)) {
        b->out_of_memory = true;
    } else if (wave_seen_triangle(l, plane, flux, c->even * plane->footprint, &b->seen[b->seen_count])) {
        b->seen_count++;
    } else {
        /* Between two objects the middle may lie under one of them, hidden from its eye points: a corner will
         * do. */
        bool alike = l[0]->object == l[1]->object && l[0]->object == l[2]->object;
        WaveLanding middle = *l[b->deposit_count % 3];
        if (alike) middle.position = plane->center;
        wave_put_deposit(c, &middle, flux);
    }
}

/* False when the three do not make a triangle that can be drawn. */
static bool join(WaveCells *c, const WaveLanding *const l[3], double area) {
    if (!one_sheet(l[0], l[1]) || !one_sheet(l[1], l[2]) || !one_sheet(l[2], l[0])) return false;
    WavePlane plane;
    wave_plane(c->run->scene, l, &plane);
    if (!one_plane(&plane, l)) return false;
    c->out->landed += rgb_max(l[0]->weight) * area; /* a measure: one corner stands for three */
    if (!c->view) return true;
    WaveTriangle t = {.receiver = l[0]->receiver};
    int before = 0;
    for (int k = 0; k < 3; k++) {
        t.x[k] = l[k]->x;
        t.y[k] = l[k]->y;
        before += l[k]->before;
    }
    if (before == 1 || before == 2) return false; /* partly behind the camera */
    Rgb flux = rgb_scale(rgb_add(l[0]->weight, rgb_add(l[1]->weight, l[2]->weight)), area / 3);
    if (c->seen) put_seen(c, l, &plane, flux);
    if (!l[0]->shown || before == 0 || outside(c->view, &t)) return true;
    t.flux[0] = (float)flux.r;
    t.flux[1] = (float)flux.g;
    t.flux[2] = (float)flux.b;
    wave_set_plane(l, &plane, &t);
    return put_triangle(c, &t);
}

/* ---- what is claimed ---- */

static void put_claim(WaveCells *c, const WaveCorner *const corner[3], const WaveLanding *const l[3]) {
    WaveClaim *claim = &c->claims[c->claim_count++];
    memcpy(claim->corner, corner, sizeof claim->corner);
    claim->path = l[0]->path;
    claim->weight = rgb_scale(rgb_add(l[0]->weight, rgb_add(l[1]->weight, l[2]->weight)), 1.0 / 3);
    for (int k = 0; k < 3; k++) claim->landing[k] = (uint32_t)(l[k] - c->landings.items);
}

static const WaveLanding *find(const WaveCells *c, const WaveCorner *corner, uint64_t path) {
    const WaveLanding *l = &c->landings.items[corner->first];
    for (uint32_t i = 0; i < corner->count; i++)
        if (l[i].path == path) return &l[i];
    return NULL;
}

/* The share of the light by which a path's flux differs over the triangle. */
static double variation(const WaveLanding *const l[3], double start) {
    double w[3] = {rgb_max(l[0]->weight), rgb_max(l[1]->weight), rgb_max(l[2]->weight)};
    return (fmax(w[0], fmax(w[1], w[2])) - fmin(w[0], fmin(w[1], w[2]))) / start;
}

/* So wide in the picture that its one irradiance and straight edges would show. */
static bool is_wide(const WaveCells *c, const WaveLanding *const l[3]) {
    if (!c->view || !l[0]->before || !l[1]->before || !l[2]->before) return false;
    WaveTriangle t = {.x = {l[0]->x, l[1]->x, l[2]->x}, .y = {l[0]->y, l[1]->y, l[2]->y}};
    for (int k = 0; k < 3; k++) {
        int next = (k + 1) % 3;
        if (hypot(t.x[k] - t.x[next], t.y[k] - t.y[next]) > c->wide) return !outside(c->view, &t);
    }
    return false;
}

/* In proportion to the triangles that as many rays would make, spread evenly over the picture: so splits take
 * a part of the rays, however large the picture. */
static void set_limits(WaveCells *c) {
    c->wide = INFINITY;
    if (!c->view) return;
    double scale = c->view->scale;
    c->even = sqrt((double)c->view->width * c->view->height / fmax(c->run->rays, 1)) / scale;
    c->wide = scale * fmax(WIDE_PIXELS, WIDE_EVEN * c->even);
}

/* Lands every path that the corners agree on; returns the share of the light that is not landed, and in
 * `wide` that of paths that are too wide. `wait`: such paths, and those whose flux varies much over a
 * triangle that may still be split, are left: at a rim the transmitted light falls with infinite slope, and
 * the mean of three corners would lose some of it. */
static double claim(WaveCells *c, const WaveCorner *const corner[3], double area, bool wait, double *wide) {
    double left = 0, start = 0;
    for (int k = 0; k < 3; k++) start = fmax(start, rgb_max(corner[k]->weight));
    const WaveLanding *own = &c->landings.items[corner[0]->first];
    for (uint32_t i = 0; i < corner[0]->count; i++) {
        uint64_t path = own[i].path;
        if (c->claim_count == WAVE_CLAIMED_MAX || wave_claimed(c, path)) continue;
        const WaveLanding *const l[3] = {&own[i], find(c, corner[1], path), find(c, corner[2], path)};
        if (!l[1] || !l[2]) continue;
        if (wait && variation(l, start) > SPLIT_VARIATION) continue;
        if (wait && is_wide(c, l)) {
            *wide += rgb_max(l[0]->weight) / start;
            continue;
        }
        if (join(c, l, area)) put_claim(c, corner, l);
    }
    for (int k = 0; k < 3; k++) {
        const WaveLanding *l = &c->landings.items[corner[k]->first];
        for (uint32_t i = 0; i < corner[k]->count; i++)
            if (!wave_claimed(c, l[i].path)) left += rgb_max(l[i].weight) / 3;
    }
    return start > 0 ? left / start : 0;
}

/* ---- triangles of the grid ---- */

static WaveCorner corner_at(WaveCells *c, double u, double v, double area, bool counted) {
    WaveCorner corner =
        wave_corner(c->run, c->front, u, v, area, &c->landings, counted ? &c->out->account : NULL);
    for (uint32_t i = 0; c->view && i < corner.count; i++) {
        WaveLanding *l = &c->landings.items[corner.first + i];
        l->before = wave_project(c->view, l->position, &l->x, &l->y);
    }
    return corner;
}

static void triangle(
    WaveCells *c, const WaveCorner *a, const WaveCorner *b, const WaveCorner *d, double area, int splits) {
    const WaveCorner *const corner[3] = {a, b, d};
    size_t before = c->claim_count;
    bool wait = c->claim_count < WAVE_CLAIMED_MAX && splits < SPLITS_MAX;
    double wide = 0, left = claim(c, corner, area, wait, &wide);
    if (wait && fmax(left, wide) > SPLIT_SHARE) {
        size_t top = c->landings.count;
        WaveCorner m[3];
        for (int k = 0; k < 3; k++) {
            const WaveCorner *p = corner[k], *q = corner[(k + 1) % 3];
            m[k] = corner_at(c, 0.5 * (p->u + q->u), 0.5 * (p->v + q->v), 0, true);
        }
        triangle(c, a, &m[0], &m[2], area / 4, splits + 1);
        triangle(c, &m[0], b, &m[1], area / 4, splits + 1);
        triangle(c, &m[2], &m[1], d, area / 4, splits + 1);
        triangle(c, &m[0], &m[1], &m[2], area / 4, splits + 1);
        c->landings.count = top;
    } else
        wave_leave(c, corner, area, claim(c, corner, area, false, NULL));
    c->claim_count = before;
}

/* Diagonals alternate, so that the map has no grain. */
static void cell(WaveCells *c, const WaveCorner *row, const WaveCorner *next, int i, int j, double area) {
    const WaveCorner *p = &row[i], *q = &row[i + 1], *r = &next[i], *s = &next[i + 1];
    bool turned = (i + j) & 1;
    const WaveCorner *one[3] = {p, q, turned ? r : s}, *two[3] = {s, r, turned ? q : p};
    triangle(c, one[0], one[1], one[2], area / 2, 0);
    triangle(c, two[0], two[1], two[2], area / 2, 0);
}

/* ---- rows of corners ---- */

typedef struct Grid {
    double origin[2], step[2], area;
} Grid;

/* The grid is shifted by a random part of a cell from replica to replica; then one cell more covers all. */
static Grid grid_of(const WaveFront *f, uint64_t key) {
    Grid g;
    for (int k = 0; k < 2; k++) {
        double shift = f->tiled ? 0 : rng_unit(rng_combine(key, (uint64_t)k + 1));
        g.step[k] = (f->hi[k] - f->lo[k]) / (f->tiled ? f->n[k] : f->n[k] - 1);
        g.origin[k] = f->lo[k] - shift * g.step[k];
    }
    g.area = g.step[0] * g.step[1];
    return g;
}

/* Weight of a corner in the sum over the grid. */
static double corner_share(const WaveFront *f, int i, int j) {
    return (i == 0 || i == f->n[0] ? 0.5 : 1) * (j == 0 || j == f->n[1] ? 0.5 : 1);
}

/* Row j of the tile's corners. A corner counts in the tile whose first row and column it is, and at the far
 * rims of the front. */
static void corner_row(WaveCells *c, const WaveTile *tile, const Grid *g, int j, WaveCorner *row) {
    const WaveFront *f = c->front;
    bool row_counts = j < tile->y1 || j == f->n[1];
    for (int i = tile->x0; i <= tile->x1; i++) {
        double area = g->area * corner_share(f, i, j);
        bool counted = row_counts && (i < tile->x1 || i == f->n[0]);
        WaveCorner *corner = &row[i - tile->x0];
        *corner = corner_at(c, g->origin[0] + i * g->step[0], g->origin[1] + j * g->step[1], area, counted);
    }
}

/* The landings of a finished row go; those of the row that stays move to the front. */
static void drop_row(WaveCells *c, WaveCorner *row, int corners) {
    uint32_t first = row[0].first;
    if (first == 0) return; /* nothing landed in the finished row */
    memmove(c->landings.items, c->landings.items + first,
        (c->landings.count - first) * sizeof *c->landings.items);
    c->landings.count -= first;
    for (int i = 0; i < corners; i++) row[i].first -= first;
}

void wave_cells(const WaveRun *run, const WaveView *view, bool seen, const WaveTile *tile, WaveBatch *out) {
    out->seen_count = out->count = out->splat_count = out->deposit_count = 0;
    out->account = (FluxAccount){0};
    out->landed = out->left = 0;
    out->looked = out->looked_flux = out->found = 0;
    WaveCells c = {.run = run, .view = view, .seen = seen, .front = tile->front, .out = out};
    set_limits(&c);
    c.key = rng_combine(tile->key, rng_combine((uint64_t)tile->x0, (uint64_t)tile->y0));
    int corners = tile->x1 - tile->x0 + 1;
    WaveCorner rows[2][WAVE_TILE + 1];
    Grid g = grid_of(tile->front, tile->key);
    corner_row(&c, tile, &g, tile->y0, rows[0]);
    for (int j = tile->y0; j < tile->y1 && !out->out_of_memory && !c.landings.out_of_memory; j++) {
        WaveCorner *row = rows[(j - tile->y0) & 1], *next = rows[(j - tile->y0 + 1) & 1];
        if (run->cancel && atomic_load_explicit(run->cancel, memory_order_relaxed)) break;
        corner_row(&c, tile, &g, j + 1, next);
        for (int i = 0; i + 1 < corners; i++) cell(&c, row, next, i, j, g.area);
        drop_row(&c, next, corners);
    }
    out->out_of_memory |= c.landings.out_of_memory;
    free(c.landings.items);
}
