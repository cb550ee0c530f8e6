/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  One render in a process of its own, with what it cost.
 *
 *  A child's CPU time and peak memory are its own (wait4), and nothing that one render leaves behind helps
 * the next. The calling process must have one thread only. */
#ifndef ACCURACY_MEASURE_H
#define ACCURACY_MEASURE_H

#include "caustics/render.h"
#include "core/error.h"

#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <sys/types.h>

/** What a process cost. */
typedef struct Cost {
    double cpu_s;  /**< user and system */
    double wall_s; /**< from fork to end */
    long peak_kib; /**< largest resident set */
} Cost;

/** A picture and what it cost. */
typedef struct Shot {
    int width, height;
    float *rgb; /**< width * height * 3 values, sum of the light layers, owned; NULL after plan_only */
    uint64_t photons;
    double stated;   /**< the render's own error, RMSE over RMS; < 0: not known */
    double before_s; /**< CPU seconds of loading and planning, part of cost.cpu_s */
    bool waved;      /**< the plan gives some light to estimator W */
    Cost cost;
} Shot;

void shot_free(Shot *shot);

/** Renders `scene` with `options`; with `plan_only` it ends after the plan. `stop` is asked when a signal
 * comes: then the child is ended and CAU_ERROR_CANCELLED returned. On failure `out` is zeroed. */
cau_result measure_render(const char *scene, const cau_render_options *options, bool plan_only,
    const volatile sig_atomic_t *stop, Shot *out, CauError *err);

/** Waits for child `pid`, started at `began_s` of now_s(). CAU_ERROR_INPUT when it failed. */
cau_result measure_wait(
    pid_t pid, double began_s, const volatile sig_atomic_t *stop, const char *what, Cost *out, CauError *err);

/** Wall seconds of a steady clock. */
double now_s(void);

#endif
