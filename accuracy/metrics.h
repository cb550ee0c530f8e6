/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  How far a picture is from the reference. */
#ifndef ACCURACY_METRICS_H
#define ACCURACY_METRICS_H

#include "core/error.h"

#include <stddef.h>

typedef struct Metrics {
    double rel_mse;         /**< mean of (x - t)^2 / (t^2 + 0.01 mean(t)^2) over pixels and channels */
    double trimmed_rel_mse; /**< without the worst 1 % of pixels */
    double nrmse;           /**< RMSE over the RMS of the reference */
    double energy;          /**< sum over sum */
} Metrics;

/** Compares `pixels` RGB pixels of `x` with the reference `t`, which must be finite and not black. A value of
 *  `x` that is not finite is an error. CAU_ERROR_RESOURCE when out of memory. */
cau_result metrics_of(const float *x, const float *t, size_t pixels, Metrics *out, CauError *err);

/** CAU_ERROR_INPUT when `t`, called `name`, holds a value that is not finite or nothing above 0. */
cau_result metrics_check_reference(const float *t, size_t pixels, const char *name, CauError *err);

/** RMSE between two pictures over the RMS of `t`. */
double metrics_distance(const float *a, const float *b, const float *t, size_t pixels);

/** Least squares of log y = c - exponent log x over points with x, y > 0; NaN with fewer than two. */
double metrics_exponent(const double *x, const double *y, size_t count);

#endif
