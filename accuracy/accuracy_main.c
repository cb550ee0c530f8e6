/* SPDX-License-Identifier: Apache-2.0 */
/* caustic-accuracy: a ladder of budgets for every estimator, against a reference. */
#include "accuracy/study.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* The one thing a signal handler can reach. */
static volatile sig_atomic_t stopped;

static void on_signal(int number) {
    (void)number;
    stopped = 1;
}

static void catch_signals(void) {
    struct sigaction action = {.sa_handler = on_signal}; /* no SA_RESTART: a wait is to end */
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

/* Minutes of rendering for a folder that cannot be would be lost: made before, not after. */
static cau_result make_folder(const char *folder, CauError *err) {
    if (!folder || ((mkdir(folder, 0777) == 0 || errno == EEXIST) && access(folder, W_OK | X_OK) == 0))
        return CAU_OK;
    return error_set(
        err, CAU_ERROR_RESOURCE, "cannot write into the folder \"%s\": %s", folder, strerror(errno));
}

/* What there is, also of a cancelled run. */
static cau_result show(const Study *study, CauError *err) {
    const Options *o = study->options;
    bool plotted = false;
    if (!study->count) return CAU_OK;
    CAU_TRY(study_write_table(study, stdout));
    if (!o->folder) return CAU_OK;
    CAU_TRY(study_write_files(study, o->folder, &plotted, err));
    if (!plotted)
        fprintf(stderr,
            "caustic-accuracy: no plots, because gnuplot was not found or failed; install "
            "gnuplot-nox and run \"gnuplot accuracy.gp\" in \"%s\"\n",
            o->folder);
    if (!o->quiet) fprintf(stderr, "wrote %s/index.html\n", o->folder);
    return CAU_OK;
}

/* A reference of ours is only worth a warning: a given one is bad input. */
static cau_result judge(const Study *study) {
    if (!study->suspicion[0]) return CAU_OK;
    fprintf(stderr, "caustic-accuracy: %s\n", study->suspicion);
    return study->options->reference ? CAU_ERROR_INPUT : CAU_OK;
}

int main(int argc, char **argv) {
    Options options;
    CauError err = {0}, late = {0};
    Study study = {0};
    int code = options_parse(argc, argv, &options);
    if (code >= 0) return code;
    cau_result result = make_folder(options.folder, &err);
    if (result == CAU_OK) {
        catch_signals();
        result = study_run(&study, &options, &stopped, &err);
    }
    if (result == CAU_OK || result == CAU_ERROR_CANCELLED) {
        cau_result shown = show(&study, &late);
        if (shown != CAU_OK) {
            result = shown;
            err = late;
        }
    }
    if (result == CAU_OK)
        result = judge(&study);
    else
        fprintf(stderr, "caustic-accuracy: %s\n", err.text[0] ? err.text : "cannot write to standard output");
    study_free(&study);
    return cau_exit_code(result);
}
