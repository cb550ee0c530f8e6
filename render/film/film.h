/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The film: per-pixel sums over independent passes, and what they say about their own error.
 *
 *  A pass is one independent randomised replica of the estimate. Sums carry what their rounding lost
 * (Neumaier 1974, "Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen"), to 2^-77 of the
 * sum: so the shares of a render that several machines made add up to the picture that one machine makes. The
 * standard error of the mean comes from the spread of the passes.
 *
 * Passes that are parts of one low-discrepancy sequence are evener together than each for itself, and their
 * spread says too much. A film of two halves also knows the sum of the first half of its passes: half the
 * difference of the two means would be the standard error if the halves knew nothing of each other, and is
 * less where evenness pays (Owen 1997 has the variance of such sums fall faster than that of independent
 * ones). It says too much still, for the two are evener than each, but by less. */
#ifndef RENDER_FILM_FILM_H
#define RENDER_FILM_FILM_H

#include "core/error.h"

#include <stddef.h>
#include <stdint.h>

/** Evenness differs between a focus and the faint light around it: it is known for so many levels of
 * brightness, each a fourth of the one before. */
enum { FILM_LEVELS = 12 };

typedef struct Film {
    size_t pixels;
    unsigned channels; /**< 1 or 3 */
    double *sum, *square_sum;
    float *sum_low, *square_low;  /**< what the rounding of the sums lost, to be added */
    double *first;                /**< of two halves: the sum of the first passes; else NULL */
    uint64_t first_passes;        /**< that it holds */
    uint64_t half;                /**< that it is to hold, or FILM_DOUBLING */
    double evenness[FILM_LEVELS]; /**< see film_settle(); [0]: of the brightest */
    double brightest;             /**< value of the mean */
    uint64_t passes;
    uint64_t stale;      /**< passes that the sums hold still, see film_restart() */
    uint64_t non_finite; /**< values of a pass refused because they were NaN or Inf (counted as 0) */
} Film;

cau_result film_create(Film *out, size_t pixels, unsigned channels, CauError *err);
void film_free(Film *film);

/** The first half is the passes before the last power of two. */
#define FILM_DOUBLING UINT64_MAX

/** Makes an empty film one of two halves, the first of `half` passes. */
cau_result film_halve(Film *film, uint64_t half, CauError *err);

/** Sets the evenness anew: the squared error of the mean that the halves tell, over what the spread of the
 * passes does, summed over all values of a level and by its own standard error greater; 1/64 to 1, and 1
 * where there are no two halves. In steps of 1/4096, so that what the sums of shards lose in rounding does
 * not show. Part of film_add(). */
void film_settle(Film *film);

/** Adds a pass (pixels * channels values). NULL is a black pass. */
void film_add(Film *film, const double *pass);

/** Forgets all passes. */
void film_clear(Film *film);

/** Forgets all passes when the next is added: until then the picture is still that of the old ones, so that a
 * render that is stopped there has one. */
void film_restart(Film *film);

/** The passes that the picture is the mean of. */
static inline uint64_t film_passes(const Film *film) { return film->passes ? film->passes : film->stale; }

/** Adds x to the sum *high + *low. */
void film_add_value(double *high, float *low, double x);

/** Mean over the passes of value i (0 without passes). */
double film_mean(const Film *film, size_t i);
/** Standard error of that mean: by the spread of the passes and their evenness; 0 with fewer than 2 passes.
 */
double film_error(const Film *film, size_t i);

/** Root mean square of the mean and of its standard error over all values, as one figure each. */
typedef struct FilmFigures {
    double mean, rms, error_rms;
    double relative_error; /**< error_rms / rms, rms freed of the noise's own share; INFINITY when unknown, 0
                              when black */
} FilmFigures;
FilmFigures film_figures(const Film *film);

#endif
