/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gather/photon_gather.h"

#include "core/checked.h"

/* Kernels as wide as the latter when they were learned are where no bias shows: they shrink by a third of the
 * power of narrow ones. In footprints. */
#define WIDE_FROM 2.0
#define WIDE_TO 8.0
#define WIDE_POWER (2.0 / 3)

/* ---- supports ---- */

/* In pixel footprints. */
static double radius_of(const GatherRun *run, size_t pixel) {
    double learned = run->radius ? (double)run->radius[pixel] : 1, radius = learned * run->radius_pixels;
    double first = learned * run->first_pixels;
    if (!(first > WIDE_FROM)) return radius;
    double wide = fmin(log(first / WIDE_FROM) / log(WIDE_TO / WIDE_FROM), 1);
    return radius * pow(run->first_pixels / run->radius_pixels, WIDE_POWER * wide);
}

static void support_row(void *data, size_t index, unsigned thread) {
    (void)thread;
    const GatherRun *run = ((void **)data)[0];
    SupportRows *out = ((void **)data)[1];
    size_t y = (size_t)run->y0 + index;
    const struct EyeRow *points = &run->points->rows[y];
    struct SupportRow *row = &out->rows[y];
    row->count = 0;
    if (run->cancel && atomic_load_explicit(run->cancel, memory_order_relaxed)) return;
    if (!array_reserve((void **)&row->items, &row->capacity, points->count, sizeof *row->items)) {
        row->out_of_memory = true;
        return;
    }
    row->count = points->count;
    for (size_t i = 0; i < points->count; i++) {
        const EyePoint *p = &points->items[i];
        row->items[i] = (Support){.radius = (double)p->size * radius_of(run, p->pixel)};
    }
}

cau_result gather_supports(const GatherRun *run, TaskPool *pool, SupportRows *out, CauError *err) {
    int height = run->points->height;
    if (!out->rows) {
        out->rows = array_new((size_t)height, sizeof *out->rows);
        if (!out->rows)
            return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %d rows of supports", height);
        out->height = height;
    }
    void *data[2] = {(void *)run, out};
    tasks_run(pool, (size_t)(run->y1 - run->y0), support_row, data);
    if (run->cancel && atomic_load(run->cancel)) return CAU_ERROR_CANCELLED;
    for (int y = run->y0; y < run->y1; y++)
        if (out->rows[y].out_of_memory)
            return error_set(err, CAU_ERROR_RESOURCE, "out of memory for supports");
    return CAU_OK;
}

void support_rows_free(SupportRows *rows) {
    for (int y = 0; y < rows->height; y++) free(rows->rows[y].items);
    free(rows->rows);
    *rows = (SupportRows){0};
}

/* ---- gathering ---- */

typedef struct Sum {
    const GatherRun *run;
    const EyePoint *point;
    Support *support;
    double inverse_r2;
    V3 normal, edge_per_r;
    Rgb flux, inner; /* times the kernel, and times that of radius r / sqrt(2) */
    uint64_t found;
    int16_t tested[2]; /* the normal tested last, and what came of it: on flat ground it is always the same */
    bool faces;
    bool limited; /* in its bounces */
} Sum;

static bool bounces_limited(const BounceParams *b) {
    return b->total >= 0 || b->diffuse >= 0 || b->glossy >= 0 || b->transmission >= 0;
}

static bool bounces_pass(const BounceParams *b, const EyePoint *p, const Deposit *d) {
    return bounces_allow(
        b, d->diffuse + 1u, (unsigned)d->glossy + p->glossy, (unsigned)d->transmission + p->transmission);
}

static bool faces_alike(Sum *s, const int16_t normal[2]) {
    if (normal[0] != s->tested[0] || normal[1] != s->tested[1]) {
        memcpy(s->tested, normal, sizeof s->tested);
        s->faces = v3_dot(normal_decode(normal), s->normal) >= SUPPORT_COSINE;
    }
    return s->faces;
}

static void set_edge(Sum *s) {
    const float *edge = s->support->edge;
    s->edge_per_r = v3_scale(v3((double)edge[0], (double)edge[1], (double)edge[2]), 1 / s->support->radius);
}

static void find_support(Sum *s) {
    support_find(s->run->trace, s->point, s->support->radius, s->support);
    s->inverse_r2 = 1 / square(s->support->radius);
    set_edge(s);
}

static void add_deposit(void *data, const Deposit *d, double distance2) {
    Sum *s = data;
    V3 place = v3((double)d->position[0], (double)d->position[1], (double)d->position[2]);
    s->found++;
    if (d->audience == AUDIENCE_SEEN && s->point->straight) return;
    double height = v3_dot(v3_sub(place, s->point->position), s->normal), r = s->support->radius;
    /* The same surface only: by side and normal, by height, and by what stands in between. */
    if (fabs(height) > SUPPORT_HEIGHT * r) return;
    if (!faces_alike(s, d->normal)) return;
    if (s->limited && !bounces_pass(&s->run->scene->bounces, s->point, d)) return;
    if (!support_found(s->support)) find_support(s);
    r = s->support->radius;
    if (fabs(height) > (double)s->support->band) return;
    double depth = (double)s->support->top - height;
    if (s->support->layered && depth > (double)s->support->flat &&
        support_hidden(s->run->trace, s->support, place, depth))
        return;
    double q = positive(distance2 - height * height) * s->inverse_r2;
    if (q >= 1) return;
    SupportKernels kernel = support_kernels(q);
    if (s->support->mixed) {
        if (!support_sees(s->run->trace, s->point, s->support, v3_mad(place, -height, s->normal))) return;
        support_mirror(s->support, q, v3_dot(v3_sub(place, s->point->position), s->edge_per_r), &kernel);
    }
    Rgb flux = rgb((double)d->flux[0], (double)d->flux[1], (double)d->flux[2]);
    s->flux = rgb_add(s->flux, rgb_scale(flux, kernel.outer));
    if (kernel.inner > 0) s->inner = rgb_add(s->inner, rgb_scale(flux, kernel.inner));
}

static void add_rgb(double *image, uint32_t pixel, Rgb value) {
    if (!image) return;
    image[3 * (size_t)pixel] += value.r;
    image[3 * (size_t)pixel + 1] += value.g;
    image[3 * (size_t)pixel + 2] += value.b;
}

typedef struct GatherJob {
    const GatherRun *run;
    SupportRows *supports;
    const PhotonTree *tree;
    const PassImages *out;
} GatherJob;

static void clear_row(const PassImages *out, size_t y, size_t width) {
    if (out->radiance) memset(out->radiance + 3 * y * width, 0, 3 * width * sizeof(double));
    if (out->kernels) {
        memset(out->kernels->bias + 3 * y * width, 0, 3 * width * sizeof(double));
        memset(out->kernels->cost + y * width, 0, width * sizeof(double));
    }
    if (out->seen) memset(out->seen + 3 * y * width, 0, 3 * width * sizeof(double));
    if (out->spread) memset(out->spread + y * width, 0, width * sizeof(double));
    if (out->irradiance) memset(out->irradiance + 3 * y * width, 0, 3 * width * sizeof(double));
    if (out->coverage) memset(out->coverage + y * width, 0, width * sizeof(double));
}

static void add_kernel(const KernelImages *out, const EyePoint *p, const Sum *sum) {
    const Support *support = sum->support;
    out->cost[p->pixel] += (double)p->share * (double)sum->found * (support->mixed ? GATHER_RAY_COST : 1);
    if (!support_found(support)) return;
    Rgb weight = rgb((double)p->weight[0], (double)p->weight[1], (double)p->weight[2]);
    Rgb bias =
        rgb_sub(rgb_scale(sum->flux, 2 / support->integral), rgb_scale(sum->inner, 2 / support->inner));
    add_rgb(out->bias, p->pixel, rgb_mul(weight, bias));
}

static void gather_point(const GatherJob *job, const EyePoint *p, Support *support) {
    double r = support->radius;
    Sum sum = {.run = job->run,
        .point = p,
        .support = support,
        .inverse_r2 = 1 / (r * r),
        .tested = {INT16_MIN, INT16_MIN}, /* no normal is so */
        .limited = bounces_limited(&job->run->scene->bounces),
        .normal = v3((double)p->ng[0], (double)p->ng[1], (double)p->ng[2])};
    set_edge(&sum);
    photon_tree_query(job->tree, p->position, r, add_deposit, &sum);
    if (job->out->kernels) add_kernel(job->out->kernels, p, &sum);
    Rgb irradiance = support_found(support) ? rgb_scale(sum.flux, 1 / support->integral) : rgb_grey(0);
    Rgb radiance = rgb_mul(irradiance, rgb((double)p->weight[0], (double)p->weight[1], (double)p->weight[2]));
    add_rgb(job->out->radiance, p->pixel, radiance);
    if (!p->straight) add_rgb(job->out->seen, p->pixel, radiance);
    if (!p->straight) spread_add(job->out->spread, p->pixel, radiance);
    if (!p->straight) return;
    add_rgb(job->out->irradiance, p->pixel,
        rgb_scale(irradiance, (double)p->share * job->run->scene->camera.exposure));
    if (job->out->coverage) job->out->coverage[p->pixel] += (double)p->share;
}

static void gather_row(void *data, size_t index, unsigned thread) {
    (void)thread;
    const GatherJob *job = data;
    size_t y = (size_t)job->run->y0 + index;
    if (!job->out->add) clear_row(job->out, y, (size_t)job->run->scene->camera.width);
    if (job->run->cancel && atomic_load_explicit(job->run->cancel, memory_order_relaxed)) return;
    const struct EyeRow *row = &job->run->points->rows[y];
    size_t step = job->run->step > 1 ? (size_t)job->run->step : 1;
    if (y % step) return;
    for (size_t i = 0; i < row->count; i++)
        if (step == 1 || row->items[i].pixel % step == 0)
            gather_point(job, &row->items[i], &job->supports->rows[y].items[i]);
}

cau_result gather_photons(const GatherRun *run, SupportRows *supports, const PhotonTree *tree, TaskPool *pool,
    const PassImages *out, CauError *err) {
    (void)err;
    GatherJob job = {run, supports, tree, out};
    tasks_run(pool, (size_t)(run->y1 - run->y0), gather_row, &job);
    return run->cancel && atomic_load(run->cancel) ? CAU_ERROR_CANCELLED : CAU_OK;
}
