/* SPDX-License-Identifier: Apache-2.0 */
/* Light tracing into pixels: paths of lights without extent, and of narrow suns, that begin with a specular
 * surface. */
#include "render/gather/reference.h"

#include "core/checked.h"
#include "core/rng.h"

enum { LIGHT_BATCH = 1024, LIGHT_DEPTH_MAX = 1000, LIGHT_ROULETTE_DEPTH = 4 };

#define LIGHT_ROULETTE_SHARE 0.1
/* A sun that fills less of the sky (steradians) is narrow: one of 11 degrees. */
#define NARROW 0.03

typedef struct Splat {
    uint32_t pixel;
    PathOwner owner;
    Rgb value;
} Splat;

typedef struct SplatBatch {
    Splat *items;
    size_t count, capacity;
    bool out_of_memory;
} SplatBatch;

typedef struct LightWalk {
    const ReferenceRun *run;
    SplatBatch *batch;
    PathNumbers numbers;
    Ray ray;
    Rgb flux; /* shading corrections and Cycles' index factor included */
    double emitted;
    Chain chain, first;
    unsigned left_visible;
} LightWalk;

static void splat(LightWalk *w, const CameraView *view, PathOwner owner, Rgb value) {
    const ReferenceRun *run = w->run;
    double reach = run->filter->half_width;
    int x0 = (int)fmax(floor(view->x - 0.5 - reach), run->x0),
        x1 = (int)fmin(ceil(view->x - 0.5 + reach), run->x1 - 1);
    int y0 = (int)fmax(floor(view->y - 0.5 - reach), run->y0),
        y1 = (int)fmin(ceil(view->y - 0.5 + reach), run->y1 - 1);
    for (int y = y0; y <= y1; y++)
        for (int x = x0; x <= x1; x++) {
            double f = filter_value(run->filter, view->x - (x + 0.5)) *
                       filter_value(run->filter, view->y - (y + 0.5));
            if (f <= 0) continue;
            SplatBatch *b = w->batch;
            if (!array_reserve((void **)&b->items, &b->capacity, b->count + 1, sizeof *b->items)) {
                b->out_of_memory = true;
                return;
            }
            b->items[b->count++] = (Splat){
                (uint32_t)y * (uint32_t)run->scene->camera.width + (uint32_t)x, owner, rgb_scale(value, f)};
        }
}

/* The photon as seen by the camera through one kind of lobe. */
static void connect_camera(LightWalk *w, const Hit *hit, unsigned lobe) {
    const Scene *scene = w->run->scene;
    Chain chain = w->chain;
    chain_add_from_light(&chain, lobe, false);
    CameraView view;
    if (!camera_project(&scene->camera, hit->position, &view)) return;
    V3 to_light = v3_neg(w->ray.dir);
    ShadingFrame f = frame_from_hit(hit, view.to_camera);
    double pdf, facing_light = fabs(v3_dot(to_light, f.ng)), facing_eye = v3_dot(view.to_camera, f.ng);
    if (!(facing_light > 0) || !(facing_eye > 0)) return;
    Rgb scatter = hit->material->kind->eval(hit->material, &f, view.to_camera, to_light, lobe, &pdf);
    if (rgb_black(scatter)) return;
    Chain counted = chain;
    bool transmit = v3_dot(to_light, f.ng) < 0;
    if (transmit && lobe == LOBE_GLOSSY) {
        counted.glossy--;
        counted.transmission++;
    }
    if (!bounces_allow(&scene->bounces, counted.diffuse - w->first.diffuse, counted.glossy - w->first.glossy,
            counted.transmission - w->first.transmission))
        return;
    double reach =
        scene->camera.type == CAMERA_ORTHOGRAPHIC ? view.distance - scene->camera.clip_near : view.distance;
    Ray ray = ray_from_hit(hit, view.to_camera, reach * (1 - 1e-9), VISIBLE_CAMERA);
    Rgb through = trace_transmittance(w->run->trace, &ray);
    if (rgb_black(through)) return;
    double geometry = facing_eye * view.raster_per_area / facing_light * scene->camera.exposure;
    splat(w, &view, chain_owner(&chain), rgb_scale(rgb_mul(rgb_mul(w->flux, scatter), through), geometry));
}

static bool light_surface(LightWalk *w, const Hit *hit, int depth) {
    const Object *o = &w->run->scene->objects[hit->object];
    V3 wi = v3_neg(w->ray.dir);
    ShadingFrame f = frame_from_light(hit, wi);
    unsigned lobes = hit->material->lobes;
    bool next_to_light = w->chain.diffuse + w->chain.glossy + w->chain.transmission == 0;
    if (next_to_light) {
        lobes &= LOBE_SPECULAR | LOBE_TRANSPARENT; /* anything else is found from the camera */
    } else if (o->visibility & VISIBLE_CAMERA) {
        if ((lobes & LOBE_DIFFUSE) && (w->left_visible & VISIBLE_DIFFUSE))
            connect_camera(w, hit, LOBE_DIFFUSE);
        if ((lobes & LOBE_GLOSSY) && (w->left_visible & VISIBLE_GLOSSY)) connect_camera(w, hit, LOBE_GLOSSY);
    }
    if (!o->casts) lobes &= ~(unsigned)LOBE_CASTING;
    double u[3];
    for (int k = 2; k >= 0; k--) u[k] = path_number(&w->numbers);
    path_numbers_next(&w->numbers);
    ScatterSample s;
    if (!lobes || !hit->material->kind->sample(hit->material, &f, wi, u, lobes, true, &s)) return false;
    w->flux = rgb_mul(w->flux, s.weight);
    unsigned seen_by = w->ray.visibility;
    if (s.lobe != LOBE_TRANSPARENT) {
        if (!(w->left_visible & visibility_after(s.lobe, s.transmit))) return false;
        w->flux = rgb_scale(w->flux, shading_adjoint(&f, wi, s.wo));
        if (!w->run->physical) w->flux = rgb_scale(w->flux, 1 / square(s.eta));
        chain_add_from_light(&w->chain, s.lobe, s.transmit);
        if (next_to_light) w->first = w->chain;
        w->left_visible = o->visibility;
        seen_by = VISIBLE_DIFFUSE | VISIBLE_GLOSSY | VISIBLE_TRANSMISSION | VISIBLE_CAMERA;
    }
    if (!rgb_finite(w->flux) || rgb_black(w->flux)) return false;
    w->ray = ray_from_hit(hit, s.wo, INFINITY, seen_by);
    double keep = rgb_max(w->flux) / (w->emitted * LIGHT_ROULETTE_SHARE);
    if (depth < LIGHT_ROULETTE_DEPTH || keep >= 1) return true;
    if (rng_next(&w->numbers.rng) >= keep) return false;
    w->flux = rgb_scale(w->flux, 1 / keep);
    return true;
}

typedef struct LightJob {
    const ReferenceRun *run;
    const Light *light;
    uint64_t key;
    SplatBatch *batches;
} LightJob;

static void light_batch(void *data, size_t index, unsigned thread) {
    (void)thread;
    LightJob *job = data;
    const ReferenceRun *run = job->run;
    if (run->cancel && atomic_load_explicit(run->cancel, memory_order_relaxed)) return;
    uint32_t first = (uint32_t)index * LIGHT_BATCH, last = first + LIGHT_BATCH;
    if (last > run->light_paths) last = run->light_paths;
    AimMix aim = {.first = run->casters};
    for (uint32_t i = first; i < last; i++) {
        Photon p;
        if (!emit_photon(job->light, &aim, i, job->key, &p) || !rgb_finite(p.flux)) continue;
        LightWalk w = {.run = run,
            .batch = &job->batches[index],
            .numbers = path_numbers(job->key, i),
            .flux = rgb_scale(p.flux, 1.0 / run->light_paths),
            .emitted = rgb_max(p.flux) / run->light_paths,
            .left_visible = 31u,
            .ray = ray_from_point(p.origin, p.dir, 0, INFINITY, VISIBLE_SHADOW)};
        for (int depth = 0; depth < LIGHT_DEPTH_MAX; depth++) {
            Hit hit;
            if (!trace_nearest(run->trace, &w.ray, &hit) || !light_surface(&w, &hit, depth)) break;
        }
    }
}

static cau_result trace_light(
    LightJob *job, size_t light, TaskPool *pool, const ReferenceImages *out, CauError *err) {
    size_t batches = (job->run->light_paths + LIGHT_BATCH - 1) / LIGHT_BATCH;
    job->batches = array_new(batches, sizeof *job->batches);
    if (!job->batches) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for light paths");
    tasks_run(pool, batches, light_batch, job);
    bool failed = false;
    for (size_t b = 0; b < batches; b++) {
        failed |= job->batches[b].out_of_memory;
        for (size_t i = 0; i < job->batches[b].count; i++) {
            const Splat *s = &job->batches[b].items[i];
            double *image = reference_image(out, s->owner, light);
            if (!image || !rgb_finite(s->value)) continue;
            image[3 * (size_t)s->pixel] += s->value.r;
            image[3 * (size_t)s->pixel + 1] += s->value.g;
            image[3 * (size_t)s->pixel + 2] += s->value.b;
        }
        free(job->batches[b].items);
    }
    free(job->batches);
    return failed ? error_set(err, CAU_ERROR_RESOURCE, "out of memory for light paths") : CAU_OK;
}

bool reference_from_light(const ReferenceRun *run, const Light *light) {
    if (light->delta) return true;
    if (!light->infinite) return false;
    for (size_t i = 0; i < run->scene->object_count; i++)
        if (!run->scene->objects[i].exact && run->scene->objects[i].mesh.normals) return false;
    EmitStart start;
    light->kind->emit_start(light, 0.5, 0.5, &start);
    return start.pdf * NARROW > 1;
}

cau_result reference_light_paths(
    const ReferenceRun *run, TaskPool *pool, const ReferenceImages *out, CauError *err) {
    if (run->casters->count == 0 || run->light_paths == 0) return CAU_OK;
    for (size_t i = 0; i < run->scene->light_count; i++) {
        const Light *l = &run->scene->lights[i];
        if (!reference_from_light(run, l)) continue;
        LightJob job = {run, l, rng_combine(rng_combine(run->key, l->stream), run->pass), NULL};
        CAU_TRY(trace_light(&job, i, pool, out, err));
    }
    return run->cancel && atomic_load(run->cancel) ? CAU_ERROR_CANCELLED : CAU_OK;
}
