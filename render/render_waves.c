/* SPDX-License-Identifier: Apache-2.0 */
/* Estimator W's part of a pass, and what it says of its own bias: some passes draw it a second time, coarser.
 */
#include "render/render_pass_state.h"

#include "core/checked.h"
#include "core/rng.h"

/* Kernel radius of W's photons in pixel footprints. */
#define RADIUS_WAVE 2.0
/* Cells along an edge of a wavefront that has a place on a light of its own; replicas expected of a render
 * without a limit. */
#define WAVE_CELLS 48.0
/* Places on a light per square root of the rays at least: error by places and by cells stay in balance. */
#define WAVE_PLACES 0.03
#define WAVE_PASSES 8.0

/* A quarter of the rays have cells twice as long. The flux over a flat triangle is off by the square of its
 * length, so what they differ by is three times the bias (Richardson 1911). */
#define COARSE_RAYS 0.25
#define COARSE_BIAS (1.0 / 3)
/* Of the first passes every second one is checked, so that short renders know something; then every fourth.
 */
enum { CHECK_FIRST = 4, CHECK_EVERY = 4 };

bool waves_check(const PassState *s) {
    uint64_t pass = s->r->pass;
    return s->waves.bias && (pass < CHECK_FIRST ? pass % 2 : pass % CHECK_EVERY) == 0;
}

cau_result waves_prepare(PassState *s, CauError *err) {
    if (!s->r->view) return CAU_OK;
    size_t values = picture_values(s->r);
    s->waves.bias = array_new(values / 3, sizeof(double));
    s->waves.coarse = array_new(values, sizeof(double));
    return s->waves.bias && s->waves.coarse
               ? CAU_OK
               : error_set(err, CAU_ERROR_RESOURCE, "out of memory for wavefronts of %zu pixels", values / 3);
}

void waves_free(PassState *s) {
    free(s->waves.bias);
    free(s->waves.coarse);
    deposits_free(&s->waves.rest);
}

void waves_clear(PassState *s) {
    if (s->waves.bias) memset(s->waves.bias, 0, picture_values(s->r) / 3 * sizeof(double));
}

static void images_clear(PassState *s) {
    size_t values = picture_values(s->r);
    memset(s->images.radiance, 0, values * sizeof(double));
    kernels_clear(s);
    if (s->images.seen) memset(s->images.seen, 0, values * sizeof(double));
    if (s->images.irradiance) memset(s->images.irradiance, 0, values * sizeof(double));
    if (s->images.coverage) memset(s->images.coverage, 0, values / 3 * sizeof(double));
}

static WaveRun run_of(PassState *s, size_t light, const GatherRun *gather) {
    cau_render *r = s->r;
    const Light *l = &r->scene.lights[light];
    const LightPlan *plan = &r->plan.lights[light];
    double casters = 0, places = plan->places, rays = render_layer_photons(r, r->group_of_light[light], 0),
           passes = r->passes_wanted ? (double)r->passes_wanted : WAVE_PASSES;
    for (size_t o = 0; o < r->scene.object_count; o++) casters += square(plan->share[o]);
    casters = 1 / casters; /* as many as would share the rays evenly */
    if (!l->delta) places = fmax(places, WAVE_PLACES * sqrt(rays * passes / casters));
    return (WaveRun){.scene = &r->scene,
        .trace = r->trace,
        .casters = &r->casters,
        .light = l,
        .waved = r->waved,
        .bent = r->bent.objects ? &r->bent : NULL,
        .share = plan->share,
        .physical = r->options.physical_radiance,
        .points = gather->points,
        .y0 = r->region[1],
        .y1 = r->region[3],
        .key = rng_combine(s->key, l->stream),
        .pass = (uint32_t)r->pass,
        .rays = render_layer_photons(r, r->group_of_light[light], 0),
        .radius_pixels = RADIUS_WAVE * fmin(gather->radius_pixels, 1),
        .places = (uint32_t)clamp(ceil(places / passes), 1, fmax(1, rays / casters / square(WAVE_CELLS))),
        .cancel = &r->cancel};
}

/* A replica with all that it leaves to photons, added to the images. */
static cau_result draw_whole(PassState *s, const WaveRun *run, const GatherRun *gather,
    const PassImages *images, FluxAccount *account, CauError *err) {
    cau_render *r = s->r;
    s->waves.rest.count = 0;
    CAU_TRY(wave_pass(run, r->view, r->pool, images, &s->waves.rest, account, err));
    CAU_TRY(photon_tree_build(&s->tree, s->waves.rest.items, s->waves.rest.count, err));
    return gather_photons(gather, &s->supports, &s->tree, r->pool, images, err);
}

/* The replica, and what the same places on the light give by coarser cells: less what the finer gave. */
static cau_result draw_twice(
    PassState *s, WaveRun *run, const GatherRun *gather, FluxAccount *account, CauError *err) {
    size_t values = picture_values(s->r);
    double *coarse = s->waves.coarse;
    memcpy(coarse, s->images.radiance, values * sizeof *coarse);
    CAU_TRY(draw_whole(s, run, gather, &s->images, account, err));
    s->images.coverage = NULL; /* counted */
    for (size_t i = 0; i < values; i++) coarse[i] -= s->images.radiance[i];
    run->rays = (uint32_t)(run->rays * COARSE_RAYS);
    FluxAccount uncounted = {0};
    CAU_TRY(draw_whole(s, run, gather, &(PassImages){.radiance = coarse, .add = true}, &uncounted, err));
    for (size_t i = 0; i < values; i++) s->waves.bias[i / 3] += COARSE_BIAS / 3 * coarse[i];
    return CAU_OK;
}

cau_result waves_try(PassState *s, size_t light, const GatherRun *gather, const PassImages *images,
    double *rays, CauError *err) {
    WaveRun run = run_of(s, light, gather);
    run.key = rng_combine(run.key, 0x747279u);
    run.pass = 0;
    run.rays = (uint32_t)(run.rays * COARSE_RAYS);
    FluxAccount account = {0};
    CAU_TRY(draw_whole(s, &run, gather, images, &account, err));
    *rays += (double)account.rays / COARSE_RAYS;
    return CAU_OK;
}

cau_result waves_draw(
    PassState *s, size_t light, RenderGroup *group, const GatherRun *gather, CauError *err) {
    WaveRun run = run_of(s, light, gather);
    if (!s->images.add) images_clear(s);
    s->images.add = true;
    if (waves_check(s)) return draw_twice(s, &run, gather, &group->wave_account, err);
    return wave_pass(&run, s->r->view, s->r->pool, &s->images, &s->deposits, &group->wave_account, err);
}
