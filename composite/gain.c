/* SPDX-License-Identifier: Apache-2.0 */
/* From settings and colour spaces to one 3 x 3 matrix per layer. */
#include "composite/job.h"

#include "core/checked.h"

#include <math.h>

static const double pi = 3.14159265358979323846;

static void multiply(double out[9], const double a[9], const double b[9]) {
    double product[9];
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            product[3 * r + c] = a[3 * r] * b[c] + a[3 * r + 1] * b[3 + c] + a[3 * r + 2] * b[6 + c];
    memcpy(out, product, sizeof product);
}

static bool coloured(const Setting *s) { return s->temperature_k != 6500 || s->saturation != 1; }

/* Temperatures and luminance are known in linear Rec.709. */
static cau_result find_rec709(const Job *job, Conversion *out) {
    static const double weights[3] = {0.2126, 0.7152, 0.0722}; /* ITU-R BT.709 */
    bool same;
    double to_rec709[9];
    const char *space = space_of_id(job->colour, "lin_rec709_scene");
    if (!space)
        return error_set(job->err, CAU_ERROR_INPUT,
            "%s has no linear Rec.709, which colour temperature and saturation need: use a tint, or another "
            "configuration",
            colour_origin(job->colour));
    CAU_TRY(colour_matrix(job->colour, job->tint_space, space, to_rec709, &same, job->err));
    CAU_TRY(colour_matrix(job->colour, space, job->tint_space, out->from_rec709, &same, job->err));
    for (int c = 0; c < 3; c++)
        out->luminance[c] =
            weights[0] * to_rec709[c] + weights[1] * to_rec709[3 + c] + weights[2] * to_rec709[6 + c];
    return CAU_OK;
}

cau_result conversion_find(Conversion *out, const Job *job) {
    bool same, any = false;
    CAU_TRY(colour_matrix(
        job->colour, job->caustics_space, job->beauty_space, out->direct, &out->same, job->err));
    CAU_TRY(colour_matrix(job->colour, job->caustics_space, job->tint_space, out->to_tint, &same, job->err));
    CAU_TRY(colour_matrix(
        job->colour, job->tint_space, job->beauty_space, out->to_beauty, &out->tint_in_beauty, job->err));
    for (size_t i = 0; i < job->lights.count; i++)
        any = any || coloured(&job->lights.lights[i].both) || coloured(&job->lights.lights[i].indirect_only);
    return any ? find_rec709(job, out) : CAU_OK;
}

/* Towards the grey of the same luminance, in the tint's space. */
static void saturate(double matrix[9], const Conversion *c, double saturation) {
    double s[9];
    for (int i = 0; i < 9; i++) s[i] = (1 - saturation) * c->luminance[i % 3] + (i % 4 == 0 ? saturation : 0);
    multiply(matrix, s, matrix);
}

/* beauty <- tint space <- caustics, with the factors and the saturation applied in the tint's space. */
static void fill_matrix(Term *term, const Conversion *c, const double factor[3], double saturation) {
    bool grey = factor[0] == factor[1] && factor[1] == factor[2];
    if ((grey || c->tint_in_beauty) && saturation == 1) {
        for (int i = 0; i < 9; i++) term->matrix[i] = factor[i / 3] * c->direct[i];
        term->diagonal = c->same;
        return;
    }
    memcpy(term->matrix, c->to_tint, sizeof term->matrix);
    if (saturation != 1) saturate(term->matrix, c, saturation);
    for (int i = 0; i < 9; i++) term->matrix[i] *= factor[i / 3];
    if (!c->tint_in_beauty) multiply(term->matrix, c->to_beauty, term->matrix);
}

void conversion_warm(double factor[3], const Conversion *c, double kelvin) {
    double rgb[3], tinted[3], luminance = 0;
    if (kelvin == 6500 || !black_body_rgb(rgb, kelvin)) return;
    for (int i = 0; i < 3; i++) {
        const double *row = &c->from_rec709[3 * i];
        tinted[i] = row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2];
        luminance += c->luminance[i] * tinted[i];
    }
    for (int i = 0; i < 3; i++) factor[i] *= tinted[i] > 0 ? tinted[i] / luminance : 0;
}

static cau_result factor_of(
    const Job *job, const Light *l, bool indirect, const Conversion *c, double factor[3]) {
    for (int i = 0; i < 3; i++) {
        factor[i] = l->both.gain * exp2(l->both.ev) * l->both.tint[i];
        if (indirect)
            factor[i] *= l->indirect_only.gain * exp2(l->indirect_only.ev) * l->indirect_only.tint[i];
        if (!isfinite(factor[i]) || fabs(factor[i]) > 1e30)
            return error_set(job->err, job->options->light_count ? CAU_ERROR_USAGE : CAU_ERROR_INPUT,
                "light \"%s\": gain %g, ev %g and tint %g make a factor beyond 1e30", l->name, l->both.gain,
                l->both.ev, l->both.tint[i]);
    }
    conversion_warm(factor, c, l->both.temperature_k);
    if (indirect) conversion_warm(factor, c, l->indirect_only.temperature_k);
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

/* One layer of a light, on its way into the list of terms. */
typedef struct Part {
    const Light *light;
    const Conversion *conversion;
    double factor[3], saturation;
} Part;

static void add_term(Job *job, const Part *part, int layer, double scale, bool times_albedo) {
    double scaled[3] = {part->factor[0] * scale, part->factor[1] * scale, part->factor[2] * scale};
    if (scaled[0] == 0 && scaled[1] == 0 && scaled[2] == 0) return; /* as if it were muted */
    Term *term = &job->terms[job->term_count++];
    *term = (Term){
        .layer = layer, .light = (size_t)(part->light - job->lights.lights), .times_albedo = times_albedo};
    fill_matrix(term, part->conversion, scaled, part->saturation);
}

static cau_result add_direct(Job *job, const Light *l, const Conversion *c) {
    Part part = {.light = l, .conversion = c, .saturation = l->both.saturation};
    CAU_TRY(factor_of(job, l, false, c, part.factor));
    if (job->albedo && l->radiance >= 0 && (l->irradiance < 0 || l->seen < 0))
        return error_set(job->err, CAU_ERROR_INPUT,
            "--albedo needs the layers %s%s and %s%s, and \"%s\" lacks %s: render it with --layers "
            "radiance,irradiance",
            l->base, CAU_SUFFIX_IRRADIANCE, l->base, CAU_SUFFIX_SEEN, job->options->caustics,
            l->irradiance >= 0 ? "the second"
            : l->seen >= 0     ? "the first"
                               : "both");
    if (job->albedo && l->irradiance >= 0) {
        add_term(job, &part, l->irradiance, 1 / pi, true);
        if (l->seen >= 0) add_term(job, &part, l->seen, 1, false);
    } else if (l->radiance >= 0) {
        add_term(job, &part, l->radiance, 1, false);
    }
    return CAU_OK;
}

static cau_result add_light(Job *job, const Light *l, const Conversion *c, bool solo) {
    if (audible(l, false, solo)) CAU_TRY(add_direct(job, l, c));
    if (l->indirect < 0 || !audible(l, true, solo)) return CAU_OK;
    Part part = {.light = l, .conversion = c, .saturation = l->both.saturation * l->indirect_only.saturation};
    CAU_TRY(factor_of(job, l, true, c, part.factor));
    add_term(job, &part, l->indirect, 1, false);
    return CAU_OK;
}

cau_result job_gain(Job *job) {
    if (job->options->recipe) CAU_TRY(recipe_apply(&job->lights, job->options->recipe, job->err));
    for (size_t i = 0; i < job->options->light_count; i++)
        CAU_TRY(setting_apply(&job->lights, &job->options->lights[i], job->err));
    if (job->lights.tint_space && !job->options->tint_space)
        CAU_TRY(space_named(&job->tint_space, job, job->lights.tint_space, "the recipe's tint_space"));
    Conversion conversion = {0};
    CAU_TRY(conversion_find(&conversion, job));
    job->terms = array_new(job->lights.count * 3, sizeof *job->terms);
    if (!job->terms)
        return error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for %zu lights", job->lights.count);
    bool solo = any_solo(&job->lights);
    for (size_t i = 0; i < job->lights.count; i++)
        CAU_TRY(add_light(job, &job->lights.lights[i], &conversion, solo));
    if (job->term_count == 0) job_notice(job, "every light is muted: the output equals the beauty");
    return CAU_OK;
}
