/* SPDX-License-Identifier: Apache-2.0 */
/* The triangles of a front: what three corners agree on lands as a triangle, what they do not is split, and
 * left to photons in the end. */
#include "render/gather/wave/wave_internal.h"

#include "core/checked.h"
#include "core/rng.h"

enum { CLAIMED_MAX = 192, SPLITS_MAX = 2 };

/* A triangle is split while more than this share of its light is not agreed on. */
#define SPLIT_SHARE 0.1
/* Or while the flux of a path differs by more than this share of the light between the corners. */
#define SPLIT_VARIATION 0.1
/* What is left over becomes one photon for certain above this share, below it with less probability. */
#define PHOTON_SHARE 0.02
/* Neighbouring normals of one sheet of a receiver, and how steep a step between them may be. */
#define SHEET_COSINE 0.8
#define SHEET_SLOPE 0.3
/* Normals this close are one plane. */
#define FLAT_COSINE (1 - 1e-9)

/* Share of the triangles in which a ray looks for what their corners do not tell. */
#define LOOK_CHANCE (1.0 / 16)

/* A path that landed as a triangle. */
typedef struct Claim {
    uint64_t path;
    uint32_t landing[3]; /* its corners, in Cells.landings */
    Rgb weight;          /* their mean */
} Claim;

typedef struct Cells {
    const WaveRun *run;
    const WaveView *view;
    bool seen; /* some eye points see receivers through glass or in mirrors */
    const WaveFront *front;
    WaveBatch *out;
    WaveLandings landings; /* of the two rows of corners, and of a triangle's midpoints on top */
    uint64_t key;
    Claim claims[CLAIMED_MAX];
    size_t claim_count;
    uint64_t leaves; /* triangles that were not split, so far */
} Cells;

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

/* The receiver around the triangle: its plane, and how far from it the receiver may be seen. */
static void set_plane(const Cells *c, const WaveLanding *const l[3], WaveTriangle *t) {
    V3 n = v3_normalize(v3_add(l[0]->normal, v3_add(l[1]->normal, l[2]->normal)));
    V3 center = v3_scale(v3_add(l[0]->position, v3_add(l[1]->position, l[2]->position)), 1.0 / 3);
    V3 e1 = v3_sub(l[1]->position, l[0]->position), e2 = v3_sub(l[2]->position, l[0]->position);
    double cosine = fmin(v3_dot(n, l[0]->normal), fmin(v3_dot(n, l[1]->normal), v3_dot(n, l[2]->normal)));
    double extent = fmax(v3_length(e1), v3_length(e2)), area = 0.5 * v3_length(v3_cross(e1, e2));
    bool flat = cosine > FLAT_COSINE;
    CameraView seen;
    double footprint = 0;
    if (camera_project(&c->run->scene->camera, center, &seen)) footprint = 1 / sqrt(seen.raster_per_area);
    t->plane[0] = t->normal[0] = (float)n.x;
    t->plane[1] = t->normal[1] = (float)n.y;
    t->plane[2] = t->normal[2] = (float)n.z;
    t->plane[3] = (float)-v3_dot(n, center);
    t->reach = (float)(extent * sqrt(fmax(0, 2 - 2 * cosine)) + footprint * (flat ? 0.05 : 1));
    t->per_area = flat && area > 0 && isfinite((float)(1 / area)) ? (float)(1 / area) : 0;
}

static bool put_triangle(Cells *c, const WaveTriangle *t) {
    WaveBatch *b = c->out;
    if (!array_reserve((void **)&b->triangles, &b->capacity, b->count + 1, sizeof *b->triangles)) {
        b->out_of_memory = true;
        return false;
    }
    b->triangles[b->count++] = *t;
    return true;
}

/* For receivers seen through glass or in mirrors. */
static void put_deposit(Cells *c, const WaveLanding *l, double scale) {
    WaveBatch *b = c->out;
    if (!array_reserve(
            (void **)&b->deposits, &b->deposit_capacity, b->deposit_count + 1, sizeof *b->deposits)) {
        b->out_of_memory = true;
        return;
    }
    Deposit *d = &b->deposits[b->deposit_count++];
    *d = (Deposit){.position = {(float)l->position.x, (float)l->position.y, (float)l->position.z},
        .flux = {(float)(l->weight.r * scale), (float)(l->weight.g * scale), (float)(l->weight.b * scale)},
        .glossy = l->glossy,
        .transmission = l->transmission,
        .audience = AUDIENCE_SEEN};
    normal_encode(l->normal, d->normal);
}

/* The same triangle for eye points behind glass and in mirrors. */
static void put_seen(Cells *c, const WaveLanding *const l[3], Rgb flux) {
    WaveBatch *b = c->out;
    V3 center = v3_scale(v3_add(l[0]->position, v3_add(l[1]->position, l[2]->position)), 1.0 / 3);
    CameraView view;
    double footprint = 0;
    if (camera_project(&c->run->scene->camera, center, &view)) footprint = 1 / sqrt(view.raster_per_area);
    if (!array_reserve((void **)&b->seen, &b->seen_capacity, b->seen_count + 1, sizeof *b->seen)) {
        b->out_of_memory = true;
    } else if (wave_seen_triangle(l, flux, center, footprint, &b->seen[b->seen_count])) {
        b->seen_count++;
    } else {
        WaveLanding middle = *l[0];
        middle.position = center;
        middle.weight = flux;
        put_deposit(c, &middle, 1);
    }
}

/* False when the three do not make a triangle that can be drawn. */
static bool join(Cells *c, const WaveLanding *const l[3], double area) {
    if (!one_sheet(l[0], l[1]) || !one_sheet(l[1], l[2]) || !one_sheet(l[2], l[0])) return false;
    c->out->landed += rgb_max(l[0]->weight) * area; /* a measure: one corner stands for three */
    if (!c->view) return true;
    WaveTriangle t = {.object = l[0]->object};
    int before = 0;
    for (int k = 0; k < 3; k++) before += wave_project(c->view, l[k]->position, &t.x[k], &t.y[k]);
    if (before == 1 || before == 2) return false; /* partly behind the camera */
    Rgb flux = rgb_scale(rgb_add(l[0]->weight, rgb_add(l[1]->weight, l[2]->weight)), area / 3);
    if (c->seen) put_seen(c, l, flux);
    if (!l[0]->shown || before == 0 || outside(c->view, &t)) return true;
    t.flux[0] = (float)flux.r;
    t.flux[1] = (float)flux.g;
    t.flux[2] = (float)flux.b;
    set_plane(c, l, &t);
    return put_triangle(c, &t);
}

/* ---- what is claimed ---- */

static const Claim *claimed(const Cells *c, uint64_t path) {
    for (size_t i = 0; i < c->claim_count; i++)
        if (c->claims[i].path == path) return &c->claims[i];
    return NULL;
}

static void put_claim(Cells *c, const WaveLanding *const l[3]) {
    Claim *claim = &c->claims[c->claim_count++];
    claim->path = l[0]->path;
    claim->weight = rgb_scale(rgb_add(l[0]->weight, rgb_add(l[1]->weight, l[2]->weight)), 1.0 / 3);
    for (int k = 0; k < 3; k++) claim->landing[k] = (uint32_t)(l[k] - c->landings.items);
}

static const WaveLanding *find(const Cells *c, const WaveCorner *corner, uint64_t path) {
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

/* Lands every path that the corners agree on; returns the share of the light that they do not. Where a path's
 * flux varies much over a triangle that may still be split, it waits: at a rim the transmitted light falls
 * with infinite slope, and the mean of three corners would lose some of it. */
static double claim(Cells *c, const WaveCorner *const corner[3], double area, bool may_split) {
    double left = 0, start = 0;
    for (int k = 0; k < 3; k++) start = fmax(start, rgb_max(corner[k]->weight));
    const WaveLanding *own = &c->landings.items[corner[0]->first];
    for (uint32_t i = 0; i < corner[0]->count; i++) {
        uint64_t path = own[i].path;
        if (c->claim_count == CLAIMED_MAX || claimed(c, path)) continue;
        const WaveLanding *const l[3] = {&own[i], find(c, corner[1], path), find(c, corner[2], path)};
        if (!l[1] || !l[2] || (may_split && variation(l, start) > SPLIT_VARIATION)) continue;
        if (join(c, l, area)) put_claim(c, l);
    }
    for (int k = 0; k < 3; k++) {
        const WaveLanding *l = &c->landings.items[corner[k]->first];
        for (uint32_t i = 0; i < corner[k]->count; i++)
            if (!claimed(c, l[i].path)) left += rgb_max(l[i].weight) / 3;
    }
    return start > 0 ? left / start : 0;
}

/* ---- photons for the rest ---- */

static void put_splat(Cells *c, const WaveLanding *l, double scale, double turn) {
    WaveBatch *b = c->out;
    if (!array_reserve((void **)&b->splats, &b->splat_capacity, b->splat_count + 1, sizeof *b->splats))
        b->out_of_memory = true;
    else if (wave_splat(c->run, c->view, l, scale, turn, &b->splats[b->splat_count]))
        b->splat_count++;
}

static Rgb corner_weight(const WaveCorner *const corner[3]) {
    Rgb most = corner[0]->weight;
    for (int k = 1; k < 3; k++)
        if (rgb_max(corner[k]->weight) > rgb_max(most)) most = corner[k]->weight;
    return most;
}

static void put_photon(Cells *c, const WaveLanding *l, Rgb weight, double scale, double least, Rng *rng) {
    double size = fmax(fabs(weight.r), fmax(fabs(weight.g), fabs(weight.b)));
    double chance = least > 0 ? fmin(1, size / least) : 1;
    if (!(size > 0) || rng_next(rng) >= chance) return;
    WaveLanding photon = *l;
    photon.weight = weight;
    put_splat(c, &photon, scale / chance, rng_next(rng));
    if (c->seen) put_deposit(c, &photon, scale / chance);
}

/* What a ray finds at its place in a triangle, less what the triangles have put there. In the mean that is
 * what they lack: paths that none claimed, a feature that no corner met, weight that bends between corners.
 * So a grid's energy is right however coarse it is. */
static void put_difference(Cells *c, const WaveCorner *ray, double scale, double least, Rng *rng) {
    const WaveLanding *found = &c->landings.items[ray->first];
    bool met[CLAIMED_MAX] = {false};
    for (uint32_t i = 0; i < ray->count; i++) {
        const Claim *claim = claimed(c, found[i].path);
        if (claim && met[claim - c->claims]) claim = NULL; /* triangles have the first of the same kind */
        Rgb weight = claim ? rgb_sub(found[i].weight, claim->weight) : found[i].weight;
        if (claim) met[claim - c->claims] = true;
        put_photon(c, &found[i], weight, scale, claim ? least : 0, rng);
    }
    for (size_t i = 0; i < c->claim_count; i++) {
        const Claim *claim = &c->claims[i];
        const WaveLanding *corner = &c->landings.items[claim->landing[(int)(3 * rng_next(rng))]];
        if (!met[i]) put_photon(c, corner, rgb_scale(claim->weight, -1), scale, least, rng);
    }
}

static void leave_to_photon(Cells *c, const WaveCorner *const corner[3], double area, double left) {
    Rgb start = corner_weight(corner);
    c->out->left += left * rgb_max(start) * area;
    uint64_t leaf = c->leaves++;
    if (!c->view) return;
    Rng rng = rng_make(rng_combine(c->key, leaf));
    double chance = clamp(left / PHOTON_SHARE, LOOK_CHANCE, 1);
    if (rng_next(&rng) >= chance) return;
    double a = sqrt(rng_next(&rng)), b = rng_next(&rng), w[3] = {1 - a, a * (1 - b), a * b}, u = 0, v = 0;
    for (int k = 0; k < 3; k++) {
        u += w[k] * corner[k]->u;
        v += w[k] * corner[k]->v;
    }
    size_t top = c->landings.count;
    WaveCorner ray = wave_corner(c->run, c->front, u, v, 0, &c->landings, &c->out->account);
    put_difference(c, &ray, area / chance, PHOTON_SHARE * chance * rgb_max(start), &rng);
    c->landings.count = top;
}

/* ---- triangles of the grid ---- */

static void triangle(
    Cells *c, const WaveCorner *a, const WaveCorner *b, const WaveCorner *d, double area, int splits) {
    const WaveCorner *const corner[3] = {a, b, d};
    size_t before = c->claim_count;
    bool may_split = splits < SPLITS_MAX && c->claim_count < CLAIMED_MAX;
    double left = claim(c, corner, area, may_split);
    if (left > SPLIT_SHARE && may_split) {
        size_t top = c->landings.count;
        WaveCorner m[3];
        for (int k = 0; k < 3; k++) {
            const WaveCorner *p = corner[k], *q = corner[(k + 1) % 3];
            m[k] = wave_corner(c->run, c->front, 0.5 * (p->u + q->u), 0.5 * (p->v + q->v), 0, &c->landings,
                &c->out->account);
        }
        triangle(c, a, &m[0], &m[2], area / 4, splits + 1);
        triangle(c, &m[0], b, &m[1], area / 4, splits + 1);
        triangle(c, &m[2], &m[1], d, area / 4, splits + 1);
        triangle(c, &m[0], &m[1], &m[2], area / 4, splits + 1);
        c->landings.count = top;
    } else
        leave_to_photon(c, corner, area, left);
    c->claim_count = before;
}

/* Diagonals alternate, so that the map has no grain. */
static void cell(Cells *c, const WaveCorner *row, const WaveCorner *next, int i, int j, double area) {
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
static void corner_row(Cells *c, const WaveTile *tile, const Grid *g, int j, WaveCorner *row) {
    const WaveFront *f = c->front;
    bool row_counts = j < tile->y1 || j == f->n[1];
    for (int i = tile->x0; i <= tile->x1; i++) {
        double area = g->area * corner_share(f, i, j);
        bool counted = row_counts && (i < tile->x1 || i == f->n[0]);
        WaveCorner *corner = &row[i - tile->x0];
        *corner = wave_corner(c->run, f, g->origin[0] + i * g->step[0], g->origin[1] + j * g->step[1], area,
            &c->landings, counted ? &c->out->account : NULL);
    }
}

/* The landings of a finished row go; those of the row that stays move to the front. */
static void drop_row(Cells *c, WaveCorner *row, int corners) {
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
    Cells c = {.run = run, .view = view, .seen = seen, .front = tile->front, .out = out};
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
