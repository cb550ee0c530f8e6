/* SPDX-License-Identifier: Apache-2.0 */
/* Light that no triangle claimed, on what the camera sees directly: each photon is spread by a kernel over
 * its own receiver. The kernel's support is taken at the photon, so that all of its flux lands. */
#include "render/gather/wave/wave_internal.h"

#define MIXED_RADIUS 0.35

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

/* The kernel at a subpixel; 0 where it is another surface or hidden from the photon. */
static double kernel_at(const TraceScene *trace, const WaveSplat *s, const WaveSubpixel *p) {
    if (p->object != s->point.object) return 0;
    V3 n = v3((double)s->point.ng[0], (double)s->point.ng[1], (double)s->point.ng[2]);
    V3 place = v3((double)p->position[0], (double)p->position[1], (double)p->position[2]);
    double r = s->support.radius;
    V3 d = v3_sub(place, s->point.position);
    double height = v3_dot(d, n), across = v3_dot(d, d) - height * height;
    if (across >= r * r || fabs(height) > SUPPORT_HEIGHT * r) return 0;
    if (v3_dot(v3((double)p->normal[0], (double)p->normal[1], (double)p->normal[2]), n) < SUPPORT_COSINE)
        return 0;
    if (s->support.mixed && !support_sees(trace, &s->point, &s->support, v3_mad(place, -height, n))) return 0;
    return 1 - across / (r * r);
}

void wave_splat_draw(const TraceScene *trace, WaveView *view, const WaveSplat *s, int y0, int y1) {
    int top = (int)fmax(floor(s->y - s->reach), y0), bottom = (int)fmin(ceil(s->y + s->reach), y1);
    int left = (int)fmax(floor(s->x - s->reach), 0), right = (int)fmin(ceil(s->x + s->reach), view->width);
    for (int y = top; y < bottom; y++)
        for (int x = left; x < right; x++) {
            size_t at = (size_t)y * (size_t)view->width + (size_t)x;
            double k = kernel_at(trace, s, &view->subpixels[at]);
            if (k <= 0) continue;
            view->lit[y] = 1;
            for (size_t c = 0; c < 3; c++) view->irradiance[3 * at + c] += (float)(k * (double)s->flux[c]);
        }
}
