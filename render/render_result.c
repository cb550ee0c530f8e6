/* SPDX-License-Identifier: Apache-2.0 */
/* What a render has to say when it has ended. */
#include "render/render_internal.h"

#include <string.h>

/* The layers in file order: the beauty; then per group radiance, indirect, and what was asked for beside
 * them. */
typedef struct LayerSource {
    cau_layer layer;
    const Film *film, *coverage;
    bool error;
    const Bandwidth *bias; /* its size instead of the film's mean */
} LayerSource;

void cau_render_size(const cau_render *r, int *width, int *height) {
    *width = r->scene.camera.width;
    *height = r->scene.camera.height;
}

void cau_render_region(const cau_render *r, int out[4]) { memcpy(out, r->region, sizeof r->region); }

/* Calls for every layer in order; stops at `wanted` and returns true with *out filled; *count gets how many.
 */
static bool walk_layers(const cau_render *r, size_t wanted, LayerSource *out, size_t *count) {
    size_t n = 0;
    bool found = false;
#define ADD(...)                                                                                             \
    do {                                                                                                     \
        if (n++ == wanted && out) {                                                                          \
            *out = (LayerSource){__VA_ARGS__};                                                               \
            found = true;                                                                                    \
        }                                                                                                    \
    } while (0)
    if (r->options.layers & CAU_WANT_BEAUTY)
        ADD({"beauty", CAU_LAYER_BEAUTY, 0}, &r->beauty, NULL, false, NULL);
    if ((r->options.layers & CAU_WANT_BEAUTY) && (r->options.layers & CAU_WANT_ERROR))
        ADD({"beauty", CAU_LAYER_BEAUTY_ERROR, 0}, &r->beauty, NULL, true, NULL);
    bool caustics = render_wants_caustics(r);
    for (size_t i = 0; caustics && i < r->group_count; i++) {
        const RenderGroup *g = &r->groups[i];
        ADD({g->name, CAU_LAYER_RADIANCE, 0}, &g->films[0], NULL, false, NULL);
        bool indirect = g->indirect || (r->options.layers & CAU_WANT_INDIRECT);
        if (indirect) ADD({g->name, CAU_LAYER_INDIRECT, 1}, &g->films[1], NULL, false, NULL);
        if (r->options.layers & CAU_WANT_IRRADIANCE) {
            ADD({g->name, CAU_LAYER_IRRADIANCE, 0}, g->irradiance, g->coverage, false, NULL);
            ADD({g->name, CAU_LAYER_SEEN, 0}, g->seen, NULL, false, NULL);
        }
        if (r->options.layers & CAU_WANT_ERROR) {
            ADD({g->name, CAU_LAYER_ERROR, 0}, &g->films[0], NULL, true, NULL);
            if (indirect) ADD({g->name, CAU_LAYER_ERROR, 1}, &g->films[1], NULL, true, NULL);
        }
        if (r->options.layers & CAU_WANT_BIAS) {
            ADD({g->name, CAU_LAYER_BIAS, 0}, &g->films[0], NULL, false, &g->kernels[0]);
            if (indirect) ADD({g->name, CAU_LAYER_BIAS, 1}, &g->films[1], NULL, false, &g->kernels[1]);
        }
    }
#undef ADD
    if (count) *count = n;
    return found;
}

size_t cau_render_layer_count(const cau_render *r) {
    size_t n;
    walk_layers(r, SIZE_MAX, NULL, &n);
    return n;
}

cau_layer cau_render_layer(const cau_render *r, size_t index) {
    LayerSource s = {.layer = {"", 0, 0}};
    walk_layers(r, index, &s, NULL);
    return s.layer;
}

/* The size of the bias has the colour of the light that it blurs. */
static void bias_pixels(const LayerSource *s, size_t pixels, float *out) {
    for (size_t i = 0; s->bias->radius && i < pixels; i++) {
        double bias = bandwidth_bias(s->bias, i), square_sum = 0;
        for (size_t c = 0; c < 3; c++) square_sum += square(film_mean(s->film, 3 * i + c)) / 3;
        for (size_t c = 0; c < 3; c++)
            out[3 * i + c] =
                (float)(square_sum > 0 ? bias * film_mean(s->film, 3 * i + c) / sqrt(square_sum) : bias);
    }
}

cau_result cau_render_pixels(const cau_render *r, size_t index, float *out) {
    LayerSource s = {.layer = {"", 0, 0}};
    if (!walk_layers(r, index, &s, NULL))
        return error_set(&r->source->context->error, CAU_ERROR_USAGE, "layer %zu does not exist", index);
    size_t pixels = (size_t)r->scene.camera.width * (size_t)r->scene.camera.height;
    memset(out, 0, pixels * 3 * sizeof *out);
    if (!s.film->sum) return CAU_OK; /* nothing was called for: black */
    if (s.bias) {
        bias_pixels(&s, pixels, out);
        return CAU_OK;
    }
    for (size_t i = 0; i < 3 * pixels; i++) {
        double value = s.error ? film_error(s.film, i) : film_mean(s.film, i);
        if (s.coverage) {
            double covered = film_mean(s.coverage, i / 3);
            value = covered > 0 ? value / covered : 0;
        }
        out[i] = (float)value;
    }
    return CAU_OK;
}

/* ---- figures ---- */

/* A layer that is part of the picture; R fills both films even where one is asked for. */
static const Film *film_of(const RenderGroup *g, int kind) {
    const Film *f = &g->films[kind];
    return f->sum && film_passes(f) > 0 && (kind ? g->indirect : g->direct) ? f : NULL;
}

static ErrorPart part_of(const cau_render *r, size_t g, int kind) {
    if (r->options.estimator == CAU_ESTIMATOR_R) return ERROR_PATHS;
    return render_waves_draw(r, g, kind) ? ERROR_WAVES : ERROR_PHOTONS;
}

/* Adds a layer's parts; returns the sum of the noise's squares. */
static double add_parts(const cau_render *r, size_t g, int kind, const Film *f, ErrorParts *e) {
    size_t values = picture_values(r);
    ErrorPart part = part_of(r, g, kind); /* asks every light: not at every pixel */
    e->bias[part] += (double)values * bandwidth_mean_bias2(&r->groups[g].kernels[kind]);
    double squares = 0;
    for (size_t i = 0; i < values; i++) {
        double variance = square(film_error(f, i));
        e->noise[part] += variance;
        squares += square(variance);
    }
    return squares;
}

ErrorParts render_error_parts(const cau_render *r) {
    ErrorParts e = {0};
    double square_sum = 0, noise = 0, bias = 0, squares = 0;
    size_t values = picture_values(r);
    bool any = false, enough = true;
    for (size_t g = 0; g < r->group_count; g++)
        for (int k = 0; k < 2; k++) {
            const Film *f = film_of(&r->groups[g], k);
            any |= f != NULL;
            enough &= !f || film_passes(f) > 1;
            if (f) squares += add_parts(r, g, k, f, &e);
        }
    for (size_t i = 0; any && i < values; i++) {
        double mean = 0;
        for (size_t g = 0; g < r->group_count; g++)
            for (int k = 0; k < 2; k++) {
                const Film *f = film_of(&r->groups[g], k);
                if (f) mean += film_mean(f, i);
            }
        square_sum += mean * mean;
    }
    for (int i = 0; i < ERROR_PARTS; i++) {
        noise += e.noise[i];
        bias += e.bias[i];
    }
    double truth = square_sum - noise;
    e.values = squares > 0 ? square(noise) / squares : 0;
    e.total = enough && truth > 0 ? sqrt((noise + bias) / truth) : -1;
    if (!any || square_sum == 0) e.total = any ? 0 : -1;
    return e;
}

double render_total_error(const cau_render *r) { return render_error_parts(r).total; }

double cau_render_error(const cau_render *r) { return render_total_error(r); }

size_t cau_render_light_count(const cau_render *r) { return r->group_count; }

static cau_flux flux_in_watts(const cau_render *r, const FluxAccount *a) {
    double n = r->passes ? (double)r->passes : 1, s = 1 / (n * square(r->scene.units_per_m));
    return (cau_flux){.emitted = rgb_mean(a->emitted) * s,
        .landed = rgb_mean(a->landed) * s,
        .straight = rgb_mean(a->straight) * s,
        .absorbed = rgb_mean(a->absorbed) * s,
        .escaped = rgb_mean(a->escaped) * s,
        .cut = rgb_mean(a->cut) * s,
        .dropped = rgb_mean(a->dropped) * s,
        .bent = rgb_mean(a->bent) * s,
        .photons = a->photons,
        .rays = a->rays,
        .deposits = a->deposits,
        .non_finite = a->non_finite};
}

/* Relative error, bias and mean of a layer. Of a layer in which nothing was found nothing is known: its error
 * may be all of it. */
static void film_report(const RenderGroup *g, int kind, double *error, double *bias, double *mean) {
    const Film *f = film_of(g, kind);
    *error = *bias = -1;
    *mean = 0;
    if (!f) return;
    FilmFigures figures = film_figures(f);
    *mean = figures.mean;
    double truth = square(figures.rms) - square(figures.error_rms);
    if (figures.rms == 0) *error = 1;
    if (!(truth > 0) || !isfinite(figures.relative_error)) return;
    *bias = sqrt(bandwidth_mean_bias2(&g->kernels[kind]) / truth);
    *error = hypot(figures.relative_error, *bias);
}

ErrorParts render_layer_parts(const cau_render *r, size_t group, int kind) {
    ErrorParts e = {0};
    const Film *f = film_of(&r->groups[group], kind);
    double bias, mean;
    if (f) add_parts(r, group, kind, f, &e);
    film_report(&r->groups[group], kind, &e.total, &bias, &mean);
    return e;
}

static const char *direct_estimator(const cau_render *r, size_t g) {
    static const char *const names[ERROR_PARTS] = {
        [ERROR_WAVES] = "W", [ERROR_PHOTONS] = "P", [ERROR_PATHS] = "R"};
    return r->groups[g].direct ? names[part_of(r, g, 0)] : "";
}

cau_light_report cau_render_light(const cau_render *r, size_t index) {
    if (index >= r->group_count) return (cau_light_report){.light = "", .estimator_direct = ""};
    const RenderGroup *g = &r->groups[index];
    FluxAccount direct = g->accounts[0];
    flux_account_add(&direct, &g->wave_account);
    cau_light_report report = {.light = g->name,
        .direct = flux_in_watts(r, &direct),
        .indirect = flux_in_watts(r, &g->accounts[1]),
        .direct_bent = flux_in_watts(r, &g->bent[0]),
        .indirect_bent = flux_in_watts(r, &g->bent[1]),
        .estimator_direct = direct_estimator(r, index)};
    film_report(g, 0, &report.relative_error_direct, &report.bias_direct, &report.mean_direct);
    film_report(g, 1, &report.relative_error_indirect, &report.bias_indirect, &report.mean_indirect);
    return report;
}

const char *cau_render_warning(const cau_render *r, size_t index) {
    return index < r->scene.warning_count ? r->scene.warnings[index] : NULL;
}

uint64_t cau_scene_hash(const cau_scene *scene) { return scene_hash(scene); }
