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
    if (r->options.layers & CAU_WANT_BEAUTY) ADD({"beauty", CAU_LAYER_BEAUTY, 0}, &r->beauty, NULL, false);
    if ((r->options.layers & CAU_WANT_BEAUTY) && (r->options.layers & CAU_WANT_ERROR))
        ADD({"beauty", CAU_LAYER_BEAUTY_ERROR, 0}, &r->beauty, NULL, true);
    bool caustics = render_wants_caustics(r);
    for (size_t i = 0; caustics && i < r->group_count; i++) {
        const RenderGroup *g = &r->groups[i];
        ADD({g->name, CAU_LAYER_RADIANCE, 0}, &g->films[0], NULL, false);
        bool indirect = g->indirect || (r->options.layers & CAU_WANT_INDIRECT);
        if (indirect) ADD({g->name, CAU_LAYER_INDIRECT, 1}, &g->films[1], NULL, false);
        if (r->options.layers & CAU_WANT_IRRADIANCE) {
            ADD({g->name, CAU_LAYER_IRRADIANCE, 0}, g->irradiance, g->coverage, false);
            ADD({g->name, CAU_LAYER_SEEN, 0}, g->seen, NULL, false);
        }
        if (r->options.layers & CAU_WANT_ERROR) {
            ADD({g->name, CAU_LAYER_ERROR, 0}, &g->films[0], NULL, true);
            if (indirect) ADD({g->name, CAU_LAYER_ERROR, 1}, &g->films[1], NULL, true);
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

cau_result cau_render_pixels(const cau_render *r, size_t index, float *out) {
    LayerSource s = {.layer = {"", 0, 0}};
    if (!walk_layers(r, index, &s, NULL))
        return error_set(&r->source->context->error, CAU_ERROR_USAGE, "layer %zu does not exist", index);
    size_t pixels = (size_t)r->scene.camera.width * (size_t)r->scene.camera.height;
    memset(out, 0, pixels * 3 * sizeof *out);
    if (!s.film->sum) return CAU_OK; /* nothing was called for: black */
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

double render_total_error(const cau_render *r) {
    double square_sum = 0, error = 0;
    size_t values = 3 * (size_t)r->scene.camera.width * (size_t)r->scene.camera.height;
    bool any = false, enough = true;
    for (size_t i = 0; i < values; i++) {
        double mean = 0;
        for (size_t g = 0; g < r->group_count; g++)
            for (int k = 0; k < 2; k++) {
                const Film *f = &r->groups[g].films[k];
                if (!f->sum || f->passes == 0) continue;
                any = true;
                enough &= f->passes > 1;
                double e = film_error(f, i);
                mean += film_mean(f, i);
                error += e * e;
            }
        square_sum += mean * mean;
    }
    if (!any || square_sum == 0) return any ? 0 : -1;
    double truth = square_sum - error;
    return enough && truth > 0 ? sqrt(error / truth) : -1;
}

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

static void film_report(const Film *f, double *error, double *mean) {
    *error = -1;
    *mean = 0;
    if (!f->sum || f->passes == 0) return;
    FilmFigures figures = film_figures(f);
    *mean = figures.mean;
    if (isfinite(figures.relative_error)) *error = figures.relative_error;
}

cau_light_report cau_render_light(const cau_render *r, size_t index) {
    if (index >= r->group_count) return (cau_light_report){.light = ""};
    const RenderGroup *g = &r->groups[index];
    FluxAccount direct = g->accounts[0];
    flux_account_add(&direct, &g->wave_account);
    cau_light_report report = {.light = g->name,
        .direct = flux_in_watts(r, &direct),
        .indirect = flux_in_watts(r, &g->accounts[1]),
        .direct_bent = flux_in_watts(r, &g->bent[0]),
        .indirect_bent = flux_in_watts(r, &g->bent[1])};
    film_report(&g->films[0], &report.relative_error_direct, &report.mean_direct);
    film_report(&g->films[1], &report.relative_error_indirect, &report.mean_indirect);
    return report;
}

const char *cau_render_warning(const cau_render *r, size_t index) {
    return index < r->scene.warning_count ? r->scene.warnings[index] : NULL;
}

uint64_t cau_scene_hash(const cau_scene *scene) { return scene_hash(scene); }
