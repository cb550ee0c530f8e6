/* SPDX-License-Identifier: Apache-2.0 */
#include "render/film/bandwidth.h"

#include "core/checked.h"
#include "core/wide.h"

/* Least squared bias that is believed, in parts of the noise: bounds how fast a kernel grows. */
#define BIAS_LEAST 0.005
/* Bias that chance may show in a window, in parts of the noise: the radius is not to fall by luck, for it
 * rises slowly. */
#define BIAS_CHANCE 0.8
/* In footprints: what kernels may cost makes none narrower. */
#define RADIUS_NARROW 2.0
/* Half a window's edge in kernel radii, and its limits in pixels. */
#define WINDOW_RADII 2.0
#define WINDOW_MIN 2
#define WINDOW_MAX 24
/* Widest kernel in pixel footprints, and the most that it may change at once. */
#define RADIUS_MAX 24.0
/* See keep_apart(). */
#define LEVEL_STEP 1.4
/* Steep, or light at the foot of a slope is met by too few: a mirror tube lost .7 % of its flux by .5. */
#define LEVEL_SLOPE 0.8
/* Least learned radius in footprints: what is finer lies well within the pixel. It shrinks with the photons
 * as any. */
#define RADIUS_LEAST 0.15
#define CHANGE_MIN 0.5
#define CHANGE_MAX 1.6
/* A radius that is wanted less than this part of the old one is still falling. */
#define FALLING 0.7

cau_result bandwidth_create(Bandwidth *out, int width, int height, double radius, bool waves, CauError *err) {
    size_t pixels = (size_t)width * (size_t)height;
    *out = (Bandwidth){.width = width, .height = height, .radius = array_new(pixels, sizeof(float))};
    if (!out->radius)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the kernels of %zu pixels", pixels);
    bandwidth_restart(out, radius);
    if (waves) CAU_TRY(film_create(&out->waves, pixels, 1, err));
    return film_create(&out->bias, pixels, 3, err);
}

void bandwidth_restart(Bandwidth *b, double radius) {
    size_t pixels = (size_t)b->width * (size_t)b->height;
    for (size_t i = 0; i < pixels; i++) b->radius[i] = (float)radius;
    b->tried = false;
}

void bandwidth_free(Bandwidth *b) {
    free(b->radius);
    film_free(&b->bias);
    film_free(&b->waves);
    *b = (Bandwidth){0};
}

double bandwidth_mean_radius(const Bandwidth *b) {
    size_t pixels = (size_t)b->width * (size_t)b->height;
    double sum = 0;
    for (size_t i = 0; i < pixels; i++) sum += (double)b->radius[i];
    return pixels ? sum / (double)pixels : 0;
}

/* ---- learning ---- */

/* Sums over any rectangle from the top left corner on: [(height + 1) * (width + 1)]. */
typedef struct Sums {
    double *noise, *bias; /* variance and squared bias of the mean over the passes */
    double *light;        /* the noise's root, which grows with the light */
    int width, height;
} Sums;

static cau_result sums_create(Sums *s, const Bandwidth *b, CauError *err) {
    size_t count = ((size_t)b->width + 1) * ((size_t)b->height + 1);
    *s = (Sums){array_new(count, sizeof(double)), array_new(count, sizeof(double)),
        array_new(count, sizeof(double)), b->width, b->height};
    return s->noise && s->bias && s->light
               ? CAU_OK
               : error_set(err, CAU_ERROR_RESOURCE, "out of memory to learn the kernels");
}

static void sums_free(Sums *s) {
    free(s->noise);
    free(s->bias);
    free(s->light);
}

static size_t sums_place(const Sums *s, int x, int y) {
    return (size_t)y * ((size_t)s->width + 1) + (size_t)x;
}

/* From values at [y + 1][x + 1] to sums. */
static void sum_up(const Sums *s, double *values) {
    for (int y = 1; y <= s->height; y++) {
        double row = 0;
        for (int x = 1; x <= s->width; x++) {
            row += values[sums_place(s, x, y)];
            values[sums_place(s, x, y)] = row + values[sums_place(s, x, y - 1)];
        }
    }
}

static double window_sum(const Sums *s, const double *sums, int x, int y, int half) {
    int x0 = x > half ? x - half : 0, y0 = y > half ? y - half : 0, x1 = x + half + 1, y1 = y + half + 1;
    if (x1 > s->width) x1 = s->width;
    if (y1 > s->height) y1 = s->height;
    return sums[sums_place(s, x1, y1)] - sums[sums_place(s, x0, y1)] - sums[sums_place(s, x1, y0)] +
           sums[sums_place(s, x0, y0)];
}

static int window_of(double radius) {
    return (int)clamp(ceil(WINDOW_RADII * radius), WINDOW_MIN, WINDOW_MAX);
}

/* The radius that balances noise and bias, of kernels of radius `old`. */
static double balance(double old, double noise, double bias) {
    if (!(noise > 0)) return old;
    return old * pow(noise / (12 * fmax(bias - BIAS_CHANCE * noise, BIAS_LEAST * noise)), 1.0 / 6);
}

/* For every pixel. Returns the share of the light whose kernels are still falling. */
static double choose(Bandwidth *b, const Sums *s, const double *cost, const BandwidthTrial *t) {
    double shrink = t->shrink, falling = 0, all = s->light[sums_place(s, s->width, s->height)];
    for (int y = 0; y < b->height; y++)
        for (int x = 0; x < b->width; x++) {
            size_t i = (size_t)y * (size_t)b->width + (size_t)x;
            double old = (double)b->radius[i] * shrink;
            int half = window_of(old);
            double noise = window_sum(s, s->noise, x, y, half), bias = window_sum(s, s->bias, x, y, half);
            double r = balance(old, noise, bias), narrow = RADIUS_NARROW * shrink;
            if (cost[i] > 0) r = fmin(r, fmax(old * sqrt(t->most / cost[i]), narrow));
            if (r < FALLING * old) falling += window_sum(s, s->light, x, y, 0);
            r = fmin(clamp(r, CHANGE_MIN * old, CHANGE_MAX * old), RADIUS_MAX);
            if (t->settle) r = sqrt(r * old);
            b->radius[i] = (float)fmax(r / shrink, RADIUS_LEAST);
        }
    return all > 0 ? falling / all : 0;
}

/* Windows with less than this part of the light are rounding. */
#define LIGHT_LEAST 1e-9

/* The mean of the logarithms around, weighted by the light. A dark pixel beside a bright one knows the
 * other's bias but little of its noise, and would have the narrower kernel: light near an edge would be
 * gathered by too few. So the radius is that of the light that it gathers. The sums of the noise are used up.
 */
static void share_radii(Bandwidth *b, Sums *s, double shrink) {
    double *product = s->noise, all = s->light[sums_place(s, s->width, s->height)];
    for (int y = 0; y < b->height; y++)
        for (int x = 0; x < b->width; x++) {
            double radius = (double)b->radius[(size_t)y * (size_t)b->width + (size_t)x];
            product[sums_place(s, x + 1, y + 1)] = window_sum(s, s->light, x, y, 0) * log(radius);
        }
    sum_up(s, product);
    for (int y = 0; y < b->height; y++)
        for (int x = 0; x < b->width; x++) {
            float *radius = &b->radius[(size_t)y * (size_t)b->width + (size_t)x];
            int half = window_of((double)*radius * shrink);
            double light = window_sum(s, s->light, x, y, half);
            if (light > LIGHT_LEAST * all) *radius = (float)exp(window_sum(s, product, x, y, half) / light);
        }
}

double bandwidth_bias2(const Film *bias, size_t pixel) {
    double n = (double)film_passes(bias), sum = 0;
    if (n < 2) return 0;
    for (size_t c = bias->channels * pixel; c < bias->channels * (pixel + 1); c++)
        sum += square(bias->sum[c] + (double)bias->sum_low[c]) -
               (bias->square_sum[c] + (double)bias->square_low[c]);
    return sum / (bias->channels * n * (n - 1));
}

static double all_bias2(const Bandwidth *b, size_t pixel) {
    return bandwidth_bias2(&b->bias, pixel) + bandwidth_bias2(&b->waves, pixel);
}

double bandwidth_bias(const Bandwidth *b, size_t pixel) {
    enum { HALF = 2 };
    int x = (int)(pixel % (size_t)b->width), y = (int)(pixel / (size_t)b->width), count = 0;
    double sum = 0;
    for (int v = y - HALF; v <= y + HALF; v++)
        for (int u = x - HALF; u <= x + HALF; u++) {
            if (u < 0 || v < 0 || u >= b->width || v >= b->height) continue;
            sum += all_bias2(b, (size_t)v * (size_t)b->width + (size_t)u);
            count++;
        }
    return sqrt(fmax(0, sum / count));
}

double bandwidth_mean_bias2(const Bandwidth *b) {
    size_t pixels = (size_t)b->width * (size_t)b->height;
    double sum = 0;
    for (size_t i = 0; i < pixels; i++) sum += all_bias2(b, i);
    return pixels ? fmax(0, sum / (double)pixels) : 0;
}

/* ---- neighbours ---- */

/* From the row before it, which is known. */
static void distances_across(float *row, const float *known, int width) {
    const float diagonal = 1.41421356F;
    for (int x = 0; x < width; x++) row[x] = wide_min(row[x], known[x] + 1);
    for (int x = 1; x < width; x++) row[x] = wide_min(row[x], known[x - 1] + diagonal);
    for (int x = 0; x + 1 < width; x++) row[x] = wide_min(row[x], known[x + 1] + diagonal);
}

/* Distance in pixels to the nearest pixel that has 0, by two sweeps. */
static void distances(float *d, int width, int height) {
    for (int y = 0; y < height; y++) {
        float *row = &d[(size_t)y * (size_t)width];
        if (y > 0) distances_across(row, row - width, width);
        for (int x = 1; x < width; x++) row[x] = wide_min(row[x], row[x - 1] + 1);
    }
    for (int y = height - 1; y >= 0; y--) {
        float *row = &d[(size_t)y * (size_t)width];
        if (y + 1 < height) distances_across(row, row + width, width);
        for (int x = width - 2; x >= 0; x--) row[x] = wide_min(row[x], row[x + 1] + 1);
    }
}

/* Which pixels have a radius of at most `learned`: 0 there; false where all or none have. */
static bool level_set(const Bandwidth *b, double learned, float *d, size_t pixels) {
    size_t low = 0;
    for (size_t i = 0; i < pixels; i++) {
        bool is_low = (double)b->radius[i] <= learned;
        d[i] = is_low ? 0 : INFINITY;
        low += is_low;
    }
    return low > 0 && low < pixels;
}

/* Light that a narrow kernel keeps to its place must not be met again by the wide kernels around it, or there
 * would be more of it: a radius stays what it is within that reach of a smaller one, and grows slowly beyond.
 */
static cau_result keep_apart(Bandwidth *b, double shrink, CauError *err) {
    size_t pixels = (size_t)b->width * (size_t)b->height;
    float *d = array_new(pixels, sizeof *d);
    if (!d) return error_set(err, CAU_ERROR_RESOURCE, "out of memory to learn the kernels");
    for (double level = RADIUS_MAX / LEVEL_STEP; level > RADIUS_LEAST * shrink / LEVEL_STEP;
         level /= LEVEL_STEP) {
        if (!level_set(b, level / shrink, d, pixels)) continue;
        distances(d, b->width, b->height);
        for (size_t i = 0; i < pixels; i++) {
            double most = fmax(level, (1 - LEVEL_SLOPE) * level + LEVEL_SLOPE * (double)d[i]) / shrink;
            if (d[i] > 0 && (double)b->radius[i] > most) b->radius[i] = (float)most;
        }
    }
    free(d);
    return CAU_OK;
}

cau_result bandwidth_learn(Bandwidth *b, const Film *film, const Film *bias, const double *cost,
    const BandwidthTrial *trial, double *falling, CauError *err) {
    Sums s;
    cau_result result = sums_create(&s, b, err);
    for (int y = 0; result == CAU_OK && y < b->height; y++)
        for (int x = 0; x < b->width; x++) {
            size_t i = (size_t)y * (size_t)b->width + (size_t)x, to = sums_place(&s, x + 1, y + 1);
            for (size_t c = 3 * i; c < 3 * i + 3; c++) s.noise[to] += square(film_error(film, c)) / 3;
            s.light[to] = sqrt(s.noise[to]);
            s.bias[to] = bandwidth_bias2(bias, i);
        }
    if (result == CAU_OK) {
        sum_up(&s, s.noise);
        sum_up(&s, s.bias);
        sum_up(&s, s.light);
        *falling = choose(b, &s, cost, trial);
        share_radii(b, &s, trial->shrink);
        result = keep_apart(b, trial->shrink, err);
    }
    sums_free(&s);
    return result;
}
