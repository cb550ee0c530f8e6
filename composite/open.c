/* SPDX-License-Identifier: Apache-2.0 */
/* Opens the inputs, and makes sure that the output is none of them before anything is computed. */
#include "composite/job.h"
#include "core/file_atomic.h"

#include <glob.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

void job_notice(const Job *job, const char *format, ...) {
    if (!job->options->notice) return;
    char text[CAU_ERROR_TEXT_MAX];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    job->options->notice(job->options->user, text);
}

cau_result job_poll(const Job *job) {
    if (!job->options->cancelled || !job->options->cancelled(job->options->user)) return CAU_OK;
    return error_set(job->err, CAU_ERROR_CANCELLED, "stopped on request; no output was written or changed");
}

cau_result output_check(const char *output, const char *input, CauError *err) {
    struct stat out, in;
    if (lstat(output, &out) == 0 && !S_ISREG(out.st_mode) && !S_ISLNK(out.st_mode) && !S_ISDIR(out.st_mode))
        return error_set(
            err, CAU_ERROR_RESOURCE, "cannot write \"%s\": it is a device or a pipe; name a file", output);
    if (stat(output, &out) == 0 && S_ISDIR(out.st_mode))
        return error_set(
            err, CAU_ERROR_RESOURCE, "cannot write \"%s\": it is a folder; name a file in it", output);
    if (!input || stat(output, &out) != 0 || stat(input, &in) != 0) return CAU_OK;
    if (in.st_dev != out.st_dev || in.st_ino != out.st_ino) return CAU_OK;
    return error_set(err, CAU_ERROR_INPUT,
        "the output \"%s\" is the input \"%s\" itself: inputs are never changed, choose another name", output,
        input);
}

static cau_result check_output(const Job *job, const char *output) {
    const cau_merge_options *o = job->options;
    const char *inputs[] = {NULL, o->beauty, o->caustics, o->recipe, o->ocio, o->holdout};
    for (size_t i = 0; output && i < sizeof inputs / sizeof *inputs; i++)
        CAU_TRY(output_check(output, inputs[i], job->err));
    return CAU_OK;
}

static cau_result check_outputs(const Job *job) {
    const cau_merge_options *o = job->options;
    const char *outputs[] = {o->output, o->preview, o->contact_sheet, o->write_recipe};
    enum { OUTPUTS = sizeof outputs / sizeof *outputs };
    for (int i = 0; i < OUTPUTS; i++) {
        CAU_TRY(check_output(job, outputs[i]));
        for (int k = 0; k < i; k++)
            if (outputs[i] && outputs[k] && strcmp(outputs[i], outputs[k]) == 0)
                return error_set(job->err, CAU_ERROR_USAGE, "two outputs are both \"%s\"", outputs[i]);
    }
    return CAU_OK;
}

/* What is written after the picture must not fail when that is there: tried now. */
static cau_result try_outputs(const Job *job) {
    const cau_merge_options *o = job->options;
    const char *outputs[] = {o->preview, o->contact_sheet, o->write_recipe};
    for (size_t i = 0; o->output && i < sizeof outputs / sizeof *outputs; i++) {
        FileAtomic file;
        if (!outputs[i]) continue;
        CAU_TRY(file_atomic_begin(&file, outputs[i], job->err));
        file_atomic_abort(&file);
    }
    return CAU_OK;
}

/* Blender's own configuration: beside the program, or where distributions put it. */
static cau_result find_blender(char *out, size_t room, CauError *err) {
    static const char *const places[] = {"/usr/share/blender/datafiles/colormanagement/config.ocio",
        "/usr/share/blender/*/datafiles/colormanagement/config.ocio",
        "/usr/lib/blender/*/datafiles/colormanagement/config.ocio",
        "/opt/blender*/*/datafiles/colormanagement/config.ocio"};
    const char *folders = getenv("PATH");
    char pattern[PATH_MAX + 64], program[PATH_MAX], real[PATH_MAX];
    glob_t found = {0};
    while (folders && *folders) {
        size_t length = strcspn(folders, ":");
        snprintf(program, sizeof program, "%.*s/blender", (int)length, folders);
        folders += length + (folders[length] == ':');
        if (!realpath(program, real)) continue;
        *strrchr(real, '/') = '\0';
        snprintf(pattern, sizeof pattern, "%s/*/datafiles/colormanagement/config.ocio", real);
        glob(pattern, GLOB_APPEND, NULL, &found);
    }
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) glob(places[i], GLOB_APPEND, NULL, &found);
    bool any = found.gl_pathc > 0 && strlen(found.gl_pathv[0]) < room;
    if (any) strcpy(out, found.gl_pathv[0]);
    globfree(&found);
    return any ? CAU_OK
               : error_set(err, CAU_ERROR_INPUT,
                     "--ocio blender: no Blender was found on the PATH with a "
                     "datafiles/colormanagement/config.ocio; name the file itself");
}

cau_result job_open_colour(Colour **out, const cau_merge_options *o, CauError *err) {
    char path[PATH_MAX];
    if (!o->ocio || strcmp(o->ocio, "blender") != 0) return colour_open(out, o->ocio, err);
    CAU_TRY(find_blender(path, sizeof path, err));
    return colour_open(out, path, err);
}

cau_result job_open(Job *job) {
    const cau_merge_options *o = job->options;
    CAU_TRY(check_outputs(job));
    CAU_TRY(try_outputs(job));
    if (!job->colour_lent) CAU_TRY(job_open_colour(&job->colour, o, job->err));
    CAU_TRY(picture_open(&job->beauty, o->beauty, job->err));
    CAU_TRY(picture_check_readable(&job->beauty, job->err));
    if (!o->caustics) return CAU_OK;
    CAU_TRY(picture_open(&job->caustics, o->caustics, job->err));
    return picture_check_readable(&job->caustics, job->err);
}

void job_close(Job *job) {
    free(job->targets);
    free(job->kept);
    holdout_close(&job->holdout);
    free(job->terms);
    colour_view_close(&job->view);
    lights_free(&job->lights);
    picture_close(&job->caustics);
    picture_close(&job->beauty);
    if (!job->colour_lent) colour_close(&job->colour);
}
