/* SPDX-License-Identifier: Apache-2.0 */
/* The figures of a render as JSON: what a farm or a benchmark reads. */
#include "caustics/render_file.h"
#include "core/file_atomic.h"
#include "render/scene/scene.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

static json_t *flux_json(const cau_flux *f) {
    return json_pack("{s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:I, s:I, s:I, s:I}", "emitted_w", f->emitted,
        "landed_w", f->landed, "straight_w", f->straight, "absorbed_w", f->absorbed, "escaped_w", f->escaped,
        "cut_w", f->cut, "bent_w", f->bent, "dropped_w", f->dropped, "photons", (json_int_t)f->photons,
        "rays", (json_int_t)f->rays, "deposits", (json_int_t)f->deposits, "non_finite",
        (json_int_t)f->non_finite);
}

static json_t *light_json(const cau_light_report *r) {
    json_t *all = json_pack("{s:s, s:f, s:f, s:f, s:f, s:o, s:o}", "light", r->light, "error_direct",
        r->relative_error_direct, "error_indirect", r->relative_error_indirect, "mean_direct", r->mean_direct,
        "mean_indirect", r->mean_indirect, "flux_direct", flux_json(&r->direct), "flux_indirect",
        flux_json(&r->indirect));
    json_object_set_new(all, "estimator_direct", json_string(r->estimator_direct));
    json_object_set_new(all, "bias_direct", json_real(r->bias_direct));
    json_object_set_new(all, "bias_indirect", json_real(r->bias_indirect));
    if (!r->direct_bent.photons && !r->indirect_bent.photons) return all;
    json_object_set_new(all, "flux_direct_bent", flux_json(&r->direct_bent));
    json_object_set_new(all, "flux_indirect_bent", flux_json(&r->indirect_bent));
    return all;
}

cau_result cau_render_write_report(cau_render *render, cau_scene *scene, const char *path) {
    CauError *err = &scene->context->error;
    cau_progress p = cau_render_poll(render);
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    json_t *lights = json_array(), *warnings = json_array();
    for (size_t i = 0; i < cau_render_light_count(render); i++) {
        cau_light_report r = cau_render_light(render, i);
        json_array_append_new(lights, light_json(&r));
    }
    for (size_t i = 0; cau_render_warning(render, i); i++)
        json_array_append_new(warnings, json_string(cau_render_warning(render, i)));
    json_t *all = json_pack("{s:s, s:I, s:I, s:f, s:f, s:f, s:I, s:s, s:o, s:o}", "version", cau_version(),
        "passes", (json_int_t)p.passes, "photons_per_light", (json_int_t)p.photons_per_light, "error",
        p.error, "wall_s", p.elapsed_s, "cpu_s",
        (double)usage.ru_utime.tv_sec + 1e-6 * (double)usage.ru_utime.tv_usec, "peak_memory_kb",
        (json_int_t)usage.ru_maxrss, "plan", cau_render_explain(render), "lights", lights, "warnings",
        warnings);
    char *text = all ? json_dumps(all, JSON_INDENT(1)) : NULL;
    json_decref(all);
    if (!text) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the report \"%s\"", path);
    cau_result result = file_write_atomic(path, text, strlen(text), err);
    free(text);
    return result;
}
