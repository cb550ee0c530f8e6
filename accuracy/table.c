/* SPDX-License-Identifier: Apache-2.0 */
/* The tables on standard output, and accuracy.csv. */
#include "accuracy/study.h"
#include "accuracy/write.h"

#include <inttypes.h>
#include <math.h>

/* "-" for what is not known. */
static void put_percent(FILE *out, double x) {
    if (x >= 0)
        fprintf(out, " %.3g %% |", 100 * x);
    else
        fputs(" - |", out);
}

static void write_row(const Series *series, const Row *row, FILE *out) {
    const Shot *s = &row->shot;
    fprintf(out, "| %s | %.3g | %" PRIu64 " | %.2e | %.2e |", series->name, (double)row->budget, s->photons,
        row->metrics.rel_mse, row->metrics.trimmed_rel_mse);
    put_percent(out, row->metrics.nrmse);
    put_percent(out, s->stated);
    fprintf(out, " %.4f | %.2f | %.2f | %.2f | %.0f |\n", row->metrics.energy, s->cost.cpu_s, s->before_s,
        s->cost.wall_s, (double)s->cost.peak_kib / 1024);
}

static void write_exponents(const Study *study, FILE *out) {
    fputs("\n| estimator | trimmed relMSE falls with CPU seconds to the power | with photons "
          "|\n|---|---|---|\n",
        out);
    for (int i = 0; i < study->count; i++) {
        const Series *s = &study->series[i];
        double by_time = study_exponent(s, false), by_photons = study_exponent(s, true);
        if (by_time > 0 && by_photons > 0)
            fprintf(out, "| %s | %.2f | %.2f |\n", s->name, by_time, by_photons);
        else {
            const char *why = isfinite(by_time) ? "does not fall" : "-";
            fprintf(out, "| %s | %s | %s |\n", s->name, why, why);
        }
    }
}

static void write_effects(const Study *study, FILE *out) {
    if (!study->effect_count) return;
    fprintf(out,
        "\n| effect, auto, %.3g photons | light over the reference's | CPU s | MiB |\n|---|---|---|---|\n",
        (double)study->effect_photons);
    for (int i = 0; i < study->effect_count; i++) {
        const Effect *e = &study->effects[i];
        fprintf(out, "| %s | %.3f | %.2f | %.0f |\n", e->name, e->share, e->cost.cpu_s,
            (double)e->cost.peak_kib / 1024);
    }
}

cau_result study_write_table(const Study *study, FILE *out) {
    const Options *o = study->options;
    fprintf(out, "%s, %d x %d pixels, %s, against %s", o->scene, study->reference.width,
        study->reference.height, o->indirect ? "direct and indirect" : "direct", study->reference_name);
    if (study->reference.stated >= 0) fprintf(out, ", stated error %.2g %%", 100 * study->reference.stated);
    fputs("\n\n| estimator | budget | photons | relMSE | trimmed | true error | stated | energy | CPU s | of "
          "it "
          "loading, plan | wall s | MiB |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        out);
    for (int s = 0; s < study->count; s++)
        for (int i = 0; i < study->series[s].count; i++)
            write_row(&study->series[s], &study->series[s].rows[i], out);
    write_exponents(study, out);
    write_effects(study, out);
    if (study->left_out[0]) fprintf(out, "\n%s\n", study->left_out);
    return fflush(out) == 0 && !ferror(out) ? CAU_OK : CAU_ERROR_RESOURCE;
}

cau_result write_csv(const Study *study, FILE *out) {
    fputs("estimator,budget,photons,rel_mse,trimmed_rel_mse,nrmse,stated_error,energy,cpu_s,before_s,wall_s,"
          "peak_mib\n",
        out);
    for (int s = 0; s < study->count; s++)
        for (int i = 0; i < study->series[s].count; i++) {
            const Row *row = &study->series[s].rows[i];
            const Shot *shot = &row->shot;
            fprintf(out, "%s,%" PRIu64 ",%" PRIu64 ",%.6g,%.6g,%.6g,", study->series[s].name, row->budget,
                shot->photons, row->metrics.rel_mse, row->metrics.trimmed_rel_mse, row->metrics.nrmse);
            if (shot->stated >= 0) fprintf(out, "%.6g", shot->stated);
            fprintf(out, ",%.6g,%.4f,%.4f,%.4f,%.2f\n", row->metrics.energy, shot->cost.cpu_s, shot->before_s,
                shot->cost.wall_s, (double)shot->cost.peak_kib / 1024);
        }
    return CAU_OK;
}
