/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/study.h"

#include "accuracy/picture.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

static const uint64_t REFERENCE_SEED = 1000003; /* away from those of the ladder, which are neighbours */
static const uint64_t REFERENCE_FACTOR = 16;

static const char *estimator_name(int estimator) {
    switch (estimator) {
    case CAU_ESTIMATOR_W:
        return "W";
    case CAU_ESTIMATOR_P:
        return "P";
    case CAU_ESTIMATOR_R:
        return "R";
    default:
        return "auto";
    }
}

static cau_render_options render_options(const Options *o, int estimator, uint64_t photons, uint64_t seed) {
    cau_render_options r = cau_render_defaults();
    r.photons = photons;
    r.seed = o->seed + seed;
    r.threads = o->threads;
    r.width = o->width;
    r.height = o->height;
    r.estimator = estimator;
    r.layers = CAU_WANT_RADIANCE;
    r.indirect = o->indirect ? CAU_INDIRECT_ON : CAU_INDIRECT_OFF;
    return r;
}

static size_t pixels_of(const Shot *shot) { return (size_t)shot->width * (size_t)shot->height; }

static void tell(const Options *o, const char *what, uint64_t budget) {
    if (!o->quiet) fprintf(stderr, "%s, %" PRIu64 "\n", what, budget);
}

/* Does estimator W find anything to do? */
static cau_result ask_waved(const Options *o, const volatile sig_atomic_t *stop, bool *waved, CauError *err) {
    cau_render_options r = render_options(o, CAU_ESTIMATOR_W, 1, 0);
    Shot plan;
    CAU_TRY(measure_render(o->scene, &r, true, stop, &plan, err));
    *waved = plan.waved;
    return CAU_OK;
}

static cau_result load_reference(Study *study, CauError *err) {
    const Options *o = study->options;
    Shot *t = &study->reference;
    t->stated = -1;
    CAU_TRY(picture_read(o->reference, &t->width, &t->height, &t->rgb, err));
    snprintf(study->reference_name, sizeof study->reference_name, "\"%.200s\"", o->reference);
    if (!o->width || (o->width == t->width && o->height == t->height)) return CAU_OK;
    return error_set(err, CAU_ERROR_INPUT,
        "the reference \"%s\" has %d x %d pixels, not the %d x %d of --resolution; leave that out or render "
        "it anew",
        o->reference, t->width, t->height, o->width, o->height);
}

static cau_result make_reference(Study *study, bool waved, const volatile sig_atomic_t *stop, CauError *err) {
    const Options *o = study->options;
    if (o->reference) return load_reference(study, err);
    uint64_t photons =
        o->reference_photons ? o->reference_photons : REFERENCE_FACTOR * o->ladder[o->rungs - 1];
    cau_render_options r =
        render_options(o, waved ? CAU_ESTIMATOR_W : CAU_ESTIMATOR_P, photons, REFERENCE_SEED);
    tell(o, "reference", photons);
    CAU_TRY(measure_render(o->scene, &r, false, stop, &study->reference, err));
    snprintf(study->reference_name, sizeof study->reference_name, "%s, %.3g photons, %.3g CPU s",
        estimator_name(r.estimator), (double)photons, study->reference.cost.cpu_s);
    return CAU_OK;
}

static cau_result run_rung(
    Study *study, Series *series, int estimator, int rung, const volatile sig_atomic_t *stop, CauError *err) {
    const Options *o = study->options;
    Row *row = &series->rows[series->count];
    cau_render_options r = render_options(o, estimator, o->ladder[rung], (uint64_t)rung + 1);
    r.width = study->reference.width;
    r.height = study->reference.height;
    tell(o, series->name, o->ladder[rung]);
    *row = (Row){.budget = o->ladder[rung]};
    CAU_TRY(measure_render(o->scene, &r, false, stop, &row->shot, err));
    if (series->count && row[-1].shot.photons == row->shot.photons) {
        shot_free(&row->shot); /* R has a least number of paths: the same budget again */
        return CAU_OK;
    }
    series->count++;
    return metrics_of(row->shot.rgb, study->reference.rgb, pixels_of(&study->reference), &row->metrics, err);
}

static cau_result run_series(Study *study, bool waved, const volatile sig_atomic_t *stop, CauError *err) {
    const Options *o = study->options;
    for (int e = 0; e < o->estimator_count; e++) {
        if (o->estimators[e] == CAU_ESTIMATOR_W && !waved) {
            strcpy(study->left_out, "Estimator W finds nothing to do in this scene and is left out.");
            continue;
        }
        Series *series = &study->series[study->count++];
        series->name = estimator_name(o->estimators[e]);
        for (int i = 0; i < o->rungs; i++) CAU_TRY(run_rung(study, series, o->estimators[e], i, stop, err));
    }
    return CAU_OK;
}

/* The picture by estimator auto with an effect on, off, and as the plan decides. */
static cau_result run_effects(Study *study, const volatile sig_atomic_t *stop, CauError *err) {
    static const struct {
        const char *name;
        int indirect;
    } kinds[EFFECTS] = {{"direct", CAU_INDIRECT_OFF}, {"direct and indirect", CAU_INDIRECT_ON},
        {"as the plan decides", CAU_INDIRECT_AUTO}};
    const Options *o = study->options;
    const Shot *t = &study->reference;
    study->effect_photons = o->ladder[o->rungs / 2];
    for (int i = 0; i < EFFECTS; i++) {
        cau_render_options r = render_options(o, CAU_ESTIMATOR_AUTO, study->effect_photons, 0);
        r.indirect = kinds[i].indirect;
        r.width = t->width;
        r.height = t->height;
        Shot shot;
        tell(o, kinds[i].name, study->effect_photons);
        CAU_TRY(measure_render(o->scene, &r, false, stop, &shot, err));
        Metrics m;
        cau_result result = metrics_of(shot.rgb, t->rgb, pixels_of(t), &m, err);
        study->effects[study->effect_count++] = (Effect){kinds[i].name, m.energy, shot.cost};
        shot_free(&shot);
        CAU_TRY(result);
    }
    return CAU_OK;
}

/* The larger two rows of W, P and auto. R is left out: with few paths it is black but for some pixels. */
static int rows_to_trust(const Study *study, const Row **rows, bool *waved) {
    int n = 0;
    for (int s = 0; s < study->count; s++) {
        const Series *series = &study->series[s];
        for (int i = series->count > 1 ? series->count - 2 : 0; i < series->count; i++) {
            if (series->name[0] == 'R') continue;
            waved[n] = series->name[0] == 'W';
            rows[n++] = &series->rows[i];
        }
    }
    return n;
}

/* Two renders with other seeds share no noise: were the reference right, they would not be much closer to
 * each other than to it. The blur of P's kernels they do share, so pixels are compared only when one of the
 * two is W's; what P's kernels keep is the energy. */
static void look_at_reference(Study *study) {
    static const double FACTOR = 3, ENERGY = 0.02;
    const Row *rows[2 * SERIES_MAX];
    bool waved[2 * SERIES_MAX];
    const Shot *t = &study->reference;
    int n = rows_to_trust(study, rows, waved);
    for (int a = 0; a < n; a++)
        for (int b = 0; b < a; b++) {
            const Metrics *p = &rows[a]->metrics, *q = &rows[b]->metrics;
            double apart = metrics_distance(rows[a]->shot.rgb, rows[b]->shot.rgb, t->rgb, pixels_of(t));
            double nearest = fmin(p->nrmse, q->nrmse), energy = fabs(p->energy - q->energy);
            double off = fmin(fabs(p->energy - 1), fabs(q->energy - 1));
            if (off <= ENERGY + FACTOR * energy && (nearest <= FACTOR * apart || !(waved[a] || waved[b])))
                continue;
            snprintf(study->suspicion, sizeof study->suspicion,
                "the reference %s differs from two renders by %.3g %% RMS and %.3g %% of the energy, which "
                "differ by %.2g %% and %.2g %% from each other; it shows another scene or is damaged; "
                "render it anew",
                study->reference_name, 100 * nearest, 100 * off, 100 * apart, 100 * energy);
            return;
        }
}

cau_result study_run(Study *study, const Options *options, const volatile sig_atomic_t *stop, CauError *err) {
    *study = (Study){.options = options};
    bool waved;
    CAU_TRY(ask_waved(options, stop, &waved, err));
    CAU_TRY(make_reference(study, waved, stop, err));
    CAU_TRY(metrics_check_reference(
        study->reference.rgb, pixels_of(&study->reference), study->reference_name, err));
    CAU_TRY(run_series(study, waved, stop, err));
    look_at_reference(study);
    if (options->cycles) CAU_TRY(cycles_run(study, stop, err));
    return run_effects(study, stop, err);
}

void study_free(Study *study) {
    shot_free(&study->reference);
    for (int s = 0; s < study->count; s++)
        for (int i = 0; i < study->series[s].count; i++) shot_free(&study->series[s].rows[i].shot);
}

double study_exponent(const Series *series, bool by_budget) {
    double x[LADDER_MAX], y[LADDER_MAX];
    for (int i = 0; i < series->count; i++) {
        const Row *row = &series->rows[i];
        x[i] = by_budget ? (double)row->shot.photons : row->shot.cost.cpu_s - row->shot.before_s;
        y[i] = row->metrics.trimmed_rel_mse;
    }
    return metrics_exponent(x, y, (size_t)series->count);
}

const Row *study_row_at(const Series *series, double cpu_s) {
    const Row *best = &series->rows[0];
    for (int i = 0; i < series->count; i++)
        if (series->rows[i].shot.cost.cpu_s <= cpu_s) best = &series->rows[i];
    return best;
}

double study_common_time(const Study *study) {
    double most = 0;
    for (int s = 0; s < study->count; s++) {
        double least = INFINITY;
        for (int i = 0; i < study->series[s].count; i++)
            least = fmin(least, study->series[s].rows[i].shot.cost.cpu_s);
        if (study->series[s].count) most = fmax(most, least);
    }
    return most;
}

const Row *study_row_reaching(const Series *series, double error) {
    const Row *best = NULL;
    for (int i = 0; i < series->count; i++) {
        const Row *row = &series->rows[i];
        if (row->metrics.trimmed_rel_mse <= error && (!best || row->shot.cost.cpu_s < best->shot.cost.cpu_s))
            best = row;
    }
    return best;
}

double study_common_error(const Study *study) {
    double least = INFINITY, second = INFINITY;
    for (int s = 0; s < study->count; s++) {
        double own = INFINITY;
        for (int i = 0; i < study->series[s].count; i++)
            own = fmin(own, study->series[s].rows[i].metrics.trimmed_rel_mse);
        second = fmin(second, fmax(least, own));
        least = fmin(least, own);
    }
    return isfinite(second) ? second : least;
}
