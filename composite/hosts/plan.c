/* SPDX-License-Identifier: Apache-2.0 */
/* From an output of `add`, or a caustics file, to what a script has to build. */
#include "composite/hosts/hosts.h"
#include "core/frames.h"

#include "core/checked.h"

#include <jansson.h>

/* What `add` recorded; texts belong to `root`. */
typedef struct Record {
    json_t *root;
    const char *beauty, *caustics, *pass, *albedo, *beauty_space, *caustics_space, *tint_space;
    bool has_offset;
    int offset[2];
} Record;

static const char *text_of(const Record *r, const char *key) {
    return json_string_value(json_object_get(r->root, key));
}

static cau_result read_record(Record *out, const Picture *picture, const char *file, CauError *err) {
    *out = (Record){0};
    char *text = exr_attr_text(exr_attr_find(&picture->header->parts[0], CAU_ATTRIBUTE_MERGE));
    if (!text) return CAU_OK;
    out->root = json_loads(text, 0, NULL);
    free(text);
    *out = (Record){out->root, text_of(out, "beauty"), text_of(out, "caustics"), text_of(out, "pass"),
        text_of(out, "albedo"), text_of(out, "beauty_space"), text_of(out, "caustics_space"),
        text_of(out, "tint_space"), false, {0, 0}};
    if (!out->beauty || !out->caustics || !out->pass || !out->beauty_space || !out->caustics_space ||
        !out->tint_space)
        return error_set(
            err, CAU_ERROR_INPUT, "\"%s\": its record %s cannot be read", file, CAU_ATTRIBUTE_MERGE);
    json_t *offset = json_object_get(out->root, "offset");
    out->has_offset = offset && json_unpack(offset, "[i,i]", &out->offset[0], &out->offset[1]) == 0;
    return CAU_OK;
}

static cau_result open_inputs(
    HostPlan *plan, const char *file, const Record *record, const char *script, CauError *err) {
    char *caustics = NULL, *beauty = NULL;
    if (record->root) {
        picture_close(&plan->caustics);
        plan->has_beauty = true;
        cau_result result = host_find_input(&caustics, record->caustics, file, err);
        if (result == CAU_OK) result = host_find_input(&beauty, record->beauty, file, err);
        if (result == CAU_OK) result = picture_open(&plan->caustics, caustics, err);
        if (result == CAU_OK) result = picture_open(&plan->beauty, beauty, err);
        if (result == CAU_OK) result = picture_check_readable(&plan->beauty, err);
        if (result == CAU_OK) result = host_paths(plan, file, caustics, beauty, script, err);
        free(caustics);
        free(beauty);
        CAU_TRY(result);
    } else {
        CAU_TRY(host_paths(plan, file, NULL, NULL, script, err));
    }
    return picture_check_readable(&plan->caustics, err);
}

static cau_result find_layers(HostPlan *plan, const Record *record, CauError *err) {
    if (!record->root) return CAU_OK;
    CAU_TRY(picture_find_layer(&plan->target, &plan->beauty, record->pass, "--pass", err));
    if (plan->target->view)
        return error_set(err, CAU_ERROR_INPUT,
            "\"%s\" was added to the view \"%s\" of a stereo picture, and a script has no views: save each "
            "view as a file "
            "of its own first",
            record->beauty, plan->target->view);
    if (!record->albedo) return CAU_OK;
    return picture_find_layer(&plan->albedo, &plan->beauty, record->albedo, "--albedo", err);
}

static cau_result apply_settings(
    Lights *lights, const Record *record, const cau_merge_options *options, CauError *err) {
    json_t *recipe = json_object_get(record->root, "recipe");
    char *text = recipe ? json_dumps(recipe, JSON_COMPACT) : NULL;
    cau_result result = text ? recipe_apply_text(lights, text, "the recorded recipe", err) : CAU_OK;
    free(text);
    if (result == CAU_OK && options->recipe) result = recipe_apply(lights, options->recipe, err);
    for (size_t i = 0; result == CAU_OK && i < options->light_count; i++)
        result = setting_apply(lights, &options->lights[i], err);
    return result;
}

static bool coloured(const Setting *s) { return s->temperature_k != 6500 || s->saturation != 1; }

static bool is_plain(const Setting *s) {
    return s->gain == 1 && s->ev == 0 && s->tint[0] == 1 && s->tint[1] == 1 && s->tint[2] == 1 && !s->mute &&
           !s->solo && !coloured(s);
}

/* The spaces of the picture that was made; of caustics alone, their own for all that is not named. */
static cau_result find_spaces(Job *job, const HostPlan *plan, const Record *r, CauError *err) {
    const cau_merge_options *o = job->options;
    ColourTagSource unused;
    const char *tint = o->tint_space ? o->tint_space : plan->lights.tint_space;
    CAU_TRY(job_open_colour(&job->colour, o, err));
    job->beauty_space = r->beauty_space;
    job->caustics_space = r->caustics_space;
    if (!r->root) {
        CAU_TRY(space_find(&job->caustics_space, &unused, job, &plan->caustics,
            picture_colour_part(&plan->caustics, &plan->lights), o->caustics_space, "--caustics-space"));
        job->beauty_space = job->caustics_space;
        if (o->beauty_space) CAU_TRY(space_named(&job->beauty_space, job, o->beauty_space, "--beauty-space"));
    }
    job->tint_space = r->root ? r->tint_space : job->beauty_space;
    return tint ? space_named(&job->tint_space, job, tint, "--tint-space") : CAU_OK;
}

static cau_result find_conversion(
    HostPlan *plan, const Record *r, const cau_merge_options *options, CauError *err) {
    bool needed = options->beauty_space || options->tint_space || plan->lights.tint_space;
    for (size_t i = 0; i < plan->lights.count; i++)
        needed = needed || coloured(&plan->lights.lights[i].both) ||
                 coloured(&plan->lights.lights[i].indirect_only);
    if (r->root) needed = needed || strcmp(r->caustics_space, r->beauty_space) != 0;
    if (!needed) return CAU_OK;
    Job job = {.options = options, .err = err, .lights = plan->lights};
    cau_result result = find_spaces(&job, plan, r, err);
    if (result == CAU_OK) result = conversion_find(&plan->conversion, &job);
    if (result == CAU_OK) {
        plan->has_to_tint = strcmp(job.caustics_space, job.tint_space) != 0;
        plan->has_to_beauty = !plan->conversion.tint_in_beauty;
        if (plan->has_to_beauty) plan->tint_space = string_copy(job.tint_space);
    }
    colour_close(&job.colour);
    return result;
}

/* A name that a host would change could not be found again in a saved panel. */
static cau_result check_name(const char *name, CauError *err) {
    for (const char *c = name; *c; c++)
        if (!(*c == '_' || (*c >= '0' && *c <= '9') || (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z')))
            return error_set(err, CAU_ERROR_INPUT,
                "layer \"%s\": hosts change names with other characters than letters, digits and _; rename "
                "the "
                "layer, or render it with caustic-render",
                name);
    if (strlen(name) + sizeof CAU_SUFFIX_INDIRECT <= HOST_NAME_MAX) return CAU_OK;
    return error_set(err, CAU_ERROR_INPUT,
        "layer \"%s\": its name is longer than the %zu characters of a host's", name,
        HOST_NAME_MAX - sizeof CAU_SUFFIX_INDIRECT);
}

static int add_control(HostPlan *plan, const char *base, const char *suffix, int of, const Setting *setting) {
    HostControl *c = &plan->controls[plan->control_count];
    *c = (HostControl){.of = of, .saturates = setting->saturation != 1, .setting = *setting};
    /* Of a temperature the panel has the colour. */
    conversion_warm(c->setting.tint, &plan->conversion, setting->temperature_k);
    c->setting.temperature_k = setting_plain.temperature_k;
    snprintf(c->key, sizeof c->key, "%s%s", base, suffix);
    return (int)plan->control_count++;
}

static void add_layer(HostPlan *plan, int layer, int control, bool times_albedo) {
    if (layer < 0) return;
    plan->layers[plan->layer_count++] =
        (HostLayer){&plan->caustics.layers.layers[layer], control, times_albedo};
}

static cau_result add_light(HostPlan *plan, const Light *l, CauError *err) {
    bool weighted = plan->albedo && l->irradiance >= 0;
    if (!weighted && l->radiance < 0 && l->indirect < 0) return CAU_OK;
    CAU_TRY(check_name(l->base, err));
    int control = add_control(plan, l->base, "", -1, &l->both);
    add_layer(plan, weighted ? l->irradiance : l->radiance, control, weighted);
    if (weighted) add_layer(plan, l->seen, control, false);
    if (l->indirect >= 0 && !is_plain(&l->indirect_only))
        control = add_control(plan, l->base, CAU_SUFFIX_INDIRECT, control, &l->indirect_only);
    add_layer(plan, l->indirect, control, false);
    return CAU_OK;
}

static cau_result add_lights(HostPlan *plan, const char *file, CauError *err) {
    plan->controls = array_new(plan->lights.count * 2, sizeof *plan->controls);
    plan->layers = array_new(plan->lights.count * 3, sizeof *plan->layers);
    if (!plan->controls || !plan->layers)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu lights", plan->lights.count);
    for (size_t i = 0; i < plan->lights.count; i++) CAU_TRY(add_light(plan, &plan->lights.lights[i], err));
    if (plan->layer_count) return CAU_OK;
    return error_set(err, CAU_ERROR_INPUT,
        "\"%s\" is neither an output of caustic-merge add nor a caustics file: it has no light layers", file);
}

static void say_left_out(const Record *r, const cau_merge_options *options) {
    static const char *const left_out[][2] = {
        {"holdout", "the holdout of this picture is not in the script: mask the group's result there"},
        {"into_passes",
            "light groups and diffuse passes are not changed by the script, only the picture is"}};
    for (size_t i = 0; options->notice && i < 2; i++)
        if (json_is_true(json_object_get(r->root, left_out[i][0])))
            options->notice(options->user, left_out[i][1]);
}

static void find_shift(HostPlan *plan, const Record *record) {
    const ExrPart *b = &plan->beauty.header->parts[plan->target->part];
    if (!record->has_offset) return;
    plan->shift_x = record->offset[0] - b->data_window.x0;
    plan->shift_y = record->offset[1] - b->data_window.y0;
}

static cau_result plan_open(
    HostPlan *plan, const cau_merge_options *options, const char *file, const char *script, CauError *err) {
    Record record = {0};
    CAU_TRY(picture_open(&plan->caustics, file, err));
    cau_result result = read_record(&record, &plan->caustics, file, err);
    if (result == CAU_OK) result = open_inputs(plan, options->beauty, &record, script, err);
    if (result == CAU_OK) result = find_layers(plan, &record, err);
    if (result == CAU_OK) result = lights_find(&plan->lights, &plan->caustics, err);
    if (result == CAU_OK) result = apply_settings(&plan->lights, &record, options, err);
    if (result == CAU_OK) result = find_conversion(plan, &record, options, err);
    if (result == CAU_OK) result = add_lights(plan, file, err);
    if (result == CAU_OK) say_left_out(&record, options);
    if (result == CAU_OK && plan->has_beauty) find_shift(plan, &record);
    json_decref(record.root);
    return result;
}

cau_result host_plan(
    HostPlan *out, const cau_merge_options *options, const int frames[2], const char *script, CauError *err) {
    *out = (HostPlan){.has_frames = frames != NULL};
    char *frame = NULL;
    if (frames) {
        out->first = frames[0];
        out->last = frames[1];
        frame = frame_name(options->beauty, frames[0]);
        if (!frame)
            return error_set(err, CAU_ERROR_USAGE, "--frames needs #### or %%04d in \"%s\"", options->beauty);
    }
    cau_result result = plan_open(out, options, frame ? frame : options->beauty, script, err);
    free(frame);
    return result;
}

void host_plan_free(HostPlan *plan) {
    free(plan->controls);
    free(plan->layers);
    free(plan->caustics_path.path);
    free(plan->beauty_path.path);
    free(plan->tint_space);
    lights_free(&plan->lights);
    picture_close(&plan->caustics);
    picture_close(&plan->beauty);
}
