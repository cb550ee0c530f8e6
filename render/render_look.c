/* SPDX-License-Identifier: Apache-2.0 */
/* How many eye paths a layer takes of each pixel, beside those that all layers share.
 *
 * Where kernels are narrow each path covers a part of its pixel alone. And what estimator W shows through
 * glass and in mirrors is what eye paths happen to meet: a focus that is small there is met by few. Before
 * the layer's first pass a trial, with coarser wavefronts, tells by how much the paths of a pixel differ; a
 * number in proportion to that gives the least error for the paths in all (Neyman 1934). The trial is the
 * same whichever pass is the first here, so that shards and renders that go on agree. */
#include "render/render_pass_state.h"

#include "core/checked.h"
#include "core/rng.h"

/* Radius in footprints from which on one eye path to a pixel will do: as many more as the kernel's area is
 * less. */
#define RADIUS_ONE_PATH 2.5
enum { NARROW_PATHS_MAX = 64, LOOKS_MAX = UINT8_MAX };
/* Of the trial: eye paths of a pixel that shows glass or a mirror; as many in all as the pass has photons,
 * but one path alone cannot differ. */
enum { TRIAL_PATHS_MIN = 2, TRIAL_PATHS_MAX = 16 };
/* Eye points are held in memory: no more paths than pixels, but in small pictures. */
#define LOOKS_SMALL 131072.0

/* Passes may have so many times the rays of what looks cost. Beyond that more passes of fewer rays have the
 * lower error: a ball that fills a fifth of 160x90 pixels, 1e6 rays in 8, 32 and 128 passes: .38, .16 and .16
 * % in 30, 26 and 46 s. */
#define RAYS_BEYOND_LOOKS 4.0

/* What is seen through glass and in mirrors. */
typedef struct Trial {
    double *seen;   /* [pixel][3] */
    double *spread; /* [pixel] first PassImages.spread, then the variance of a path */
    double paths;   /* of each pixel */
    double rays;    /* of a whole pass's wavefronts */
    EyePoints points;
} Trial;

static double looks_most(const cau_render *r) {
    return fmax((double)(r->region[2] - r->region[0]) * (r->region[3] - r->region[1]), LOOKS_SMALL);
}

double look_pass_most(const cau_render *r, double most) {
    if (!r->view || !wave_view_any_busy(r->view)) return most;
    for (size_t i = 0; i < r->plan.light_count; i++)
        if (r->plan.lights[i].wave && r->plan.lights[i].wave_rays > 0)
            most = fmin(
                most, RAYS_BEYOND_LOOKS * RENDER_RAYS_PER_LOOK * looks_most(r) / r->plan.lights[i].wave_rays);
    return most;
}

static size_t count_busy(const EyeRun *eye) {
    size_t count = 0, width = (size_t)eye->scene->camera.width;
    for (int y = eye->y0; y < eye->y1; y++)
        for (int x = eye->x0; x < eye->x1; x++) count += eye->busy[(size_t)y * width + (size_t)x];
    return count;
}

static cau_result trial_draw(PassState *s, size_t group, size_t busy, Trial *t, CauError *err) {
    cau_render *r = s->r;
    EyeRun eye = s->eye;
    eye.key = rng_combine(eye.key, 0x6c6f6f6bu);
    eye.pass = 0;
    eye.samples = 0;
    eye.samples_busy =
        (uint32_t)clamp((double)r->photons_per_pass / (double)busy, TRIAL_PATHS_MIN, TRIAL_PATHS_MAX);
    t->paths = eye.samples_busy;
    CAU_TRY(eye_trace(&eye, r->pool, &t->points, err));
    GatherRun gather = {.scene = &r->scene,
        .trace = r->trace,
        .points = &t->points,
        .y0 = eye.y0,
        .y1 = eye.y1,
        .radius_pixels = 1,
        .cancel = &r->cancel};
    CAU_TRY(gather_supports(&gather, r->pool, &s->supports, err));
    PassImages images = {.radiance = s->images.radiance, .seen = t->seen, .spread = t->spread, .add = true};
    for (size_t i = 0; i < r->scene.light_count; i++)
        if (r->group_of_light[i] == group && r->plan.lights[i].wave)
            CAU_TRY(waves_try(s, i, &gather, &images, &t->rays, err));
    return CAU_OK;
}

/* Of one path; what the paths of a pixel summed to are shares of it. */
static void trial_variance(const Trial *t, size_t pixels) {
    for (size_t i = 0; i < pixels; i++) {
        double mean = (t->seen[3 * i] + t->seen[3 * i + 1] + t->seen[3 * i + 2]) / 3;
        t->spread[i] = positive(t->paths * t->spread[i] - mean * mean);
    }
}

/* A few paths may miss what the next pixel's meet. */
static double deviation_around(const Trial *t, const EyeRun *eye, int x, int y) {
    double sum = 0, count = 0;
    for (int j = y - 1; j <= y + 1; j++)
        for (int i = x - 1; i <= x + 1; i++) {
            if (i < eye->x0 || i >= eye->x1 || j < eye->y0 || j >= eye->y1) continue;
            size_t at = (size_t)j * (size_t)eye->scene->camera.width + (size_t)i;
            if (!eye->busy[at]) continue;
            sum += t->spread[at];
            count++;
        }
    return sqrt(sum / fmax(count, 1));
}

/* The first time `scale` is 0, for the sum of the deviations. */
static double share_out(const Trial *t, const EyeRun *eye, double scale, uint8_t *looks) {
    double sum = 0;
    for (int y = eye->y0; y < eye->y1; y++)
        for (int x = eye->x0; x < eye->x1; x++) {
            size_t at = (size_t)y * (size_t)eye->scene->camera.width + (size_t)x;
            if (!eye->busy[at]) continue;
            double deviation = deviation_around(t, eye, x, y);
            sum += deviation;
            looks[at] = (uint8_t)fmin(scale * deviation, LOOKS_MAX);
        }
    return sum;
}

/* Where many paths look, kernels need not be wider than what one of them stands for: they blurred a focus
 * that is smaller than a pixel. */
static void looks_take(RenderGroup *group, uint8_t *looks, size_t pixels) {
    float *radius = group->kernels[0].radius;
    for (size_t i = 0; i < pixels; i++)
        if (looks[i]) radius[i] = (float)fmin((double)radius[i], RADIUS_ONE_PATH / sqrt(looks[i]));
    group->looks = looks;
}

cau_result look_learn(PassState *s, size_t g, CauError *err) {
    cau_render *r = s->r;
    RenderGroup *group = &r->groups[g];
    if (group->looks || !render_waves_draw(r, g, 0)) return CAU_OK;
    size_t pixels = picture_values(r) / 3, busy = count_busy(&s->eye);
    Trial t = {array_new(3 * pixels, sizeof(double)), array_new(pixels, sizeof(double)), 0, 0, {0}};
    uint8_t *looks = array_new(pixels, 1);
    cau_result result = t.seen && t.spread && looks
                            ? CAU_OK
                            : error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu pixels", pixels);
    if (result == CAU_OK && busy) result = trial_draw(s, g, busy, &t, err);
    if (result == CAU_OK && busy) {
        trial_variance(&t, pixels);
        double sum = share_out(&t, &s->eye, 0, looks);
        /* As much time for looks as for rays: whichever makes the error, half of the time lowers it. */
        if (sum > 0) share_out(&t, &s->eye, fmin(t.rays / RENDER_RAYS_PER_LOOK, looks_most(r)) / sum, looks);
    }
    if (result == CAU_OK)
        looks_take(group, looks, pixels);
    else
        free(looks);
    free(t.seen);
    free(t.spread);
    eye_points_free(&t.points);
    return result;
}

/* Estimator W draws what is seen directly: paths there are for photons, and to tell what receivers cover. */
static bool wanted_everywhere(const PassState *s, const RenderGroup *group, int kind) {
    const cau_render *r = s->r;
    if (kind || !group->looks || s->images.irradiance) return true;
    for (size_t i = 0; i < r->scene.light_count; i++)
        if (&r->groups[r->group_of_light[i]] == group && r->plan.lights[i].direct &&
            (r->plan.lights[i].photons || render_bent_photons(r, i, false)))
            return true;
    return false;
}

cau_result look_closer(PassState *s, const RenderGroup *group, int kind, GatherRun *gather, CauError *err) {
    size_t pixels = picture_values(s->r) / 3;
    const float *radius = group->kernels[kind].radius;
    const uint8_t *looks = kind ? NULL : group->looks;
    bool everywhere = wanted_everywhere(s, group, kind);
    uint8_t most = 0;
    for (size_t i = 0; i < pixels; i++) {
        s->eye_paths[i] = 0;
        if (!everywhere && !s->eye.busy[i]) continue;
        double paths = square(RADIUS_ONE_PATH / ((double)radius[i] * gather->radius_pixels));
        s->eye_paths[i] = (uint8_t)clamp(ceil(paths), 1, NARROW_PATHS_MAX);
        if (looks && looks[i] > s->eye_paths[i]) s->eye_paths[i] = looks[i];
        if (s->eye_paths[i] > most) most = s->eye_paths[i];
    }
    if (most <= s->eye.samples) return CAU_OK;
    EyeRun eye = s->eye;
    eye.at_least = s->eye_paths;
    eye.base = &s->points;
    gather->points = &s->layer_points;
    return eye_trace(&eye, s->r->pool, &s->layer_points, err);
}
