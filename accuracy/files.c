/* SPDX-License-Identifier: Apache-2.0 */
/* Files into the folder, each whole or not at all. */
#include "accuracy/picture.h"
#include "accuracy/write.h"
#include "core/file_atomic.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { PATH_MAX_LENGTH = 4096 };

static cau_result path_of(char *out, const char *folder, const char *name, CauError *err) {
    if (snprintf(out, PATH_MAX_LENGTH, "%s/%s", folder, name) < PATH_MAX_LENGTH) return CAU_OK;
    return error_set(err, CAU_ERROR_INPUT, "the folder's name is longer than %d bytes; choose a shorter one",
        PATH_MAX_LENGTH);
}

/* Ends a stream in memory and makes it the file. */
static cau_result put(
    const char *folder, const char *name, FILE *stream, char **text, const size_t *bytes, CauError *err) {
    char path[PATH_MAX_LENGTH];
    cau_result result = path_of(path, folder, name, err);
    if (fclose(stream) != 0 && result == CAU_OK)
        result = error_set(err, CAU_ERROR_RESOURCE, "out of memory for \"%s\"", path);
    if (result == CAU_OK) result = file_write_atomic(path, *text, *bytes, err);
    free(*text);
    return result;
}

/* One series' picture of a kind; `row` NULL: none. */
static cau_result write_picture(
    const char *folder, const char *kind, const Series *series, const Row *row, double gain, CauError *err) {
    char path[PATH_MAX_LENGTH], name[64];
    if (!row) return CAU_OK;
    snprintf(name, sizeof name, "%s_%s.png", kind, series->name);
    CAU_TRY(path_of(path, folder, name, err));
    return picture_write_png(path, row->shot.rgb, row->shot.width, row->shot.height, gain, err);
}

static cau_result write_pictures(const Study *study, const char *folder, CauError *err) {
    const Shot *t = &study->reference;
    double gain = picture_gain(t->rgb, t->width, t->height), time = study_common_time(study),
           error = study_common_error(study);
    char path[PATH_MAX_LENGTH];
    CAU_TRY(path_of(path, folder, "reference.png", err));
    CAU_TRY(picture_write_png(path, t->rgb, t->width, t->height, gain, err));
    for (int s = 0; s < study->count; s++) {
        const Series *series = &study->series[s];
        const Row *row = series->count ? study_row_at(series, time) : NULL;
        CAU_TRY(write_picture(folder, "equal_time", series, row, gain, err));
        row = study_row_reaching(series, error);
        CAU_TRY(write_picture(folder, "equal_error", series, row, gain, err));
    }
    return CAU_OK;
}

/* Runs gnuplot in the folder; false when there is none, or it failed. */
static bool plot(const char *folder) {
    int status;
    fflush(NULL);
    pid_t pid = fork();
    if (pid == 0) {
        int nowhere = open("/dev/null", O_RDWR);
        if (nowhere >= 0) {
            dup2(nowhere, STDOUT_FILENO);
            dup2(nowhere, STDERR_FILENO);
        }
        if (chdir(folder) == 0) execlp("gnuplot", "gnuplot", "accuracy.gp", (char *)NULL);
        _exit(127);
    }
    while (pid > 0 && waitpid(pid, &status, 0) < 0)
        if (errno != EINTR) return false;
    return pid > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

cau_result study_write_files(const Study *study, const char *folder, bool *plotted, CauError *err) {
    char *text = NULL;
    size_t bytes = 0;
    *plotted = false;
    FILE *stream = open_memstream(&text, &bytes);
    if (!stream) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the files");
    write_csv(study, stream);
    CAU_TRY(put(folder, "accuracy.csv", stream, &text, &bytes, err));
    if (!study->count || !study->series[0].count) return CAU_OK;
    CAU_TRY(write_pictures(study, folder, err));
    stream = open_memstream(&text, &bytes);
    if (!stream) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the files");
    write_plot(study, stream);
    CAU_TRY(put(folder, "accuracy.gp", stream, &text, &bytes, err));
    *plotted = plot(folder);
    stream = open_memstream(&text, &bytes);
    if (!stream) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the files");
    write_page(study, *plotted, stream);
    return put(folder, "index.html", stream, &text, &bytes, err);
}
