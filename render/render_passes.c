/* SPDX-License-Identifier: Apache-2.0 */
/* The passes: each is one independent replica of the whole picture. */
#include "render/render_pass_state.h"

#include "core/checked.h"
#include "core/rng.h"

/* A learned radius is that of 131072 photons; it shrinks with the photons so far to the power of -(1 - alpha)
 * / 2 with alpha = 1/2 (Knaus and Zwicker 2011), without a floor. 2/3 would be the best where the light is
 * smooth and its bias grows with the radius squared; most of the bias lies at folds and edges, where its
 * square grows with about that power itself. */
#define RADIUS_EXPONENT (-1.0 / 4)
#define RADIUS_PHOTONS 131072.0
/* Of the eye paths, that kernels are tried on. */
#define TRIAL_SHARE 0.25
/* Share of an indirect run's photons that start towards any surface; the others start towards the casters. */
#define INDIRECT_SHARE 0.5

enum { EYE_SAMPLES_MAX = 16, EYE_SAMPLES_BUSY = 32 };

bool render_has_layers(const cau_render *r) {
    if (r->options.estimator == CAU_ESTIMATOR_R) return true;
    for (size_t g = 0; g < r->group_count; g++)
        if (r->groups[g].direct || r->groups[g].indirect) return true;
    return false;
}

/* ---- photons ---- */

/* One light's pass of one layer, added to the group's pass image. */
static cau_result light_pass(PassState *s, size_t light, int kind, GatherRun *gather, CauError *err) {
    cau_render *r = s->r;
    const Light *l = &r->scene.lights[light];
    const LightPlan *plan = &r->plan.lights[light];
    RenderGroup *group = &r->groups[r->group_of_light[light]];
    PhotonRun run = {.scene = &r->scene,
        .trace = r->trace,
        .light = l,
        .aim = {kind ? &r->surfaces : &r->casters, kind ? &r->casters : NULL, INDIRECT_SHARE},
        .casters = &r->casters,
        .owner = kind ? OWNER_INDIRECT : OWNER_DIRECT,
        .waved = !kind && plan->wave ? r->waved : NULL,
        .physical = r->options.physical_radiance,
        .key = rng_combine(rng_combine(s->key, l->stream), 2 * r->pass + (uint64_t)kind),
        .photons = kind || plan->photons ? render_layer_photons(r, r->group_of_light[light], kind) : 0,
        .bent = r->bent.objects ? &r->bent : NULL,
        .guide = r->guides ? &r->guides[light] : NULL,
        .bent_photons = render_bent_photons(r, light, kind),
        .bent_account = &group->bent[kind],
        .cancel = &r->cancel};
    s->deposits.count = 0;
    if (run.photons || run.bent_photons)
        CAU_TRY(photons_trace(&run, r->pool, &s->deposits, &group->accounts[kind], err));
    if (!kind && plan->wave) CAU_TRY(waves_draw(s, light, group, gather, err));
    CAU_TRY(photon_tree_build(&s->tree, s->deposits.items, s->deposits.count, err));
    if (!group->kernels[kind].tried && !s->images.add) CAU_TRY(kernels_try(s, group, kind, gather, err));
    return gather_photons(gather, &s->supports, &s->tree, r->pool, &s->images, err);
}

static void add_to_films(PassState *s, RenderGroup *group, int kind) {
    film_add(&group->films[kind], s->images.radiance);
    film_add(&group->kernels[kind].bias, s->kernels.bias);
    if (!kind && waves_check(s)) film_add(&group->kernels[0].waves, s->waves.bias);
    if (kind || !s->images.irradiance) return;
    film_add(group->seen, s->images.seen);
    film_add(group->irradiance, s->images.irradiance);
    film_add(group->coverage, s->images.coverage);
}

static cau_result group_lights(PassState *s, size_t g, int kind, GatherRun *gather, CauError *err) {
    cau_render *r = s->r;
    s->images.add = false;
    waves_clear(s);
    for (size_t i = 0; i < r->scene.light_count; i++) {
        const LightPlan *plan = &r->plan.lights[i];
        if (r->group_of_light[i] != g || !(kind ? plan->indirect : plan->direct)) continue;
        CAU_TRY(light_pass(s, i, kind, gather, err));
        s->images.add = true;
        s->images.coverage = NULL; /* counted once per pass, not once per light */
    }
    return CAU_OK;
}

/* What learned radii are multiplied by when so many photons are there. */
static double radius_shrink(double photons) { return pow(photons / RADIUS_PHOTONS, RADIUS_EXPONENT); }

static uint64_t eye_point_count(const GatherRun *gather) {
    uint64_t count = 0;
    for (int y = gather->y0; y < gather->y1; y++) count += gather->points->rows[y].count;
    return count;
}

static cau_result group_pass(PassState *s, size_t g, int kind, CauError *err) {
    cau_render *r = s->r;
    double photons = render_layer_photons(r, g, kind);
    RenderGroup *group = &r->groups[g];
    GatherRun gather = {.scene = &r->scene,
        .trace = r->trace,
        .points = &s->points,
        .y0 = r->region[1],
        .y1 = r->region[3],
        .radius_pixels = radius_shrink((double)(r->pass + 1) * photons),
        .first_pixels = radius_shrink(photons),
        .radius = group->kernels[kind].radius,
        .cancel = &r->cancel};
    if (!kind) CAU_TRY(look_learn(s, g, err));
    if (group->kernels[kind].tried || render_waves_draw(r, g, kind)) {
        CAU_TRY(look_closer(s, group, kind, &gather, err));
        CAU_TRY(gather_supports(&gather, r->pool, &s->supports, err));
    }
    PassImages full = s->images;
    RenderGroup before = *group; /* a pass that is stopped leaves no trace in the accounts */
    if (s->learning) {           /* nor does one that only teaches */
        memset(group->accounts, 0, sizeof group->accounts);
        memset(&group->wave_account, 0, sizeof group->wave_account);
    }
    if (kind) s->images.seen = s->images.irradiance = s->images.coverage = NULL;
    cau_result result = group_lights(s, g, kind, &gather, err);
    s->images.coverage = kind ? NULL : full.coverage;
    bool tried = group->kernels[kind].tried || render_waves_draw(r, g, kind);
    if (result != CAU_OK || s->learning) *group = before;
    if (result == CAU_OK) kernels_settle(group, kind, tried);
    if (result == CAU_OK && !s->learning) {
        add_to_films(s, group, kind);
        group->eye_points[kind] += eye_point_count(&gather);
    }
    s->images = full;
    return result;
}

/* As many eye paths as photons, within reason: in a small picture one path per pixel would be the noise. */
static uint32_t eye_samples(const cau_render *r, double photons) {
    double pixels = (double)(r->region[2] - r->region[0]) * (r->region[3] - r->region[1]);
    return (uint32_t)clamp(photons / pixels, 1, EYE_SAMPLES_MAX);
}

/* For what is seen directly: photons alone need them. */
static uint32_t eye_samples_plain(const cau_render *r, bool irradiance) {
    if (!render_waves_alone(r) || irradiance) return eye_samples(r, r->photons_per_pass);
    double photons = 0;
    for (size_t i = 0; i < r->scene.light_count; i++)
        if (r->plan.lights[i].direct) photons += render_bent_photons(r, i, false);
    return photons > 0 ? eye_samples(r, photons) : 0;
}

/* Without photons elsewhere, what is seen through glass and in mirrors is what eye paths are for. */
static uint32_t eye_samples_busy(const cau_render *r) {
    uint32_t samples = eye_samples(r, r->photons_per_pass) * (render_waves_alone(r) ? 4 : 1);
    return samples < EYE_SAMPLES_BUSY ? samples : EYE_SAMPLES_BUSY;
}

static cau_result photon_pass(PassState *s, CauError *err) {
    cau_render *r = s->r;
    s->eye = (EyeRun){.scene = &r->scene,
        .trace = r->trace,
        .filter = &r->filter,
        .key = s->key,
        .pass = (uint32_t)r->pass,
        .samples = eye_samples_plain(r, s->images.irradiance != NULL),
        .busy = r->view ? wave_view_busy(r->view) : NULL,
        .samples_busy = eye_samples_busy(r),
        .x0 = r->region[0],
        .y0 = r->region[1],
        .x1 = r->region[2],
        .y1 = r->region[3],
        .cancel = &r->cancel,
        .physical = r->options.physical_radiance};
    EyeRun few = s->eye;
    few.samples = (uint32_t)fmax(few.samples ? 1 : 0, TRIAL_SHARE * few.samples);
    if (r->pass == 0) CAU_TRY(eye_trace(&few, r->pool, &s->trial_points, err));
    CAU_TRY(eye_trace(&s->eye, r->pool, &s->points, err));
    for (int kind = 0; kind < 2; kind++)
        for (size_t g = 0; g < r->group_count; g++)
            /* A render that was stopped within a pass goes on with those who lack it. */
            if ((kind ? r->groups[g].indirect : r->groups[g].direct) &&
                (s->learning || r->groups[g].films[kind].passes == r->passes))
                CAU_TRY(group_pass(s, g, kind, err));
    return CAU_OK;
}

/* ---- reference ---- */

static cau_result reference_prepare(PassState *s, CauError *err) {
    cau_render *r = s->r;
    size_t values = picture_values(r), lights = r->scene.light_count;
    bool caustics = render_wants_caustics(r);
    size_t images = (r->options.layers & CAU_WANT_BEAUTY ? 1 : 0) + (caustics ? 2 * lights : 0), bytes;
    if (checked_mul(images, values, &bytes)) s->reference_block = array_new(bytes, sizeof(double));
    double **tables = array_new(2 * lights, sizeof *tables);
    if (!s->reference_block || !tables) {
        free(tables);
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the reference of %zu lights", lights);
    }
    double *next = s->reference_block;
    if (r->options.layers & CAU_WANT_BEAUTY) {
        s->reference.beauty = next;
        next += values;
    }
    s->reference.direct = tables;
    s->reference.indirect = tables + lights;
    for (size_t i = 0; caustics && i < 2 * lights; i++, next += values) tables[i] = next;
    if (!caustics) s->reference.direct = s->reference.indirect = NULL;
    if (!caustics) free(tables);
    return CAU_OK;
}

/* Lights of one group are one layer: their passes are summed before the film sees them. */
static void reference_to_films(PassState *s) {
    cau_render *r = s->r;
    size_t values = picture_values(r);
    if (s->reference.beauty) film_add(&r->beauty, s->reference.beauty);
    for (size_t g = 0; s->reference.direct && g < r->group_count; g++)
        for (int kind = 0; kind < 2; kind++) {
            double **images = kind ? s->reference.indirect : s->reference.direct, *sum = NULL;
            for (size_t i = 0; i < r->scene.light_count; i++) {
                if (r->group_of_light[i] != g || !r->scene.lights[i].casts) continue;
                if (!sum)
                    sum = images[i];
                else
                    for (size_t v = 0; v < values; v++) sum[v] += images[i][v];
            }
            film_add(&r->groups[g].films[kind], sum);
        }
}

static cau_result one_reference_pass(PassState *s, CauError *err) {
    cau_render *r = s->r;
    ReferenceRun run = {.scene = &r->scene,
        .trace = r->trace,
        .filter = &r->filter,
        .casters = &r->casters,
        .physical = r->options.physical_radiance,
        .key = rng_combine(s->key, 0x52u),
        .pass = (uint32_t)r->pass,
        .light_paths = (uint32_t)clamp((double)picture_values(r) / 3, 1024, 1 << 20),
        .x0 = r->region[0],
        .y0 = r->region[1],
        .x1 = r->region[2],
        .y1 = r->region[3],
        .cancel = &r->cancel};
    CAU_TRY(reference_pass(&run, r->pool, &s->reference, err));
    reference_to_films(s);
    return CAU_OK;
}

/* ---- the loop ---- */

static cau_result images_prepare(PassState *s, CauError *err) {
    cau_render *r = s->r;
    size_t values = picture_values(r);
    s->images.radiance = array_new(values, sizeof(double));
    bool ok = s->images.radiance;
    if (r->options.layers & CAU_WANT_IRRADIANCE) {
        s->images.seen = array_new(values, sizeof(double));
        s->images.irradiance = array_new(values, sizeof(double));
        s->images.coverage = array_new(values / 3, sizeof(double));
        ok = ok && s->images.seen && s->images.irradiance && s->images.coverage;
    }
    if (!ok) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for a pass of %zu pixels", values / 3);
    CAU_TRY(kernels_prepare(s, err));
    return waves_prepare(s, err);
}

static void state_free(PassState *s) {
    eye_points_free(&s->points);
    eye_points_free(&s->trial_points);
    eye_points_free(&s->layer_points);
    support_rows_free(&s->supports);
    deposits_free(&s->deposits);
    photon_tree_free(&s->tree);
    free(s->images.radiance);
    kernels_free(s);
    waves_free(s);
    free(s->images.seen);
    free(s->images.irradiance);
    free(s->images.coverage);
    free(s->reference_block);
    free(s->reference.direct);
}

static bool has_learnt(const cau_render *r) {
    for (size_t g = 0; g < r->group_count; g++)
        for (int kind = 0; kind < 2; kind++)
            if ((kind ? r->groups[g].indirect : r->groups[g].direct) && !r->groups[g].kernels[kind].tried)
                return false;
    return true;
}

static bool has_begun(const cau_render *r) {
    for (size_t g = 0; g < r->group_count; g++)
        if (r->groups[g].films[0].passes || r->groups[g].films[1].passes) return true;
    return false;
}

/* A shard without the first pass, or a render that goes on, makes it all the same, for what it teaches. */
static cau_result learn_from_first_pass(PassState *s, CauError *err) {
    cau_render *r = s->r;
    if ((r->options.shard_index < 2 && !has_begun(r)) || has_learnt(r)) return CAU_OK;
    r->pass = 0;
    s->learning = true;
    cau_result result = photon_pass(s, err);
    s->learning = false;
    return result;
}

cau_result render_passes(cau_render *r, CauError *err) {
    CAU_TRY(render_check_joined(r, err));
    if (!render_has_layers(r)) return CAU_OK;
    bool reference = r->options.estimator == CAU_ESTIMATOR_R;
    PassState s = {.r = r, .key = rng_combine(r->options.seed, 0x63617573u)};
    limits_begin(&s);
    if (limits_met_already(&s)) return CAU_OK;
    cau_result result = reference ? reference_prepare(&s, err) : images_prepare(&s, err);
    if (result == CAU_OK && !reference) result = learn_from_first_pass(&s, err);
    uint64_t first = r->options.shard_count ? r->options.shard_index - 1 : 0,
             step = r->options.shard_count ? r->options.shard_count : 1;
    while (result == CAU_OK) {
        r->pass = first + step * r->passes;
        result = reference ? one_reference_pass(&s, err) : photon_pass(&s, err);
        if (result != CAU_OK) break;
        r->passes++;
        bool met = false;
        result = limits_met(&s, &met, err);
        if (met) break;
        render_pause(r);
    }
    state_free(&s);
    return result;
}
