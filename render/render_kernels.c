/* SPDX-License-Identifier: Apache-2.0 */
/* How wide estimator P's kernels are: tried on the first photons, then learned from the passes. */
#include "render/render_pass_state.h"

#include "core/checked.h"

/* Kernel radius in pixel footprints that a layer's first trial begins with: wide, because a bias shows at
 * once and noise hides it. What follows is learned; see bandwidth.h. */
#define RADIUS_DIRECT 4.0
#define RADIUS_INDIRECT 8.0
/* Where estimator W draws the layer, and photons only what is left. */
#define RADIUS_BESIDE_WAVE 1.0
/* Trials of kernels on the first pass's photons: these, and more while kernels of this share of the light
 * are far too wide (a ball's caustic in 64x36 pixels: a thirtieth of the first radius). */
#define TRIALS 3
#define TRIALS_MAX 6
#define FALLING_LEAST 0.05
/* In large pictures, while kernels are wide: the first trials know enough from every second pixel along each
 * edge. */
enum { SPARSE_TRIALS = 2, SPARSE_STEP = 2 };
/* Kernels may cost as much as the rays of their photons: deposits met per ray, and at least per eye point. */
#define DEPOSITS_PER_RAY 40.0
#define DEPOSITS_MIN 96.0

void kernels_clear(PassState *s) {
    size_t values = picture_values(s->r);
    memset(s->kernels.bias, 0, values * sizeof(double));
    memset(s->kernels.cost, 0, values / 3 * sizeof(double));
}

/* Deposits that an eye point's kernel may meet, by the rays of the first pass's first light. */
static double most_deposits(const PassState *s, const RenderGroup *group, int kind) {
    const cau_render *r = s->r;
    double points = 0;
    for (int y = r->region[1]; y < r->region[3]; y++) points += (double)s->points.rows[y].count;
    double rays = (double)(group->accounts[kind].rays + (kind ? 0 : group->wave_account.rays));
    return fmax(DEPOSITS_PER_RAY * rays / fmax(points, 1), DEPOSITS_MIN);
}

/* The two halves of a run's photons are two replicas of half as many. */
static cau_result gather_half(
    PassState *s, bool second, Film *film, Film *bias, const GatherRun *gather, CauError *err) {
    size_t half = s->deposits.count / 2, count = second ? s->deposits.count - half : half;
    const Deposit *items = s->deposits.items + (second ? half : 0);
    PassImages trial = {.radiance = s->images.radiance, .kernels = &s->kernels};
    CAU_TRY(photon_tree_build(&s->tree, items, count, err));
    CAU_TRY(gather_photons(gather, &s->supports, &s->tree, s->r->pool, &trial, err));
    film_add(film, s->images.radiance);
    film_add(bias, s->kernels.bias);
    return CAU_OK;
}

static cau_result trial(PassState *s, RenderGroup *group, int kind, const GatherRun *gather, bool settle,
    double *falling, CauError *err) {
    Film film, bias = {0};
    BandwidthTrial how = {gather->radius_pixels, most_deposits(s, group, kind) / 2, settle};
    CAU_TRY(film_create(&film, picture_values(s->r) / 3, 3, err));
    cau_result result = film_create(&bias, picture_values(s->r) / 3, 3, err);
    if (result == CAU_OK) result = gather_supports(gather, s->r->pool, &s->supports, err);
    for (int k = 0; result == CAU_OK && k < 2; k++) result = gather_half(s, k, &film, &bias, gather, err);
    if (result == CAU_OK)
        result = bandwidth_learn(&group->kernels[kind], &film, &bias, s->kernels.cost, &how, falling, err);
    film_free(&film);
    film_free(&bias);
    return result;
}

cau_result kernels_try(PassState *s, RenderGroup *group, int kind, GatherRun *gather, CauError *err) {
    GatherRun run = *gather;
    run.points = &s->trial_points;
    double falling = 1;
    for (int i = 0; i < TRIALS || (i < TRIALS_MAX && falling > FALLING_LEAST); i++) {
        run.step = i < SPARSE_TRIALS && render_pixel_count(s->r) >= RENDER_LARGE_PIXELS ? SPARSE_STEP : 0;
        CAU_TRY(trial(s, group, kind, &run, i >= TRIALS, &falling, err));
    }
    group->kernels[kind].tried = true;
    CAU_TRY(photon_tree_build(&s->tree, s->deposits.items, s->deposits.count, err));
    CAU_TRY(look_closer(s, group, kind, gather, err));
    return gather_supports(gather, s->r->pool, &s->supports, err);
}

/* Shards and resumed renders compare the mean radius: it is the same where all photons were. */
void kernels_settle(RenderGroup *group, int kind, bool tried) {
    group->kernels[kind].tried = tried;
    group->radius_scale[kind] = bandwidth_mean_radius(&group->kernels[kind]);
}

static double first_radius(const cau_render *r, size_t g, int kind) {
    if (render_waves_draw(r, g, kind)) return RADIUS_BESIDE_WAVE;
    return kind ? RADIUS_INDIRECT : RADIUS_DIRECT;
}

void kernels_restart(cau_render *r, size_t g, int kind) {
    bandwidth_restart(&r->groups[g].kernels[kind], first_radius(r, g, kind));
    r->groups[g].radius_scale[kind] = 0;
}

cau_result render_make_kernels(cau_render *r, CauError *err) {
    for (size_t g = 0; g < r->group_count; g++)
        for (int kind = 0; kind < 2; kind++) {
            if (!(kind ? r->groups[g].indirect : r->groups[g].direct)) continue;
            CAU_TRY(bandwidth_create(&r->groups[g].kernels[kind], r->scene.camera.width,
                r->scene.camera.height, first_radius(r, g, kind), render_waves_draw(r, g, kind), err));
        }
    return CAU_OK;
}

cau_result kernels_prepare(PassState *s, CauError *err) {
    size_t values = picture_values(s->r);
    s->kernels = (KernelImages){array_new(values, sizeof(double)), array_new(values / 3, sizeof(double))};
    s->eye_paths = array_new(values / 3, 1);
    if (!s->kernels.bias || !s->kernels.cost || !s->eye_paths)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the kernels of %zu pixels", values / 3);
    s->images.kernels = &s->kernels;
    return CAU_OK;
}

void kernels_free(PassState *s) {
    free(s->kernels.bias);
    free(s->kernels.cost);
    free(s->eye_paths);
}
