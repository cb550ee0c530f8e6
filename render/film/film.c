/* SPDX-License-Identifier: Apache-2.0 */
#include "render/film/film.h"

#include "core/checked.h"

#include <math.h>
#include <string.h>

static void level_even(Film *film) {
    for (int i = 0; i < FILM_LEVELS; i++) film->evenness[i] = 1;
}

cau_result film_create(Film *out, size_t pixels, unsigned channels, CauError *err) {
    *out = (Film){.pixels = pixels, .channels = channels};
    level_even(out);
    size_t values;
    if (checked_mul(pixels, channels, &values)) {
        out->sum = array_new(values, sizeof(double));
        out->square_sum = array_new(values, sizeof(double));
        out->sum_low = array_new(values, sizeof(float));
        out->square_low = array_new(values, sizeof(float));
    }
    if (out->sum && out->square_sum && out->sum_low && out->square_low) return CAU_OK;
    film_free(out);
    return error_set(
        err, CAU_ERROR_RESOURCE, "out of memory for a film of %zu pixels; use a smaller resolution", pixels);
}

void film_free(Film *film) {
    free(film->sum);
    free(film->first);
    free(film->square_sum);
    free(film->sum_low);
    free(film->square_low);
    *film = (Film){0};
}

void film_clear(Film *film) {
    size_t values = film->pixels * film->channels;
    film->passes = film->stale = film->non_finite = film->first_passes = 0;
    level_even(film);
    if (!film->sum) return;
    if (film->first) memset(film->first, 0, values * sizeof *film->first);
    memset(film->sum, 0, values * sizeof *film->sum);
    memset(film->square_sum, 0, values * sizeof *film->square_sum);
    memset(film->sum_low, 0, values * sizeof *film->sum_low);
    memset(film->square_low, 0, values * sizeof *film->square_low);
}

void film_restart(Film *film) {
    film->stale = film_passes(film);
    film->passes = 0;
}

void film_add_value(double *high, float *low, double x) {
    double sum = *high + x, part = sum - *high, lost = (*high - (sum - part)) + (x - part);
    *high = sum;
    if (isfinite(lost)) *low += (float)lost;
}

/* ---- two halves ---- */

/* Of fewer passes the halves tell nothing that the passes do not. */
enum { HALVES_LEAST = 4, EVENNESS_STEPS = 4096 };
#define EVENNESS_LEAST (1.0 / 64)

cau_result film_halve(Film *film, uint64_t half, CauError *err) {
    film->first = array_new(film->pixels * film->channels, sizeof *film->first);
    film->half = half;
    return film->first
               ? CAU_OK
               : error_set(err, CAU_ERROR_RESOURCE,
                     "out of memory for the halves of %zu pixels; use a smaller resolution", film->pixels);
}

static void take_half(Film *film) {
    size_t values = film->pixels * film->channels;
    for (size_t i = 0; i < values; i++) film->first[i] = film->sum[i] + (double)film->sum_low[i];
    film->first_passes = film->passes;
}

/* Squared standard error of the mean by the spread of the passes. */
static double spread(const Film *film, size_t i) {
    double n = (double)film_passes(film), mean = film_mean(film, i);
    double square = (film->square_sum[i] + (double)film->square_low[i]) / n;
    return fmax(0, square - mean * mean) / (n - 1);
}

static int level_of(const Film *film, size_t i) {
    int exponent = 1;
    if (film->brightest > 0) frexp(film_mean(film, i) / film->brightest, &exponent);
    int level = (1 - exponent) / 2;
    return level < 0 ? 0 : level < FILM_LEVELS ? level : FILM_LEVELS - 1;
}

static void find_brightest(Film *film) {
    film->brightest = 0;
    for (size_t i = 0; i < film->pixels * film->channels; i++)
        film->brightest = fmax(film->brightest, film_mean(film, i));
}

/* Sums over the values of a level of the squared error of the mean. */
typedef struct Level {
    double by_passes, by_halves, fourth;
} Level;

/* Of so many independent values as the fourth powers tell, the sum of squares is off by sqrt(2 / n). */
static double level_evenness(const Level *l) {
    if (!(l->by_passes > 0) || !(l->by_halves > 0)) return 1;
    double own_error = sqrt(2 * l->fourth) / l->by_halves;
    double evenness = l->by_halves / l->by_passes * (1 + own_error);
    return fmin(fmax(ceil(evenness * EVENNESS_STEPS) / EVENNESS_STEPS, EVENNESS_LEAST), 1);
}

void film_settle(Film *film) {
    level_even(film);
    if (!film->first || film->passes < HALVES_LEAST || film->first_passes == 0 ||
        film->first_passes >= film->passes)
        return;
    double n = (double)film->passes, a = (double)film->first_passes, b = n - a;
    Level levels[FILM_LEVELS] = {{0}};
    size_t values = film->pixels * film->channels;
    find_brightest(film);
    for (size_t i = 0; film->brightest > 0 && i < values; i++) {
        Level *level = &levels[level_of(film, i)];
        double second = film->sum[i] + (double)film->sum_low[i] - film->first[i];
        double square =
            (film->first[i] / a - second / b) * (film->first[i] / a - second / b) * a * b / (n * n);
        level->by_passes += spread(film, i);
        level->by_halves += square;
        level->fourth += square * square;
    }
    for (int i = 0; i < FILM_LEVELS; i++) film->evenness[i] = level_evenness(&levels[i]);
}

/* ---- passes ---- */

static bool is_power_of_two(uint64_t n) { return n && !(n & (n - 1)); }

static void add_values(Film *film, const double *pass) {
    size_t values = film->pixels * film->channels;
    for (size_t i = 0; i < values; i++) {
        double x = pass[i];
        if (!isfinite(x)) {
            film->non_finite++;
            continue;
        }
        film_add_value(&film->sum[i], &film->sum_low[i], x);
        film_add_value(&film->square_sum[i], &film->square_low[i], x * x);
    }
}

void film_add(Film *film, const double *pass) {
    if (film->stale) film_clear(film);
    if (film->first && film->half == FILM_DOUBLING && is_power_of_two(film->passes)) take_half(film);
    film->passes++;
    if (pass) add_values(film, pass);
    if (!film->first) return;
    if (film->passes == film->half) take_half(film);
    film_settle(film);
}

double film_mean(const Film *film, size_t i) {
    uint64_t n = film_passes(film);
    return n ? (film->sum[i] + (double)film->sum_low[i]) / (double)n : 0;
}

double film_error(const Film *film, size_t i) {
    if (film_passes(film) < 2) return 0;
    return sqrt(film->first ? spread(film, i) * film->evenness[level_of(film, i)] : spread(film, i));
}

FilmFigures film_figures(const Film *film) {
    double mean = 0, square_sum = 0, error = 0;
    size_t values = film->pixels * film->channels;
    for (size_t i = 0; i < values; i++) {
        double m = film_mean(film, i), e = film_error(film, i);
        mean += m;
        square_sum += m * m;
        error += e * e;
    }
    double n = values ? (double)values : 1;
    FilmFigures f = {.mean = mean / n, .rms = sqrt(square_sum / n), .error_rms = sqrt(error / n)};
    /* E[m^2] = truth^2 + variance: without this a picture of pure noise would claim an error of 100 % at
     * most. */
    double truth = fmax(square_sum - error, 0);
    if (square_sum == 0)
        f.relative_error = 0;
    else
        f.relative_error = film_passes(film) < 2 || truth == 0 ? INFINITY : sqrt(error / truth);
    return f;
}
