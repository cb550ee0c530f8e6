/* SPDX-License-Identifier: Apache-2.0 */
/* One ray of a wavefront along every smooth path: reflected and refracted at each interface. */
#include "render/gather/wave/wave_internal.h"

#include "core/checked.h"
#include "core/rng.h"

/* What a partial reflection sends on is followed for certain while it is this share of the light at the
 * start; below, with probability in proportion (Russian roulette: Arvo and Kirk 1990), and then weighs as
 * much as that share. A body of many interfaces would have thousands of paths, and a probability by the
 * number of reflections would all but never find light that goes round at grazing angles, where each
 * reflection loses little. */
#define REFLECT_SHARE 0.03
/* The chance is a wave over the front, with so many cells from crest to crest, that each replica and path
 * shifts and turns anew: neighbouring rays agree but at its borders, and every replica has each path in part,
 * not the whole of it now and then. */
#define REFLECT_PERIOD 48.0
enum { STACK = 64 };

/* Below this share of the light at the start a path is dropped, and counted. */
#define SHARE_MIN 1e-7

/* Normals of flat facets are told apart to this many steps per unit. */
#define FACET_STEPS 4096.0

typedef struct Branch {
    Ray ray;
    Rgb flux;
    double correction, eta;
    Chain chain, first;
    uint64_t path;
    unsigned left_visible;
    int depth;
    bool met; /* the caster */
} Branch;

typedef struct Walk {
    const WaveRun *run;
    const WaveFront *front;
    WaveLandings *landings;
    FluxAccount *account;     /* NULL: not counted */
    double u, v, area, start; /* start: largest channel of the light's weight */
    Branch stack[STACK];
    int count;
    double passed; /* light_first()'s */
    bool any;      /* the caster was met */
} Walk;

static void tally(Walk *w, size_t offset, Rgb flux) {
    if (!w->account) return;
    Rgb *sum = (Rgb *)(void *)((char *)w->account + offset);
    *sum = rgb_add(*sum, rgb_scale(flux, w->area));
}
#define TALLY(w, field, flux) tally(w, offsetof(FluxAccount, field), flux)

static uint64_t mix(uint64_t path, uint64_t value) { return rng_combine(path, value); }

/* Facets that lie in one plane are one. */
static uint64_t facet_of(const Hit *hit, bool front) {
    uint64_t id = (uint64_t)(uint32_t)hit->object * 2 + front;
    uint64_t x = (uint64_t)(int64_t)lrint(hit->ng.x * FACET_STEPS),
             y = (uint64_t)(int64_t)lrint(hit->ng.y * FACET_STEPS),
             z = (uint64_t)(int64_t)lrint(hit->ng.z * FACET_STEPS);
    return mix(id, x * 0x1fffu * 0x1fffu + y * 0x1fffu + z);
}

/* What tells surfaces apart: the object and the side; on flat facets the normal too, for each is a map of its
 * own. */
static uint64_t surface_of(const Hit *hit, bool front, const Object *o) {
    bool flat = !o->exact && (!o->mesh.normals || v3_dot(hit->ns, hit->ng) > 1 - 1e-12);
    return flat ? facet_of(hit, front) : (uint64_t)(uint32_t)hit->object * 2 + front;
}

static uint8_t byte_count(unsigned n) { return (uint8_t)(n < 255 ? n : 255); }

/* ---- landing ---- */

static void land(Walk *w, const Branch *b, const Hit *hit, const ShadingFrame *frame, V3 wi) {
    double ns = v3_dot(wi, frame->ns), ng = v3_dot(wi, frame->ng);
    if (ns <= 0 || ng <= 0) return;
    double factor = b->correction * ns / ng * material_received(hit->material, frame, wi);
    if (!w->run->physical) factor /= square(b->eta);
    Rgb weight = rgb_scale(b->flux, factor);
    if (!rgb_finite(weight) || rgb_black(weight) || !v3_finite(hit->position)) {
        if (w->account && !rgb_black(weight)) w->account->non_finite++;
        return;
    }
    WaveLandings *l = w->landings;
    if (!array_reserve((void **)&l->items, &l->capacity, l->count + 1, sizeof *l->items)) {
        l->out_of_memory = true;
        return;
    }
    unsigned glossy = b->chain.glossy - b->first.glossy,
             transmission = b->chain.transmission - b->first.transmission;
    int receiver = wave_receiver(w->run->scene, hit->object);
    l->items[l->count++] = (WaveLanding){.path = mix(b->path, (uint64_t)(receiver & 1 ? 1 : receiver)),
        .position = hit->position,
        .normal = frame->ng,
        .weight = weight,
        .object = hit->object,
        .receiver = receiver,
        .primitive = hit->primitive,
        .glossy = byte_count(glossy),
        .transmission = byte_count(transmission),
        .shown = bounces_allow(&w->run->scene->bounces, 1, glossy, transmission)};
}

/* True when light of this branch that reaches a receiver here is a direct caustic. */
static bool receives(const Branch *b, const Object *o, const Material *m) {
    return b->chain.cast && o->receives && (m->lobes & LOBE_DIFFUSE) && (b->left_visible & VISIBLE_DIFFUSE);
}

/* ---- going on ---- */

/* Uniform in [0, 1) over replicas, and over the front in each; see REFLECT_PERIOD. */
static double chance_of(const Walk *w, uint64_t path) {
    const WaveFront *f = w->front;
    uint64_t key = rng_combine(rng_combine(w->run->key, w->run->pass), path);
    double turn = 2 * CAU_PI * rng_unit(rng_combine(key, 1));
    double x = (w->u - f->lo[0]) / (f->hi[0] - f->lo[0]) * f->n[0],
           y = (w->v - f->lo[1]) / (f->hi[1] - f->lo[1]) * f->n[1];
    double phase = rng_unit(key) + (x * cos(turn) + y * sin(turn)) / REFLECT_PERIOD;
    return phase - floor(phase);
}

/* How a branch leaves a surface. */
typedef struct Way {
    ScatterSample sample;
    double share; /* of the light */
    bool partial; /* a reflection that leaves light to refraction */
    bool bent;    /* by a bent normal: its weight holds all corrections, and each facet is a map of its own */
} Way;

static uint64_t path_after(const Branch *b, const Hit *hit, bool front, const Object *o, const Way *way) {
    uint64_t at = way->bent ? facet_of(hit, front) : surface_of(hit, front, o);
    return mix(mix(b->path, at), way->bent ? 3 : (way->sample.transmit ? 2 : 1));
}

static void push(Walk *w, Branch *b, const Hit *hit, const ShadingFrame *frame, V3 wi, const Way *way) {
    const ScatterSample *s = &way->sample;
    unsigned seen_by = b->ray.visibility;
    Branch next = *b;
    next.flux = rgb_scale(rgb_mul(b->flux, s->weight), way->share);
    if (s->lobe != LOBE_TRANSPARENT) {
        const Object *o = &w->run->scene->objects[hit->object];
        seen_by = VISIBLE_DIFFUSE | VISIBLE_GLOSSY | VISIBLE_TRANSMISSION;
        if (!way->bent) next.correction *= shading_adjoint(frame, wi, s->wo);
        next.eta *= s->eta;
        next.met = true;
        bool is_first = b->chain.glossy + b->chain.transmission == 0;
        chain_add_from_light(&next.chain, s->lobe, s->transmit);
        if (is_first) next.first = next.chain;
        next.left_visible = o->visibility;
        next.path = path_after(b, hit, frame->front, o, way);
        next.depth++;
        if (!bounces_allow(&w->run->scene->bounces, 0, next.chain.glossy - next.first.glossy,
                next.chain.transmission - next.first.transmission)) {
            TALLY(w, cut, next.flux);
            return;
        }
    }
    double keep = way->partial ? fmin(1, rgb_max(next.flux) / (REFLECT_SHARE * w->start)) : 1;
    if (next.depth > PHOTONS_WAVE_DEPTH) { /* estimator P's, in its account */
        TALLY(w, emitted, rgb_scale(next.flux, -1));
        return;
    }
    bool lost = rgb_max(next.flux) < SHARE_MIN * w->start || w->count == STACK;
    if (lost || (keep < 1 && chance_of(w, next.path) >= keep)) {
        TALLY(w, dropped, next.flux);
        return;
    }
    if (keep < 1) {
        Rgb grown = rgb_scale(next.flux, 1 / keep);
        TALLY(w, dropped, rgb_sub(next.flux, grown));
        next.flux = grown;
    }
    next.ray = ray_from_hit(hit, s->wo, INFINITY, seen_by);
    w->stack[w->count++] = next;
}

/* Light is scattered by a normal that the eye may see bent. What a lamp without extent sends is found by no
 * eye path, and not bent (photons.c). */
static bool may_bend(const Walk *w, const Hit *hit) {
    const BentSet *bent = w->run->bent;
    return bent && bent->objects[hit->object].bends && !w->run->light->delta;
}

/* What leaves by the normal as it is but would be seen by a bent one: refracted it is cross_bent()'s,
 * mirrored it is photons' that start there. */
static bool leaves_bent(const Walk *w, const Hit *hit, const ShadingFrame *frame, const ScatterSample *s) {
    return s->lobe != LOBE_TRANSPARENT && may_bend(w, hit) && light_is_bent(frame, s->wo) &&
           !(s->transmit && w->run->bent->objects[hit->object].eta == 0);
}

/* Refraction by a normal that is seen bent goes one way, which photons find likewise (bent_turn.c). */
static void cross_bent(Walk *w, Branch *b, const Hit *hit, const ShadingFrame *frame, V3 wi) {
    if (!may_bend(w, hit)) return;
    BentTurn turn = bent_prepare(w->run->bent, hit, frame, wi);
    if (!(turn.cross > 0)) return;
    const Material *m = hit->material;
    ShadingFrame bent = {frame->ng, turn.through, frame->front};
    Way way = {.share = m->kind->reflected ? 1 - m->kind->reflected(m, &bent, wi) : 1, .bent = true};
    double u[4] = {0.5, 0.5, 1 - 0x1p-53, 0};
    if (!(way.share > 0) || !bent_turn(&turn, hit, frame, wi, true, u, &way.sample)) return;
    if (!(b->left_visible & visibility_after(way.sample.lobe, true))) return;
    TALLY(w, bent, rgb_scale(rgb_mul(b->flux, way.sample.weight), -way.share));
    push(w, b, hit, frame, wi, &way);
}

/* Both ways on from an interface; returns what neither takes. */
static Rgb split(Walk *w, Branch *b, const Hit *hit, const ShadingFrame *frame, V3 wi, unsigned lobes) {
    const Material *m = hit->material;
    double reflected = m->kind->reflected ? m->kind->reflected(m, frame, wi) : 1;
    Rgb left = b->flux;
    for (int way = 0; way < 2; way++) {
        double share = way ? 1 - reflected : reflected, u[3] = {0.5, 0.5, way ? 1 - 0x1p-53 : 0};
        ScatterSample s;
        if (!(share > 0) || !m->kind->sample(m, frame, wi, u, lobes, true, &s)) continue;
        bool seen = s.lobe == LOBE_TRANSPARENT ||
                    (light_is_seen(frame, wi) && (b->left_visible & visibility_after(s.lobe, s.transmit)));
        if (!seen || !rgb_finite(s.weight)) continue;
        Rgb on = rgb_scale(rgb_mul(b->flux, s.weight), share);
        if (rgb_black(on)) continue;
        left = rgb_sub(left, on);
        Way taken = {s, share, m->kind->reflected && !s.transmit && reflected < 1, false};
        if (leaves_bent(w, hit, frame, &s))
            TALLY(w, bent, on);
        else
            push(w, b, hit, frame, wi, &taken);
    }
    return left;
}

/* One surface. The caster is met when the first thing that does not let light straight through is it. */
static void surface(Walk *w, Branch *b, const Hit *hit) {
    V3 wi = v3_neg(b->ray.dir);
    const Object *o = &w->run->scene->objects[hit->object];
    const Material *m = hit->material;
    bool straight = m->lobes & LOBE_TRANSPARENT;
    if (!b->met && !straight) {
        LightFirst first = light_first(w->run->light, b->ray.dir, hit->position, &w->passed);
        if (first == LIGHT_BEFORE) {
            w->stack[w->count] = *b;
            w->stack[w->count++].ray = ray_from_hit(hit, b->ray.dir, INFINITY, b->ray.visibility);
        }
        if (first != LIGHT_LIT || hit->object != w->front->object) return;
        b->met = true;
    }
    if (b->met && !w->any) {
        w->any = true;
        TALLY(w, emitted, b->flux);
    }
    ShadingFrame frame = frame_from_light(hit, wi);
    unsigned lobes = m->lobes & (LOBE_SPECULAR | LOBE_TRANSPARENT);
    bool waved = w->run->waved[hit->object];
    if (!o->casts || !waved) lobes &= ~(unsigned)LOBE_SPECULAR;
    bool lands = receives(b, o, m);
    if (lands) land(w, b, hit, &frame, wi);
    if (lobes & LOBE_SPECULAR) cross_bent(w, b, hit, &frame, wi);
    Rgb left = lobes ? split(w, b, hit, &frame, wi, lobes) : b->flux;
    if (lands)
        TALLY(w, landed, left);
    else if (o->casts && !(m->lobes & LOBE_DIFFUSE) && ((m->lobes & LOBE_GLOSSY) || !waved))
        TALLY(w, emitted, rgb_scale(left, -1)); /* the path goes on as estimator P's, in its account */
    else
        TALLY(w, absorbed, left);
}

WaveCorner wave_corner(const WaveRun *run, const WaveFront *front, double u, double v, double area,
    WaveLandings *landings, FluxAccount *account) {
    Walk w = {.run = run,
        .front = front,
        .landings = landings,
        .account = account,
        .u = u,
        .v = v,
        .area = area,
        .passed = -INFINITY};
    WaveCorner corner = {u, v, (uint32_t)landings->count, 0, rgb_grey(0)};
    Rgb weight;
    Ray ray = wave_front_ray(front, u, v, &weight);
    w.start = rgb_max(weight);
    if (!(w.start > 0) || !rgb_finite(weight)) return corner;
    w.stack[w.count++] = (Branch){.ray = ray,
        .flux = weight,
        .correction = 1,
        .eta = 1,
        .path = (uint64_t)(uint32_t)front->object,
        .left_visible = 31u};
    while (w.count) {
        Branch b = w.stack[--w.count];
        Hit hit;
        if (account) account->rays++;
        if (trace_nearest(run->trace, &b.ray, &hit))
            surface(&w, &b, &hit);
        else if (b.met)
            TALLY(&w, escaped, b.flux);
    }
    if (w.any) corner.weight = weight;
    corner.count = (uint32_t)landings->count - corner.first;
    return corner;
}
