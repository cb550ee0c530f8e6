/* SPDX-License-Identifier: Apache-2.0 */
#include "render/film/film.h"

#include "core/checked.h"

#include <math.h>
#include <string.h>

cau_result film_create(Film *out, size_t pixels, unsigned channels, CauError *err) {
    *out = (Film){.pixels = pixels, .channels = channels};
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
    free(film->square_sum);
    free(film->sum_low);
    free(film->square_low);
    *film = (Film){0};
}

void film_clear(Film *film) {
    size_t values = film->pixels * film->channels;
    film->passes = film->non_finite = 0;
    if (!film->sum) return;
    memset(film->sum, 0, values * sizeof *film->sum);
    memset(film->square_sum, 0, values * sizeof *film->square_sum);
    memset(film->sum_low, 0, values * sizeof *film->sum_low);
    memset(film->square_low, 0, values * sizeof *film->square_low);
}

void film_add_value(double *high, float *low, double x) {
    double sum = *high + x, part = sum - *high, lost = (*high - (sum - part)) + (x - part);
    *high = sum;
    if (isfinite(lost)) *low += (float)lost;
}

void film_add(Film *film, const double *pass) {
    film->passes++;
    if (!pass) return;
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

double film_mean(const Film *film, size_t i) {
    return film->passes ? (film->sum[i] + (double)film->sum_low[i]) / (double)film->passes : 0;
}

double film_error(const Film *film, size_t i) {
    if (film->passes < 2) return 0;
    double n = (double)film->passes, mean = film_mean(film, i);
    double square = (film->square_sum[i] + (double)film->square_low[i]) / n;
    double variance = fmax(0, square - mean * mean) * n / (n - 1);
    return sqrt(variance / n);
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
        f.relative_error = film->passes < 2 || truth == 0 ? INFINITY : sqrt(error / truth);
    return f;
}
