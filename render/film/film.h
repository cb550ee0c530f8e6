/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The film: per-pixel sums over independent passes, and what they say about their own error.
 *
 *  A pass is one independent randomised replica of the estimate. Sums carry what their rounding lost
 * (Neumaier 1974, "Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen"), to 2^-77 of the
 * sum: so the shares of a render that several machines made add up to the picture that one machine makes. The
 * standard error of the mean comes from the spread of the passes. */
#ifndef RENDER_FILM_FILM_H
#define RENDER_FILM_FILM_H

#include "core/error.h"

#include <stddef.h>
#include <stdint.h>

typedef struct Film {
    size_t pixels;
    unsigned channels; /**< 1 or 3 */
    double *sum, *square_sum;
    float *sum_low, *square_low; /**< what the rounding of the sums lost, to be added */
    uint64_t passes;
    uint64_t non_finite; /**< values of a pass refused because they were NaN or Inf (counted as 0) */
} Film;

cau_result film_create(Film *out, size_t pixels, unsigned channels, CauError *err);
void film_free(Film *film);

/** Adds a pass (pixels * channels values). NULL is a black pass. */
void film_add(Film *film, const double *pass);

/** Forgets all passes. */
void film_clear(Film *film);

/** Adds x to the sum *high + *low. */
void film_add_value(double *high, float *low, double x);

/** Mean over the passes of value i (0 without passes). */
double film_mean(const Film *film, size_t i);
/** Standard error of that mean; 0 with fewer than 2 passes. */
double film_error(const Film *film, size_t i);

/** Root mean square of the mean and of its standard error over all values, as one figure each. */
typedef struct FilmFigures {
    double mean, rms, error_rms;
    double relative_error; /**< error_rms / rms, rms freed of the noise's own share; INFINITY when unknown, 0
                              when black */
} FilmFigures;
FilmFigures film_figures(const Film *film);

#endif
