/* SPDX-License-Identifier: Apache-2.0 */
/* A sequence: frames side by side, each with its own files, told in order. */
#include "composite/job.h"

#include "core/checked.h"
#include "core/file_atomic.h"
#include "core/frames.h"
#include "core/ordered.h"

#include <jansson.h>
#include <stdatomic.h>
#include <stdio.h>
#include <unistd.h>

typedef struct Sequence Sequence;

/* What one frame said and counted while others were running. */
typedef struct Frame {
    Sequence *sequence;
    int number;
    cau_merge_options options;
    char *names[8]; /* the storage of the options' names */
    json_t *notices;
    bool skipped;
    cau_result result;
    uint64_t repaired, clamped;
    CauError err;
} Frame;

struct Sequence {
    const cau_merge_options *options;
    const cau_merge_frames *frames;
    Colour *colour; /* read once: a configuration may be large */
    Frame *running; /* per slot */
    unsigned threads, at_once;
    atomic_bool cancelled;
    atomic_bool recipe_written; /* one that is not of each frame */
    json_t *told;
    size_t done, skipped, failed;
};

/* Every name of a file in the options, and whether it must have a place for the number. */
static const struct Name {
    size_t at;
    bool needed;
} names[] = {
    {offsetof(cau_merge_options, beauty), true},
    {offsetof(cau_merge_options, caustics), true},
    {offsetof(cau_merge_options, output), true},
    {offsetof(cau_merge_options, preview), true},
    {offsetof(cau_merge_options, contact_sheet), true},
    {offsetof(cau_merge_options, recipe), false},
    {offsetof(cau_merge_options, write_recipe), false},
    {offsetof(cau_merge_options, holdout), false},
};
enum { NAMES = sizeof names / sizeof *names };

static cau_result check_names(const cau_merge_options *o, CauError *err) {
    size_t begin, length;
    int digits;
    for (int i = 0; i < NAMES; i++) {
        const char *name;
        memcpy(&name, (const char *)o + names[i].at, sizeof name);
        if (name && names[i].needed && !frame_place(name, &begin, &length, &digits))
            return error_set(err, CAU_ERROR_USAGE,
                "a sequence needs #### or %%04d in every name of a picture: \"%s\" has none", name);
    }
    return CAU_OK;
}

static void keep_notice(void *user, const char *sentence) {
    json_array_append_new(((Frame *)user)->notices, json_stringn_nocheck(sentence, strlen(sentence)));
}

static void poll_user(void *data) {
    Sequence *s = data;
    const cau_merge_options *o = s->options;
    if (o->cancelled && o->cancelled(o->user)) atomic_store(&s->cancelled, true);
}

/* The user is asked on the calling thread only, which is this one when there are no others. */
static int is_cancelled(void *user) {
    Sequence *s = ((Frame *)user)->sequence;
    if (s->at_once == 1) poll_user(s);
    return atomic_load(&s->cancelled);
}

static cau_result prepare(const Sequence *s, Frame *f) {
    f->options = *s->options;
    f->options.notice = keep_notice;
    f->options.cancelled = is_cancelled;
    f->options.user = f;
    f->notices = json_array();
    for (int i = 0; i < NAMES; i++) {
        const char *name;
        size_t begin, length;
        int digits;
        memcpy(&name, (const char *)s->options + names[i].at, sizeof name);
        if (!name || !frame_place(name, &begin, &length, &digits)) continue;
        f->names[i] = frame_name(name, f->number);
        if (!f->names[i]) return error_set(&f->err, CAU_ERROR_RESOURCE, "out of memory for a name");
        memcpy((char *)&f->options + names[i].at, &f->names[i], sizeof name);
    }
    if (s->at_once > 1) f->options.threads = s->threads / s->at_once ? s->threads / s->at_once : 1;
    f->options.memory_bytes = job_memory(s->options) / s->at_once;
    if (atomic_load(&s->recipe_written)) f->options.write_recipe = NULL; /* the same for all */
    return f->notices ? CAU_OK : error_set(&f->err, CAU_ERROR_RESOURCE, "out of memory for a frame");
}

/* A picture that is asked for, or none. */
static bool is_there(const char *path) { return !path || access(path, R_OK) == 0; }

static cau_result add_frame(Sequence *s, Frame *f) {
    char stamp[STAMP_MAX];
    CAU_TRY(prepare(s, f));
    CAU_TRY(stamp_make(stamp, &f->options, &f->err));
    f->skipped = s->frames->resume && is_there(f->options.preview) && is_there(f->options.contact_sheet) &&
                 stamp_matches(f->options.output, stamp);
    if (f->skipped) return CAU_OK;
    Job job = {
        .options = &f->options, .err = &f->err, .stamp = stamp, .colour = s->colour, .colour_lent = true};
    cau_result result = job_add(&job);
    f->repaired = job.repaired;
    f->clamped = job.clamped;
    if (result == CAU_OK && f->options.write_recipe == s->options->write_recipe)
        atomic_store(&s->recipe_written, true);
    return result;
}

static cau_result work(void *data, size_t index, unsigned slot, CauError *err) {
    Sequence *s = data;
    Frame *f = &s->running[slot];
    (void)err; /* a frame's failure is told, it does not end the run here */
    *f = (Frame){.sequence = s, .number = s->frames->first + (int)index * s->frames->step};
    f->result = add_frame(s, f);
    return CAU_OK;
}

static const char *sentence_of(const Frame *f) {
    return f->result != CAU_OK ? f->err.text : f->skipped ? "skipped" : "done";
}

static void record(Sequence *s, const Frame *f) {
    json_t *item = json_object();
    const char *texts[][2] = {
        {"beauty", f->options.beauty}, {"caustics", f->options.caustics}, {"output", f->options.output}};
    json_object_set_new(item, "frame", json_integer(f->number));
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        json_t *text = texts[i][1] ? json_string(texts[i][1]) : NULL;
        json_object_set_new(item, texts[i][0], text ? text : json_string("(not UTF-8)"));
    }
    json_object_set_new(item, "result",
        json_string(f->result != CAU_OK ? "failed"
                    : f->skipped        ? "skipped"
                                        : "done"));
    if (f->result != CAU_OK) {
        json_t *text = json_string(f->err.text);
        json_object_set_new(item, "error", text ? text : json_string("(not UTF-8)"));
    }
    json_object_set_new(item, "repaired_nan", json_integer((json_int_t)f->repaired));
    json_object_set_new(item, "clamped", json_integer((json_int_t)f->clamped));
    json_object_set(item, "notices", f->notices);
    json_array_append_new(s->told, item);
}

static cau_result take(void *data, size_t index, unsigned slot, CauError *err) {
    Sequence *s = data;
    Frame *f = &s->running[slot];
    const cau_merge_options *o = s->options;
    size_t i;
    json_t *text;
    (void)index;
    json_array_foreach(f->notices, i, text) {
        if (o->notice) o->notice(o->user, json_string_value(text));
    }
    if (s->frames->frame) s->frames->frame(o->user, f->number, f->options.output, f->result, sentence_of(f));
    record(s, f);
    *(f->result != CAU_OK ? &s->failed : f->skipped ? &s->skipped : &s->done) += 1;
    cau_result result = f->result;
    bool ends = result == CAU_ERROR_CANCELLED || result == CAU_ERROR_USAGE || result == CAU_ERROR_RESOURCE;
    if (ends) {
        error_set(err, result, "%s", f->err.text);
        atomic_store(&s->cancelled, true); /* the frames beside it end too */
    }
    for (int k = 0; k < NAMES; k++) free(f->names[k]);
    json_decref(f->notices);
    *f = (Frame){0};
    poll_user(s);
    return ends ? result : CAU_OK;
}

static cau_result write_report(const Sequence *s, CauError *err) {
    json_t *root = json_object();
    json_object_set_new(root, "program", json_string("caustic-merge " CAUSTICS_VERSION));
    json_object_set_new(root, "done", json_integer((json_int_t)s->done));
    json_object_set_new(root, "skipped", json_integer((json_int_t)s->skipped));
    json_object_set_new(root, "failed", json_integer((json_int_t)s->failed));
    json_object_set(root, "frames", s->told);
    char *text = json_dumps(root, JSON_INDENT(1));
    json_decref(root);
    if (!text) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the report");
    cau_result result = file_write_atomic(s->frames->report, text, strlen(text), err);
    free(text);
    return result;
}

/* What one frame takes, by the headers of the first that can be opened; else a guess. */
static size_t frame_bytes(const Sequence *s, size_t count) {
    enum { GUESS = 150 << 20, OTHERWISE = 20 << 20 };
    size_t bytes = 0;
    for (size_t i = 0; !bytes && i < count && i < 10; i++) {
        int number = s->frames->first + (int)i * s->frames->step;
        char *paths[2] = {frame_name(s->options->beauty, number), frame_name(s->options->caustics, number)};
        Picture pictures[2] = {{0}, {0}};
        CauError unused = {0};
        if (paths[0] && paths[1] && picture_open(&pictures[0], paths[0], &unused) == CAU_OK &&
            picture_open(&pictures[1], paths[1], &unused) == CAU_OK)
            bytes = OTHERWISE + job_lane_bytes(pictures[0].header, pictures[1].header);
        for (int k = 0; k < 2; k++) {
            picture_close(&pictures[k]);
            free(paths[k]);
        }
    }
    return bytes ? bytes : GUESS;
}

/* As many frames as there are processors and room for. */
static void choose_at_once(Sequence *s, size_t count) {
    size_t memory = job_memory(s->options), each = frame_bytes(s, count);
    s->threads = s->options->threads ? s->options->threads : ordered_processors();
    s->at_once = s->threads;
    if (s->at_once > count) s->at_once = (unsigned)count;
    while (s->at_once > 1 && each > memory / s->at_once) s->at_once--;
}

static cau_result run_frames(Sequence *s, size_t count, CauError *err) {
    CAU_TRY(job_open_colour(&s->colour, s->options, err));
    choose_at_once(s, count);
    s->running = array_new(s->at_once + 1, sizeof *s->running);
    s->told = json_array();
    if (!s->running || !s->told)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu frames", count);
    unsigned slots = s->at_once + (s->at_once > 1);
    cau_result result = ordered_run(s->at_once, slots, count, work, take, poll_user, s, err);
    for (unsigned i = 0; i < slots; i++) { /* frames that ended after the run did */
        for (int k = 0; k < NAMES; k++) free(s->running[i].names[k]);
        json_decref(s->running[i].notices);
    }
    if (!s->frames->report) return result;
    cau_result written = write_report(s, err);
    return result == CAU_OK ? written : result;
}

cau_result sequence_run(const cau_merge_options *o, const cau_merge_frames *frames, CauError *err) {
    CAU_TRY(check_names(o, err));
    if (frames->step < 1 || frames->last < frames->first)
        return error_set(err, CAU_ERROR_USAGE, "frames %d to %d in steps of %d are no sequence",
            frames->first, frames->last, frames->step);
    size_t count = ((size_t)frames->last - (size_t)frames->first) / (size_t)frames->step + 1;
    Sequence s = {.options = o, .frames = frames};
    cau_result result = run_frames(&s, count, err);
    colour_close(&s.colour);
    free(s.running);
    json_decref(s.told);
    if (result != CAU_OK || !s.failed) return result;
    return error_set(err, CAU_ERROR_INPUT, "%zu of %zu frames were not done", s.failed, count);
}
