/* SPDX-License-Identifier: Apache-2.0 */
/* From settings and colour spaces to one 3 x 3 matrix per layer. */
#include "composite/job.h"

#include "core/checked.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

typedef struct Conversion {
    double to_tint[9], to_beauty[9], direct[9];
    bool same; /* caustics and beauty share a space */
    bool tint_in_beauty;
} Conversion;

static void multiply(double out[9], const double a[9], const double b[9]) {
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            out[3 * r + c] = a[3 * r] * b[c] + a[3 * r + 1] * b[3 + c] + a[3 * r + 2] * b[6 + c];
}

static cau_result find_conversion(const Job *job, Conversion *out) {
    bool same;
    CAU_TRY(colour_matrix(
        job->colour, job->caustics_space, job->beauty_space, out->direct, &out->same, job->err));
    CAU_TRY(colour_matrix(job->colour, job->caustics_space, job->tint_space, out->to_tint, &same, job->err));
    return colour_matrix(
        job->colour, job->tint_space, job->beauty_space, out->to_beauty, &out->tint_in_beauty, job->err);
}

/* beauty <- tint space <- caustics, with the factors applied in the tint's space. */
static void fill_matrix(Term *term, const Conversion *c, const double factor[3]) {
    bool grey = factor[0] == factor[1] && factor[1] == factor[2];
    const double *first = grey || c->tint_in_beauty ? c->direct : c->to_tint;
    for (int i = 0; i < 9; i++) term->matrix[i] = factor[i / 3] * first[i];
    term->diagonal = c->same && (grey || c->tint_in_beauty);
    if (grey || c->tint_in_beauty) return;
    double scaled[9];
    memcpy(scaled, term->matrix, sizeof scaled);
    multiply(term->matrix, c->to_beauty, scaled);
}

static cau_result factor_of(const Job *job, const Light *l, bool indirect, double factor[3]) {
    for (int i = 0; i < 3; i++) {
        factor[i] = l->both.gain * exp2(l->both.ev) * l->both.tint[i];
        if (indirect)
            factor[i] *= l->indirect_only.gain * exp2(l->indirect_only.ev) * l->indirect_only.tint[i];
        if (!isfinite(factor[i]) || fabs(factor[i]) > 1e30)
            return error_set(job->err, CAU_ERROR_USAGE,
                "light \"%s\": gain %g, ev %g and tint %g make a factor beyond 1e30", l->name, l->both.gain,
                l->both.ev, l->both.tint[i]);
    }
    return CAU_OK;
}

static bool any_solo(const Lights *lights) {
    for (size_t i = 0; i < lights->count; i++)
        if (lights->lights[i].both.solo || lights->lights[i].indirect_only.solo) return true;
    return false;
}

static bool audible(const Light *l, bool indirect, bool solo) {
    if (l->both.mute || (indirect && l->indirect_only.mute)) return false;
    return !solo || l->both.solo || (indirect && l->indirect_only.solo);
}

static void add_term(Job *job, const Light *light, int layer, const Conversion *c, const double factor[3],
    double scale, bool times_albedo) {
    double scaled[3] = {factor[0] * scale, factor[1] * scale, factor[2] * scale};
    if (scaled[0] == 0 && scaled[1] == 0 && scaled[2] == 0) return; /* as if it were muted */
    Term *term = &job->terms[job->term_count++];
    *term =
        (Term){.layer = layer, .light = (size_t)(light - job->lights.lights), .times_albedo = times_albedo};
    fill_matrix(term, c, scaled);
}

static cau_result add_light(Job *job, const Light *l, const Conversion *c, bool solo) {
    double factor[3];
    if (audible(l, false, solo)) {
        CAU_TRY(factor_of(job, l, false, factor));
        if (job->albedo && l->radiance >= 0 && (l->irradiance < 0 || l->seen < 0))
            return error_set(job->err, CAU_ERROR_INPUT,
                "--albedo needs the layers %s%s and %s%s, and \"%s\" lacks %s: render it with --layers "
                "radiance,irradiance",
                l->base, CAU_SUFFIX_IRRADIANCE, l->base, CAU_SUFFIX_SEEN, job->options->caustics,
                l->irradiance >= 0 ? "the second"
                : l->seen >= 0     ? "the first"
                                   : "both");
        if (job->albedo && l->irradiance >= 0) {
            add_term(job, l, l->irradiance, c, factor, 1 / pi, true);
            if (l->seen >= 0) add_term(job, l, l->seen, c, factor, 1, false);
        } else if (l->radiance >= 0) {
            add_term(job, l, l->radiance, c, factor, 1, false);
        }
    }
    if (l->indirect >= 0 && audible(l, true, solo)) {
        CAU_TRY(factor_of(job, l, true, factor));
        add_term(job, l, l->indirect, c, factor, 1, false);
    }
    return CAU_OK;
}

cau_result job_gain(Job *job) {
    if (job->options->recipe) CAU_TRY(recipe_apply(&job->lights, job->options->recipe, job->err));
    for (size_t i = 0; i < job->options->light_count; i++)
        CAU_TRY(setting_apply(&job->lights, &job->options->lights[i], job->err));
    Conversion conversion;
    CAU_TRY(find_conversion(job, &conversion));
    job->terms = array_new(job->lights.count * 3, sizeof *job->terms);
    if (!job->terms)
        return error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for %zu lights", job->lights.count);
    bool solo = any_solo(&job->lights);
    for (size_t i = 0; i < job->lights.count; i++)
        CAU_TRY(add_light(job, &job->lights.lights[i], &conversion, solo));
    if (job->term_count == 0) job_notice(job, "every light is muted: the output equals the beauty");
    return CAU_OK;
}
