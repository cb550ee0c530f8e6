/* SPDX-License-Identifier: Apache-2.0 */
#include "render/trace/eye.h"

#include "core/checked.h"
#include "core/rng.h"
#include "render/trace/photons.h"

enum { EYE_DEPTH_MAX = 256, EYE_ROULETTE_DEPTH = 2 };

/* Below this throughput an eye path plays roulette: a plastic coat (4 %) is followed one time in six. */
#define EYE_ROULETTE_THROUGHPUT 0.25

typedef struct EyeWalk {
    const EyeRun *run;
    struct EyeRow *row;
    uint32_t pixel;
    PathNumbers numbers;
    Ray ray;
    Rgb throughput;
    Chain chain;
    double distance;
    uint32_t samples; /* of this pixel */
    bool straight;
} EyeWalk;

static void add_point(EyeWalk *w, const Hit *hit, const ShadingFrame *frame, V3 wi, Rgb albedo) {
    struct EyeRow *row = w->row;
    if (!array_reserve((void **)&row->items, &row->capacity, row->count + 1, sizeof *row->items)) {
        row->out_of_memory = true;
        return;
    }
    const Camera *camera = &w->run->scene->camera;
    Rgb weight = rgb_scale(rgb_mul(w->throughput, albedo), camera->exposure / CAU_PI);
    /* A slanted pixel covers more: the mean of its two edges. */
    double cosine = fmax(fabs(v3_dot(wi, frame->ng)), 0.05);
    EyePoint *point = &row->items[row->count++];
    *point = (EyePoint){.position = hit->position,
        .ng = {(float)frame->ng.x, (float)frame->ng.y, (float)frame->ng.z},
        .weight = {(float)weight.r, (float)weight.g, (float)weight.b},
        .size = (float)(camera_pixel_size(camera, w->distance) / sqrt(cosine)),
        .share = (float)(1.0 / w->samples),
        .turn = (float)rng_next(&w->numbers.rng),
        .pixel = w->pixel,
        .object = hit->object,
        .primitive = hit->primitive,
        .glossy = (uint8_t)(w->chain.glossy < 255 ? w->chain.glossy : 255),
        .transmission = (uint8_t)(w->chain.transmission < 255 ? w->chain.transmission : 255),
        .straight = w->straight};
    normal_encode(wi, point->from);
}

/* One surface; false ends the walk. */
static bool eye_surface(EyeWalk *w, const Hit *hit) {
    V3 wi = v3_neg(w->ray.dir);
    ShadingFrame frame = frame_from_hit(hit, wi);
    const Material *m = hit->material;
    const Object *o = &w->run->scene->objects[hit->object];
    if ((m->lobes & LOBE_DIFFUSE) && o->receives) {
        Rgb albedo = m->kind->albedo(m, &frame, wi);
        if (!rgb_black(albedo)) add_point(w, hit, &frame, wi, albedo);
    }
    unsigned lobes = m->lobes & (LOBE_CASTING | LOBE_TRANSPARENT);
    double u[3];
    ScatterSample s;
    for (int k = 2; k >= 0; k--)
        u[k] = path_number(&w->numbers); /* the choice of lobe gets the best dimension */
    if (!lobes || !m->kind->sample(m, &frame, wi, u, lobes, false, &s)) return false;
    w->throughput = rgb_mul(w->throughput, s.weight);
    if (!rgb_finite(w->throughput) || rgb_black(w->throughput)) return false;
    unsigned visibility = w->ray.visibility;
    if (s.lobe != LOBE_TRANSPARENT) {
        if (w->run->physical) w->throughput = rgb_scale(w->throughput, 1 / square(s.eta));
        chain_add_from_eye(&w->chain, s.lobe, s.transmit);
        visibility = visibility_after(s.lobe, s.transmit);
        w->straight = false;
    }
    w->ray = ray_from_hit(hit, s.wo, INFINITY, visibility);
    const BounceParams *b = &w->run->scene->bounces;
    return bounces_allow(b, w->chain.diffuse, w->chain.glossy, w->chain.transmission);
}

static bool eye_roulette(EyeWalk *w, int depth) {
    double keep = rgb_max(w->throughput) * w->samples / EYE_ROULETTE_THROUGHPUT;
    if (keep >= 1 || (depth < EYE_ROULETTE_DEPTH && keep > 0.5)) return true;
    if (rng_next(&w->numbers.rng) >= keep) return false;
    w->throughput = rgb_scale(w->throughput, 1 / keep);
    return true;
}

static void walk_pixel(
    const EyeRun *run, struct EyeRow *row, int x, int y, uint32_t samples, uint32_t index) {
    uint32_t pixel = (uint32_t)y * (uint32_t)run->scene->camera.width + (uint32_t)x;
    uint64_t key = rng_combine(run->key, pixel);
    EyeWalk w = {.run = run,
        .row = row,
        .pixel = pixel,
        .numbers = path_numbers(key, index),
        .throughput = rgb_grey(1.0 / samples),
        .samples = samples,
        .straight = true};
    double fx = filter_sample(run->filter, sobol_owen(index, 0, key));
    double fy = filter_sample(run->filter, sobol_owen(index, 1, key));
    w.ray = camera_ray(&run->scene->camera, x + 0.5 + fx, y + 0.5 + fy);
    for (int depth = 0; depth < EYE_DEPTH_MAX; depth++) {
        Hit hit;
        if (!trace_nearest(run->trace, &w.ray, &hit)) return;
        w.distance += hit.t;
        if (!eye_surface(&w, &hit) || !eye_roulette(&w, depth)) return;
        path_numbers_next(&w.numbers);
    }
}

/* The points of a pixel from another run's row, in which those before `next` are of pixels on the left.
 * Returns where the next pixels' begin. */
static size_t copy_pixel(const EyePoints *from, struct EyeRow *row, int x, int y, size_t width, size_t next) {
    const struct EyeRow *source = &from->rows[y];
    uint32_t pixel = (uint32_t)((size_t)y * width + (size_t)x);
    while (next < source->count && source->items[next].pixel < pixel) next++;
    size_t first = next;
    while (next < source->count && source->items[next].pixel == pixel) next++;
    if (!array_reserve((void **)&row->items, &row->capacity, row->count + next - first, sizeof *row->items)) {
        row->out_of_memory = true;
        return next;
    }
    if (next > first)
        memcpy(row->items + row->count, source->items + first, (next - first) * sizeof *row->items);
    row->count += next - first;
    return next;
}

static void walk_row(void *data, size_t index, unsigned thread) {
    (void)thread;
    const EyeRun *run = ((void **)data)[0];
    EyePoints *out = ((void **)data)[1];
    int y = run->y0 + (int)index;
    struct EyeRow *row = &out->rows[y];
    size_t width = (size_t)run->scene->camera.width, copied = 0;
    row->count = 0;
    if (run->cancel && atomic_load_explicit(run->cancel, memory_order_relaxed)) return;
    for (int x = run->x0; x < run->x1; x++) {
        size_t pixel = (size_t)y * width + (size_t)x;
        uint32_t samples = run->busy && run->busy[pixel] ? run->samples_busy : run->samples;
        if (run->at_least && (samples == 0 || run->at_least[pixel] <= samples)) {
            copied = copy_pixel(run->base, row, x, y, width, copied);
            continue;
        }
        if (run->at_least) samples = run->at_least[pixel];
        for (uint32_t k = 0; k < samples; k++) walk_pixel(run, row, x, y, samples, run->pass * samples + k);
    }
}

cau_result eye_trace(const EyeRun *run, TaskPool *pool, EyePoints *out, CauError *err) {
    int height = run->scene->camera.height;
    if (!out->rows) {
        out->rows = array_new((size_t)height, sizeof *out->rows);
        if (!out->rows)
            return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %d rows of eye points", height);
        out->height = height;
    }
    void *data[2] = {(void *)run, out};
    tasks_run(pool, (size_t)(run->y1 - run->y0), walk_row, data);
    if (run->cancel && atomic_load(run->cancel)) return CAU_ERROR_CANCELLED;
    for (int y = run->y0; y < run->y1; y++)
        if (out->rows[y].out_of_memory)
            return error_set(err, CAU_ERROR_RESOURCE, "out of memory for eye points");
    return CAU_OK;
}

void eye_points_free(EyePoints *points) {
    for (int y = 0; y < points->height; y++) free(points->rows[y].items);
    free(points->rows);
    *points = (EyePoints){0};
}
