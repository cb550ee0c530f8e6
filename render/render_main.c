/* SPDX-License-Identifier: Apache-2.0 */
/* caustic-render: a thin front of the library. Options: DESIGN section 6. */
#include "caustics/render.h"
#include "caustics/render_file.h"
#include "caustics/scene_file.h"
#include "core/file_atomic.h"
#include "core/frames.h"
#include "render/render_options.h"

#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* All that a signal handler can reach. */
static cau_render *volatile running_render;
static volatile sig_atomic_t stopped;

static void on_signal(int number) {
    stopped = number;
    cau_render *r = running_render;
    if (r) cau_render_cancel(r);
}

static void catch_signals(cau_render *render) {
    running_render = render;
    struct sigaction action = {.sa_handler = on_signal};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    if (stopped) cau_render_cancel(render); /* between two frames */
}

static void format_seconds(char *out, size_t size, double s) {
    if (s < 0)
        snprintf(out, size, "?");
    else if (s < 100)
        snprintf(out, size, "%.0f s", s);
    else
        snprintf(out, size, "%.0f min %02d s", (double)(long)(s / 60), (int)((long)s % 60));
}

/* For a host that shows its own bar; null: not known yet. */
static void print_progress(const cau_progress *p) {
    char error[32] = "null", left[32] = "null";
    if (p->error >= 0) snprintf(error, sizeof error, "%.6g", p->error);
    if (p->remaining_s >= 0) snprintf(left, sizeof left, "%.3f", p->remaining_s);
    fprintf(stderr,
        "{\"stage\": \"%s\", \"photons_per_light\": %" PRIu64
        ", \"error\": %s, \"elapsed_s\": %.3f, \"remaining_s\": %s}\n",
        p->stage, p->photons_per_light, error, p->elapsed_s, left);
}

typedef struct Run {
    const RenderArguments *arguments;
    cau_render *render;
    cau_scene *scene;
    const cau_context *context;
    double saved_s;
    cau_result saved; /* a checkpoint that failed is told once; rendering goes on */
} Run;

static void save_sometimes(Run *run, const cau_progress *p) {
    const RenderArguments *a = run->arguments;
    if (!a->checkpoint || run->saved != CAU_OK || strcmp(p->stage, "rendering") != 0 ||
        p->elapsed_s - run->saved_s < a->checkpoint_s)
        return;
    run->saved = cau_render_save_file(run->render, run->scene, a->checkpoint);
    run->saved_s = cau_render_poll(run->render).elapsed_s;
    if (run->saved != CAU_OK) fprintf(stderr, "caustic-render: %s\n", cau_error_text(run->context));
}

static void show_progress(void *data, const cau_progress *p) {
    Run *run = data;
    const RenderArguments *a = run->arguments;
    save_sometimes(run, p);
    if (a->progress) {
        print_progress(p);
        return;
    }
    if (a->quiet) return;
    char left[32], error[32];
    format_seconds(left, sizeof left, p->remaining_s);
    if (p->error >= 0)
        snprintf(error, sizeof error, "%.2f %%", 100 * p->error);
    else
        snprintf(error, sizeof error, "?");
    bool terminal = isatty(STDERR_FILENO), last = strcmp(p->stage, "done") == 0;
    if (!terminal && !last) return;
    fprintf(stderr, "%s%s: %.2f million photons per light, error %s, %.1f s gone, %s left",
        terminal ? "\r\033[K" : "", p->stage, (double)p->photons_per_light * 1e-6, error, p->elapsed_s, left);
    if (last) fputc('\n', stderr);
}

/* NAME.incomplete.exr beside NAME.exr: a stopped render never takes the place of a whole one. */
static char *incomplete_name(const char *path) {
    size_t n = strlen(path);
    char *name = malloc(n + 20);
    if (!name) return NULL;
    size_t stem = n > 4 && strcmp(path + n - 4, ".exr") == 0 ? n - 4 : n;
    snprintf(name, n + 20, "%.*s.incomplete.exr", (int)stem, path);
    return name;
}

static cau_write_options write_options(const RenderArguments *a) {
    return (cau_write_options){.size = sizeof(cau_write_options),
        .half = a->half,
        .interleave = a->interleave,
        .crop = a->crop,
        .shard_index = a->options.shard_index,
        .shard_count = a->options.shard_count,
        .stamp = a->frames != NULL,
        .seed = a->options.seed};
}

static cau_result write_result(
    cau_render *render, cau_scene *scene, const RenderArguments *a, bool complete) {
    cau_write_options options = write_options(a);
    options.complete = complete;
    options.photons = cau_render_poll(render).photons_per_light;
    char *path = complete ? strdup(a->output) : incomplete_name(a->output);
    if (!path) return CAU_ERROR_RESOURCE;
    cau_result result = cau_render_write(render, scene, path, &options);
    if (result == CAU_OK && !a->quiet) fprintf(stderr, "wrote %s%s\n", path, complete ? "" : " (incomplete)");
    free(path);
    if (result == CAU_OK && a->report) result = cau_render_write_report(render, scene, a->report);
    return result;
}

/* Blender and Nuke would make something else of dots, spaces and long names: say what a light is called now.
 */
static void show_mapped_names(cau_render *render, cau_scene *scene, const RenderArguments *a) {
    for (size_t i = 0; !a->quiet && i < cau_render_light_count(render); i++) {
        char name[32];
        int mapped = 0;
        if (cau_render_layer_name(render, scene, i, name, sizeof name, &mapped) == CAU_OK && mapped)
            fprintf(
                stderr, "note: the layer of \"%s\" is called %s\n", cau_render_light(render, i).light, name);
    }
}

static void show_warnings(const cau_render *render, const RenderArguments *a) {
    for (size_t i = 0; !a->quiet && cau_render_warning(render, i); i++)
        fprintf(stderr, "warning: %s\n", cau_render_warning(render, i));
}

/* Minutes of rendering for a folder that does not exist would be lost: tried before, not after. */
static cau_result check_output(const RenderArguments *a) {
    const char *paths[] = {a->output, a->report, a->checkpoint};
    CauError error = {0};
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
        FileAtomic file;
        if (!paths[i]) continue;
        cau_result result = file_atomic_begin(&file, paths[i], &error);
        file_atomic_abort(&file);
        if (result == CAU_OK) continue;
        fprintf(stderr, "caustic-render: %s\n", error.text);
        return result;
    }
    return CAU_OK;
}

/* What an earlier run, or other machines, have rendered already. */
static cau_result take_states(cau_scene *scene, cau_render *render, const RenderArguments *a) {
    for (size_t i = 0; i < a->joined_count; i++) CAU_TRY(cau_render_join_file(render, scene, a->joined[i]));
    if (!a->resume || !a->checkpoint) return CAU_OK;
    if (access(a->checkpoint, F_OK) == 0) return cau_render_load_file(render, scene, a->checkpoint);
    if (!a->quiet) fprintf(stderr, "note: there is no %s yet: the render starts anew\n", a->checkpoint);
    return CAU_OK;
}

static cau_result render_scene(Run *run) {
    const RenderArguments *a = run->arguments;
    cau_scene *scene = run->scene;
    cau_render *render = run->render;
    cau_write_options options = write_options(a);
    if (a->frames && a->resume && cau_render_is_written(render, a->output, &options)) {
        if (!a->quiet) fprintf(stderr, "%s is done already\n", a->output);
        return CAU_OK;
    }
    show_warnings(render, a);
    show_mapped_names(render, scene, a);
    if (a->explain) {
        cau_result planned = cau_render_plan(render);
        if (planned == CAU_OK) fputs(cau_render_explain(render), stdout);
        fflush(stdout);
        if (planned != CAU_OK || !a->output) return planned;
    }
    cau_result result = take_states(scene, render, a);
    if (result == CAU_OK) result = cau_render_start(render);
    if (result != CAU_OK) return result;
    result = cau_render_wait(render, 0.25, show_progress, run);
    if (result != CAU_OK && result != CAU_ERROR_CANCELLED) return result;
    cau_result saved = a->checkpoint ? cau_render_save_file(render, scene, a->checkpoint) : CAU_OK;
    if (saved == CAU_ERROR_CANCELLED) saved = CAU_OK; /* stopped before there was anything to keep */
    if (!a->output) return saved != CAU_OK ? saved : result;
    if (result == CAU_OK && cau_render_error(render) == 0 && !a->quiet)
        fprintf(stderr, "note: the layers are black: %s", cau_render_explain(render));
    cau_result written = write_result(render, scene, a, result == CAU_OK);
    if (written == CAU_OK) written = saved;
    return written != CAU_OK ? written : result;
}

static cau_result render_file(const RenderArguments *a) {
    cau_context *context = NULL;
    cau_scene *scene = NULL;
    cau_render *render = NULL;
    cau_result result = cau_context_create(&context);
    if (result == CAU_OK) result = cau_scene_load_file(context, a->scene, &scene);
    if (result == CAU_OK) result = cau_render_create(scene, &a->options, &render);
    if (result == CAU_OK) {
        catch_signals(render);
        Run run = {.arguments = a, .context = context, .scene = scene, .render = render};
        result = render_scene(&run);
        running_render = NULL;
    }
    if (result != CAU_OK && result != CAU_ERROR_CANCELLED)
        fprintf(stderr, "caustic-render: %s\n", context ? cau_error_text(context) : "out of memory");
    cau_render_destroy(&render);
    cau_scene_destroy(&scene);
    cau_context_destroy(&context);
    return result;
}

static cau_result render_frame(const RenderArguments *a, int frame) {
    RenderArguments one = *a;
    const char **names[] = {&one.scene, &one.output, &one.report, &one.checkpoint};
    enum { NAMES = sizeof names / sizeof *names };
    char *made[NAMES] = {0};
    cau_result result = CAU_OK;
    for (size_t i = 0; i < NAMES; i++) {
        size_t begin, length;
        int digits;
        if (!*names[i] || !frame_place(*names[i], &begin, &length, &digits)) continue;
        made[i] = frame_name(*names[i], frame);
        if (!made[i]) result = CAU_ERROR_RESOURCE;
        *names[i] = made[i];
    }
    if (result == CAU_OK) result = check_output(&one);
    if (result == CAU_OK) result = render_file(&one);
    for (size_t i = 0; i < NAMES; i++) free(made[i]);
    return result;
}

/* A frame whose scene is missing or broken is told and the others are rendered; a full disk or an interrupt
 * ends the run. */
static cau_result render_frames(const RenderArguments *a) {
    cau_result worst = CAU_OK;
    for (int frame = a->first; frame <= a->last; frame += a->step) {
        cau_result result = render_frame(a, frame);
        if (result == CAU_OK) continue;
        if (result == CAU_ERROR_CANCELLED || result == CAU_ERROR_RESOURCE) return result;
        worst = result;
        fprintf(stderr, "caustic-render: frame %d failed\n", frame);
    }
    return worst;
}

int main(int argc, char **argv) {
    RenderArguments arguments;
    int code = render_arguments_parse(argc, argv, &arguments);
    if (code >= 0) return code;
    if (arguments.frames) return cau_exit_code(render_frames(&arguments));
    cau_result result = check_output(&arguments);
    if (result == CAU_OK) result = render_file(&arguments);
    return cau_exit_code(result);
}
