/* SPDX-License-Identifier: Apache-2.0 */
/* Light that no triangle claimed, on what the camera sees directly: each photon is spread by a kernel over
 * its own receiver, over what the camera sees of it, so that all of its flux shows. */
#include "render/gather/wave/wave_internal.h"

#define MIXED_RADIUS 0.35

V3 wave_seen_at(const Camera *camera, V3 point, V3 normal, double x, double y) {
    Ray ray = camera_ray(camera, x, y);
    double along = v3_dot(ray.dir, normal);
    if (fabs(along) < WAVE_GRAZING_COSINE) return point;
    return v3_mad(ray.origin, v3_dot(v3_sub(point, ray.origin), normal) / along, ray.dir);
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
    if (s->strays ? p->receiver == WAVE_NOTHING : wave_object(p->receiver) != s->point.object) return 0;
    V3 middle = v3((double)p->position[0], (double)p->position[1], (double)p->position[2]);
    double sum = 0;
    for (int k = 0; k < n * n; k++) {
        double x = (k % n + 0.5) / n - 0.5, y = (k / n + 0.5) / n - 0.5;
        sum += fmax(0, kernel_at(trace, s, p, v3_mad(v3_mad(middle, x, s->step[0]), y, s->step[1])));
    }
    return sum / (n * n);
}

/* What the splat lights of one subpixel, or of the parts of a mixed one: the kernel's integral there. Adds to
 * the view's irradiance when `lit` is not NULL. */
static double cover(const TraceScene *trace, const WaveView *v, const WaveSplat *s, size_t at, float *lit) {
    bool mixed = v->subpixels[at].receiver == WAVE_MIXED;
    size_t first = mixed ? wave_block(v, &v->subpixels[at]) : at,
           parts = mixed ? (size_t)v->parts * (size_t)v->parts : 1;
    int places = mixed || v->scale > 1 ? 1 : v->parts;
    double sum = 0;
    for (size_t i = first; i < first + parts; i++) {
        double kernel = kernel_mean(trace, s, &v->subpixels[i], places);
        if (!(kernel > 0)) continue;
        sum += kernel / (double)v->subpixels[i].per_flux;
        for (size_t c = 0; lit && c < 3; c++) lit[3 * i + c] += (float)(kernel * (double)s->flux[c]);
    }
    return sum;
}

/* The kernel's integral over all that the view shows of the receiver, so that all of the flux shows. Beyond
 * the view's rim the receiver is taken to go on evenly, as far as nothing hides it: `even` is a subpixel's
 * area on it. */
static double shown_area(const TraceScene *trace, const WaveView *v, const WaveSplat *s, double even) {
    int top = (int)floor(s->y - s->reach), bottom = (int)ceil(s->y + s->reach);
    int left = (int)floor(s->x - s->reach), right = (int)ceil(s->x + s->reach);
    double sum = 0;
    for (int y = top; y < bottom; y++)
        for (int x = left; x < right; x++) {
            if (x >= 0 && x < v->width && y >= 0 && y < v->height) {
                sum += cover(trace, v, s, (size_t)y * (size_t)v->width + (size_t)x, NULL);
                continue;
            }
            V3 d = v3_mad(v3_scale(s->step[0], x + 0.5 - s->x), y + 0.5 - s->y, s->step[1]);
            double kernel = positive(1 - v3_dot(d, d) / square(s->support.radius));
            if (kernel > 0 && s->support.mixed &&
                !support_sees(trace, &s->point, &s->support, v3_add(s->point.position, d)))
                continue;
            sum += even * kernel;
        }
    return sum;
}

bool wave_splat(const WaveRun *run, const WaveView *view, const WaveLanding *l, Rgb flux,
    double radius_pixels, double turn, WaveSplat *out) {
    CameraView seen;
    if (!camera_project(&view->scene->camera, l->position, &seen)) return false;
    double footprint = 1 / sqrt(seen.raster_per_area), radius = radius_pixels * footprint;
    out->reach = radius_pixels * view->scale + 1;
    out->x = seen.x * view->scale - view->x0;
    out->y = seen.y * view->scale - view->y0;
    if (out->x < -out->reach || out->x > view->width + out->reach || out->y < -out->reach ||
        out->y > view->height + out->reach)
        return false;
    double half = 0.5 / view->scale;
    for (int k = 0; k < 2; k++) {
        double x = k ? 0 : half, y = k ? half : 0;
        const Camera *camera = &view->scene->camera;
        out->step[k] = v3_sub(wave_seen_at(camera, l->position, l->normal, seen.x + x, seen.y + y),
            wave_seen_at(camera, l->position, l->normal, seen.x - x, seen.y - y));
    }
    out->point = (EyePoint){.position = l->position,
        .ng = {(float)l->normal.x, (float)l->normal.y, (float)l->normal.z},
        .turn = (float)turn,
        .object = l->object,
        .primitive = l->primitive};
    support_find(run->trace, &out->point, radius, &out->support);
    if (out->support.mixed) { /* a ray for every subpixel: near walls a smaller kernel must do */
        support_find(run->trace, &out->point, MIXED_RADIUS * radius, &out->support);
        out->reach = MIXED_RADIUS * radius_pixels * view->scale + 1;
    }
    double facing = fmax(fabs(v3_dot(seen.to_camera, l->normal)), WAVE_GRAZING_COSINE);
    double even = 1 / (seen.raster_per_area * facing * view->scale * view->scale);
    out->strays = false;
    double area = shown_area(run->trace, view, out, even);
    if (!(area > 0)) {
        out->strays = true;
        area = shown_area(run->trace, view, out, even);
    }
    if (!(area > 0)) return false;
    out->flux[0] = (float)(flux.r / area);
    out->flux[1] = (float)(flux.g / area);
    out->flux[2] = (float)(flux.b / area);
    return true;
}

void wave_splat_draw(const TraceScene *trace, WaveView *view, const WaveSplat *s, int y0, int y1) {
    int top = (int)fmax(floor(s->y - s->reach), y0), bottom = (int)fmin(ceil(s->y + s->reach), y1);
    int left = (int)fmax(floor(s->x - s->reach), 0), right = (int)fmin(ceil(s->x + s->reach), view->width);
    for (int y = top; y < bottom; y++)
        for (int x = left; x < right; x++) {
            view->lit[y] = 1;
            cover(trace, view, s, (size_t)y * (size_t)view->width + (size_t)x, view->irradiance);
        }
}
