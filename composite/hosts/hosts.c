/* SPDX-License-Identifier: Apache-2.0 */
/* The public calls. */
#include "composite/hosts/hosts.h"

#include "core/checked.h"
#include "core/file_atomic.h"

#include <sys/stat.h>

typedef void Text(void *user, const char *text);

/* To a file, or to the caller when there is none. */
static cau_result deliver(
    const char *text, size_t size, const char *output, Text *call, void *user, CauError *err) {
    if (output) return file_write_atomic(output, text, size, err);
    if (call) call(user, text);
    return CAU_OK;
}

static cau_result check_output(const char *output, const char *input, CauError *err) {
    struct stat a, b;
    if (output && stat(output, &a) == 0 && stat(input, &b) == 0 && a.st_dev == b.st_dev &&
        a.st_ino == b.st_ino)
        return error_set(err, CAU_ERROR_INPUT,
            "the output \"%s\" is the input \"%s\" itself: inputs are never changed, choose another name",
            output, input);
    return CAU_OK;
}

static cau_result write_script(
    const HostPlan *plan, cau_merge_host host, char **text, size_t *size, CauError *err) {
    FILE *out = open_memstream(text, size);
    if (!out) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the script");
    cau_result result =
        host == CAU_MERGE_NUKE ? host_write_nuke(out, plan, err) : host_write_blender(out, plan, err);
    if (fclose(out) != 0 && result == CAU_OK)
        result = error_set(err, CAU_ERROR_RESOURCE, "out of memory for the script");
    return result;
}

cau_result cau_merge_script(cau_merge *merge, cau_merge_host host, const cau_merge_options *options,
    const int frames[2], Text *text, void *user) {
    if (!merge) return CAU_ERROR_USAGE;
    CauError *err = merge_begin(merge);
    cau_merge_options o;
    CAU_TRY(options_take(&o, options, err));
    CAU_TRY(check_output(o.output, o.beauty, err));
    HostPlan plan;
    char *script = NULL;
    size_t size = 0;
    cau_result result = host_plan(&plan, &o, frames, o.output, err);
    if (result == CAU_OK) result = write_script(&plan, host, &script, &size, err);
    if (result == CAU_OK) result = deliver(script, size, o.output, text, user, err);
    free(script);
    host_plan_free(&plan);
    return result;
}

static cau_result read_values(Lights *out, cau_merge_source source, const char *file, CauError *err) {
    if (source == CAU_MERGE_FROM_NUKE) return host_read_nuke(out, file, err);
    if (source == CAU_MERGE_FROM_BLENDER) return host_read_blender(out, file, err);
    char *text, from[CAU_ERROR_TEXT_MAX / 2];
    size_t size;
    CAU_TRY(host_read_file(&text, &size, file, err));
    snprintf(from, sizeof from, "recipe \"%s\"", file);
    cau_result result = host_read_recipe(out, text, from, err);
    free(text);
    return result;
}

cau_result cau_merge_recipe(cau_merge *merge, cau_merge_source source, const char *file, const char *output,
    const char *scene, Text *text, void *user) {
    if (!merge) return CAU_ERROR_USAGE;
    CauError *err = merge_begin(merge);
    if (!file) return error_set(err, CAU_ERROR_USAGE, "no file was named");
    CAU_TRY(check_output(output, file, err));
    Lights lights = {0};
    cau_result result = read_values(&lights, source, file, err);
    char *recipe = result == CAU_OK ? host_recipe_text(&lights) : NULL;
    if (result == CAU_OK && !recipe)
        result = error_set(err, CAU_ERROR_RESOURCE, "out of memory for a recipe");
    if (result == CAU_OK && scene) result = host_to_scene(&lights, scene, err);
    if (result == CAU_OK && (output || !scene))
        result = deliver(recipe, strlen(recipe), output, text, user, err);
    free(recipe);
    lights_free(&lights);
    return result;
}
