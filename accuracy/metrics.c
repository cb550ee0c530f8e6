/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/metrics.h"

#include "core/checked.h"

#include <math.h>

static const double FLOOR = 0.01;   /* of the squared mean: dark pixels do not decide */
static const double TRIMMED = 0.01; /* of the pixels */

static int larger_first(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x < y) - (x > y);
}

cau_result metrics_check_reference(const float *t, size_t pixels, const char *name, CauError *err) {
    double sum = 0;
    for (size_t i = 0; i < 3 * pixels; i++) {
        if (!isfinite(t[i]))
            return error_set(err, CAU_ERROR_INPUT,
                "the reference %s holds a value that is not finite in pixel %zu; render it anew", name,
                i / 3);
        sum += (double)t[i];
    }
    if (sum > 0) return CAU_OK;
    return error_set(err, CAU_ERROR_INPUT,
        "the reference %s is black: there is no caustic to compare; choose another scene or view", name);
}

cau_result metrics_of(const float *x, const float *t, size_t pixels, Metrics *out, CauError *err) {
    double mean = 0, energy = 0, square = 0, difference = 0, all = 0, rest = 0;
    for (size_t i = 0; i < 3 * pixels; i++) {
        if (!isfinite(x[i]))
            return error_set(
                err, CAU_ERROR_INTERNAL, "a render holds a value that is not finite in pixel %zu", i / 3);
        mean += (double)t[i];
        energy += (double)x[i];
        square += (double)t[i] * (double)t[i];
    }
    out->energy = energy / mean;
    mean /= (double)(3 * pixels);
    double *each = array_new(pixels, sizeof *each);
    if (!each) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu pixels", pixels);
    for (size_t i = 0; i < 3 * pixels; i++) {
        double d = (double)x[i] - (double)t[i];
        difference += d * d;
        each[i / 3] += d * d / ((double)t[i] * (double)t[i] + FLOOR * mean * mean) / 3;
    }
    qsort(each, pixels, sizeof *each, larger_first);
    size_t left_out = (size_t)(TRIMMED * (double)pixels);
    for (size_t i = pixels; i-- > 0;) {
        all += each[i];
        if (i >= left_out) rest += each[i];
    }
    free(each);
    out->rel_mse = all / (double)pixels;
    out->trimmed_rel_mse = rest / (double)(pixels - left_out);
    out->nrmse = sqrt(difference / square);
    return CAU_OK;
}

double metrics_distance(const float *a, const float *b, const float *t, size_t pixels) {
    double difference = 0, square = 0;
    for (size_t i = 0; i < 3 * pixels; i++) {
        double d = (double)a[i] - (double)b[i];
        difference += d * d;
        square += (double)t[i] * (double)t[i];
    }
    return sqrt(difference / square);
}

double metrics_exponent(const double *x, const double *y, size_t count) {
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (size_t i = 0; i < count; i++) {
        if (!(x[i] > 0) || !(y[i] > 0)) continue;
        double a = log(x[i]), b = log(y[i]);
        n += 1, sx += a, sy += b, sxx += a * a, sxy += a * b;
    }
    double d = n * sxx - sx * sx;
    return n >= 2 && d > 0 ? -(n * sxy - sx * sy) / d : NAN;
}
