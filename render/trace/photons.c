/* SPDX-License-Identifier: Apache-2.0 */
#include "render/trace/deposits.h"

#include "core/checked.h"
#include "core/rng.h"

enum { DEPTH_MAX = 1000, ROULETTE_DEPTH = 1 };

/* Below this share of the emitted flux a photon plays roulette. */
#define ROULETTE_SHARE 0.05

typedef struct Flight {
    const PhotonRun *run;
    PhotonBatch *batch;
    double photons; /* how many share the flux */
    PathNumbers numbers;
    Ray ray;
    Rgb flux;              /* uncorrected */
    double emitted;        /* largest channel when it left the lamp */
    double correction;     /* adjoint of the shading normals so far */
    bool unseen;           /* left a lamp without extent by S: no eye path, and not bent.h, can find it */
    double passed;         /* light_first()'s */
    double eta;            /* product of n(after) / n(before) along the path */
    Chain chain, first;    /* all scatterings; the one next to the light */
    unsigned left_visible; /* which rays see the surface left last */
    int depth;
    bool waved; /* so far the path is estimator W's */
} Flight;

static void tally(Rgb *sum, Rgb flux) { *sum = rgb_add(*sum, flux); }

/* ---- deposits ---- */

static uint8_t byte_count(unsigned n) { return (uint8_t)(n < 255 ? n : 255); }

/* What is stored is what a gather must sum to get Cycles' irradiance: the flux, corrected for interpolated
 * normals on the way and at the receiver, and divided by the square of the relative index where Cycles does
 * not scale radiance (DESIGN: (n_light / n_eye)^2, with the eye side left unscaled). */
static void deposit(Flight *f, const Hit *hit, const ShadingFrame *frame, V3 wi) {
    double ns = v3_dot(wi, frame->ns), ng = v3_dot(wi, frame->ng);
    if (ns <= 0 || ng <= 0) return;
    double factor = f->correction * ns / ng / f->photons * material_received(hit->material, frame, wi);
    if (!f->run->physical) factor /= square(f->eta);
    Rgb e = rgb_scale(f->flux, factor);
    PhotonBatch *b = f->batch;
    if (!rgb_finite(e) || !isfinite((float)rgb_max(e)) || !v3_finite(hit->position)) {
        b->account.non_finite++;
        return;
    }
    if (!array_reserve((void **)&b->items, &b->capacity, b->count + 1, sizeof *b->items)) {
        b->out_of_memory = true;
        return;
    }
    Deposit *d = &b->items[b->count++];
    *d = (Deposit){.position = {(float)hit->position.x, (float)hit->position.y, (float)hit->position.z},
        .flux = {(float)e.r, (float)e.g, (float)e.b},
        .diffuse = byte_count(f->chain.diffuse - f->first.diffuse),
        .glossy = byte_count(f->chain.glossy - f->first.glossy),
        .transmission = byte_count(f->chain.transmission - f->first.transmission)};
    normal_encode(frame->ng, d->normal);
    b->account.deposits++;
}

/* A receiver: keeps a deposit when the path with it is ours. Returns the owner of the path that ends here. */
static PathOwner receive(Flight *f, const Hit *hit, const ShadingFrame *frame, V3 wi) {
    Chain with = f->chain;
    chain_add_from_light(&with, LOBE_DIFFUSE, false);
    PathOwner owner = chain_owner(&with);
    const Object *o = &f->run->scene->objects[hit->object];
    if (f->waved && owner == OWNER_DIRECT) return OWNER_CYCLES;
    if (owner != f->run->owner || !o->receives || !(f->left_visible & VISIBLE_DIFFUSE)) return owner;
    deposit(f, hit, frame, wi);
    return owner;
}

/* ---- going on ---- */

/* Without the scattering next to the light, to which no limit applies. */
static bool within_limits(const Flight *f) {
    return bounces_allow(&f->run->scene->bounces, f->chain.diffuse - f->first.diffuse,
        f->chain.glossy - f->first.glossy, f->chain.transmission - f->first.transmission);
}

/* Smooth paths over waved objects alone are estimator W's, as far as it follows them. */
static bool wave_goes_on(const Flight *f, const Hit *hit, const ScatterSample *s) {
    return s->lobe == LOBE_SPECULAR && f->run->waved[hit->object] &&
           f->chain.glossy + f->chain.transmission <= PHOTONS_WAVE_DEPTH;
}

static bool next_to_lamp(const Flight *f) {
    return f->chain.diffuse + f->chain.glossy + f->chain.transmission == 0;
}

static void advance(
    Flight *f, const Hit *hit, const ShadingFrame *frame, V3 wi, const ScatterSample *s, bool corrected) {
    unsigned seen_by = f->ray.visibility; /* straight through: still the same ray */
    if (s->lobe != LOBE_TRANSPARENT) {
        seen_by = VISIBLE_DIFFUSE | VISIBLE_GLOSSY | VISIBLE_TRANSMISSION;
        if (!corrected) f->correction *= shading_adjoint(frame, wi, s->wo);
        f->eta *= s->eta;
        bool is_first = next_to_lamp(f);
        chain_add_from_light(&f->chain, s->lobe, s->transmit);
        if (f->waved && !wave_goes_on(f, hit, s)) f->waved = false;
        if (is_first) f->first = f->chain;
        f->unseen |= is_first && f->run->light->delta && s->lobe == LOBE_SPECULAR;
        f->left_visible = f->run->scene->objects[hit->object].visibility;
    }
    f->ray = ray_from_hit(hit, s->wo, INFINITY, seen_by);
}

/* Unbiased: survivors carry what the others lose, and the balance is counted. */
static bool roulette(Flight *f, double keep) {
    FluxAccount *a = &f->batch->account;
    if (keep >= 1) return true;
    if (rng_next(&f->numbers.rng) >= keep) {
        tally(&a->dropped, f->flux);
        return false;
    }
    Rgb grown = rgb_scale(f->flux, 1 / keep);
    tally(&a->dropped, rgb_sub(f->flux, grown));
    f->flux = grown;
    return true;
}

/* Probability with which a diffuse bounce that still needs S or G is aimed at the casters. */
#define AIMED_SHARE 0.75

/* A diffuse bounce of light that has not met S or G yet: without a caster ahead it can never be ours, so most
 * go there; the density is that of the mixture with the Lambert lobe. */
static bool bounce_towards_casters(
    Flight *f, const Hit *hit, const ShadingFrame *frame, V3 wi, const double u[3], ScatterSample *s) {
    double aimed;
    V3 dir;
    if (!aim_direction(f->run->casters, hit->position, u[0], u[1], &dir, &aimed)) return false;
    const Material *m = hit->material;
    if (u[2] >= AIMED_SHARE) {
        s->weight = rgb_grey(0);
        if (!m->kind->sample(m, frame, wi, u, LOBE_DIFFUSE, true, s)) return false;
        dir = s->wo;
        aimed = aim_direction_pdf(f->run->casters, hit->position, dir);
    }
    /* eval() answers for an eye path: the eye is where this light goes. */
    double lambert, cos_light = fabs(v3_dot(wi, frame->ns)), cos_out = v3_dot(dir, frame->ns);
    *s = (ScatterSample){.wo = dir, .lobe = LOBE_DIFFUSE, .eta = 1, .weight = rgb_grey(0)};
    if (cos_out <= 0 || v3_dot(dir, frame->ng) <= 0 || cos_light <= 0) return true;
    Rgb value = m->kind->eval(m, frame, dir, wi, LOBE_DIFFUSE, &lambert);
    lambert = cos_out / CAU_PI;
    double pdf = AIMED_SHARE * aimed + (1 - AIMED_SHARE) * lambert;
    s->weight = rgb_scale(value, cos_out / (cos_light * pdf));
    return true;
}

/* Draws where the light goes on. Diffuse and casting lobes are chosen evenly, so that each can have its own
 * density. */
static bool scatter(
    Flight *f, const Hit *hit, const ShadingFrame *frame, V3 wi, unsigned lobes, ScatterSample *s) {
    double u[3], choice = 1;
    if (!lobes) return false;
    for (int k = 2; k >= 0; k--) u[k] = path_number(&f->numbers);
    if ((lobes & LOBE_DIFFUSE) && (lobes & ~(unsigned)LOBE_DIFFUSE)) {
        choice = 0.5;
        lobes = path_number(&f->numbers) < 0.5 ? LOBE_DIFFUSE : lobes & ~(unsigned)LOBE_DIFFUSE;
    }
    path_numbers_next(&f->numbers);
    bool drawn = lobes == LOBE_DIFFUSE && !f->chain.cast && bounce_towards_casters(f, hit, frame, wi, u, s);
    if (!drawn && !hit->material->kind->sample(hit->material, frame, wi, u, lobes, true, s)) return false;
    s->weight = rgb_scale(s->weight, 1 / choice);
    if (s->lobe == LOBE_TRANSPARENT) return rgb_finite(s->weight);
    return (f->left_visible & visibility_after(s->lobe, s->transmit)) && light_is_seen(frame, wi) &&
           rgb_finite(s->weight);
}

/* Light is scattered by a normal that the eye may see bent; not where no eye path finds the light. */
static bool may_bend(const Flight *f, const Hit *hit, unsigned lobes) {
    if (!f->run->bent || !f->run->bent->objects[hit->object].bends || !(lobes & LOBE_CASTING)) return false;
    return !f->unseen && !(next_to_lamp(f) && f->run->light->delta && (lobes & LOBE_SPECULAR));
}

/* What was drawn by the normal as it is belongs to a bent one: bent_turn() or a photon that starts there has
 * it. Glass that does not refract (eta 0) lets light through by any normal. */
static bool leaves_bent(const Flight *f, const Hit *hit, const ShadingFrame *frame, const ScatterSample *s) {
    return may_bend(f, hit, s->lobe) && light_is_bent(frame, s->wo) &&
           !(s->transmit && f->run->bent->objects[hit->object].eta == 0);
}

static void fly(Flight *f);

/* One of `count` photons that go on by the bent normal. */
static void fly_bent(const Flight *from, const Hit *hit, const ShadingFrame *frame, V3 wi,
    const BentTurn *turn, bool cross, const double u[4], double count) {
    ScatterSample s;
    if (!bent_turn(turn, hit, frame, wi, cross, u, &s) ||
        !(from->left_visible & visibility_after(s.lobe, s.transmit)))
        return;
    Flight f = *from;
    f.flux = rgb_scale(rgb_mul(from->flux, s.weight), 1 / count);
    if (!rgb_finite(f.flux)) return;
    FluxAccount *a = &f.batch->account;
    a->bent = rgb_sub(a->bent, f.flux);
    advance(&f, hit, frame, wi, &s, true);
    if (!within_limits(&f)) {
        tally(&a->cut, f.flux);
        return;
    }
    f.depth++;
    if (roulette(&f, rgb_max(f.flux) / f.emitted / ROULETTE_SHARE)) fly(&f);
}

/* As many photons as are called for, in the mean, share the light that a bent normal turns. Less light calls
 * for fewer, so that they do not breed. */
static void split_bent(
    Flight *f, const Hit *hit, const ShadingFrame *frame, V3 wi, const BentTurn *turn, bool cross) {
    double wanted = (cross ? turn->cross : turn->reflect) * fmin(1, rgb_max(f->flux) / f->emitted);
    if (!(wanted > 0)) return;
    double count = ceil(wanted), chance = wanted / count;
    for (double k = 0; k < count; k++) {
        double u[4];
        for (int i = 0; i < 4; i++) u[i] = rng_next(&f->numbers.rng);
        if (rng_next(&f->numbers.rng) >= chance) continue;
        Flight child = *f;
        child.numbers = path_numbers(rng_combine(f->numbers.key, f->numbers.rng.counter), f->numbers.index);
        u[0] = (k + u[0]) / count;
        fly_bent(&child, hit, frame, wi, turn, cross, u, wanted);
    }
}

static void turn_bent(Flight *f, const Hit *hit, const ShadingFrame *frame, V3 wi, unsigned lobes) {
    if (!may_bend(f, hit, lobes)) return;
    BentTurn turn = bent_prepare(f->run->bent, hit, frame, wi);
    split_bent(f, hit, frame, wi, &turn, true);
    split_bent(f, hit, frame, wi, &turn, false);
}

/* One surface. False: the photon's flight is over, and its flux is accounted for. */
static bool surface(Flight *f, const Hit *hit) {
    FluxAccount *a = &f->batch->account;
    V3 wi = v3_neg(f->ray.dir);
    ShadingFrame frame = frame_from_light(hit, wi);
    unsigned lobes = hit->material->lobes;
    if (!(lobes & LOBE_TRANSPARENT) && next_to_lamp(f)) {
        LightFirst first = light_first(f->run->light, f->ray.dir, hit->position, &f->passed);
        if (first == LIGHT_BEFORE)
            f->ray = ray_from_hit(hit, f->ray.dir, INFINITY, f->ray.visibility);
        else if (first == LIGHT_UNLIT) /* none of the lamp's light */
            tally(&a->emitted, rgb_scale(f->flux, -1));
        if (first != LIGHT_LIT) return first == LIGHT_BEFORE;
    }
    PathOwner owner = OWNER_CYCLES;
    bool receiver = lobes & LOBE_DIFFUSE;
    if (receiver) owner = receive(f, hit, &frame, wi);
    if (!f->run->scene->objects[hit->object].casts) lobes &= ~(unsigned)LOBE_CASTING;
    if (f->run->owner == OWNER_DIRECT) lobes &= ~(unsigned)LOBE_DIFFUSE;
    ScatterSample s;
    turn_bent(f, hit, &frame, wi, lobes);
    bool goes_on = scatter(f, hit, &frame, wi, lobes, &s);
    Rgb on = goes_on ? rgb_mul(f->flux, s.weight) : rgb_grey(0), stays = rgb_sub(f->flux, on);
    if (f->run->owner == OWNER_INDIRECT) {
        tally(&a->absorbed, stays);
        if (owner == OWNER_INDIRECT) tally(&a->landed, f->flux);
    } else {
        tally(!receiver ? &a->absorbed : (owner == OWNER_DIRECT ? &a->landed : &a->straight), stays);
    }
    if (!goes_on || rgb_black(on)) return false;
    f->flux = on;
    if (leaves_bent(f, hit, &frame, &s)) {
        tally(&a->bent, f->flux);
        return false;
    }
    advance(f, hit, &frame, wi, &s, false);
    if (!within_limits(f)) {
        tally(&a->cut, f->flux);
        return false;
    }
    double share = rgb_max(f->flux) / f->emitted;
    return f->depth < ROULETTE_DEPTH || roulette(f, share / ROULETTE_SHARE);
}

static void fly(Flight *f) {
    FluxAccount *a = &f->batch->account;
    for (f->depth = 0; f->depth < DEPTH_MAX; f->depth++) {
        Hit hit;
        a->rays++;
        if (!trace_nearest(f->run->trace, &f->ray, &hit)) {
            tally(&a->escaped, f->flux);
            return;
        }
        if (!surface(f, &hit)) return;
    }
    tally(&a->dropped, f->flux);
}

static void lamp_photon(const PhotonRun *run, PhotonBatch *b, uint32_t i) {
    Photon p;
    if (!emit_photon(run->light, &run->aim, i, run->key, &p) || !rgb_finite(p.flux)) return;
    tally(&b->account.emitted, p.flux);
    Flight f = {.run = run,
        .batch = b,
        .photons = run->photons,
        .numbers = path_numbers(run->key, i),
        .flux = p.flux,
        .emitted = rgb_max(p.flux),
        .passed = -INFINITY,
        .correction = 1,
        .eta = 1,
        .waved = run->waved != NULL,
        .left_visible = 31u,
        .ray = ray_from_point(p.origin, p.dir, 0, INFINITY, VISIBLE_SHADOW)};
    fly(&f);
}

/* Backwards an eye path, from there on a photon: no correction, no index yet. */
static void bent_photon(const PhotonRun *run, PhotonBatch *b, uint32_t i) {
    BentRun search = {.set = run->bent,
        .guide = run->guide,
        .scene = run->scene,
        .trace = run->trace,
        .light = run->light,
        .diffuse = run->owner == OWNER_INDIRECT,
        .physical = run->physical,
        .key = rng_combine(run->key, 0x62656e74u)};
    BentStart start;
    if (!bent_start(&search, i, &start, &b->account.rays) || !rgb_finite(start.flux)) return;
    tally(&b->account.emitted, start.flux);
    Flight f = {.run = run,
        .batch = b,
        .photons = run->bent_photons,
        .numbers = path_numbers(rng_combine(search.key, 2), i),
        .flux = start.flux,
        .emitted = rgb_max(start.flux),
        .correction = 1,
        .eta = 1,
        .chain = start.chain,
        .first = start.first,
        .left_visible = run->scene->objects[start.hit.object].visibility,
        .ray = ray_from_hit(
            &start.hit, start.dir, INFINITY, VISIBLE_DIFFUSE | VISIBLE_GLOSSY | VISIBLE_TRANSMISSION)};
    if (within_limits(&f))
        fly(&f);
    else
        tally(&b->account.cut, f.flux);
}

/* First the lamp's batches, then those of bent normals. */
static void trace_batch(void *data, size_t index, unsigned thread) {
    (void)thread;
    const PhotonRun *run = ((void **)data)[0];
    PhotonBatch *b = &((DepositList *)((void **)data)[1])->batches[index];
    b->count = 0;
    b->account = (FluxAccount){0};
    if (run->cancel && atomic_load_explicit(run->cancel, memory_order_relaxed)) return;
    bool bent = index >= photon_batches(run->photons);
    if (bent) index -= photon_batches(run->photons);
    uint32_t first = (uint32_t)index * PHOTONS_PER_BATCH, last = first + PHOTONS_PER_BATCH;
    uint32_t photons = bent ? run->bent_photons : run->photons;
    if (last > photons) last = photons;
    b->account.photons = last - first;
    for (uint32_t i = first; i < last; i++) (bent ? bent_photon : lamp_photon)(run, b, i);
}

cau_result photons_trace(
    const PhotonRun *run, TaskPool *pool, DepositList *out, FluxAccount *account, CauError *err) {
    size_t batches = photon_batches(run->photons) + photon_batches(run->bent_photons);
    if (batches > out->batch_count) {
        PhotonBatch *grown = realloc(out->batches, batches * sizeof *grown);
        if (!grown)
            return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu photon batches", batches);
        memset(grown + out->batch_count, 0, (batches - out->batch_count) * sizeof *grown);
        out->batches = grown;
        out->batch_count = batches;
    }
    for (size_t i = batches; i < out->batch_count; i++) {
        out->batches[i].count = 0;
        out->batches[i].account = (FluxAccount){0};
    }
    void *data[2] = {(void *)run, out};
    tasks_run(pool, batches, trace_batch, data);
    if (run->cancel && atomic_load(run->cancel)) return CAU_ERROR_CANCELLED;
    return deposits_join(run, out, account, err);
}
