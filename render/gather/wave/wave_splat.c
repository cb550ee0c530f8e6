/* SPDX-License-Identifier: Apache-2.0 */
/* Light that no triangle claimed, on what the camera sees directly: each photon is spread by a kernel over
 * its own receiver. The kernel's support is taken at the photon, so that all of its flux lands. */
#include "render/gather/wave/wave_internal.h"

#define MIXED_RADIUS 0.35
/* A receiver seen at less than this cosine: the kernel is not resolved within a subpixel. */
#define GRAZING_COSINE 1e-2

/* Where the camera sees the photon's plane through a raster position. */
static V3 seen_at(const Camera *camera, const WaveLanding *l, double x, double y) {
    Ray ray = camera_ray(camera, x, y);
    double along = v3_dot(ray.dir, l->normal);
    if (fabs(along) < GRAZING_COSINE) return l->position;
    return v3_mad(ray.origin, v3_dot(v3_sub(l->position, ray.origin), l->normal) / along, ray.dir);
}

bool wave_splat(const WaveRun *run, const WaveView *view, const WaveLanding *l, double scale, double turn,
    WaveSplat *out) {
    CameraView seen;
    if (!l->shown || !camera_project(&view->scene->camera, l->position, &seen)) return false;
    double footprint = 1 / sqrt(seen.raster_per_area), radius = run->radius_pixels * footprint;
    out->reach = run->radius_pixels * view->scale + 1;
    out->x = seen.x * view->scale - view->x0;
    out->y = seen.y * view->scale - view->y0;
    if (out->x < -out->reach || out->x > view->width + out->reach || out->y < -out->reach ||
        out->y > view->height + out->reach)
        return false;
    double half = 0.5 / view->scale;
    for (int k = 0; k < 2; k++) {
        double x = k ? 0 : half, y = k ? half : 0;
        const Camera *camera = &view->scene->camera;
        out->step[k] =
            v3_sub(seen_at(camera, l, seen.x + x, seen.y + y), seen_at(camera, l, seen.x - x, seen.y - y));
    }
    out->point = (EyePoint){.position = l->position,
        .ng = {(float)l->normal.x, (float)l->normal.y, (float)l->normal.z},
        .turn = (float)turn,
        .object = l->object,
        .primitive = l->primitive};
    support_find(run->trace, &out->point, radius, &out->support);
    if (out->support.mixed) { /* a ray for every subpixel: near walls a smaller kernel must do */
        support_find(run->trace, &out->point, MIXED_RADIUS * radius, &out->support);
        out->reach = MIXED_RADIUS * run->radius_pixels * view->scale + 1;
    }
    double density = scale / out->support.integral;
    out->flux[0] = (float)(l->weight.r * density);
    out->flux[1] = (float)(l->weight.g * density);
    out->flux[2] = (float)(l->weight.b * density);
    return true;
}

/* The kernel at a place of a subpixel; 0 where it is another surface or hidden from the photon. */
static double kernel_at(const TraceScene *trace, const WaveSplat *s, const WaveSubpixel *p, V3 place) {
    V3 n = v3((double)s->point.ng[0], (double)s->point.ng[1], (double)s->point.ng[2]);
    double r = s->support.radius;
    V3 d = v3_sub(place, s->point.position);
    double height = v3_dot(d, n), across = v3_dot(d, d) - height * height;
    if (across >= r * r || fabs(height) > SUPPORT_HEIGHT * r) return 0;
    if (v3_dot(v3((double)p->normal[0], (double)p->normal[1], (double)p->normal[2]), n) < SUPPORT_COSINE)
        return 0;
    if (s->support.mixed && !support_sees(trace, &s->point, &s->support, v3_mad(place, -height, n))) return 0;
    return 1 - across / (r * r);
}

/* The mean of the kernel over a subpixel, from n x n places. */
static double kernel_mean(const TraceScene *trace, const WaveSplat *s, const WaveSubpixel *p, int n) {
    if (p->object != s->point.object) return 0;
    V3 middle = v3((double)p->position[0], (double)p->position[1], (double)p->position[2]);
    double sum = 0;
    for (int k = 0; k < n * n; k++) {
        double x = (k % n + 0.5) / n - 0.5, y = (k / n + 0.5) / n - 0.5;
        sum += fmax(0, kernel_at(trace, s, p, v3_mad(v3_mad(middle, x, s->step[0]), y, s->step[1])));
    }
    return sum / (n * n);
}

static void light(const TraceScene *trace, WaveView *v, const WaveSplat *s, size_t at, int n) {
    double kernel = kernel_mean(trace, s, &v->subpixels[at], n);
    if (kernel <= 0) return;
    for (size_t c = 0; c < 3; c++) v->irradiance[3 * at + c] += (float)(kernel * (double)s->flux[c]);
}

void wave_splat_draw(const TraceScene *trace, WaveView *view, const WaveSplat *s, int y0, int y1) {
    int top = (int)fmax(floor(s->y - s->reach), y0), bottom = (int)fmin(ceil(s->y + s->reach), y1);
    int left = (int)fmax(floor(s->x - s->reach), 0), right = (int)fmin(ceil(s->x + s->reach), view->width);
    size_t parts = (size_t)view->parts * (size_t)view->parts;
    for (int y = top; y < bottom; y++)
        for (int x = left; x < right; x++) {
            size_t at = (size_t)y * (size_t)view->width + (size_t)x;
            bool mixed = view->subpixels[at].object == WAVE_MIXED;
            size_t first = mixed ? wave_block(view, &view->subpixels[at]) : at;
            view->lit[y] = 1;
            for (size_t i = 0; i < (mixed ? parts : 1); i++)
                light(trace, view, s, first + i, mixed || view->scale > 1 ? 1 : view->parts);
        }
}
