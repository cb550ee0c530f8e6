/* SPDX-License-Identifier: Apache-2.0 */
/* Plots by gnuplot. */
#include "accuracy/write.h"

enum { STATED = 5 }; /* the column of stated errors, which Cycles has none of */

static void write_data(const Study *study, FILE *out) {
    for (int s = 0; s < study->count; s++) {
        fprintf(out, "$s%d << EOD\n", s);
        for (int i = 0; i < study->series[s].count; i++) {
            const Row *row = &study->series[s].rows[i];
            fprintf(out, "%.6g %.6g %.6g %.6g ", row->shot.cost.cpu_s, row->metrics.rel_mse,
                row->metrics.trimmed_rel_mse, row->metrics.nrmse);
            if (row->shot.stated > 0)
                fprintf(out, "%.6g\n", row->shot.stated);
            else
                fputs("NaN\n", out);
        }
        fputs("EOD\n", out);
    }
}

/* Column `y` of each series over CPU seconds. */
static void write_curves(const Study *study, int y, const char *kind, const char *suffix, FILE *out) {
    const char *comma = "";
    for (int s = 0; s < study->count; s++) {
        bool known = y != STATED;
        for (int i = 0; i < study->series[s].count; i++) known |= study->series[s].rows[i].shot.stated > 0;
        if (!known) continue;
        fprintf(out, "%s $s%d using 1:%d with %s lc %d title \"%s%s\"", comma, s, y, kind, s + 1,
            study->series[s].name, suffix);
        comma = ",";
    }
}

cau_result write_plot(const Study *study, FILE *out) {
    fputs("# gnuplot accuracy.gp\nset datafile missing \"NaN\"\n", out);
    write_data(study, out);
    fputs("set terminal svg size 760,440 background \"white\"\nset logscale xy\nset grid\nset key outside\n"
          "set format y \"10^{%T}\"\nset xlabel \"CPU seconds, whole process\"\n"
          "set output \"error.svg\"\nset ylabel \"relMSE\"\nplot",
        out);
    write_curves(study, 2, "linespoints pt 7", "", out);
    fputs(",", out);
    write_curves(study, 3, "linespoints pt 6 dt 2", ", trimmed", out);
    fputs("\nset output \"stated.svg\"\nset format y \"%g\"\nset ylabel \"RMSE / RMS\"\nplot", out);
    write_curves(study, 4, "linespoints pt 7", "", out);
    fputs(",", out);
    write_curves(study, STATED, "linespoints pt 6 dt 2", ", stated", out);
    fputs("\n", out);
    return CAU_OK;
}
