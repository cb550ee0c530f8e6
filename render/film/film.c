/* SPDX-License-Identifier: Apache-2.0 */
#include "render/film/film.h"

#include "core/checked.h"

#include <math.h>

cau_result film_create(Film *out, size_t pixels, unsigned channels, CauError *err) {
    *out = (Film){.pixels = pixels, .channels = channels};
    size_t values;
    if (checked_mul(pixels, channels, &values)) {
        out->sum = array_new(values, sizeof(double));
        out->square_sum = array_new(values, sizeof(double));
    }
    if (out->sum && out->square_sum) return CAU_OK;
    film_free(out);
    return error_set(
        err, CAU_ERROR_RESOURCE, "out of memory for a film of %zu pixels; use a smaller resolution", pixels);
}

void film_free(Film *film) {
    free(film->sum);
    free(film->square_sum);
    *film = (Film){0};
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
        film->sum[i] += x;
        film->square_sum[i] += x * x;
    }
}

double film_mean(const Film *film, size_t i) {
    return film->passes ? film->sum[i] / (double)film->passes : 0;
}

double film_error(const Film *film, size_t i) {
    if (film->passes < 2) return 0;
    double n = (double)film->passes, mean = film->sum[i] / n;
    double variance = fmax(0, film->square_sum[i] / n - mean * mean) * n / (n - 1);
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
