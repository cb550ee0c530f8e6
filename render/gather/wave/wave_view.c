/* SPDX-License-Identifier: Apache-2.0 */
/* What the camera sees directly, on a grid of subpixels, and the filter that makes pixels of it. */
#include "render/gather/wave/wave_internal.h"

#include "core/checked.h"

enum { SCALE_MAX = 4, PASSES_MAX = 64, FILL_ROWS = 8 };

/* Corners of a pixel whose receivers lie in one plane: the subpixels between need no ray. */
#define FLAT_COSINE (1 - 1e-9)
#define FLAT_OFFSET 1e-6

typedef struct Seen {
    Hit hit;
    V3 dir;
    Rgb through; /* of transparent surfaces in front */
    bool any;    /* a receiver */
    bool casts;
} Seen;

static Seen look(const WaveView *v, const TraceScene *trace, double x, double y) {
    Ray ray = camera_ray(&v->scene->camera, x, y);
    Seen s = {.through = rgb_grey(1), .dir = ray.dir};
    for (int i = 0; i < PASSES_MAX; i++) {
        if (!trace_nearest(trace, &ray, &s.hit)) return s;
        const Material *m = s.hit.material;
        if (!(m->lobes & LOBE_TRANSPARENT)) {
            s.casts = m->lobes & LOBE_CASTING;
            s.any = (m->lobes & LOBE_DIFFUSE) && v->scene->objects[s.hit.object].receives;
            return s;
        }
        s.through = rgb_mul(s.through, m->kind->transparency(m));
        ray = ray_from_hit(&s.hit, ray.dir, ray.t_max - s.hit.t, ray.visibility);
    }
    return s;
}

static WaveSubpixel subpixel_of(const WaveView *v, const Seen *s) {
    WaveSubpixel p = {.object = -1, .casts = s->casts};
    if (!s->any) return p;
    V3 wi = v3_neg(s->dir);
    ShadingFrame frame = frame_from_hit(&s->hit, wi);
    const Camera *camera = &v->scene->camera;
    CameraView view;
    Rgb albedo = rgb_mul(s->through, s->hit.material->kind->albedo(s->hit.material, &frame, wi));
    if (rgb_black(albedo) || !camera_project(camera, s->hit.position, &view)) return p;
    double cosine = fabs(v3_dot(wi, frame.ng)), gain = camera->exposure / CAU_PI;
    return (WaveSubpixel){
        .position = {(float)s->hit.position.x, (float)s->hit.position.y, (float)s->hit.position.z},
        .normal = {(float)frame.ng.x, (float)frame.ng.y, (float)frame.ng.z},
        .per_flux = (float)(view.raster_per_area * cosine * v->scale * v->scale),
        .weight = {(float)(albedo.r * gain), (float)(albedo.g * gain), (float)(albedo.b * gain)},
        .object = s->hit.object,
        .casts = s->casts};
}

/* ---- filling ---- */

typedef struct ViewJob {
    WaveView *view;
    const WaveViewRun *run;
    Seen *corners; /* two rows per piece of work */
} ViewJob;

static bool same_plane(const Seen *a, const Seen *b) {
    if (a->any != b->any || a->casts != b->casts) return false;
    if (!a->any) return true;
    if (a->hit.object != b->hit.object || a->through.r != b->through.r || a->through.g != b->through.g ||
        a->through.b != b->through.b)
        return false;
    V3 d = v3_sub(b->hit.position, a->hit.position);
    return v3_dot(a->hit.ng, b->hit.ng) > FLAT_COSINE && v3_dot(a->hit.ns, a->hit.ng) > FLAT_COSINE &&
           v3_dot(b->hit.ns, b->hit.ng) > FLAT_COSINE &&
           fabs(v3_dot(d, a->hit.ng)) <= FLAT_OFFSET * v3_length(d);
}

/* The plane of `s` seen through another raster position. */
static Seen on_plane(const WaveView *v, const Seen *s, double x, double y) {
    Seen out = *s;
    if (!s->any) return out;
    Ray ray = camera_ray(&v->scene->camera, x, y);
    double along = v3_dot(ray.dir, s->hit.ng);
    double t = v3_dot(v3_sub(s->hit.position, ray.origin), s->hit.ng) / along;
    out.hit.position = v3_mad(ray.origin, t, ray.dir);
    out.dir = ray.dir;
    return out;
}

/* One pixel's subpixels; c: what its corners see. */
static void fill_pixel(const ViewJob *job, int px, int py, const Seen *const c[4]) {
    WaveView *v = job->view;
    double step = 1.0 / v->scale, left = (double)v->x0 / v->scale + px, top = (double)v->y0 / v->scale + py;
    Seen middle = look(v, job->run->trace, left + 0.5, top + 0.5);
    bool flat = true;
    for (int k = 0; k < 4; k++) flat = flat && same_plane(&middle, c[k]);
    for (int j = 0; j < v->scale; j++)
        for (int i = 0; i < v->scale; i++) {
            double x = left + (i + 0.5) * step, y = top + (j + 0.5) * step;
            Seen s = flat ? on_plane(v, &middle, x, y) : look(v, job->run->trace, x, y);
            size_t at = (size_t)(py * v->scale + j) * (size_t)v->width + (size_t)(px * v->scale + i);
            v->subpixels[at] = subpixel_of(v, &s);
        }
}

static void look_along(const ViewJob *job, double y, Seen *row) {
    const WaveView *v = job->view;
    for (int x = 0; x <= v->width / v->scale; x++)
        row[x] = look(v, job->run->trace, (double)v->x0 / v->scale + x, (double)v->y0 / v->scale + y);
}

static void fill_rows(void *data, size_t index, unsigned thread) {
    const ViewJob *job = data;
    WaveView *v = job->view;
    int pixels = v->width / v->scale, rows = v->height / v->scale;
    Seen *above = job->corners + 2 * (size_t)thread * ((size_t)pixels + 1), *below = above + pixels + 1;
    look_along(job, (double)(index * FILL_ROWS), above);
    for (int y = (int)index * FILL_ROWS; y < ((int)index + 1) * FILL_ROWS && y < rows; y++) {
        if (job->run->cancel && atomic_load_explicit(job->run->cancel, memory_order_relaxed)) return;
        look_along(job, y + 1, below);
        for (int x = 0; x < pixels; x++) {
            const Seen *const c[4] = {&above[x], &above[x + 1], &below[x], &below[x + 1]};
            fill_pixel(job, x, y, c);
        }
        Seen *swap = above;
        above = below;
        below = swap;
    }
}

/* ---- the filter ---- */

/* Mean of the filter over each subpixel around the middle of a pixel, so that a pixel is the filtered flux of
 * its subpixels. */
static bool make_taps(WaveView *v, const PixelFilter *filter) {
    enum { STEPS = 64 };
    int margin = (int)ceil(filter->half_width - 0.5 - 1e-9);
    if (margin < 0) margin = 0;
    v->taps = (2 * margin + 1) * v->scale;
    v->tap = array_new((size_t)v->taps, sizeof *v->tap);
    if (!v->tap) return false;
    double sum = 0;
    for (int i = 0; i < v->taps; i++) {
        for (int k = 0; k < STEPS; k++)
            v->tap[i] += filter_value(filter, (i + (k + 0.5) / STEPS) / v->scale - margin - 0.5);
        sum += v->tap[i];
    }
    for (int i = 0; i < v->taps; i++) v->tap[i] /= sum;
    return true;
}

/* A pixel is busy when any subpixel under its filter is. */
static void busy_row(void *data, size_t index, unsigned thread) {
    (void)thread;
    WaveView *v = data;
    int y = v->region[1] + (int)index;
    for (int x = v->region[0]; x < v->region[2]; x++) {
        size_t left = (size_t)(x - v->region[0]) * (size_t)v->scale, top = index * (size_t)v->scale;
        bool casts = false;
        for (size_t k = 0; k < (size_t)v->taps * (size_t)v->taps && !casts; k++)
            casts = v->subpixels[(top + k / (size_t)v->taps) * (size_t)v->width + left + k % (size_t)v->taps]
                        .casts;
        v->busy[(size_t)y * (size_t)v->scene->camera.width + (size_t)x] = casts;
    }
}

const bool *wave_view_busy(const WaveView *view) { return view->busy; }

static void set_size(WaveView *v, const WaveViewRun *run) {
    int margin = (int)ceil(run->filter->half_width - 0.5 - 1e-9);
    if (margin < 0) margin = 0;
    double pixels = (double)(run->x1 - run->x0 + 2 * margin) * (run->y1 - run->y0 + 2 * margin);
    size_t each = sizeof(WaveSubpixel) + 3 * sizeof(float);
    v->scale = SCALE_MAX;
    while (v->scale > 1 && pixels * v->scale * v->scale * (double)each > (double)run->memory_bytes)
        v->scale--;
    v->x0 = (run->x0 - margin) * v->scale;
    v->y0 = (run->y0 - margin) * v->scale;
    v->width = (run->x1 - run->x0 + 2 * margin) * v->scale;
    v->height = (run->y1 - run->y0 + 2 * margin) * v->scale;
    memcpy(v->region, (int[4]){run->x0, run->y0, run->x1, run->y1}, sizeof v->region);
}

cau_result wave_view_create(WaveView **out, const WaveViewRun *run, TaskPool *pool, CauError *err) {
    WaveView *v = *out = array_new(1, sizeof *v);
    if (!v) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for a view");
    v->scene = run->scene;
    set_size(v, run);
    size_t count = (size_t)v->width * (size_t)v->height, row = (size_t)(v->width / v->scale) + 1;
    v->subpixels = array_new(count, sizeof *v->subpixels);
    v->irradiance = array_new(3 * count, sizeof *v->irradiance);
    v->lit = array_new((size_t)v->height, 1);
    v->columns = array_new(6 * (size_t)v->width * tasks_threads(pool), sizeof *v->columns);
    v->busy = array_new((size_t)run->scene->camera.width * (size_t)run->scene->camera.height, 1);
    Seen *corners = array_new(2 * row * tasks_threads(pool), sizeof *corners);
    bool ok = v->subpixels && v->irradiance && v->lit && v->columns && v->busy && corners &&
              make_taps(v, run->filter);
    if (ok) {
        ViewJob job = {v, run, corners};
        tasks_run(pool, (size_t)(v->height / v->scale + FILL_ROWS - 1) / FILL_ROWS, fill_rows, &job);
        tasks_run(pool, (size_t)(run->y1 - run->y0), busy_row, v);
    }
    free(corners);
    if (!ok)
        return error_set(
            err, CAU_ERROR_RESOURCE, "out of memory for %zu subpixels; use a lower resolution", count);
    return run->cancel && atomic_load(run->cancel) ? CAU_ERROR_CANCELLED : CAU_OK;
}

void wave_view_free(WaveView **view) {
    WaveView *v = *view;
    if (!v) return;
    free(v->subpixels);
    free(v->irradiance);
    free(v->columns);
    free(v->lit);
    free(v->busy);
    free(v->tap);
    free(v);
    *view = NULL;
}

bool wave_project(const WaveView *view, V3 p, double *x, double *y) {
    CameraView seen;
    if (!camera_project(&view->scene->camera, p, &seen)) return false;
    *x = seen.x * view->scale - view->x0;
    *y = seen.y * view->scale - view->y0;
    return true;
}

/* ---- resolving ---- */

typedef struct ResolveJob {
    WaveView *view;
    const PassImages *images;
} ResolveJob;

/* Filters the rows of a pixel row into one: radiance [0..2] and irradiance [3..5] per column of subpixels. */
static bool resolve_columns(const WaveView *v, int top, double *columns) {
    bool any = false;
    for (int j = 0; j < v->taps; j++) any |= v->lit[top + j];
    if (!any) return false;
    memset(columns, 0, 6 * (size_t)v->width * sizeof *columns);
    for (int j = 0; j < v->taps; j++) {
        if (!v->lit[top + j]) continue;
        const WaveSubpixel *p = &v->subpixels[(size_t)(top + j) * (size_t)v->width];
        const float *e = &v->irradiance[3 * (size_t)(top + j) * (size_t)v->width];
        for (int x = 0; x < v->width; x++)
            for (int k = 0; k < 3; k++) {
                double value = v->tap[j] * (double)e[3 * x + k];
                columns[6 * x + k] += value * (double)p[x].weight[k];
                columns[6 * x + 3 + k] += value;
            }
    }
    return true;
}

static void resolve_row(void *data, size_t index, unsigned thread) {
    const ResolveJob *job = data;
    const WaveView *v = job->view;
    const Camera *camera = &v->scene->camera;
    double *columns = v->columns + 6 * (size_t)thread * (size_t)v->width;
    if (!resolve_columns(v, (int)index * v->scale, columns)) return;
    size_t row = ((size_t)v->region[1] + index) * (size_t)camera->width;
    for (int x = v->region[0]; x < v->region[2]; x++) {
        double sum[6] = {0};
        const double *c = columns + 6 * (size_t)((x - v->region[0]) * v->scale);
        for (int i = 0; i < v->taps; i++)
            for (int k = 0; k < 6; k++) sum[k] += v->tap[i] * c[6 * i + k];
        size_t at = 3 * (row + (size_t)x);
        for (size_t k = 0; k < 3; k++) {
            job->images->radiance[at + k] += sum[k];
            if (job->images->irradiance) job->images->irradiance[at + k] += sum[3 + k] * camera->exposure;
        }
    }
}

void wave_resolve(WaveView *v, TaskPool *pool, const PassImages *images) {
    ResolveJob job = {v, images};
    tasks_run(pool, (size_t)(v->region[3] - v->region[1]), resolve_row, &job);
    for (int y = 0; y < v->height; y++)
        if (v->lit[y])
            memset(v->irradiance + 3 * (size_t)y * (size_t)v->width, 0, 3 * (size_t)v->width * sizeof(float));
    memset(v->lit, 0, (size_t)v->height);
}
