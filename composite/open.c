/* SPDX-License-Identifier: Apache-2.0 */
/* Opens the inputs, and makes sure that the output is none of them before anything is computed. */
#include "composite/job.h"

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

static cau_result check_output(const Job *job, const char *output) {
    struct stat out, in;
    if (!output) return CAU_OK;
    if (lstat(output, &out) == 0 && !S_ISREG(out.st_mode) && !S_ISLNK(out.st_mode) && !S_ISDIR(out.st_mode))
        return error_set(
            job->err, CAU_ERROR_INPUT, "cannot write \"%s\": it is a device or a pipe, not a file", output);
    if (stat(output, &out) != 0) return CAU_OK;
    const char *inputs[] = {job->options->beauty, job->options->caustics, job->options->recipe,
        job->options->ocio, job->options->holdout};
    for (size_t i = 0; i < sizeof inputs / sizeof *inputs; i++)
        if (inputs[i] && stat(inputs[i], &in) == 0 && in.st_dev == out.st_dev && in.st_ino == out.st_ino)
            return error_set(job->err, CAU_ERROR_INPUT,
                "the output \"%s\" is the input \"%s\" itself: inputs are never changed, choose another name",
                output, inputs[i]);
    return CAU_OK;
}

static cau_result check_outputs(const Job *job) {
    const cau_merge_options *o = job->options;
    const char *outputs[] = {o->output, o->preview, o->write_recipe};
    enum { OUTPUTS = sizeof outputs / sizeof *outputs };
    for (int i = 0; i < OUTPUTS; i++) {
        CAU_TRY(check_output(job, outputs[i]));
        for (int k = 0; k < i; k++)
            if (outputs[i] && outputs[k] && strcmp(outputs[i], outputs[k]) == 0)
                return error_set(job->err, CAU_ERROR_USAGE, "two outputs are both \"%s\"", outputs[i]);
    }
    return CAU_OK;
}

cau_result job_open(Job *job) {
    const cau_merge_options *o = job->options;
    CAU_TRY(check_outputs(job));
    CAU_TRY(colour_open(&job->colour, o->ocio, job->err));
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
    colour_close(&job->colour);
}
