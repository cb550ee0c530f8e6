/* SPDX-License-Identifier: Apache-2.0 */
/* Which passes of the beauty are added to. */
#include "composite/job.h"

#include "core/checked.h"

static cau_result add_target(Job *job, const ExrLayer *layer, int light, const ExrLayer *divisor) {
    for (size_t t = 0; t < job->target_count; t++)
        if (job->targets[t].layer == layer) return CAU_OK; /* named by --pass already */
    for (int c = 0; c < 3; c++) {
        const ExrChannel *channel = &job->beauty.header->parts[layer->part].channels[layer->rgb[c]];
        if (channel->type == EXR_TYPE_UINT)
            return error_set(job->err, CAU_ERROR_INPUT,
                "\"%s\": channel \"%s\" holds whole numbers, to which light cannot be added: save it as half "
                "or float",
                job->options->beauty, channel->name);
    }
    void *array = job->targets;
    if (!array_reserve(&array, &job->target_capacity, job->target_count + 1, sizeof *job->targets))
        return error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for the list of passes");
    job->targets = array;
    job->targets[job->target_count++] = (Target){.layer = layer, .light = light, .divisor = divisor};
    return CAU_OK;
}

/* Of the target's view layer, and of its view in a stereo picture. */
static bool is_sibling(const Job *job, const ExrLayer *l) {
    return exr_layer_is_rgb(l) && l->pass_at == job->target->pass_at &&
           strncmp(l->name, job->target->name, l->pass_at) == 0 && exr_layer_same_view(l, job->target);
}

/* The sibling whose pass has that name; NULL. */
static const ExrLayer *sibling(const Job *job, const char *pass) {
    for (size_t i = 0; i < job->beauty.layers.count; i++) {
        const ExrLayer *l = &job->beauty.layers.layers[i];
        if (is_sibling(job, l) && strcmp(l->pass, pass) == 0) return l;
    }
    return NULL;
}

/* Blender makes dots of a light group's name underscores; our own layer names go further. */
static bool names_group(const Light *light, const char *group) {
    if (strcmp(light->name, group) == 0) return true;
    size_t i = 0;
    while (light->name[i] && (light->name[i] == group[i] || (light->name[i] == '.' && group[i] == '_'))) i++;
    if (!light->name[i] && !group[i]) return true;
    size_t prefix = strlen(CAU_LAYER_PREFIX);
    return strncmp(light->base, CAU_LAYER_PREFIX, prefix) == 0 && strcmp(light->base + prefix, group) == 0;
}

static cau_result find_groups(Job *job) {
    static const char prefix[] = "Combined_";
    size_t found = 0;
    for (size_t k = 0; k < job->lights.count; k++) {
        bool any = false;
        for (size_t i = 0; i < job->beauty.layers.count; i++) {
            const ExrLayer *l = &job->beauty.layers.layers[i];
            if (!is_sibling(job, l) || strncmp(l->pass, prefix, sizeof prefix - 1) != 0 ||
                !names_group(&job->lights.lights[k], l->pass + sizeof prefix - 1))
                continue;
            CAU_TRY(add_target(job, l, (int)k, NULL));
            any = true;
        }
        found += any;
        if (!any)
            job_notice(job, "light \"%s\" has no pass %s%s in the beauty: it is added to %s only",
                job->lights.lights[k].name, prefix, job->lights.lights[k].name, exr_layer_shown(job->target));
    }
    return found ? CAU_OK
                 : error_set(job->err, CAU_ERROR_INPUT,
                       "--into-groups: \"%s\" has no pass %sNAME for any of the lights; render it with light "
                       "groups of their names",
                       job->options->beauty, prefix);
}

static cau_result find_diffuse(Job *job) {
    static const char *const names[][2] = {
        {"DiffDir", "DiffCol"}, {"Diffuse Direct", "Diffuse Color"}, {"DiffuseDirect", "DiffuseColor"}};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const ExrLayer *direct = sibling(job, names[i][0]), *colour = sibling(job, names[i][1]);
        if (direct && colour) return add_target(job, direct, -1, colour);
    }
    return error_set(job->err, CAU_ERROR_INPUT,
        "--into-diffuse: \"%s\" has no direct diffuse pass with its colour (DiffDir and DiffCol, or Diffuse "
        "Direct and Diffuse Color) beside %s; render it with both",
        job->options->beauty, exr_layer_shown(job->target));
}

cau_result targets_find(Job *job) {
    CAU_TRY(add_target(job, job->target, -1, NULL));
    if (job->options->into_groups) CAU_TRY(find_groups(job));
    return job->options->into_diffuse ? find_diffuse(job) : CAU_OK;
}
