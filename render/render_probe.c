/* SPDX-License-Identifier: Apache-2.0 */
/* The probes: the whole render once, small and cheap, so that the plan can decide what the scene calls for.
 */
#include "render/render_internal.h"

#include "core/checked.h"
#include "core/rng.h"

enum { PROBE_WIDTH = 64, PROBE_PASSES = 4, PROBE_PHOTONS = 4096, PROBE_RAYS = 1024 };

/* In footprints of the small picture's pixels. */
#define PROBE_RADIUS 1.5

typedef struct Probe {
    cau_render *r;
    Scene scene; /* the same scene with a small picture */
    PixelFilter filter;
    size_t pixels;
    double *image;
    double **cycles;
    uint64_t *found;
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
    p->found = array_new((size_t)c->height, sizeof *p->found);
    bool ok = p->image && p->cycles && p->found;
    for (size_t i = 0; ok && i < r->scene.light_count; i++)
        ok = (p->cycles[i] = array_new(p->pixels * 3, sizeof(double))) != NULL;
    return ok ? CAU_OK : error_set(err, CAU_ERROR_RESOURCE, "out of memory for the probes");
}

static void probe_free(Probe *p) {
    for (size_t i = 0; p->cycles && i < p->scene.light_count; i++) free(p->cycles[i]);
    free(p->cycles);
    free(p->image);
    free(p->found);
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
    double *mean, uint64_t *deposits, CauError *err) {
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
        .bent_photons = render_bent_photons(r, l, owner == OWNER_INDIRECT, PROBE_PHOTONS),
        .bent_account = &bent_account,
        .cancel = &r->cancel};
    CAU_TRY(photons_trace(&run, r->pool, &p->deposits, &account, err));
    CAU_TRY(photon_tree_build(&p->tree, p->deposits.items, p->deposits.count, err));
    PassImages out = {.radiance = p->image, .found = p->found};
    CAU_TRY(gather_photons(gather, &p->supports, &p->tree, r->pool, &out, err));
    *mean = image_mean(p->image, p->pixels);
    *deposits += p->deposits.count;
    return CAU_OK;
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
            double mean;
            uint64_t *count = k ? &probes[i].indirect_deposits : &probes[i].direct_deposits;
            CAU_TRY(probe_layer(p, &gather, i, k ? OWNER_INDIRECT : OWNER_DIRECT, pass, &mean, count, err));
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

static cau_result probe_all(Probe *p, LightProbe *probes, Spread *spreads, CauError *err) {
    for (uint32_t pass = 0; pass < PROBE_PASSES; pass++) {
        CAU_TRY(probe_cycles(p, pass, probes, err));
        CAU_TRY(probe_photons(p, probes, spreads, pass, err));
    }
    for (size_t i = 0; i < p->scene.light_count; i++) {
        spread_result(&spreads[2 * i], &probes[i].direct_mean, &probes[i].direct_error);
        spread_result(&spreads[2 * i + 1], &probes[i].indirect_mean, &probes[i].indirect_error);
    }
    return probe_hits(p, probes, err);
}

cau_result render_probe(cau_render *r, CauError *err) {
    int indirect = r->options.indirect;
    if (!plan_scene_can_have_caustics(&r->scene)) return plan_make(&r->plan, &r->scene, NULL, indirect, err);
    size_t n = r->scene.light_count;
    LightProbe *probes = array_new(n, sizeof *probes);
    Spread *spreads = array_new(2 * n, sizeof *spreads);
    Probe p = {0};
    cau_result result = probes && spreads
                            ? probe_prepare(&p, r, err)
                            : error_set(err, CAU_ERROR_RESOURCE, "out of memory for the probes");
    if (result == CAU_OK) result = probe_all(&p, probes, spreads, err);
    if (result == CAU_OK) result = plan_make(&r->plan, &r->scene, probes, indirect, err);
    for (size_t i = 0; probes && i < n; i++) free(probes[i].object_hits);
    probe_free(&p);
    free(probes);
    free(spreads);
    return result;
}
