/* SPDX-License-Identifier: Apache-2.0 */
/* caustic-merge: a thin front of include/caustics/composite.h. */
#include "composite/cli/arguments.h"
#include "core/frames.h"
#include "core/nearest.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void print_line(void *user, const char *text) {
    (void)user;
    puts(text);
}

static void print_notice(void *user, const char *text) {
    const Arguments *a = user;
    if (!a->quiet) fprintf(stderr, "caustic-merge: note: %s\n", text);
}

/* The signals are blocked, so nothing is ever interrupted half-way; whether one came is asked between bands.
 */
static int signal_came(void *user) {
    (void)user;
    sigset_t pending;
    return sigpending(&pending) == 0 &&
           (sigismember(&pending, SIGINT) == 1 || sigismember(&pending, SIGTERM) == 1);
}

static void block_signals(void) {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    sigprocmask(SIG_BLOCK, &set, NULL);
    signal(SIGXFSZ, SIG_IGN); /* a file size limit is then an error of write(), like a full disk */
}

static void leave(int number) {
    static const char text[] = "caustic-merge: stopped on request\n";
    (void)number;
    _exit(write(STDERR_FILENO, text, sizeof text - 1) < 0 ? 4 : 3);
}

/* For commands that write nothing, and so may stop anywhere. */
static void unblock_signals(void) {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    signal(SIGINT, leave);
    signal(SIGTERM, leave);
    sigprocmask(SIG_UNBLOCK, &set, NULL);
}

static cau_result say(cau_result result, const char *text) {
    if (result != CAU_OK) fprintf(stderr, "caustic-merge: %s\n", text);
    return result;
}

static cau_result usage(const char *text) { return say(CAU_ERROR_USAGE, text); }

static cau_result add_one(cau_merge *merge, Arguments *a) {
    cau_result result = say(cau_merge_add(merge, &a->options), cau_merge_error(merge));
    if (result == CAU_OK && !a->quiet) printf("wrote %s\n", a->options.output);
    return result;
}

static void print_frame(void *user, int frame, const char *output, cau_result result, const char *sentence) {
    const Arguments *a = user;
    if (result != CAU_OK)
        fprintf(stderr, "caustic-merge: frame %d was not done: %s\n", frame, sentence);
    else if (!a->quiet)
        printf("%s %s\n", strcmp(sentence, "done") == 0 ? "wrote" : sentence, output);
}

static cau_result add_frames(cau_merge *merge, Arguments *a) {
    CauError err = {0};
    cau_merge_frames frames = {
        .size = sizeof frames, .report = a->report, .resume = a->resume, .frame = print_frame};
    if (frames_parse(a->frames, &frames.first, &frames.last, &frames.step, &err) != CAU_OK)
        return usage(err.text);
    return say(cau_merge_add_frames(merge, &a->options, &frames), cau_merge_error(merge));
}

static cau_result run_add(cau_merge *merge, Arguments *a) {
    if (a->file_count != 2)
        return usage("add needs two files, the beauty and the caustics: see caustic-merge --help");
    if (!a->output) return usage("add needs an output: -o OUT.exr");
    a->options.beauty = a->files[0];
    a->options.caustics = a->files[1];
    a->options.output = a->output;
    if (a->frames) return add_frames(merge, a);
    if (a->report || a->resume) return usage("--report and --resume need --frames");
    return add_one(merge, a);
}

static cau_result run_preview(cau_merge *merge, Arguments *a) {
    if (a->file_count != 1) return usage("preview needs one file: see caustic-merge --help");
    if (!a->output) return usage("preview needs an output: -o OUT.png");
    a->options.beauty = a->files[0];
    a->options.preview = a->output;
    return say(cau_merge_preview(merge, &a->options), cau_merge_error(merge));
}

static cau_result run_files(cau_merge *merge, Arguments *a,
    cau_result (*call)(cau_merge *, const char *, void (*)(void *, const char *), void *)) {
    if (a->any_option || a->output || (a->json && call == cau_merge_check))
        return usage("list and check take files and --quiet only, list --json too");
    if (a->file_count < 1) return usage("name at least one file: see caustic-merge --help");
    cau_result worst = CAU_OK;
    unblock_signals();
    for (size_t i = 0; i < a->file_count; i++) {
        if (a->file_count > 1 && call == cau_merge_list) printf("%s:\n", a->files[i]);
        cau_result result = call(merge, a->files[i], a->quiet ? NULL : print_line, NULL);
        fflush(stdout);
        say(result, cau_merge_error(merge));
        if (result != CAU_OK) worst = result;
    }
    return worst;
}

static void print_text(void *user, const char *text) {
    (void)user;
    fputs(text, stdout);
}

static cau_result run_script(cau_merge *merge, Arguments *a) {
    if (a->file_count != 1)
        return usage(
            "nuke and blender need one file, an output of add or caustics: see caustic-merge --help");
    CauError err = {0};
    int frames[2], step;
    if (a->frames && frames_parse(a->frames, &frames[0], &frames[1], &step, &err) != CAU_OK)
        return usage(err.text);
    if (a->frames && step != 1) return usage("nuke and blender need every frame: --frames A-B");
    a->options.beauty = a->files[0];
    a->options.output = a->output;
    cau_merge_host host = strcmp(a->command, "nuke") == 0 ? CAU_MERGE_NUKE : CAU_MERGE_BLENDER;
    return say(cau_merge_script(merge, host, &a->options, a->frames ? frames : NULL, print_text, NULL),
        cau_merge_error(merge));
}

static cau_result run_recipe(cau_merge *merge, Arguments *a) {
    const char *files[] = {a->from_nuke, a->from_blender, a->options.recipe};
    int given = 0, which = 0;
    for (int i = 0; i < 3; i++) {
        if (!files[i]) continue;
        which = i;
        given++;
    }
    if (given != 1 || a->file_count || a->light_count)
        return usage(
            "recipe needs one of --from-nuke FILE, --from-blender FILE, --recipe FILE, and no more files");
    return say(cau_merge_recipe(
                   merge, (cau_merge_source)which, files[which], a->output, a->to_scene, print_text, NULL),
        cau_merge_error(merge));
}

static cau_result run_diff(cau_merge *merge, Arguments *a) {
    if (a->any_option || a->output || a->file_count != 2)
        return usage("diff takes two files: see caustic-merge --help");
    unblock_signals();
    cau_result result = cau_merge_diff(merge, a->files[0], a->files[1], a->quiet ? NULL : print_line, NULL);
    fflush(stdout);
    return say(result, cau_merge_error(merge));
}

static cau_result run_shards(cau_merge *merge, Arguments *a) {
    if (!a->output) return usage("shards needs an output: -o OUT.exr");
    a->options.output = a->output;
    cau_result result =
        say(cau_merge_shards(merge, a->files, a->file_count, &a->options), cau_merge_error(merge));
    if (result == CAU_OK && !a->quiet) printf("wrote %s\n", a->output);
    return result;
}

static cau_result run_command(cau_merge *merge, Arguments *a) {
    static const char *const commands[] = {
        "add", "preview", "list", "check", "diff", "shards", "nuke", "blender", "recipe"};
    enum { COMMANDS = sizeof commands / sizeof *commands };
    if (strcmp(a->command, "add") == 0) return run_add(merge, a);
    if (strcmp(a->command, "preview") == 0) return run_preview(merge, a);
    if (strcmp(a->command, "list") == 0)
        return run_files(merge, a, a->json ? cau_merge_list_json : cau_merge_list);
    if (strcmp(a->command, "check") == 0) return run_files(merge, a, cau_merge_check);
    if (strcmp(a->command, "nuke") == 0 || strcmp(a->command, "blender") == 0) return run_script(merge, a);
    if (strcmp(a->command, "recipe") == 0) return run_recipe(merge, a);
    if (strcmp(a->command, "shards") == 0) return run_shards(merge, a);
    if (strcmp(a->command, "diff") == 0) return run_diff(merge, a);
    fprintf(stderr, "caustic-merge: unknown command \"%s\"; did you mean %s? See caustic-merge --help\n",
        a->command, commands[nearest_name(a->command, commands, COMMANDS)]);
    return CAU_ERROR_USAGE;
}

static cau_result run(Arguments *a) {
    if (a->help) return fputs(arguments_help(), stdout) < 0 ? CAU_ERROR_RESOURCE : CAU_OK;
    if (a->version) return puts("caustic-merge " CAUSTICS_VERSION) < 0 ? CAU_ERROR_RESOURCE : CAU_OK;
    if (!a->command) {
        fputs(arguments_help(), stderr);
        return CAU_ERROR_USAGE;
    }
    cau_merge *merge = NULL;
    if (cau_merge_create(&merge) != CAU_OK) return say(CAU_ERROR_RESOURCE, "out of memory");
    a->options.notice = print_notice;
    a->options.cancelled = signal_came;
    a->options.user = a;
    cau_result result = run_command(merge, a);
    cau_merge_destroy(&merge);
    return result;
}

int main(int argc, char **argv) {
    block_signals();
    Arguments arguments;
    CauError err = {0};
    cau_result result = arguments_parse(&arguments, argc, argv, &err);
    if (result == CAU_OK)
        result = run(&arguments);
    else
        say(result, err.text);
    arguments_free(&arguments);
    if (fflush(stdout) != 0 && result == CAU_OK) {
        fprintf(stderr, "caustic-merge: cannot write to standard output: %s\n", strerror(errno));
        result = CAU_ERROR_RESOURCE;
    }
    return cau_exit_code(result);
}
