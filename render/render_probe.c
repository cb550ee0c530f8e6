/* SPDX-License-Identifier: Apache-2.0 */
/* The probes: the whole render once, small and cheap, so that the plan can decide what the scene calls for.
 */
#include "render/render_internal.h"

#include "core/checked.h"
#include "core/rng.h"

enum { PROBE_WIDTH = 64, PROBE_PASSES = 4, PROBE_PHOTONS = 4096, PROBE_BENT = 1024, PROBE_RAYS = 1024 };

/* In footprints of the small picture's pixels. */
#define PROBE_RADIUS 1.5

typedef struct Probe {
    cau_render *r;
    Scene scene; /* the same scene with a small picture */
    PixelFilter filter;
    size_t pixels;
    double *image;
    double **cycles;
    EyePoints points;
    SupportRows supports;
    DepositList deposits;
    PhotonTree tree;
    uint64_t key;
} Probe;

static cau_result probe_prepare(Probe *p, cau_render *r, CauError *err) {
    *p = (Probe){.r = r, .scene = r->scene, .key = rng_combine(r->options.seed, 0x70726f6265u)};
    Camera *c = &p->scene.camera;
    double aspect = (double)r->scene.camera.height / r->scene.camera.width;
    c->width = r->scene.camera.width < PROBE_WIDTH ? r->scene.camera.width : PROBE_WIDTH;
    c->height = (int)clamp(ceil(c->width * aspect), 1, 4 * PROBE_WIDTH);
    c->pixel_aspect = r->scene.camera.pixel_aspect * c->height / (c->width * aspect);
    filter_prepare(&p->filter, FILTER_BOX, 1);
    p->pixels = (size_t)c->width * (size_t)c->height;
    p->image = array_new(p->pixels * 3, sizeof(double));
    p->cycles = array_new(r->scene.light_count, sizeof *p->cycles);
    bool ok = p->image && p->cycles;
    for (size_t i = 0; ok && i < r->scene.light_count; i++)
        ok = (p->cycles[i] = array_new(p->pixels * 3, sizeof(double))) != NULL;
    return ok ? CAU_OK : error_set(err, CAU_ERROR_RESOURCE, "out of memory for the probes");
}

static void probe_free(Probe *p) {
    for (size_t i = 0; p->cycles && i < p->scene.light_count; i++) free(p->cycles[i]);
    free(p->cycles);
    free(p->image);
    eye_points_free(&p->points);
    support_rows_free(&p->supports);
    deposits_free(&p->deposits);
    photon_tree_free(&p->tree);
}

static double image_mean(const double *image, size_t pixels) {
    double sum = 0;
    for (size_t i = 0; i < 3 * pixels; i++)
        if (isfinite(image[i])) sum += image[i];
    return sum / (double)(3 * pixels);
}

/* What Cycles has of each light: path tracing, whose variance without caustics is small. */
static cau_result probe_cycles(Probe *p, uint32_t pass, LightProbe *probes, CauError *err) {
    ReferenceRun run = {.scene = &p->scene,
        .trace = p->r->trace,
        .filter = &p->filter,
        .casters = &p->r->casters,
        .key = p->key,
        .pass = pass,
        .x1 = p->scene.camera.width,
        .y1 = p->scene.camera.height,
        .cancel = &p->r->cancel};
    ReferenceImages out = {.cycles = p->cycles};
    CAU_TRY(reference_pass(&run, p->r->pool, &out, err));
    for (size_t i = 0; i < p->scene.light_count; i++)
        probes[i].cycles_mean += image_mean(p->cycles[i], p->pixels) / PROBE_PASSES;
    return CAU_OK;
}

/* The mean picture of one pass of one layer of one light. */
static cau_result probe_layer(Probe *p, const GatherRun *gather, size_t light, PathOwner owner, uint32_t pass,
    double *mean, double *bent_share, double *rays, uint64_t *deposits, CauError *err) {
    cau_render *r = p->r;
    const Light *l = &p->scene.lights[light];
    uint64_t key =
        rng_combine(rng_combine(p->key, l->stream), 2 * (uint64_t)pass + (owner == OWNER_INDIRECT));
    FluxAccount account = {0}, bent_account = {0};
    PhotonRun run = {.scene = &p->scene,
        .trace = r->trace,
        .light = l,
        .aim = {owner == OWNER_DIRECT ? &r->casters : &r->surfaces,
            owner == OWNER_DIRECT ? NULL : &r->casters, 0.5},
        .casters = &r->casters,
        .owner = owner,
        .key = key,
        .physical = r->options.physical_radiance,
        .photons = PROBE_PHOTONS,
        .bent = r->bent.objects ? &r->bent : NULL,
        .guide = r->guides ? &r->guides[light] : NULL,
        .bent_photons = render_bent_found(r, l, owner == OWNER_INDIRECT) ? PROBE_BENT : 0,
        .bent_account = &bent_account,
        .cancel = &r->cancel};
    CAU_TRY(photons_trace(&run, r->pool, &p->deposits, &account, err));
    CAU_TRY(photon_tree_build(&p->tree, p->deposits.items, p->deposits.count, err));
    PassImages out = {.radiance = p->image};
    CAU_TRY(gather_photons(gather, &p->supports, &p->tree, r->pool, &out, err));
    *mean = image_mean(p->image, p->pixels);
    double bent = rgb_max(bent_account.landed), landed = rgb_max(account.landed) + bent;
    *bent_share = landed > 0 ? bent / landed : 0;
    *rays = account.photons ? (double)account.rays / (double)account.photons : 0;
    *deposits += p->deposits.count;
    return CAU_OK;
}

/* Distance of a deposit from the nearest caster. */
static double throw_of(const Aim *casters, const Deposit *d) {
    V3 p = v3((double)d->position[0], (double)d->position[1], (double)d->position[2]);
    double nearest = INFINITY;
    for (size_t k = 0; k < casters->count; k++)
        nearest = fmin(nearest, v3_length(v3_sub(p, casters->balls[k].center)));
    return nearest;
}

/* Diameter of the light as a caster sees it, in radians: of a disk it is 2 sqrt(2) times the places' spread.
 */
static double diameter_of(const Light *light, const Ball *around) {
    enum { PLACES = 64 };
    V3 sum = v3(0, 0, 0);
    double square_sum = 0, distance = 1;
    if (light->delta) return 0;
    for (uint32_t k = 0; k < PLACES; k++) {
        EmitStart start;
        light->kind->emit_start(light, sobol_owen(k, 0, 1), sobol_owen(k, 1, 1), &start);
        V3 at = light->infinite ? start.dir : start.position;
        if (!light->infinite && k == 0) distance = fmax(v3_length(v3_sub(at, around->center)), 1e-9);
        sum = v3_add(sum, v3_scale(at, 1.0 / PLACES));
        square_sum += v3_dot(at, at) / PLACES;
    }
    return 2 * sqrt(2) * sqrt(fmax(0, square_sum - v3_dot(sum, sum))) / distance;
}

/* Adds a pass's part of the mean blur of each light. */
static void probe_blur(Probe *p, size_t light, LightProbe *probe) {
    double size = 0, thrown = 0, points = 0;
    for (int y = 0; y < p->scene.camera.height; y++)
        for (size_t i = 0; i < p->points.rows[y].count; i++, points++)
            size += (double)p->points.rows[y].items[i].size;
    for (size_t i = 0; i < p->deposits.count; i++) thrown += throw_of(&p->r->casters, &p->deposits.items[i]);
    if (!(size > 0) || p->deposits.count == 0) return;
    double pixel = size / points * p->scene.camera.width / p->r->scene.camera.width;
    double all = 0, deep = 0;
    for (size_t i = 0; i < p->deposits.count; i++) {
        const Deposit *d = &p->deposits.items[i];
        double flux = (double)d->flux[0] + (double)d->flux[1] + (double)d->flux[2];
        all += flux;
        if (d->glossy + d->transmission >= PHOTONS_WAVE_DEPTH) deep += flux;
    }
    if (all > 0) probe->deep_share += deep / all / PROBE_PASSES;
    probe->blur_pixels += diameter_of(&p->scene.lights[light], &p->r->casters.around) * thrown /
                          (double)p->deposits.count / pixel / PROBE_PASSES;
}

typedef struct Spread {
    double sum, square_sum;
} Spread;

static void spread_result(const Spread *s, double *mean, double *error) {
    double n = PROBE_PASSES, m = s->sum / n;
    *mean = m;
    *error = sqrt(fmax(0, s->square_sum / n - m * m) / (n - 1));
}

static cau_result probe_photons(Probe *p, LightProbe *probes, Spread *spreads, uint32_t pass, CauError *err) {
    cau_render *r = p->r;
    EyeRun eye = {.scene = &p->scene,
        .trace = r->trace,
        .filter = &p->filter,
        .key = p->key,
        .pass = pass,
        .samples = 1,
        .x1 = p->scene.camera.width,
        .y1 = p->scene.camera.height,
        .cancel = &r->cancel,
        .physical = r->options.physical_radiance};
    CAU_TRY(eye_trace(&eye, r->pool, &p->points, err));
    GatherRun gather = {.scene = &p->scene,
        .trace = r->trace,
        .points = &p->points,
        .y1 = p->scene.camera.height,
        .radius_pixels = PROBE_RADIUS,
        .cancel = &r->cancel};
    CAU_TRY(gather_supports(&gather, r->pool, &p->supports, err));
    for (size_t i = 0; i < p->scene.light_count; i++) {
        if (!p->scene.lights[i].casts) continue;
        for (int k = 0; k < 2; k++) {
            double mean, bent, rays;
            uint64_t *count = k ? &probes[i].indirect_deposits : &probes[i].direct_deposits;
            CAU_TRY(probe_layer(
                p, &gather, i, k ? OWNER_INDIRECT : OWNER_DIRECT, pass, &mean, &bent, &rays, count, err));
            if (k == 0) probe_blur(p, i, &probes[i]);
            if (k == 0) probes[i].bent_share += bent / PROBE_PASSES;
            if (k == 0) probes[i].photon_rays += rays / PROBE_PASSES;
            spreads[2 * i + (size_t)k].sum += mean;
            spreads[2 * i + (size_t)k].square_sum += mean * mean;
        }
        probes[i].probes += PROBE_PHOTONS;
    }
    return CAU_OK;
}

/* Which caster the aimed light meets first. */
static cau_result probe_hits(Probe *p, LightProbe *probes, CauError *err) {
    for (size_t i = 0; i < p->scene.light_count; i++) {
        LightProbe *probe = &probes[i];
        probe->object_hits = array_new(p->scene.object_count, sizeof *probe->object_hits);
        if (!probe->object_hits) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the probes");
        uint64_t key = rng_combine(p->key, p->scene.lights[i].stream), seen = 0;
        for (uint32_t k = 0; k < PROBE_RAYS; k++) {
            Photon photon;
            Hit hit;
            AimMix aim = {.first = &p->r->casters};
            if (!emit_photon(&p->scene.lights[i], &aim, k, key, &photon)) continue;
            Ray ray = ray_from_point(photon.origin, photon.dir, 0, INFINITY, VISIBLE_SHADOW);
            if (!trace_nearest(p->r->trace, &ray, &hit)) continue;
            probe->object_hits[hit.object]++;
            seen++;
        }
        probe->caster_hits = seen;
        /* Scaled to the number of photon probes, so that one figure says how many tries stand behind a bound.
         */
        for (size_t o = 0; o < p->scene.object_count; o++)
            probe->object_hits[o] = probe->object_hits[o] * PROBE_PASSES * PROBE_PHOTONS / PROBE_RAYS;
    }
    return CAU_OK;
}

static cau_result probe_wave(
    const Probe *p, size_t light, size_t object, double enough, WaveCost *cost, CauError *err) {
    cau_render *r = p->r;
    WaveRun run = {.scene = &r->scene,
        .trace = r->trace,
        .casters = &r->casters,
        .light = &r->scene.lights[light],
        .waved = r->waved,
        .bent = r->bent.objects ? &r->bent : NULL,
        .key = p->key,
        .places = 1,
        .cancel = &r->cancel};
    WaveProbe found;
    CAU_TRY(wave_probe(&run, (int)object, enough, &found, err));
    double all = found.left + found.landed;
    *cost = (WaveCost){.rays = (double)found.rays / (double)found.corners,
        .left = all > 0 ? found.left / all : 0,
        .noise = found.noise};
    return CAU_OK;
}

static cau_result probe_waves(Probe *p, LightProbe *probes, CauError *err) {
    cau_render *r = p->r;
    if (r->options.estimator != CAU_ESTIMATOR_AUTO && r->options.estimator != CAU_ESTIMATOR_W) return CAU_OK;
    for (size_t i = 0; i < r->scene.light_count; i++) {
        probes[i].wave = array_new(r->scene.object_count, sizeof *probes[i].wave);
        if (!probes[i].wave) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the probes");
        for (size_t o = 0; o < r->scene.object_count; o++)
            if (r->waved[o] && r->scene.lights[i].casts)
                CAU_TRY(probe_wave(p, i, o, PLAN_WAVE_DEAR * probes[i].photon_rays, &probes[i].wave[o], err));
    }
    return CAU_OK;
}

static cau_result probe_all(Probe *p, LightProbe *probes, Spread *spreads, CauError *err) {
    for (uint32_t pass = 0; pass < PROBE_PASSES; pass++) {
        CAU_TRY(probe_cycles(p, pass, probes, err));
        CAU_TRY(probe_photons(p, probes, spreads, pass, err));
    }
    CAU_TRY(probe_waves(p, probes, err)); /* photons tell what is dear */
    for (size_t i = 0; i < p->scene.light_count; i++) {
        spread_result(&spreads[2 * i], &probes[i].direct_mean, &probes[i].direct_error);
        spread_result(&spreads[2 * i + 1], &probes[i].indirect_mean, &probes[i].indirect_error);
    }
    return probe_hits(p, probes, err);
}

cau_result render_probe(cau_render *r, CauError *err) {
    int estimator = r->options.estimator == CAU_ESTIMATOR_P   ? PLAN_ESTIMATOR_P
                    : r->options.estimator == CAU_ESTIMATOR_W ? PLAN_ESTIMATOR_W
                                                              : PLAN_ESTIMATOR_AUTO;
    PlanChoice choice = {r->options.indirect, estimator, r->waved, render_has_rounds(r)};
    if (!plan_scene_can_have_caustics(&r->scene)) return plan_make(&r->plan, &r->scene, NULL, &choice, err);
    size_t n = r->scene.light_count;
    LightProbe *probes = array_new(n, sizeof *probes);
    Spread *spreads = array_new(2 * n, sizeof *spreads);
    Probe p = {0};
    cau_result result = probes && spreads
                            ? probe_prepare(&p, r, err)
                            : error_set(err, CAU_ERROR_RESOURCE, "out of memory for the probes");
    if (result == CAU_OK) result = probe_all(&p, probes, spreads, err);
    if (result == CAU_OK) result = plan_make(&r->plan, &r->scene, probes, &choice, err);
    for (size_t i = 0; probes && i < n; i++) {
        free(probes[i].object_hits);
        free(probes[i].wave);
    }
    probe_free(&p);
    free(probes);
    free(spreads);
    return result;
}
