/* SPDX-License-Identifier: Apache-2.0 */
/* What the camera sees directly, on a grid of subpixels: one ray for each pixel, more only where neighbouring
 * pixels do not see one smooth sheet. */
#include "render/gather/wave/wave_internal.h"

#include "core/checked.h"

enum { SCALE_MAX = 4, PASSES_MAX = 64, FILL_ROWS = 16 };

/* Neighbours that lie in one plane. */
#define FLAT_COSINE (1 - 1e-9)
#define FLAT_OFFSET 1e-6
/* Neighbours on one smooth sheet: the parabola through them is off by a small part of a pixel. */
#define SMOOTH_COSINE 0.995
#define SMOOTH_BEND 0.1
/* A place is seen when the ray to it ends so near it, in pixels. */
#define SEEN_OFF 0.25

typedef struct Seen {
    Hit hit;
    V3 dir;
    Rgb through; /* of transparent surfaces in front */
    bool any;    /* a receiver */
    bool casts;
} Seen;

typedef struct ViewJob {
    WaveView *view;
    const WaveViewRun *run;
    Seen *rows; /* three rows of pixels for each thread */
} ViewJob;

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

bool wave_view_sees(const WaveView *v, const TraceScene *trace, const WaveLanding *l) {
    CameraView view;
    if (!camera_project(&v->scene->camera, l->position, &view)) return false;
    Seen s = look(v, trace, view.x, view.y);
    if (!s.any || s.hit.object != l->object) return false;
    double off = SEEN_OFF / sqrt(view.raster_per_area) + 1e-5 * view.distance;
    double cosine = fabs(v3_dot(s.dir, s.hit.ng));
    return v3_length(v3_sub(s.hit.position, l->position)) * fmax(cosine, 1e-3) <= off;
}

/* Stores what was seen through a square of `scale` to a pixel. */
static void put_subpixel(WaveView *v, size_t at, const Seen *s, int scale) {
    WaveSubpixel *p = &v->subpixels[at];
    *p = (WaveSubpixel){.receiver = WAVE_NOTHING};
    for (size_t k = 0; k < 3; k++) v->weight[3 * at + k] = 0;
    if (!s->any) return;
    V3 wi = v3_neg(s->dir);
    ShadingFrame frame = frame_from_hit(&s->hit, wi);
    const Camera *camera = &v->scene->camera;
    CameraView view;
    Rgb albedo = rgb_mul(s->through, s->hit.material->kind->albedo(s->hit.material, &frame, wi));
    if (rgb_black(albedo) || !camera_project(camera, s->hit.position, &view)) return;
    double cosine = fabs(v3_dot(wi, frame.ng)), gain = camera->exposure / CAU_PI;
    *p = (WaveSubpixel){
        .position = {(float)s->hit.position.x, (float)s->hit.position.y, (float)s->hit.position.z},
        .normal = {(float)frame.ng.x, (float)frame.ng.y, (float)frame.ng.z},
        .per_flux = (float)(view.raster_per_area * cosine * scale * scale),
        .receiver = wave_receiver(v->scene, s->hit.object)};
    v->weight[3 * at] = (float)(albedo.r * gain);
    v->weight[3 * at + 1] = (float)(albedo.g * gain);
    v->weight[3 * at + 2] = (float)(albedo.b * gain);
}

/* ---- what neighbours agree on ---- */

typedef enum Sheet { SHEET_NONE, SHEET_SMOOTH, SHEET_FLAT } Sheet;

static Sheet sheet_of(const Seen *a, const Seen *b) {
    if (a->any != b->any || a->casts != b->casts) return SHEET_NONE;
    if (!a->any) return SHEET_FLAT;
    if (a->hit.object != b->hit.object || a->through.r != b->through.r || a->through.g != b->through.g ||
        a->through.b != b->through.b)
        return SHEET_NONE;
    V3 d = v3_sub(b->hit.position, a->hit.position);
    double even = fmin(v3_dot(a->hit.ng, b->hit.ng), v3_dot(a->hit.ns, a->hit.ng));
    bool flat = even > FLAT_COSINE && v3_dot(b->hit.ns, b->hit.ng) > FLAT_COSINE &&
                fabs(v3_dot(d, a->hit.ng)) <= FLAT_OFFSET * v3_length(d);
    if (flat) return SHEET_FLAT;
    return v3_dot(a->hit.ng, b->hit.ng) > SMOOTH_COSINE && v3_dot(a->hit.ns, b->hit.ns) > SMOOTH_COSINE
               ? SHEET_SMOOTH
               : SHEET_NONE;
}

/* Bent less than SMOOTH_BEND of the step between the two around it. */
static bool straight(const Seen *a, const Seen *middle, const Seen *b) {
    V3 step = v3_scale(v3_sub(b->hit.position, a->hit.position), 0.5);
    V3 bend = v3_sub(v3_scale(v3_add(a->hit.position, b->hit.position), 0.5), middle->hit.position);
    return v3_length(bend) <= SMOOTH_BEND * v3_length(step);
}

/* Of a pixel and the eight around it. An edge across a pixel parts the eight, so a ray for each is enough. */
static Sheet sheet_around(const Seen *const row[3], int x) {
    const Seen *middle = &row[1][x];
    Sheet sheet = SHEET_FLAT;
    for (int k = 0; k < 9 && sheet != SHEET_NONE; k++) {
        Sheet with = k == 4 ? SHEET_FLAT : sheet_of(middle, &row[k / 3][x + k % 3 - 1]);
        if (with < sheet) sheet = with;
    }
    if (sheet != SHEET_SMOOTH) return sheet;
    bool even =
        straight(&row[1][x - 1], middle, &row[1][x + 1]) && straight(&row[0][x], middle, &row[2][x]) &&
        straight(&row[0][x - 1], middle, &row[2][x + 1]) && straight(&row[0][x + 1], middle, &row[2][x - 1]);
    return even ? SHEET_SMOOTH : SHEET_NONE;
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

/* The parabola through the pixels left and right, above and below. */
static V3 parabola(V3 left, V3 right, V3 up, V3 down, V3 middle, double x, double y) {
    V3 out = v3_mad(middle, 0.5 * x, v3_sub(right, left));
    out = v3_mad(out, 0.5 * y, v3_sub(down, up));
    out = v3_mad(out, 0.5 * x * x, v3_sub(v3_add(left, right), v3_scale(middle, 2)));
    return v3_mad(out, 0.5 * y * y, v3_sub(v3_add(up, down), v3_scale(middle, 2)));
}

static Seen on_parabola(const Seen *const row[3], int at, double x, double y) {
    const Seen *l = &row[1][at - 1], *m = &row[1][at], *r = &row[1][at + 1], *u = &row[0][at],
               *d = &row[2][at];
    Seen out = *m;
    out.hit.position =
        parabola(l->hit.position, r->hit.position, u->hit.position, d->hit.position, m->hit.position, x, y);
    out.hit.ng = v3_normalize(parabola(l->hit.ng, r->hit.ng, u->hit.ng, d->hit.ng, m->hit.ng, x, y));
    out.hit.ns = v3_normalize(parabola(l->hit.ns, r->hit.ns, u->hit.ns, d->hit.ns, m->hit.ns, x, y));
    out.dir = v3_normalize(parabola(l->dir, r->dir, u->dir, d->dir, m->dir, x, y));
    return out;
}

/* ---- filling ---- */

static double pixel_x(const WaveView *v, int x) { return (double)v->x0 / v->scale + x; }
static double pixel_y(const WaveView *v, int y) { return (double)v->y0 / v->scale + y; }

/* Subpixels of a pixel that is no sheet on a grid of one per pixel wait for their block. */
static void fill_pixel(const ViewJob *job, int px, int py, const Seen *const row[3]) {
    WaveView *v = job->view;
    const Seen *middle = &row[1][px + 1];
    Sheet sheet = sheet_around(row, px + 1);
    double left = pixel_x(v, px), top = pixel_y(v, py);
    bool casts = middle->casts;
    for (int j = 0; j < v->scale; j++)
        for (int i = 0; i < v->scale; i++) {
            double x = (i + 0.5) / v->scale, y = (j + 0.5) / v->scale;
            size_t at = (size_t)(py * v->scale + j) * (size_t)v->width + (size_t)(px * v->scale + i);
            if (sheet == SHEET_NONE && v->scale == 1) {
                v->subpixels[at].receiver = WAVE_MIXED;
                continue;
            }
            Seen s;
            if (v->scale == 1)
                s = *middle;
            else if (sheet == SHEET_NONE)
                s = look(v, job->run->trace, left + x, top + y);
            else
                s = sheet == SHEET_FLAT ? on_plane(v, middle, left + x, top + y)
                                        : on_parabola(row, px + 1, x - 0.5, y - 0.5);
            casts = casts || s.casts;
            put_subpixel(v, at, &s, v->scale);
            if (sheet == SHEET_NONE)
                wave_mark_contact(
                    v, job->run->trace, at, px * v->scale + i + 0.5, py * v->scale + j + 0.5, 1);
        }
    v->casts[(size_t)py * (size_t)(v->width / v->scale) + (size_t)px] = casts;
}

/* A row of pixels and one more on either side. */
static void look_along(const ViewJob *job, int y, Seen *row) {
    const WaveView *v = job->view;
    for (int x = -1; x <= v->width / v->scale; x++)
        row[x + 1] = look(v, job->run->trace, pixel_x(v, x) + 0.5, pixel_y(v, y) + 0.5);
}

static void fill_rows(void *data, size_t index, unsigned thread) {
    const ViewJob *job = data;
    WaveView *v = job->view;
    int pixels = v->width / v->scale, rows = v->height / v->scale, first = (int)index * FILL_ROWS;
    Seen *memory = job->rows + 3 * (size_t)thread * ((size_t)pixels + 2), *row[3];
    for (int k = 0; k < 3; k++) row[k] = memory + (size_t)k * ((size_t)pixels + 2);
    look_along(job, first - 1, row[0]);
    look_along(job, first, row[1]);
    for (int y = first; y < first + FILL_ROWS && y < rows; y++) {
        if (job->run->cancel && atomic_load_explicit(job->run->cancel, memory_order_relaxed)) return;
        look_along(job, y + 1, row[2]);
        for (int x = 0; x < pixels; x++) fill_pixel(job, x, y, (const Seen *const *)row);
        Seen *swap = row[0];
        row[0] = row[1];
        row[1] = row[2];
        row[2] = swap;
    }
}

/* ---- blocks ---- */

static void fill_block(void *data, size_t index, unsigned thread) {
    (void)thread;
    const ViewJob *job = data;
    WaveView *v = job->view;
    if (job->run->cancel && atomic_load_explicit(job->run->cancel, memory_order_relaxed)) return;
    for (size_t b = v->row_blocks[index]; b < v->row_blocks[index + 1]; b++) {
        WaveSubpixel *mixed = &v->subpixels[v->block[b]];
        mixed->block = (uint32_t)b;
        size_t at = wave_block(v, mixed);
        int x = (int)(v->block[b] % (uint32_t)v->width);
        for (int k = 0; k < v->parts * v->parts; k++) {
            double px = x + (k % v->parts + 0.5) / v->parts,
                   py = (int)index + (k / v->parts + 0.5) / v->parts;
            Seen s = look(v, job->run->trace, v->x0 + px, v->y0 + py);
            v->casts[v->block[b]] |= s.casts;
            put_subpixel(v, at + (size_t)k, &s, v->parts);
            wave_mark_contact(v, job->run->trace, at + (size_t)k, px, py, 1.0 / v->parts);
        }
    }
}

static size_t subpixel_bytes(void) { return sizeof(WaveSubpixel) + 6 * sizeof(float); }

static bool grow(void **items, size_t count, size_t size) {
    size_t bytes;
    void *larger = checked_mul(count, size, &bytes) ? realloc(*items, bytes) : NULL;
    if (larger) *items = larger;
    return larger != NULL;
}

/* Numbers the blocks and makes room for them; fewer parts where memory is short. */
static bool make_blocks(WaveView *v, size_t memory) {
    v->row_blocks = array_new((size_t)v->height + 1, sizeof *v->row_blocks);
    if (!v->row_blocks) return false;
    for (size_t i = 0; i < v->grid; i++) v->blocks += v->subpixels[i].receiver == WAVE_MIXED;
    v->block = array_new(v->blocks + 1, sizeof *v->block);
    if (!v->block) return false;
    for (size_t i = 0, b = 0; i < v->grid; i++)
        if (v->subpixels[i].receiver == WAVE_MIXED) {
            v->block[b++] = (uint32_t)i;
            v->row_blocks[i / (size_t)v->width + 1] = (uint32_t)b;
        }
    for (int y = 0; y < v->height; y++)
        if (v->row_blocks[y + 1] < v->row_blocks[y]) v->row_blocks[y + 1] = v->row_blocks[y];
    double room = (double)memory / (double)subpixel_bytes() - (double)v->grid;
    while (v->parts > 1 && (double)v->blocks * v->parts * v->parts > room) v->parts--;
    size_t count = v->grid + v->blocks * (size_t)v->parts * (size_t)v->parts;
    if (count == v->grid) return true;
    bool ok = grow((void **)&v->subpixels, count, sizeof *v->subpixels) &&
              grow((void **)&v->weight, 3 * count, sizeof *v->weight) &&
              grow((void **)&v->irradiance, 3 * count, sizeof *v->irradiance);
    if (ok) memset(v->irradiance, 0, 3 * count * sizeof *v->irradiance);
    return ok;
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

/* A pixel is busy when any pixel under its filter shows a caster. */
static void find_busy(WaveView *v) {
    int margin = (v->taps / v->scale - 1) / 2, pixels = v->width / v->scale, rows = v->height / v->scale;
    for (int y = 0; y < rows; y++)
        for (int x = 0; x < pixels; x++) {
            if (!v->casts[(size_t)y * (size_t)pixels + (size_t)x]) continue;
            int px = v->region[0] + x - margin, py = v->region[1] + y - margin;
            for (int j = py - margin; j <= py + margin; j++)
                for (int i = px - margin; i <= px + margin; i++)
                    if (i >= v->region[0] && i < v->region[2] && j >= v->region[1] && j < v->region[3])
                        v->busy[(size_t)j * (size_t)v->scene->camera.width + (size_t)i] = true;
        }
}

const bool *wave_view_busy(const WaveView *view) { return view->busy; }

bool wave_view_any_busy(const WaveView *view) {
    const Camera *c = &view->scene->camera;
    return memchr(view->busy, true, (size_t)c->width * (size_t)c->height) != NULL;
}

/* ---- the view ---- */

/* A box over whole pixels: a pixel's flux is all that it needs. */
static bool whole_pixels(const PixelFilter *filter) {
    return filter->type == FILTER_BOX && fabs(fmod(filter->width, 2) - 1) < 1e-9;
}

static void set_size(WaveView *v, const WaveViewRun *run) {
    int margin = (int)ceil(run->filter->half_width - 0.5 - 1e-9);
    if (margin < 0) margin = 0;
    double pixels = (double)(run->x1 - run->x0 + 2 * margin) * (run->y1 - run->y0 + 2 * margin);
    v->parts = SCALE_MAX;
    v->scale = whole_pixels(run->filter) ? 1 : SCALE_MAX;
    while (v->scale > 1 &&
           (pixels * v->scale * v->scale > UINT32_MAX ||
               pixels * v->scale * v->scale * (double)subpixel_bytes() > (double)run->memory_bytes))
        v->scale--;
    v->x0 = (run->x0 - margin) * v->scale;
    v->y0 = (run->y0 - margin) * v->scale;
    v->width = (run->x1 - run->x0 + 2 * margin) * v->scale;
    v->height = (run->y1 - run->y0 + 2 * margin) * v->scale;
    v->grid = (size_t)v->width * (size_t)v->height;
    memcpy(v->region, (int[4]){run->x0, run->y0, run->x1, run->y1}, sizeof v->region);
}

static bool allocate(WaveView *v, const WaveViewRun *run, unsigned threads) {
    const Camera *camera = &run->scene->camera;
    v->subpixels = array_new(v->grid, sizeof *v->subpixels);
    v->weight = array_new(3 * v->grid, sizeof *v->weight);
    v->irradiance = array_new(3 * v->grid, sizeof *v->irradiance);
    v->lit = array_new((size_t)v->height, 1);
    v->columns = array_new(6 * (size_t)v->width * threads, sizeof *v->columns);
    v->casts = array_new(v->grid / (size_t)(v->scale * v->scale), 1);
    v->busy = array_new((size_t)camera->width * (size_t)camera->height, 1);
    return v->subpixels && v->weight && v->irradiance && v->lit && v->columns && v->casts && v->busy &&
           make_taps(v, run->filter);
}

cau_result wave_view_create(WaveView **out, const WaveViewRun *run, TaskPool *pool, CauError *err) {
    WaveView *v = *out = array_new(1, sizeof *v);
    if (!v) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for a view");
    v->scene = run->scene;
    set_size(v, run);
    size_t row = (size_t)(v->width / v->scale) + 2;
    Seen *rows = array_new(3 * row * tasks_threads(pool), sizeof *rows);
    bool ok = rows && allocate(v, run, tasks_threads(pool));
    if (ok) {
        ViewJob job = {v, run, rows};
        tasks_run(pool, (size_t)(v->height / v->scale + FILL_ROWS - 1) / FILL_ROWS, fill_rows, &job);
        ok = make_blocks(v, run->memory_bytes);
        if (ok && v->blocks) tasks_run(pool, (size_t)v->height, fill_block, &job);
        find_busy(v);
    }
    free(rows);
    if (!ok)
        return error_set(
            err, CAU_ERROR_RESOURCE, "out of memory for %zu subpixels; use a lower resolution", v->grid);
    return run->cancel && atomic_load(run->cancel) ? CAU_ERROR_CANCELLED : CAU_OK;
}

void wave_view_free(WaveView **view) {
    WaveView *v = *view;
    if (!v) return;
    free(v->subpixels);
    free(v->weight);
    free(v->irradiance);
    free(v->block);
    free(v->row_blocks);
    free(v->columns);
    free(v->lit);
    free(v->casts);
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
