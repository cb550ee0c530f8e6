/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What a run of caustic-accuracy measures. */
#ifndef ACCURACY_STUDY_H
#define ACCURACY_STUDY_H

#include "accuracy/measure.h"
#include "accuracy/metrics.h"
#include "accuracy/options.h"

enum { SERIES_MAX = ESTIMATORS_MAX + 1, EFFECTS = 3 };

/** One budget of one estimator. */
typedef struct Row {
    uint64_t budget; /**< as asked for; shot.photons is what was used: camera paths with R, samples per pixel
                        with Cycles */
    Shot shot;
    Metrics metrics;
} Row;

/** An estimator's ladder. */
typedef struct Series {
    const char *name; /**< "W", "P", "R", "auto", "Cycles" */
    Row rows[LADDER_MAX];
    int count;
} Series;

/** The price of an effect: estimator auto with the same budget. */
typedef struct Effect {
    const char *name;
    double share; /**< mean of the picture over that of the reference */
    Cost cost;
} Effect;

typedef struct Study {
    const Options *options;
    Shot reference;
    char reference_name[256];
    Series series[SERIES_MAX];
    int count;
    Effect effects[EFFECTS];
    int effect_count;
    uint64_t effect_photons;
    char left_out[512];  /**< sentences: which estimators were left out, and why */
    char suspicion[512]; /**< a sentence when the estimators contradict the reference, else "" */
} Study;

/** Renders everything. On CAU_ERROR_CANCELLED `study` holds what was measured. The caller frees with
 *  study_free() in any case. */
cau_result study_run(Study *study, const Options *options, const volatile sig_atomic_t *stop, CauError *err);
void study_free(Study *study);

/** Exponent of the trimmed relMSE over CPU seconds after loading and planning, or over photons; NaN with
 * fewer than two rows. */
double study_exponent(const Series *series, bool by_budget);

/** Adds Cycles to the study: its picture with caustics less the one without, which has four times the largest
 *  number of paths and whose time does not count. */
cau_result cycles_run(Study *study, const volatile sig_atomic_t *stop, CauError *err);

/** The row a picture at CPU time `cpu_s` shows: the largest budget within it. */
const Row *study_row_at(const Series *series, double cpu_s);
/** The cheapest row whose trimmed relMSE is at most `error`; NULL when there is none. */
const Row *study_row_reaching(const Series *series, double error);
/** The least trimmed relMSE that two series reach (that one reaches, when there is one). */
double study_common_error(const Study *study);
/** The least CPU time within which every series has a row. */
double study_common_time(const Study *study);

/** Writes the tables in Markdown. */
cau_result study_write_table(const Study *study, FILE *out);
/** Writes accuracy.csv, pictures, accuracy.gp, plots by gnuplot, and index.html into the folder. *plotted: 0
 *  when gnuplot is missing or failed. */
cau_result study_write_files(const Study *study, const char *folder, bool *plotted, CauError *err);

#endif
