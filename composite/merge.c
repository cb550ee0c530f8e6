/* SPDX-License-Identifier: Apache-2.0 */
/* The public calls: arguments are checked here, the stages do the work. */
#include "caustics/composite.h"
#include "composite/job.h"
#include "composite/report.h"
#include "core/checked.h"

#include <math.h>

struct cau_merge {
    CauError err;
};

cau_result cau_merge_create(cau_merge **out) {
    if (!out) return CAU_ERROR_USAGE;
    *out = array_new(1, sizeof **out);
    return *out ? CAU_OK : CAU_ERROR_RESOURCE;
}

void cau_merge_destroy(cau_merge **merge) {
    if (!merge) return;
    free(*merge);
    *merge = NULL;
}

const char *cau_merge_error(const cau_merge *merge) {
    return merge ? merge->err.text : "no cau_merge was given";
}

CauError *merge_begin(cau_merge *merge) {
    error_clear(&merge->err);
    return &merge->err;
}

static cau_result check_light(const cau_merge_light *l, CauError *err) {
    bool finite = true;
    if (l->set & CAU_MERGE_TEMPERATURE) finite = finite && isfinite(l->temperature_k);
    if (l->set & CAU_MERGE_SATURATION) finite = finite && isfinite(l->saturation);
    if (l->set & CAU_MERGE_GAIN) finite = finite && isfinite(l->gain);
    if (l->set & CAU_MERGE_EV) finite = finite && isfinite(l->ev);
    for (int i = 0; i < 3 && (l->set & CAU_MERGE_TINT); i++) finite = finite && isfinite(l->tint[i]);
    return finite ? CAU_OK
                  : error_set(err, CAU_ERROR_USAGE, "light \"%s\": a factor is not a finite number",
                        l->light ? l->light : "(every light)");
}

/* A caller built against an older header gives a shorter structure; what it lacks is zero. */
cau_result options_take(cau_merge_options *out, const cau_merge_options *given, CauError *err) {
    *out = (cau_merge_options){0};
    if (!given || given->size < offsetof(cau_merge_options, lights) || given->size > 65536)
        return error_set(err, CAU_ERROR_USAGE, "cau_merge_options: \"size\" is not that of the structure");
    memcpy(out, given, given->size < sizeof *out ? given->size : sizeof *out);
    if (!out->beauty) return error_set(err, CAU_ERROR_USAGE, "no picture was named");
    for (size_t i = 0; i < out->light_count; i++) CAU_TRY(check_light(&out->lights[i], err));
    return CAU_OK;
}

cau_result job_add(Job *job) {
    cau_result result = job_open(job);
    if (result == CAU_OK) result = job_match(job);
    if (result == CAU_OK) result = job_gain(job);
    if (result == CAU_OK) result = job_write(job);
    job_close(job);
    return result;
}

cau_result cau_merge_add(cau_merge *merge, const cau_merge_options *options) {
    if (!merge) return CAU_ERROR_USAGE;
    error_clear(&merge->err);
    cau_merge_options o;
    CAU_TRY(options_take(&o, options, &merge->err));
    if (!o.caustics || !o.output)
        return error_set(&merge->err, CAU_ERROR_USAGE, "add needs a beauty, caustics and an output");
    Job job = {.options = &o, .err = &merge->err};
    return job_add(&job);
}

cau_result cau_merge_add_frames(
    cau_merge *merge, const cau_merge_options *options, const cau_merge_frames *frames) {
    if (!merge) return CAU_ERROR_USAGE;
    error_clear(&merge->err);
    cau_merge_options o;
    CAU_TRY(options_take(&o, options, &merge->err));
    if (!o.caustics || !o.output)
        return error_set(&merge->err, CAU_ERROR_USAGE, "add needs a beauty, caustics and an output");
    if (!frames || frames->size != sizeof *frames)
        return error_set(
            &merge->err, CAU_ERROR_USAGE, "cau_merge_frames: \"size\" is not that of the structure");
    return sequence_run(&o, frames, &merge->err);
}

cau_result cau_merge_preview(cau_merge *merge, const cau_merge_options *options) {
    if (!merge) return CAU_ERROR_USAGE;
    error_clear(&merge->err);
    cau_merge_options o;
    CAU_TRY(options_take(&o, options, &merge->err));
    if (!o.preview) return error_set(&merge->err, CAU_ERROR_USAGE, "preview needs a picture and an output");
    o.caustics = o.output = NULL;
    Job job = {.options = &o, .err = &merge->err};
    cau_result result = job_open(&job);
    if (result == CAU_OK) result = job_preview(&job);
    job_close(&job);
    return result;
}

static cau_result run_report(cau_merge *merge, cau_result (*run)(const Report *, const char *),
    const char *file, void (*line)(void *user, const char *text), void *user) {
    if (!merge) return CAU_ERROR_USAGE;
    error_clear(&merge->err);
    if (!file) return error_set(&merge->err, CAU_ERROR_USAGE, "no file was named");
    Report report = {line, user, &merge->err};
    return run(&report, file);
}

cau_result cau_merge_list(
    cau_merge *merge, const char *file, void (*line)(void *user, const char *text), void *user) {
    return run_report(merge, report_list, file, line, user);
}

cau_result cau_merge_check(
    cau_merge *merge, const char *file, void (*line)(void *user, const char *text), void *user) {
    return run_report(merge, report_check, file, line, user);
}

cau_result cau_merge_list_json(
    cau_merge *merge, const char *file, void (*text)(void *user, const char *text), void *user) {
    return run_report(merge, report_list_json, file, text, user);
}

cau_result cau_merge_diff(
    cau_merge *merge, const char *a, const char *b, void (*line)(void *user, const char *text), void *user) {
    if (!merge) return CAU_ERROR_USAGE;
    error_clear(&merge->err);
    if (!a || !b) return error_set(&merge->err, CAU_ERROR_USAGE, "diff needs two files");
    Report report = {line, user, &merge->err};
    return report_diff(&report, a, b);
}

cau_result cau_merge_shards(
    cau_merge *merge, const char *const *files, size_t count, const cau_merge_options *options) {
    if (!merge) return CAU_ERROR_USAGE;
    error_clear(&merge->err);
    cau_merge_options o = {0};
    if (!options || options->size < offsetof(cau_merge_options, lights) || options->size > 65536)
        return error_set(
            &merge->err, CAU_ERROR_USAGE, "cau_merge_options: \"size\" is not that of the structure");
    memcpy(&o, options, options->size < sizeof o ? options->size : sizeof o);
    if (count < 2 || !files || !o.output)
        return error_set(&merge->err, CAU_ERROR_USAGE, "shards needs at least two files and an output");
    return shards_join(files, count, &o, &merge->err);
}
