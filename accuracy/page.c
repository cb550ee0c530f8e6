/* SPDX-License-Identifier: Apache-2.0 */
/* The HTML page. */
#include "accuracy/write.h"

#include <inttypes.h>

static void put_text(const char *text, FILE *out) {
    for (; *text; text++) switch (*text) {
        case '&':
            fputs("&amp;", out);
            break;
        case '<':
            fputs("&lt;", out);
            break;
        case '"':
            fputs("&quot;", out);
            break;
        default:
            fputc(*text, out);
        }
}

static void write_rows(const Study *study, FILE *out) {
    fputs(
        "<table><tr><th>estimator<th>budget<th>photons<th>relMSE<th>trimmed<th>true error<th>stated<th>energy"
        "<th>CPU s<th>of it loading, plan<th>wall s<th>MiB</tr>\n",
        out);
    for (int s = 0; s < study->count; s++)
        for (int i = 0; i < study->series[s].count; i++) {
            const Row *row = &study->series[s].rows[i];
            const Shot *shot = &row->shot;
            fprintf(out, "<tr><td>%s<td>%.3g<td>%" PRIu64 "<td>%.2e<td>%.2e<td>%.3g %%<td>",
                study->series[s].name, (double)row->budget, shot->photons, row->metrics.rel_mse,
                row->metrics.trimmed_rel_mse, 100 * row->metrics.nrmse);
            if (shot->stated >= 0) fprintf(out, "%.3g %%", 100 * shot->stated);
            fprintf(out, "<td>%.4f<td>%.2f<td>%.2f<td>%.2f<td>%.0f</tr>\n", row->metrics.energy,
                shot->cost.cpu_s, shot->before_s, shot->cost.wall_s, (double)shot->cost.peak_kib / 1024);
        }
    fputs("</table>\n", out);
}

static void write_exponents(const Study *study, FILE *out) {
    fputs("<h2>Exponents</h2><p>The trimmed relMSE falls with this power of CPU seconds after loading and "
          "planning, and of "
          "photons.</p><table><tr><th>estimator<th>CPU seconds<th>photons</tr>\n",
        out);
    for (int i = 0; i < study->count; i++) {
        double by_time = study_exponent(&study->series[i], false);
        if (by_time > 0)
            fprintf(out, "<tr><td>%s<td>%.2f<td>%.2f</tr>\n", study->series[i].name, by_time,
                study_exponent(&study->series[i], true));
    }
    fputs("</table>\n", out);
}

static void write_effects(const Study *study, FILE *out) {
    if (!study->effect_count) return;
    fprintf(out,
        "<h2>Effects</h2><p>Estimator auto, %.3g photons per light.</p><table><tr><th>effect<th>light over "
        "the "
        "reference's<th>CPU s<th>MiB</tr>\n",
        (double)study->effect_photons);
    for (int i = 0; i < study->effect_count; i++)
        fprintf(out, "<tr><td>%s<td>%.3f<td>%.2f<td>%.0f</tr>\n", study->effects[i].name,
            study->effects[i].share, study->effects[i].cost.cpu_s,
            (double)study->effects[i].cost.peak_kib / 1024);
    fputs("</table>\n", out);
}

static void put_picture(const char *kind, const Series *series, const Row *row, FILE *out) {
    fprintf(out,
        "<figure><img src=\"%s_%s.png\"><figcaption>%s, %.2f CPU s, relMSE %.2e, trimmed "
        "%.2e</figcaption></figure>\n",
        kind, series->name, series->name, row->shot.cost.cpu_s, row->metrics.rel_mse,
        row->metrics.trimmed_rel_mse);
}

static void write_pictures(const Study *study, FILE *out) {
    double time = study_common_time(study), error = study_common_error(study);
    fprintf(out,
        "<h2>Pictures at equal time</h2><p>The largest budget of each within %.2f CPU seconds, and the "
        "reference.</p>\n<figure><img src=\"reference.png\"><figcaption>reference"
        "</figcaption></figure>\n",
        time);
    for (int s = 0; s < study->count; s++)
        if (study->series[s].count)
            put_picture("equal_time", &study->series[s], study_row_at(&study->series[s], time), out);
    fprintf(out,
        "<h2>Pictures at equal error</h2><p>The cheapest of each with a trimmed relMSE of at most %.2e; "
        "those that reach it with no budget of the ladder are not shown.</p>\n",
        error);
    for (int s = 0; s < study->count; s++) {
        const Row *row = study_row_reaching(&study->series[s], error);
        if (row) put_picture("equal_error", &study->series[s], row, out);
    }
}

cau_result write_page(const Study *study, bool plotted, FILE *out) {
    const Options *o = study->options;
    fputs("<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>Accuracy: ", out);
    put_text(o->scene, out);
    fputs("</title>\n<style>body{font-family:sans-serif;max-width:70em;margin:auto;padding:1em}"
          "table{border-collapse:collapse}th,td{padding:.2em .7em;text-align:right;border-bottom:1px solid "
          "#ccc}"
          "figure{display:inline-block;margin:.5em}img{max-width:100%}</style>\n<h1>",
        out);
    put_text(o->scene, out);
    fprintf(out, "</h1>\n<p>%d x %d pixels, %s caustics, against ", study->reference.width,
        study->reference.height, o->indirect ? "direct and indirect" : "direct");
    put_text(study->reference_name, out);
    if (study->reference.stated >= 0) fprintf(out, ", stated error %.2g %%", 100 * study->reference.stated);
    fputs(".</p>\n<p>", out);
    put_text(study->suspicion, out);
    put_text(study->left_out, out);
    fputs("</p>\n", out);
    write_rows(study, out);
    fputs(plotted ? "<h2>Error over time</h2><img src=\"error.svg\"><img src=\"stated.svg\">\n"
                  : "<p>There are no plots: gnuplot was not found. <code>gnuplot accuracy.gp</code> makes "
                    "them.</p>\n",
        out);
    write_exponents(study, out);
    write_effects(study, out);
    write_pictures(study, out);
    fputs("</html>\n", out);
    return CAU_OK;
}
