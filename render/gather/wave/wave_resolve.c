/* SPDX-License-Identifier: Apache-2.0 */
/* From the view's subpixels to the pixels of a pass. */
#include "render/gather/wave/wave_internal.h"

#include <string.h>

typedef struct ResolveJob {
    WaveView *view;
    const PassImages *images;
} ResolveJob;

/* A mixed subpixel gets the mean irradiance of its parts, and the weight that gives their mean radiance. */
static void fold_row(void *data, size_t index, unsigned thread) {
    (void)thread;
    WaveView *v = data;
    if (!v->lit[index]) return;
    size_t parts = (size_t)v->parts * (size_t)v->parts;
    for (size_t b = v->row_blocks[index]; b < v->row_blocks[index + 1]; b++) {
        size_t mixed = 3 * (size_t)v->block[b], first = 3 * (v->grid + b * parts);
        for (size_t k = 0; k < 3; k++) {
            double irradiance = 0, radiance = 0;
            for (size_t i = first + k; i < first + 3 * parts; i += 3) {
                irradiance += (double)v->irradiance[i];
                radiance += (double)v->irradiance[i] * (double)v->weight[i];
            }
            v->irradiance[mixed + k] = (float)(irradiance / (double)parts);
            v->weight[mixed + k] = irradiance > 0 ? (float)(radiance / irradiance) : 0;
        }
    }
}

/* Filters the rows of a pixel row into one: radiance, and behind it irradiance when it is wanted, per column
 * of subpixels. False when there is no light. */
static bool resolve_columns(const WaveView *v, int top, double *columns, bool irradiance) {
    size_t values = 3 * (size_t)v->width;
    bool any = false;
    for (int j = 0; j < v->taps; j++) any |= v->lit[top + j];
    if (!any) return false;
    memset(columns, 0, (irradiance ? 2 : 1) * values * sizeof *columns);
    for (int j = 0; j < v->taps; j++) {
        if (!v->lit[top + j]) continue;
        const float *e = v->irradiance + (size_t)(top + j) * values,
                    *w = v->weight + (size_t)(top + j) * values;
        double tap = v->tap[j];
        for (size_t i = 0; i < values; i++) columns[i] += tap * (double)e[i] * (double)w[i];
        for (size_t i = 0; irradiance && i < values; i++) columns[values + i] += tap * (double)e[i];
    }
    return true;
}

/* One pixel from the columns. */
static void resolve_pixel(const WaveView *v, const double *columns, double gain, double *out) {
    double sum[3] = {0};
    for (int i = 0; i < v->taps; i++)
        for (int k = 0; k < 3; k++) sum[k] += v->tap[i] * columns[3 * i + k];
    for (int k = 0; k < 3; k++) out[k] += gain * sum[k];
}

static void resolve_row(void *data, size_t index, unsigned thread) {
    const ResolveJob *job = data;
    const WaveView *v = job->view;
    const Camera *camera = &v->scene->camera;
    double *columns = v->columns + 6 * (size_t)thread * (size_t)v->width;
    bool irradiance = job->images->irradiance != NULL;
    if (!resolve_columns(v, (int)index * v->scale, columns, irradiance)) return;
    size_t row = ((size_t)v->region[1] + index) * (size_t)camera->width;
    for (int x = v->region[0]; x < v->region[2]; x++) {
        const double *c = columns + 3 * (size_t)((x - v->region[0]) * v->scale);
        size_t at = 3 * (row + (size_t)x);
        resolve_pixel(v, c, 1, job->images->radiance + at);
        if (irradiance)
            resolve_pixel(v, c + 3 * (size_t)v->width, camera->exposure, job->images->irradiance + at);
    }
}

void wave_resolve(WaveView *v, TaskPool *pool, const PassImages *images) {
    ResolveJob job = {v, images};
    if (v->blocks) tasks_run(pool, (size_t)v->height, fold_row, v);
    tasks_run(pool, (size_t)(v->region[3] - v->region[1]), resolve_row, &job);
    for (int y = 0; y < v->height; y++)
        if (v->lit[y])
            memset(v->irradiance + 3 * (size_t)y * (size_t)v->width, 0, 3 * (size_t)v->width * sizeof(float));
    size_t parts = v->blocks * (size_t)v->parts * (size_t)v->parts;
    memset(v->irradiance + 3 * v->grid, 0, 3 * parts * sizeof *v->irradiance);
    memset(v->lit, 0, (size_t)v->height);
}
