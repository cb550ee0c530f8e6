/* SPDX-License-Identifier: Apache-2.0 */
/* The public face of a render, and its thread. */
#include "render/render_internal.h"

#include "core/checked.h"
#include "core/rng.h"

#include <inttypes.h>
#include <stdio.h>
#include <time.h>

enum { PASS_PHOTONS = 131072, PASSES_MIN = 8 };
/* Wavefronts hold no photons: so many passes tell their error, and of fewer a ball has more of it (1e6 rays
 * in 8, 16 and 32: .33, .27, .20 %; ring .56, .56, .59; water .42, .48, .53). */
enum { PASSES_WAVES = 16 }; /* but not of fewer rays than a round begins with */
/* In a picture of more pixels passes have more photons, up to one a pixel, or most of the time is eye paths;
 * but of a render of so many photons there are this many passes, for edges are smooth by their number. */
enum { PASSES_LARGE = 16 };
/* Of a render that is limited by error or time, whose first passes are small: an eye path to each pixel
 * should not cost more than the photons. Wavefronts hold no photons in memory. */
enum { PASS_LEAST_WAVES = 4096, PASS_LEAST_PHOTONS = 8192, PASS_WAVES = 1 << 22 };
/* Pixels for each of them; an eye path with its kernel takes as long as a photon or two. */
enum { PASS_PIXELS_WAVES = 8, PASS_PIXELS_PHOTONS = 4 };

cau_render_options cau_render_defaults(void) {
    return (cau_render_options){
        .size = sizeof(cau_render_options), .photons = 4000000, .layers = CAU_WANT_RADIANCE};
}

bool render_waves_alone(const cau_render *r) {
    bool wave = false;
    if (r->options.estimator == CAU_ESTIMATOR_R) return false;
    for (size_t i = 0; i < r->plan.light_count; i++) {
        if (r->plan.lights[i].photons || r->plan.lights[i].indirect) return false;
        wave |= r->plan.lights[i].wave;
    }
    return wave;
}

bool render_waves_draw(const cau_render *r, size_t g, int kind) {
    for (size_t i = 0; i < r->scene.light_count; i++)
        if (r->group_of_light[i] == g && !kind && r->plan.lights[i].wave) return true;
    return false;
}

double render_clock_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- creating ---- */

static cau_result set_region(cau_render *r, CauError *err) {
    const int *wanted = r->options.region;
    int w = r->scene.camera.width, h = r->scene.camera.height;
    if (!wanted[0] && !wanted[1] && !wanted[2] && !wanted[3]) {
        memcpy(r->region, (int[4]){0, 0, w, h}, sizeof r->region);
        return CAU_OK;
    }
    if (wanted[0] < 0 || wanted[1] < 0 || wanted[2] > w || wanted[3] > h || wanted[0] >= wanted[2] ||
        wanted[1] >= wanted[3])
        return error_set(err, CAU_ERROR_INPUT,
            "region %d,%d,%d,%d does not lie in the picture of %dx%d pixels", wanted[0], wanted[1], wanted[2],
            wanted[3], w, h);
    memcpy(r->region, wanted, sizeof r->region);
    return CAU_OK;
}

static void group_free(RenderGroup *g) {
    film_free(&g->films[0]);
    film_free(&g->films[1]);
    bandwidth_free(&g->kernels[0]);
    bandwidth_free(&g->kernels[1]);
    free(g->looks);
    g->looks = NULL;
    film_free(g->seen);
    film_free(g->irradiance);
    film_free(g->coverage);
}

static cau_result make_groups(cau_render *r, CauError *err) {
    size_t n = r->scene.light_count;
    r->groups = array_new(n, sizeof *r->groups);
    r->group_of_light = array_new(n, sizeof *r->group_of_light);
    if (!r->groups || !r->group_of_light)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu lights", n);
    for (size_t i = 0; i < n; i++) {
        size_t g = 0;
        while (g < r->group_count && strcmp(r->groups[g].name, r->scene.lights[i].layer) != 0) g++;
        if (g == r->group_count) r->groups[r->group_count++].name = r->scene.lights[i].layer;
        r->group_of_light[i] = g;
    }
    return CAU_OK;
}

/* Shard I of N has the passes I, I + N, ... of the whole render, whose plan, radii and random numbers it
 * shares. */
static cau_result set_share(cau_render *r, CauError *err) {
    uint64_t index = r->options.shard_index, count = r->options.shard_count;
    r->passes_share = r->passes_wanted;
    if (!count) return CAU_OK;
    if (count > r->passes_wanted)
        return error_set(err, CAU_ERROR_USAGE,
            "shard %" PRIu64 " of %" PRIu64 ": the render has %" PRIu64
            " passes, so it can be cut into that many shards at most; use fewer, or more photons",
            index, count, r->passes_wanted);
    r->passes_share = (r->passes_wanted - index) / count + 1;
    return CAU_OK;
}

double render_pixel_count(const cau_render *r) {
    return (double)(r->region[2] - r->region[0]) * (r->region[3] - r->region[1]);
}

double render_pass_least(const cau_render *r, bool waves) {
    int least = waves ? PASS_LEAST_WAVES : PASS_LEAST_PHOTONS;
    return fmax(render_pixel_count(r) / (waves ? PASS_PIXELS_WAVES : PASS_PIXELS_PHOTONS), least);
}

/* A limit of photons leaves as many passes as one alone would have. */
static void set_round_sizes(cau_render *r, double most) {
    double n = r->options.photons ? (double)r->options.photons : INFINITY;
    double largest = look_pass_most(r, render_waves_alone(r) ? PASS_WAVES : most);
    double least = fmin(fmin(render_pass_least(r, r->view != NULL), most), n / PASSES_MIN);
    r->pass_least = (uint32_t)fmax(least, 1);
    r->pass_most = (uint32_t)fmax(fmin(largest, n / PASSES_LARGE), r->pass_least);
}

static void set_budget(cau_render *r) {
    uint64_t n = r->options.photons;
    size_t memory = r->options.memory_bytes ? r->options.memory_bytes : (size_t)2 << 30;
    /* A deposit costs about 100 bytes with its sorted copy and keys; a photon leaves a few. An eighth of the
     * budget is theirs. */
    uint64_t most = memory / 8 / 500;
    double pixels = render_pixel_count(r);
    double large = n && !render_has_rounds(r) ? fmin(pixels, (double)n / PASSES_LARGE) : pixels;
    most = (uint64_t)fmin((double)most, fmax(PASS_PHOTONS, large));
    if (most < 1024) most = 1024;
    if (r->options.estimator == CAU_ESTIMATOR_R)
        most = (uint64_t)r->scene.camera.width * (uint64_t)r->scene.camera.height;
    r->photons_per_pass = r->pass_least = r->pass_most = r->photons_held = (uint32_t)most;
    if (render_has_rounds(r)) set_round_sizes(r, (double)most);
    if (n == 0 || render_has_rounds(r)) return;
    uint64_t least = r->view && n >= PASSES_WAVES * PASS_LEAST_WAVES ? PASSES_WAVES : PASSES_MIN;
    if (render_waves_alone(r)) most = n / least + 1;
    most = (uint64_t)look_pass_most(r, (double)most);
    if (most > UINT32_MAX / 2) most = UINT32_MAX / 2;
    uint64_t passes = (n + most - 1) / most;
    if (passes < least && n >= least) passes = least;
    if (r->options.estimator != CAU_ESTIMATOR_R) r->photons_per_pass = (uint32_t)((n + passes - 1) / passes);
    r->passes_wanted = passes;
}

/* Smooth casters, which estimator W can follow. */
static cau_result find_waved(cau_render *r, CauError *err) {
    r->waved = array_new(r->scene.object_count, sizeof *r->waved);
    if (!r->waved) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for a plan");
    for (size_t o = 0; o < r->scene.object_count; o++) {
        const Object *object = &r->scene.objects[o];
        r->waved[o] = object->casts && (r->scene.materials[object->material].lobes & LOBE_SPECULAR);
    }
    return CAU_OK;
}

static cau_result warn_of_contacts(cau_render *r, CauError *err) {
    for (size_t i = 0; i < r->scene.object_count; i++) {
        int on = trace_lies_on(r->trace, (int)i);
        if (on >= 0)
            CAU_TRY(scene_warn(&r->scene, err,
                "object \"%s\" lies in the plane of \"%s\": as in Cycles, no light gets between the two; "
                "lift it by a "
                "millimetre if it should",
                r->scene.objects[i].name, r->scene.objects[on].name));
    }
    return CAU_OK;
}

/* Lamps whose extent is small are hard to find in bent mirrors; the world is all around. */
static void make_guide(void *data, size_t index, unsigned thread) {
    (void)thread;
    cau_render *r = data;
    const Light *l = &r->scene.lights[index];
    if (!l->casts || l->delta || strcmp(l->kind->name, "world") == 0) return;
    BentRun run = {.set = &r->bent,
        .scene = &r->scene,
        .trace = r->trace,
        .light = l,
        .key = rng_combine(rng_combine(r->options.seed, 0x6775696465u), l->stream)};
    bent_guide_create(&r->guides[index], &run, &r->casters);
}

static cau_result make_guides(cau_render *r, CauError *err) {
    if (!r->bent.mirrors) return CAU_OK;
    r->guides = array_new(r->scene.light_count, sizeof *r->guides);
    if (!r->guides)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu lights", r->scene.light_count);
    tasks_run(r->pool, r->scene.light_count, make_guide, r);
    for (size_t i = 0; i < r->scene.light_count; i++)
        if (r->guides[i].out_of_memory)
            return error_set(err, CAU_ERROR_RESOURCE,
                "out of memory for light of \"%s\" that grazes %zu triangles", r->scene.lights[i].name,
                r->bent.mirror_count);
    return CAU_OK;
}

static cau_result render_prepare(cau_render *r, CauError *err) {
    CAU_TRY(scene_normalise(r->source, r->options.width, r->options.height, &r->scene, err));
    CAU_TRY(set_region(r, err));
    CAU_TRY(tasks_create(&r->pool, r->options.threads, err));
    CAU_TRY(trace_create(&r->trace, &r->scene, err));
    CAU_TRY(warn_of_contacts(r, err));
    CAU_TRY(aim_create(&r->casters, &r->scene, AIM_CASTERS, err));
    CAU_TRY(aim_create(&r->surfaces, &r->scene, AIM_SURFACES, err));
    if (r->options.estimator != CAU_ESTIMATOR_R) CAU_TRY(bent_create(&r->bent, &r->scene, err));
    CAU_TRY(make_guides(r, err));
    filter_prepare(&r->filter, r->scene.camera.filter, r->scene.camera.filter_width);
    CAU_TRY(find_waved(r, err));
    return make_groups(r, err);
}

/* A caller built against an older header has a shorter structure: what it lacks is as by default. A longer
 * one says what this library does not know. */
static cau_result take_options(const cau_render_options *given, cau_render_options *o, CauError *err) {
    *o = cau_render_defaults();
    if (!given || given->size < offsetof(cau_render_options, estimator) || given->size > sizeof *o)
        return error_set(
            err, CAU_ERROR_USAGE, "render options of an unknown size; fill them with cau_render_defaults()");
    memcpy(o, given, given->size);
    o->size = sizeof *o;
    if (!(o->time_s >= 0) || !(o->error >= 0) || !isfinite(o->time_s) || !isfinite(o->error))
        return error_set(err, CAU_ERROR_USAGE, "time and error limits must be finite and not negative");
    bool whole = o->shard_count == 0 && o->shard_index == 0;
    if (!whole && (o->shard_index < 1 || o->shard_index > o->shard_count || o->shard_count > CAU_SHARDS_MAX))
        return error_set(err, CAU_ERROR_USAGE,
            "shard %u of %u: it must be I of N, with I from 1 to N, N up to %d", o->shard_index,
            o->shard_count, CAU_SHARDS_MAX);
    if (!whole && (o->time_s > 0 || o->error > 0 || !o->photons))
        return error_set(err, CAU_ERROR_USAGE,
            "a shard is a share of a known number of photons; limit it by photons alone, not by time or "
            "error");
    if ((o->layers & CAU_WANT_BEAUTY) && o->estimator != CAU_ESTIMATOR_R)
        return error_set(
            err, CAU_ERROR_USAGE, "the beauty layer is estimator R's alone; ask for that estimator");
    if ((o->layers & CAU_WANT_IRRADIANCE) && o->estimator == CAU_ESTIMATOR_R)
        return error_set(
            err, CAU_ERROR_UNSUPPORTED, "not yet supported: irradiance layers with estimator R; use P");
    return CAU_OK;
}

cau_result cau_render_create(cau_scene *scene, const cau_render_options *options, cau_render **out) {
    *out = NULL;
    CauError *err = &scene->context->error;
    cau_render_options taken;
    CAU_TRY(take_options(options, &taken, err));
    cau_render *r = array_new(1, sizeof *r);
    if (!r) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for a render");
    r->source = scene;
    r->options = taken;
    if (taken.layers & CAU_WANT_INDIRECT) r->options.indirect = CAU_INDIRECT_ON;
    r->progress = (cau_progress){.error = -1, .remaining_s = -1, .stage = "probing"};
    pthread_mutex_init(&r->mutex, NULL);
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(&r->ended, &attributes);
    pthread_condattr_destroy(&attributes);
    cau_result result = render_prepare(r, err);
    if (result != CAU_OK)
        cau_render_destroy(&r);
    else
        *out = r;
    return result;
}

void cau_render_destroy(cau_render **render) {
    cau_render *r = *render;
    if (!r) return;
    if (r->running) {
        cau_render_cancel(r);
        pthread_join(r->thread, NULL);
    }
    for (size_t g = 0; g < r->group_count; g++) group_free(&r->groups[g]);
    film_free(&r->beauty);
    free(r->groups);
    free(r->group_of_light);
    wave_view_free(&r->view);
    free(r->waved);
    free(r->joined);
    plan_free(&r->plan);
    aim_free(&r->casters);
    aim_free(&r->surfaces);
    for (size_t i = 0; r->guides && i < r->scene.light_count; i++) bent_guide_free(&r->guides[i]);
    free(r->guides);
    bent_free(&r->bent);
    trace_destroy(&r->trace);
    tasks_destroy(&r->pool);
    scene_free(&r->scene);
    pthread_mutex_destroy(&r->mutex);
    pthread_cond_destroy(&r->ended);
    free(r);
    *render = NULL;
}

/* ---- running ---- */

static cau_result make_films(cau_render *r, CauError *err) {
    size_t pixels = (size_t)r->scene.camera.width * (size_t)r->scene.camera.height;
    bool reference = r->options.estimator == CAU_ESTIMATOR_R;
    if (r->options.layers & CAU_WANT_BEAUTY) CAU_TRY(film_create(&r->beauty, pixels, 3, err));
    for (size_t i = 0; i < r->scene.light_count; i++) {
        RenderGroup *g = &r->groups[r->group_of_light[i]];
        bool wanted = reference && render_wants_caustics(r);
        g->direct |= reference ? wanted : r->plan.lights[i].direct;
        g->indirect |=
            reference ? wanted && r->options.indirect != CAU_INDIRECT_OFF : r->plan.lights[i].indirect;
    }
    for (size_t i = 0; i < r->group_count; i++) {
        RenderGroup *g = &r->groups[i];
        bool irradiance = r->options.layers & CAU_WANT_IRRADIANCE;
        if (g->direct || reference) CAU_TRY(film_create(&g->films[0], pixels, 3, err));
        if (g->indirect || reference) CAU_TRY(film_create(&g->films[1], pixels, 3, err));
        if (!g->direct || !irradiance) continue;
        CAU_TRY(film_create(g->seen, pixels, 3, err));
        CAU_TRY(film_create(g->irradiance, pixels, 3, err));
        CAU_TRY(film_create(g->coverage, pixels, 1, err));
    }
    return reference ? CAU_OK : render_make_kernels(r, err);
}

/* Estimator W's passes are parts of one sequence of places on the light and of eye paths. The first half is
 * that of the whole render, of which a shard has its part. */
static cau_result make_halves(cau_render *r, CauError *err) {
    if (r->options.estimator == CAU_ESTIMATOR_R) return CAU_OK;
    uint64_t index = r->options.shard_index, count = r->options.shard_count, half = r->passes_wanted / 2;
    if (!r->passes_wanted) half = FILM_DOUBLING;
    if (count) half = half < index ? 0 : (half - index) / count + 1;
    for (size_t i = 0; i < r->scene.light_count; i++) {
        Film *film = &r->groups[r->group_of_light[i]].films[0];
        if (r->plan.lights[i].wave && film->sum && !film->first) CAU_TRY(film_halve(film, half, err));
    }
    return CAU_OK;
}

/* What estimator W needs, when any light calls for it. */
static cau_result make_view(cau_render *r, CauError *err) {
    bool wave = false;
    for (size_t i = 0; i < r->plan.light_count; i++) wave |= r->plan.lights[i].wave;
    if (!wave || r->options.estimator == CAU_ESTIMATOR_R) return CAU_OK;
    size_t memory = r->options.memory_bytes ? r->options.memory_bytes : (size_t)2 << 30;
    WaveViewRun run = {.scene = &r->scene,
        .trace = r->trace,
        .filter = &r->filter,
        .x0 = r->region[0],
        .y0 = r->region[1],
        .x1 = r->region[2],
        .y1 = r->region[3],
        .memory_bytes = memory / 4,
        .cancel = &r->cancel};
    return wave_view_create(&r->view, &run, r->pool, err);
}

cau_result render_equip(cau_render *r, CauError *err) {
    for (size_t g = 0; g < r->group_count; g++) group_free(&r->groups[g]);
    film_free(&r->beauty);
    wave_view_free(&r->view);
    CAU_TRY(make_films(r, err));
    CAU_TRY(make_view(r, err));
    set_budget(r);
    CAU_TRY(set_share(r, err));
    return make_halves(r, err);
}

cau_result cau_render_plan(cau_render *r) {
    if (r->planned) return CAU_OK;
    CAU_TRY(render_probe(r, &r->error));
    CAU_TRY(render_equip(r, &r->error));
    r->planned = true;
    return CAU_OK;
}

const char *cau_render_explain(const cau_render *r) { return r->plan.text ? r->plan.text : ""; }

void render_report(cau_render *r, const char *stage, double error, double remaining_s) {
    pthread_mutex_lock(&r->mutex);
    r->progress.stage = stage;
    r->progress.error = error;
    r->progress.passes = r->passes;
    r->progress.photons_per_light = r->passes * r->photons_per_pass;
    r->progress.elapsed_s = render_clock_s() - r->started_s;
    r->progress.remaining_s = remaining_s;
    pthread_mutex_unlock(&r->mutex);
}

static void *render_main_thread(void *argument) {
    cau_render *r = argument;
    cau_result result = cau_render_plan(r);
    if (result == CAU_OK) {
        render_report(r, "rendering", -1, -1);
        result = render_passes(r, &r->error);
    }
    render_report(r, "done", render_total_error(r), 0);
    pthread_mutex_lock(&r->mutex);
    r->result = result;
    r->has_ended = true;
    pthread_cond_broadcast(&r->ended);
    pthread_mutex_unlock(&r->mutex);
    return NULL;
}

cau_result cau_render_start(cau_render *r) {
    if (r->running || r->has_ended)
        return error_set(
            &r->source->context->error, CAU_ERROR_USAGE, "a render is started once; create another");
    r->started_s = render_clock_s();
    if (pthread_create(&r->thread, NULL, render_main_thread, r) != 0)
        return error_set(
            &r->source->context->error, CAU_ERROR_RESOURCE, "the system refused to start a thread");
    r->running = true;
    return CAU_OK;
}

cau_progress cau_render_poll(cau_render *r) {
    pthread_mutex_lock(&r->mutex);
    cau_progress p = r->progress;
    bool under_way = r->running && !r->has_ended;
    pthread_mutex_unlock(&r->mutex);
    if (!under_way) return p;
    double since = render_clock_s() - r->started_s - p.elapsed_s; /* a pass may take long */
    p.elapsed_s += since;
    if (p.remaining_s > 0) p.remaining_s = fmax(p.remaining_s - since, 0);
    return p;
}

void cau_render_cancel(cau_render *r) { atomic_store(&r->cancel, true); }

static bool wait_some(cau_render *r, double interval_s) {
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    double s = (double)until.tv_nsec * 1e-9 + interval_s;
    until.tv_sec += (time_t)s;
    until.tv_nsec = (long)((s - floor(s)) * 1e9);
    pthread_mutex_lock(&r->mutex);
    if (!r->has_ended) pthread_cond_timedwait(&r->ended, &r->mutex, &until);
    bool ended = r->has_ended;
    pthread_mutex_unlock(&r->mutex);
    return ended;
}

cau_result cau_render_wait(
    cau_render *r, double interval_s, void (*report)(void *data, const cau_progress *progress), void *data) {
    if (!r->running)
        return error_set(&r->source->context->error, CAU_ERROR_USAGE, "the render was not started");
    for (bool ended = false; !ended;) {
        ended = wait_some(r, interval_s > 0.01 ? interval_s : 0.01);
        cau_progress p = cau_render_poll(r);
        if (report) report(data, &p);
    }
    pthread_join(r->thread, NULL);
    r->running = false;
    if (r->result != CAU_OK && r->result != CAU_ERROR_CANCELLED)
        error_set(&r->source->context->error, r->result, "%s", r->error.text);
    return r->result;
}
