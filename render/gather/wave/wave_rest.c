/* SPDX-License-Identifier: Apache-2.0 */
/* What triangles of light do not tell: a ray at a random place of a triangle brings what lands there, less
 * what the triangles have put there. In the mean that is all that they lack: paths that none claimed, a
 * feature that no corner met, light that bends or fades between the corners, gaps of the receiver. So a
 * coarse grid has a fine grid's light, and its picture too, but for noise that replicas show. */
#include "render/gather/wave/wave_internal.h"

#include "core/checked.h"
#include "core/rng.h"

#include <string.h>

/* What is left over becomes one photon for certain above this share, below it with less probability. */
#define PHOTON_SHARE 0.05
/* A ray looks for what their corners do not tell in this share of the triangles at least, and in more where
 * looks found much lately: in all where the mean square of what they found, relative to a triangle's light,
 * is LOOK_SURE. On a noisy surface nearly every triangle is wrong, and one ray for sixteen of them was most
 * of the noise; on smooth ones more looks only take time. The mean is over some LOOK_MEMORY looks. What comes
 * is not asked for the chance, so the sum stays right in the mean. */
#define LOOK_CHANCE (1.0 / 16)
#define LOOK_SURE 0.5
#define LOOK_MEMORY 32.0
/* A probe draws nothing: it looks into this share of the triangles, to measure. */
#define PROBE_CHANCE 0.25
/* Where corners disagree an edge cuts the light, and most of what is there may be such rays': no estimate
 * knows how far they blur it, so their kernels are so much narrower. (With 1 a gem had .038 of error and
 * stated .011; so .012 and .010. What only moves light on a noisy surface would be half as noisy again by
 * it.) */
#define RADIUS_LEFT 0.5
/* Light that is moved by less than this part of a pixel, or of the landed triangle, stays where it is: that a
 * triangle is flat and evenly lit costs less than the noise of mending it. */
#define SAME_PLACE 0.1
#define SAME_TRIANGLE 0.25

/* How a ray's difference is weighted: `scale` by what the ray stands for; weights under `least` are put with
 * less probability and more weight. `put`: the sum of the squares of the weights that were put. */
typedef struct Share {
    double scale, least, radius_pixels;
    Rng *rng;
    double put;
} Share;

const WaveClaim *wave_claimed(const WaveCells *c, uint64_t path) {
    for (size_t i = 0; i < c->claim_count; i++)
        if (c->claims[i].path == path) return &c->claims[i];
    return NULL;
}

/* ---- photons ---- */

void wave_put_deposit(WaveCells *c, const WaveLanding *l, Rgb flux) {
    WaveBatch *b = c->out;
    if (!array_reserve(
            (void **)&b->deposits, &b->deposit_capacity, b->deposit_count + 1, sizeof *b->deposits)) {
        b->out_of_memory = true;
        return;
    }
    Deposit *d = &b->deposits[b->deposit_count++];
    *d = (Deposit){.position = {(float)l->position.x, (float)l->position.y, (float)l->position.z},
        .flux = {(float)flux.r, (float)flux.g, (float)flux.b},
        .glossy = l->glossy,
        .transmission = l->transmission,
        .audience = AUDIENCE_SEEN};
    normal_encode(l->normal, d->normal);
}

static void put_splat(WaveCells *c, const WaveLanding *l, Rgb flux, double radius_pixels, double turn) {
    WaveBatch *b = c->out;
    if (!array_reserve((void **)&b->splats, &b->splat_capacity, b->splat_count + 1, sizeof *b->splats))
        b->out_of_memory = true;
    else if (wave_splat(c->run, c->view, l, flux, radius_pixels, turn, &b->splats[b->splat_count]))
        b->splat_count++;
}

/* The weight's factor, 0 when the photon is left out. */
static double survives(Share *share, Rgb weight) {
    double size = fmax(fabs(weight.r), fmax(fabs(weight.g), fabs(weight.b)));
    double chance = share->least > 0 ? fmin(1, size / share->least) : 1;
    if (!(size > 0) || rng_next(share->rng) >= chance) return 0;
    share->put += square(size / chance);
    return share->scale / chance;
}

/* On what the camera sees directly; `sure`: it does see the place. A probe only adds up. */
static void put_shown(WaveCells *c, const WaveLanding *l, Rgb weight, Share *share, bool sure) {
    if (!c->view) survives(share, weight);
    if (!c->view) return;
    double scale = l->shown ? survives(share, weight) : 0;
    if (scale > 0 && (sure || wave_view_sees(c->view, c->run->trace, l)))
        put_splat(c, l, rgb_scale(weight, scale), share->radius_pixels, rng_next(share->rng));
}

/* On what it sees through glass and in mirrors. */
static void put_seen(WaveCells *c, const WaveLanding *l, Rgb weight, Share *share) {
    double scale = survives(share, weight);
    if (scale > 0) wave_put_deposit(c, l, rgb_scale(weight, scale));
}

/* ---- what a claimed triangle has put at a ray's place ---- */

typedef struct Drawn {
    WaveLanding at;
    bool shown, seen; /* on what the camera sees directly; on what it sees through glass and in mirrors */
    double extent;    /* the landed triangle's */
} Drawn;

/* A surface of the receiver near enough under the triangle; `at` is moved onto it. */
static bool receiver_under(const WaveCells *c, WaveLanding *at, double reach) {
    double left = 2 * reach;
    Ray ray = ray_from_point(v3_mad(at->position, reach, at->normal), v3_neg(at->normal), 0, left, 31u);
    Hit hit;
    while (trace_nearest(c->run->trace, &ray, &hit)) {
        double facing = v3_dot(hit.ng, at->normal);
        bool same = wave_same_receiver(wave_receiver(c->run->scene, hit.object), at->receiver);
        if (same && fabs(facing) >= WAVE_FACING_COSINE) {
            at->position = hit.position;
            at->normal = facing < 0 ? v3_neg(hit.ng) : hit.ng;
            at->object = hit.object;
            at->primitive = hit.primitive;
            return true;
        }
        left -= hit.t;
        if (!(hit.material->lobes & (LOBE_CASTING | LOBE_TRANSPARENT)) || !(left > 0)) return false;
        ray = ray_from_hit(&hit, ray.dir, left, 31u);
    }
    return false;
}

/* Barycentric coordinates of (u, v) in the claim's triangle of the front. */
static void weights_at(const WaveClaim *claim, double u, double v, double w[3]) {
    const WaveCorner *const *k = claim->corner;
    double au = k[1]->u - k[0]->u, av = k[1]->v - k[0]->v, bu = k[2]->u - k[0]->u, bv = k[2]->v - k[0]->v;
    double du = u - k[0]->u, dv = v - k[0]->v, turn = au * bv - av * bu;
    w[1] = (du * bv - dv * bu) / turn;
    w[2] = (au * dv - av * du) / turn;
    w[0] = 1 - w[1] - w[2];
}

static Drawn drawn_at(const WaveCells *c, const WaveClaim *claim, double u, double v) {
    const WaveLanding *l[3];
    double w[3], x, y;
    weights_at(claim, u, v, w);
    for (int i = 0; i < 3; i++) l[i] = &c->landings.items[claim->landing[i]];
    Drawn d = {.at = *l[0]};
    d.at.position = d.at.normal = v3(0, 0, 0);
    for (int i = 0; i < 3; i++) {
        d.at.position = v3_mad(d.at.position, w[i], l[i]->position);
        d.at.normal = v3_mad(d.at.normal, w[i], l[i]->normal);
        d.extent = fmax(d.extent, v3_length(v3_sub(l[i]->position, l[(i + 1) % 3]->position)));
    }
    d.at.normal = v3_normalize(d.at.normal);
    d.shown = true;
    if (!c->view) return d;
    WaveTriangle t = {.receiver = d.at.receiver};
    WavePlane plane;
    wave_plane(c->run->scene, (const WaveLanding *const *)l, &plane);
    wave_set_plane((const WaveLanding *const *)l, &plane, &t);
    d.shown = d.at.shown && wave_project(c->view, d.at.position, &x, &y) &&
              wave_shows(c->run->trace, c->view, &t, x, y, &d.at.object);
    d.at.position =
        v3_mad(d.at.position, v3_dot(v3_sub(plane.center, d.at.position), plane.normal), plane.normal);
    if (c->seen) d.seen = receiver_under(c, &d.at, plane.reach);
    return d;
}

/* Along the receiver: that a flat triangle hangs over it moves no light. It lights no sides of what stands
 * there. */
static bool same_place(const WaveCells *c, const Drawn *d, const WaveLanding *found) {
    if (v3_dot(found->normal, d->at.normal) < WAVE_FACING_COSINE) return false;
    CameraView view;
    double pixel = d->extent;
    if (camera_project(&c->run->scene->camera, found->position, &view))
        pixel = 1 / sqrt(view.raster_per_area);
    V3 off = v3_sub(found->position, d->at.position);
    off = v3_mad(off, -v3_dot(off, d->at.normal), d->at.normal);
    return v3_length(off) <= fmax(SAME_PLACE * pixel, SAME_TRIANGLE * d->extent);
}

/* ---- the difference ---- */

/* A path that the ray found and a triangle has claimed. */
static void put_moved(
    WaveCells *c, const WaveLanding *found, const WaveClaim *claim, const WaveCorner *ray, Share *share) {
    Drawn d = drawn_at(c, claim, ray->u, ray->v);
    bool same = same_place(c, &d, found);
    Rgb minus = rgb_scale(claim->weight, -1), rest = rgb_add(found->weight, minus);
    put_shown(c, found, same && d.shown ? rest : found->weight, share, same && d.shown);
    if (!same && d.shown) put_shown(c, &d.at, minus, share, true);
    if (!c->seen) return;
    put_seen(c, found, same && d.seen ? rest : found->weight, share);
    if (!same && d.seen) put_seen(c, &d.at, minus, share);
}

static void put_difference(WaveCells *c, const WaveCorner *ray, Share *share) {
    const WaveLanding *found = &c->landings.items[ray->first];
    bool met[WAVE_CLAIMED_MAX] = {false};
    for (uint32_t i = 0; i < ray->count; i++) {
        const WaveClaim *claim = wave_claimed(c, found[i].path);
        if (claim && !met[claim - c->claims]) { /* triangles have the first of the same kind */
            met[claim - c->claims] = true;
            put_moved(c, &found[i], claim, ray, share);
            continue;
        }
        put_shown(c, &found[i], found[i].weight, share, false);
        if (c->seen) put_seen(c, &found[i], found[i].weight, share);
    }
    for (size_t i = 0; i < c->claim_count; i++) {
        if (met[i]) continue;
        Drawn d = drawn_at(c, &c->claims[i], ray->u, ray->v);
        Rgb minus = rgb_scale(c->claims[i].weight, -1);
        if (d.shown) put_shown(c, &d.at, minus, share, true);
        if (d.seen) put_seen(c, &d.at, minus, share);
    }
}

static Rgb corner_weight(const WaveCorner *const corner[3]) {
    Rgb most = corner[0]->weight;
    for (int k = 1; k < 3; k++)
        if (rgb_max(corner[k]->weight) > rgb_max(most)) most = corner[k]->weight;
    return most;
}

/* A ray at a random place of the triangle. */
static WaveCorner look(WaveCells *c, const WaveCorner *const corner[3], Rng *rng) {
    double a = sqrt(rng_next(rng)), b = rng_next(rng), w[3] = {1 - a, a * (1 - b), a * b}, u = 0, v = 0;
    for (int k = 0; k < 3; k++) {
        u += w[k] * corner[k]->u;
        v += w[k] * corner[k]->v;
    }
    return wave_corner(c->run, c->front, u, v, 0, &c->landings, c->view ? &c->out->account : NULL);
}

static void measure(WaveBatch *b, double flux, double found) {
    b->looked++;
    b->looked_flux += flux;
    b->found += found;
}

void wave_leave(WaveCells *c, const WaveCorner *const corner[3], double area, double left) {
    Rgb start = corner_weight(corner);
    c->out->left += left * rgb_max(start) * area;
    Rng rng = rng_make(rng_combine(c->key, c->leaves++));
    double often = clamp(c->found / LOOK_SURE, LOOK_CHANCE, 1), rest = left / PHOTON_SHARE;
    double chance = fmin(fmax(often, rest), 1);
    if (rng_next(&rng) >= (c->view ? chance : PROBE_CHANCE)) return;
    size_t top = c->landings.count;
    WaveCorner ray = look(c, corner, &rng);
    double whole = fmax(rgb_max(start), rgb_max(ray.weight)); /* the corners may have missed the caster */
    Share share = {.scale = area / chance,
        .least = c->view ? PHOTON_SHARE * chance * rgb_max(start) : 0,
        .radius_pixels = c->run->radius_pixels * (rest > often ? RADIUS_LEFT : 1),
        .rng = &rng};
    put_difference(c, &ray, &share);
    if (!c->view)
        measure(c->out, area * whole, square(area) * share.put / chance);
    else if (rest <= often && whole > 0)
        c->found += (share.put / square(whole) - c->found) / LOOK_MEMORY;
    c->landings.count = top;
}
