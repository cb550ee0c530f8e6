/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gather/reference.h"

#include "core/rng.h"

#include <string.h>

enum { REFERENCE_DEPTH_MAX = 1000, REFERENCE_ROULETTE_DEPTH = 6 };

#define REFERENCE_ROULETTE_THROUGHPUT 0.2

typedef struct RefWalk {
    const ReferenceRun *run;
    const ReferenceImages *out;
    size_t pixel;
    PathNumbers numbers;
    Ray ray;
    V3 from;          /* where the ray was scattered last: lights are seen from there */
    double travelled; /* from `from` to the start of the ray (straight through transparents) */
    double density;   /* with which the ray's direction was drawn; 0: specular or camera */
    Rgb throughput;
    Chain chain;
    int depth;
    bool scattered;
    bool at_once; /* the eye meets a surface that is not specular first */
} RefWalk;

static void contribute(RefWalk *w, const Chain *chain, size_t light, Rgb value) {
    double *image = reference_image(w->out, chain_owner(chain), light);
    if (!image || !rgb_finite(value)) return;
    double s = w->run->scene->camera.exposure;
    image[3 * w->pixel] += value.r * s;
    image[3 * w->pixel + 1] += value.g * s;
    image[3 * w->pixel + 2] += value.b * s;
}

/* Lights that the ray meets before `t_hit`. Lamps never block, and the camera sees the world only. */
static void meet_lights(RefWalk *w, double t_hit) {
    const Scene *scene = w->run->scene;
    for (size_t i = 0; i < scene->light_count; i++) {
        const Light *l = &scene->lights[i];
        if (l->delta || !l->kind->hit) continue;
        if (!w->scattered && strcmp(l->kind->name, "world") != 0) continue;
        if (w->at_once && w->density == 0 && reference_from_light(w->run, l)) continue;
        LightSample s;
        if (!l->kind->hit(l, w->from, w->ray.dir, &s)) continue;
        if (isfinite(t_hit) && s.distance >= w->travelled + t_hit) continue;
        double weight = w->density > 0 ? w->density / (w->density + s.pdf) : 1;
        contribute(w, &w->chain, i, rgb_scale(rgb_mul(w->throughput, s.value), weight));
    }
}

/* Numbers of one light's own stream, so that its layer does not depend on the other lights. */
static void light_numbers(const RefWalk *w, const Light *l, unsigned lobe, double *u, double *v) {
    uint64_t key =
        rng_combine(rng_combine(w->numbers.key, l->stream), 64 * (uint64_t)w->numbers.depth + lobe);
    *u = sobol_owen(w->numbers.index, 0, key);
    *v = sobol_owen(w->numbers.index, 1, key);
}

/* Next-event estimation through one kind of lobe. `choice` is the probability with which sampling takes it.
 */
static void connect(RefWalk *w, const Hit *hit, const ShadingFrame *f, V3 wi, unsigned lobe, double choice) {
    const Scene *scene = w->run->scene;
    const Material *m = hit->material;
    for (size_t i = 0; i < scene->light_count; i++) {
        const Light *l = &scene->lights[i];
        LightSample s;
        double u, v, pdf = 0;
        light_numbers(w, l, lobe, &u, &v);
        if (!l->kind->sample(l, hit->position, u, v, &s) || !(s.pdf > 0)) continue;
        Rgb scatter = m->kind->eval(m, f, wi, s.dir, lobe, &pdf);
        if (rgb_black(scatter)) continue;
        Ray ray = ray_from_hit(hit, s.dir, s.distance * (1 - 1e-9), VISIBLE_SHADOW);
        Rgb through = trace_transmittance(w->run->trace, &ray);
        if (rgb_black(through)) continue;
        double weight = l->delta || !l->kind->hit ? 1 : s.pdf / (s.pdf + choice * pdf);
        Rgb value = rgb_mul(rgb_mul(w->throughput, scatter), rgb_mul(s.value, through));
        Chain chain = w->chain;
        /* Reflected or transmitted makes no difference to the owner, and no limit applies next to the light.
         */
        chain_add_from_eye(&chain, lobe, false);
        contribute(w, &chain, i, rgb_scale(value, weight / s.pdf));
    }
}

static bool go_on(RefWalk *w, const Hit *hit, const ShadingFrame *f, V3 wi, unsigned lobes, double choice) {
    const Material *m = hit->material;
    double u[3];
    for (int k = 2; k >= 0; k--) u[k] = path_number(&w->numbers);
    path_numbers_next(&w->numbers);
    ScatterSample s;
    if (!lobes || !m->kind->sample(m, f, wi, u, lobes, false, &s)) return false;
    w->throughput = rgb_scale(rgb_mul(w->throughput, s.weight), 1 / choice);
    if (!rgb_finite(w->throughput) || rgb_black(w->throughput)) return false;
    if (s.lobe == LOBE_TRANSPARENT) {
        w->travelled += hit->t;
        w->ray = ray_from_hit(hit, s.wo, INFINITY, w->ray.visibility);
        return true;
    }
    if (w->run->physical) w->throughput = rgb_scale(w->throughput, 1 / square(s.eta));
    chain_add_from_eye(&w->chain, s.lobe, s.transmit);
    if (!w->scattered) w->at_once = s.lobe != LOBE_SPECULAR;
    w->scattered = true;
    w->from = hit->position;
    w->travelled = 0;
    w->density = s.lobe == LOBE_SPECULAR ? 0 : choice * s.pdf;
    w->ray = ray_from_hit(hit, s.wo, INFINITY, visibility_after(s.lobe, s.transmit));
    return true;
}

static bool ref_surface(RefWalk *w, const Hit *hit) {
    V3 wi = v3_neg(w->ray.dir);
    ShadingFrame f = frame_from_hit(hit, wi);
    unsigned lobes = hit->material->lobes;
    const Object *o = &w->run->scene->objects[hit->object];
    /* Cycles makes no casting closure after a diffuse one; then only the beauty is wanted. An object told not
     * to cast makes none either. */
    if (w->chain.cast && (!w->out->direct || !o->casts)) lobes &= ~(unsigned)LOBE_CASTING;
    unsigned casting = lobes & (LOBE_CASTING | LOBE_TRANSPARENT), diffuse = lobes & LOBE_DIFFUSE;
    double choice = casting && diffuse ? 0.5 : 1;
    if (diffuse) connect(w, hit, &f, wi, LOBE_DIFFUSE, choice);
    if (lobes & LOBE_GLOSSY) connect(w, hit, &f, wi, LOBE_GLOSSY, choice);
    if (casting && diffuse) lobes = rng_next(&w->numbers.rng) < 0.5 ? casting : diffuse;
    return go_on(w, hit, &f, wi, lobes, choice);
}

static bool ref_roulette(RefWalk *w) {
    if (w->depth < REFERENCE_ROULETTE_DEPTH) return true;
    double keep = rgb_max(w->throughput) / REFERENCE_ROULETTE_THROUGHPUT;
    if (keep >= 1) return true;
    if (rng_next(&w->numbers.rng) >= keep) return false;
    w->throughput = rgb_scale(w->throughput, 1 / keep);
    return true;
}

static void ref_pixel(const ReferenceRun *run, const ReferenceImages *out, int x, int y) {
    const Camera *camera = &run->scene->camera;
    size_t pixel = (size_t)y * (size_t)camera->width + (size_t)x;
    uint64_t key = rng_combine(run->key, pixel);
    RefWalk w = {.run = run,
        .out = out,
        .pixel = pixel,
        .numbers = path_numbers(key, run->pass),
        .throughput = rgb_grey(1)};
    double fx = filter_sample(run->filter, sobol_owen(run->pass, 0, key));
    double fy = filter_sample(run->filter, sobol_owen(run->pass, 1, key));
    w.ray = camera_ray(camera, x + 0.5 + fx, y + 0.5 + fy);
    w.from = w.ray.origin;
    for (w.depth = 0; w.depth < REFERENCE_DEPTH_MAX; w.depth++) {
        Hit hit;
        bool found = trace_nearest(run->trace, &w.ray, &hit);
        meet_lights(&w, found ? hit.t : INFINITY);
        if (!found ||
            !bounces_allow(&run->scene->bounces, w.chain.diffuse, w.chain.glossy, w.chain.transmission))
            return;
        if (!ref_surface(&w, &hit) || !ref_roulette(&w)) return;
    }
}

static void clear_region_row(double *image, size_t y, size_t width) {
    if (image) memset(image + 3 * y * width, 0, 3 * width * sizeof(double));
}

static void ref_row(void *data, size_t index, unsigned thread) {
    (void)thread;
    const ReferenceRun *run = ((void **)data)[0];
    const ReferenceImages *out = ((void **)data)[1];
    size_t y = (size_t)run->y0 + index, width = (size_t)run->scene->camera.width;
    clear_region_row(out->beauty, y, width);
    for (size_t i = 0; i < run->scene->light_count; i++) {
        if (out->cycles) clear_region_row(out->cycles[i], y, width);
        if (!out->direct) continue;
        clear_region_row(out->direct[i], y, width);
        clear_region_row(out->indirect[i], y, width);
    }
    if (run->cancel && atomic_load_explicit(run->cancel, memory_order_relaxed)) return;
    for (int x = run->x0; x < run->x1; x++) ref_pixel(run, out, x, (int)y);
}

cau_result reference_pass(
    const ReferenceRun *run, TaskPool *pool, const ReferenceImages *out, CauError *err) {
    void *data[2] = {(void *)run, (void *)out};
    tasks_run(pool, (size_t)(run->y1 - run->y0), ref_row, data);
    if (run->cancel && atomic_load(run->cancel)) return CAU_ERROR_CANCELLED;
    return reference_light_paths(run, pool, out, err);
}
