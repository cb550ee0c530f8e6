/* SPDX-License-Identifier: Apache-2.0 */
#include "render/trace/bent.h"

#include "core/checked.h"
#include "core/rng.h"
#include "core/sampling.h"

enum { BENT_DEPTH_MAX = 256, BENT_ROULETTE_DEPTH = 6 };

#define BENT_ROULETTE_THROUGHPUT 0.2

/* Share of the starts at which a guide, where there is one, says where to look. */
#define GUIDED_SHARE 0.5

/* An object below this share is left out. */
#define BENT_SHARE_MIN 1e-3

/* ---- which triangles ---- */

static V3 corner(const Mesh *m, size_t triangle, int k) {
    const double *p = &m->positions[3 * (size_t)m->triangles[3 * triangle + (size_t)k]];
    return v3(p[0], p[1], p[2]);
}

/* The share of evenly leaving light that bends, (1 - cos a) / 2 as in bent_direction(), at the corners. */
static double triangle_share(const Mesh *m, size_t triangle, V3 ng) {
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        const float *n = &m->normals[9 * triangle + 3 * (size_t)k];
        V3 ns = v3_normalize(v3((double)n[0], (double)n[1], (double)n[2]));
        double cosine = v3_dot(ns, ng);
        if (!(cosine > 0)) cosine = 1; /* as triangle_hit() does */
        sum += 0.5 * (1 - cos(bend_elevation(acos(fmin(cosine, 1)), 1)));
    }
    return sum / 3;
}

static double triangle_area(const Mesh *m, size_t t, V3 *ng) {
    V3 a = corner(m, t, 0), n = v3_cross(v3_sub(corner(m, t, 1), a), v3_sub(corner(m, t, 2), a));
    double length = v3_length(n);
    *ng = length > 0 ? v3_scale(n, 1 / length) : n;
    return 0.5 * length;
}

/* The share of an object's evenly leaving light that bends. With `out`, its triangles are added as mirrors.
 */
static double object_share(const Scene *scene, size_t object, BentSet *out) {
    const Mesh *m = &scene->objects[object].mesh;
    double area = 0, bent = 0;
    for (size_t t = 0; t < m->triangle_count; t++) {
        V3 ng;
        double a = triangle_area(m, t, &ng), share = a > 0 ? triangle_share(m, t, ng) : 0;
        area += a;
        bent += a * share;
        if (!out || !(share > 0)) continue;
        double before = out->mirror_count ? out->mirrors[out->mirror_count - 1].last : 0;
        out->mirrors[out->mirror_count++] = (BentTriangle){
            .object = (int)object, .primitive = (uint32_t)t, .area = a, .last = before + a * share};
    }
    return area > 0 ? bent / area : 0;
}

/* What straight light tells: the index by what is refracted, the lobe's width by its density, D / 4 = 1 / (4
 * pi alpha^2) times what is reflected. */
static struct BentObject bending_object(const Material *m) {
    struct BentObject out = {.bends = true};
    ShadingFrame f = {v3(0, 0, 1), v3(0, 0, 1), true};
    ScatterSample s;
    double u[3] = {0.5, 0.5, 1 - 0x1p-53}, pdf, reflected = 1;
    if (m->kind->sample(m, &f, f.ng, u, LOBE_CASTING, false, &s) && s.transmit && s.eta != 1) {
        out.eta = s.eta;
        reflected = square((s.eta - 1) / (s.eta + 1));
    }
    if (!(m->lobes & LOBE_GLOSSY)) return out;
    m->kind->eval(m, &f, f.ng, f.ng, LOBE_GLOSSY, &pdf);
    out.alpha = pdf > 0 ? fmin(1, sqrt(reflected / (4 * CAU_PI * pdf))) : 1;
    return out;
}

static cau_result add_mirrors(BentSet *out, const Scene *scene, CauError *err) {
    size_t triangles = 0;
    for (size_t i = 0; i < scene->object_count; i++)
        if (out->objects[i].bends && out->objects[i].alpha == 0)
            triangles += scene->objects[i].mesh.triangle_count;
    if (triangles == 0) return CAU_OK;
    out->mirrors = array_new(triangles, sizeof *out->mirrors);
    if (!out->mirrors)
        return error_set(
            err, CAU_ERROR_RESOURCE, "out of memory for the normals of %zu triangles", triangles);
    for (size_t i = 0; i < scene->object_count; i++)
        if (out->objects[i].bends && out->objects[i].alpha == 0) object_share(scene, i, out);
    return CAU_OK;
}

cau_result bent_create(BentSet *out, const Scene *scene, CauError *err) {
    *out = (BentSet){0};
    for (size_t i = 0; i < scene->object_count; i++) {
        const Object *o = &scene->objects[i];
        const Material *m = &scene->materials[o->material];
        out->rough |= o->casts && (m->lobes & LOBE_GLOSSY);
        if (!o->casts || o->exact || !o->mesh.normals || !(m->lobes & LOBE_CASTING)) continue;
        if (!(object_share(scene, i, NULL) > BENT_SHARE_MIN)) continue;
        if (!out->objects && !(out->objects = array_new(scene->object_count, sizeof *out->objects)))
            return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu objects", scene->object_count);
        out->objects[i] = bending_object(m);
    }
    return out->objects ? add_mirrors(out, scene, err) : CAU_OK;
}

void bent_free(BentSet *set) {
    free(set->mirrors);
    free(set->objects);
    *set = (BentSet){0};
}

/* ---- the vertex ---- */

static const BentTriangle *choose_triangle(const BentSet *set, double u) {
    const BentTriangle *t = set->mirrors;
    double total = t[set->mirror_count - 1].last, at = u * total;
    size_t low = 0, high = set->mirror_count - 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (at < t[middle].last)
            high = middle;
        else
            low = middle + 1;
    }
    return &t[low];
}

/* A direction that bends the normal, evenly in the projected solid angle.
 * Over the disk of directions seen along ng, with x towards the normal, they are those with x below -r cos a,
 * where r = sqrt(1 - y^2) and a = bend_elevation(): a strip as wide as (1 - cos a) / 2 of the disk's chord at
 * y. */
bool bent_direction(V3 ng, V3 ns, double u, double v, V3 *dir) {
    double cosine = v3_dot(ns, ng), x, y;
    V3 side = v3_mad(ns, -cosine, ng);
    double sine = v3_length(side);
    if (!(sine > 1e-9)) return false;
    side = v3_scale(side, 1 / sine);
    sample_disk(u, v, &x, &y);
    double r = sqrt(fmax(0, 1 - y * y)), strip = 0.5 * (1 - cos(bend_elevation(atan2(sine, cosine), r)));
    x = -r + (x + r) * strip;
    V3 local = v3(x, y, sqrt(fmax(0, 1 - x * x - y * y)));
    *dir = v3_normalize(v3_from_frame(local, side, v3_cross(ng, side), ng));
    return strip > 0;
}

double bent_direction_pdf(V3 ng, V3 ns, V3 dir) {
    double cosine = v3_dot(ns, ng), z = v3_dot(dir, ng);
    V3 side = v3_mad(ns, -cosine, ng);
    double sine = v3_length(side);
    if (!(sine > 1e-9) || !(z > 0) || !normal_bends(ng, ns, dir)) return 0;
    double y = v3_dot(dir, v3_cross(ng, side)) / sine, r = sqrt(fmax(0, 1 - y * y));
    return z / (CAU_PI * 0.5 * (1 - cos(bend_elevation(atan2(sine, cosine), r))));
}

/* ---- back to the light ---- */

typedef struct BentWalk {
    const BentRun *run;
    BentStart *out;
    PathNumbers numbers;
    Ray ray;
    V3 from;          /* where it was scattered last: lights are seen from there */
    double travelled; /* from there to the start of the ray (straight through transparents) */
    double density;   /* with which the ray's direction was drawn; 0: specular */
    Rgb throughput;
    bool start;        /* at the vertex itself, which reflects: what it refracts is bent_turn()'s */
    Chain chain, last; /* all scatterings as from the eye; the last one alone */
    double found;      /* sum of the brightness of all the light found */
    uint64_t *rays;
} BentWalk;

/* Of all light found on the way one is kept, with the chance of its brightness, for all. */
static void found_light(BentWalk *w, Rgb value, const Chain *chain, const Chain *last) {
    double brightness = rgb_max(value);
    if (!rgb_finite(value) || !(brightness > 0)) return;
    w->found += brightness;
    if (rng_next(&w->numbers.rng) * w->found >= brightness) return;
    w->out->flux = rgb_scale(value, 1 / brightness);
    w->out->chain = *chain;
    w->out->chain.cast = true;
    w->out->first = *last;
}

static void meet_light(BentWalk *w, double t_hit) {
    const Light *l = w->run->light;
    LightSample s;
    if (l->delta || !l->kind->hit || !l->kind->hit(l, w->from, w->ray.dir, &s)) return;
    if (isfinite(t_hit) && s.distance >= w->travelled + t_hit) return;
    double weight = w->density > 0 ? w->density / (w->density + s.pdf) : 1;
    found_light(w, rgb_scale(rgb_mul(w->throughput, s.value), weight), &w->chain, &w->last);
}

static void connect(BentWalk *w, const Hit *hit, const ShadingFrame *f, V3 wi, unsigned lobe, double choice) {
    const Light *l = w->run->light;
    LightSample s;
    double u = rng_next(&w->numbers.rng), v = rng_next(&w->numbers.rng), pdf = 0;
    if (!l->kind->sample(l, hit->position, u, v, &s) || !(s.pdf > 0)) return;
    Rgb scatter = hit->material->kind->eval(hit->material, f, wi, s.dir, lobe, &pdf);
    if (rgb_black(scatter)) return;
    Ray ray = ray_from_hit(hit, s.dir, s.distance * (1 - 1e-9), VISIBLE_SHADOW);
    ++*w->rays;
    Rgb through = trace_transmittance(w->run->trace, &ray);
    if (rgb_black(through)) return;
    double weight = l->delta || !l->kind->hit ? 1 : s.pdf / (s.pdf + choice * pdf);
    Chain chain = w->chain, last = {0};
    bool transmit = v3_dot(s.dir, f->ng) < 0;
    chain_add_from_eye(&chain, lobe, transmit);
    chain_add_from_eye(&last, lobe, transmit);
    Rgb value = rgb_mul(rgb_mul(w->throughput, scatter), rgb_mul(s.value, through));
    found_light(w, rgb_scale(value, weight / s.pdf), &chain, &last);
}

static bool go_back(
    BentWalk *w, const Hit *hit, const ShadingFrame *f, V3 wi, unsigned lobes, double choice) {
    double u[3];
    for (int k = 2; k >= 0; k--) u[k] = path_number(&w->numbers);
    path_numbers_next(&w->numbers);
    ScatterSample s;
    if (!lobes || !hit->material->kind->sample(hit->material, f, wi, u, lobes, false, &s)) return false;
    if (w->start && s.transmit) return false;
    w->throughput = rgb_scale(rgb_mul(w->throughput, s.weight), 1 / choice);
    if (!rgb_finite(w->throughput) || rgb_black(w->throughput)) return false;
    if (s.lobe == LOBE_TRANSPARENT) {
        w->travelled += hit->t;
        w->ray = ray_from_hit(hit, s.wo, INFINITY, w->ray.visibility);
        return true;
    }
    if (w->run->physical) w->throughput = rgb_scale(w->throughput, 1 / square(s.eta));
    chain_add_from_eye(&w->chain, s.lobe, s.transmit);
    w->last = (Chain){0};
    chain_add_from_eye(&w->last, s.lobe, s.transmit);
    w->from = hit->position;
    w->travelled = 0;
    w->density = s.lobe == LOBE_SPECULAR ? 0 : choice * s.pdf;
    w->ray = ray_from_hit(hit, s.wo, INFINITY, visibility_after(s.lobe, s.transmit));
    return true;
}

/* One surface, seen from wi, through `lobes`. False: the way ends. */
static bool back_surface(BentWalk *w, const Hit *hit, V3 wi, unsigned lobes) {
    ShadingFrame f = frame_from_hit(hit, wi);
    if (!w->run->scene->objects[hit->object].casts) lobes &= ~(unsigned)LOBE_CASTING;
    if (!w->run->diffuse) lobes &= ~(unsigned)LOBE_DIFFUSE;
    unsigned casting = lobes & (LOBE_CASTING | LOBE_TRANSPARENT), diffuse = lobes & LOBE_DIFFUSE;
    double choice = casting && diffuse ? 0.5 : 1;
    if (diffuse) connect(w, hit, &f, wi, LOBE_DIFFUSE, choice);
    if (lobes & LOBE_GLOSSY) connect(w, hit, &f, wi, LOBE_GLOSSY, choice);
    if (casting && diffuse) lobes = rng_next(&w->numbers.rng) < 0.5 ? casting : diffuse;
    return go_back(w, hit, &f, wi, lobes, choice);
}

static bool back_roulette(BentWalk *w, int depth) {
    double keep = rgb_max(w->throughput) / BENT_ROULETTE_THROUGHPUT;
    if (depth < BENT_ROULETTE_DEPTH || keep >= 1) return true;
    if (rng_next(&w->numbers.rng) >= keep) return false;
    w->throughput = rgb_scale(w->throughput, 1 / keep);
    return true;
}

static void walk_back(BentWalk *w) {
    const Scene *scene = w->run->scene;
    w->start = true;
    if (!back_surface(w, &w->out->hit, w->out->dir, w->out->hit.material->lobes & LOBE_CASTING)) return;
    w->start = false;
    for (int depth = 1; depth < BENT_DEPTH_MAX; depth++) {
        Hit hit;
        ++*w->rays;
        bool found = trace_nearest(w->run->trace, &w->ray, &hit);
        meet_light(w, found ? hit.t : INFINITY);
        if (!found ||
            !bounces_allow(&scene->bounces, w->chain.diffuse, w->chain.glossy, w->chain.transmission))
            return;
        if (!back_surface(w, &hit, v3_neg(w->ray.dir), hit.material->lobes) || !back_roulette(w, depth))
            return;
    }
}

/* A face and a direction that it is seen from. */
typedef struct Seen {
    const BentTriangle *triangle;
    bool back;
    double probability; /* of the triangle, where looked for evenly */
    V3 ng, ns, dir;     /* normals on the side that is seen */
} Seen;

static void place_on(Seen *s, const BentRun *run, double u, double v, Hit *hit) {
    double root = sqrt(u);
    const BentTriangle *t = s->triangle;
    trace_triangle_point(run->trace, t->object, t->primitive, root * (1 - v), root * v, hit);
    s->ng = s->back ? v3_neg(hit->ng) : hit->ng;
    s->ns = s->back ? v3_neg(hit->ns) : hit->ns;
}

/* Density per area and steradian with which `s` is drawn, by both ways together (balance heuristic with one
 * sample, Veach and Guibas 1995). */
static double seen_pdf(const Seen *s, const BentRun *run, const Hit *hit, double guided) {
    double even = 0.5 * s->probability / s->triangle->area * bent_direction_pdf(s->ng, s->ns, s->dir);
    if (!(even > 0) || guided == 0) return even;
    uint64_t face = 2 * (uint64_t)(s->triangle - run->set->mirrors) + s->back;
    ShadingFrame f = frame_from_hit(hit, s->dir);
    return (1 - guided) * even +
           guided * bent_guide_pdf(run->guide, face, s->triangle->area, s->ng, s->ns, f.ns, s->dir);
}

static double probability_of(const BentSet *set, const BentTriangle *t) {
    return (t->last - (t > set->mirrors ? t[-1].last : 0)) / set->mirrors[set->mirror_count - 1].last;
}

bool bent_start(const BentRun *run, uint32_t index, BentStart *out, uint64_t *rays) {
    uint64_t key = rng_combine(run->key, 0x62656e74u);
    double p[SOBOL_DIMENSIONS], choice[SOBOL_DIMENSIONS];
    sobol_owen_point(index, key, p);
    sobol_owen_point(index, run->key, choice);
    double guided = run->guide && run->guide->count ? GUIDED_SHARE : 0;
    const BentSeed *seed = NULL;
    if (choice[2] < guided) seed = &run->guide->seeds[(size_t)(choice[0] * (double)run->guide->count)];
    Seen s = {.triangle = seed ? &run->set->mirrors[seed->face / 2] : choose_triangle(run->set, choice[0]),
        .back = seed ? seed->face % 2 : choice[1] < 0.5};
    s.probability = probability_of(run->set, s.triangle);
    place_on(&s, run, p[0], p[1], &out->hit);
    bool drawn = seed ? bent_guide_direction(seed, s.ng, s.ns, p[2], p[3], &s.dir)
                      : bent_direction(s.ng, s.ns, p[2], p[3], &s.dir);
    double pdf = drawn ? seen_pdf(&s, run, &out->hit, guided) : 0;
    if (!(pdf > 0)) return false;
    out->dir = s.dir;
    BentWalk w = {.run = run,
        .out = out,
        .numbers = path_numbers(rng_combine(key, 1), index),
        .throughput = rgb_grey(1),
        .rays = rays};
    walk_back(&w);
    out->flux = rgb_scale(out->flux, w.found * v3_dot(s.dir, s.ng) / pdf);
    return w.found > 0;
}
