/* SPDX-License-Identifier: Apache-2.0 */
/* Cycles, through scenes/blender_scenes.py in Blender ($BLENDER or "blender"). */
#include "accuracy/picture.h"
#include "accuracy/study.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const uint64_t PLAIN_FACTOR =
    4; /* paths of the picture without caustics, over those of the largest rung */

typedef struct Request {
    const char *mode; /* "on", "off": caustics */
    uint64_t samples, seed;
} Request;

/* The child's whole life. 127: there is no Blender. */
static void become_blender(const Study *study, const Request *q, const char *out, FILE *said) {
    const Options *o = study->options;
    char samples[32], seed[32], size[32], threads[32];
    char *const arguments[] = {getenv("BLENDER") ? getenv("BLENDER") : "blender", "-b", "--factory-startup",
        "--python-exit-code", "1", "--python", (char *)o->cycles, "--", "--scene", (char *)o->scene, "--mode",
        (char *)q->mode, "--spp", samples, "--seed", seed, "--res", size, "--threads", threads, "--out",
        (char *)out, NULL};
    snprintf(samples, sizeof samples, "%" PRIu64, q->samples);
    snprintf(seed, sizeof seed, "%" PRIu64, q->seed);
    snprintf(size, sizeof size, "%dx%d", study->reference.width, study->reference.height);
    snprintf(threads, sizeof threads, "%u", o->threads);
    dup2(fileno(said), STDOUT_FILENO);
    int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
    execvp(arguments[0], arguments);
    _exit(127);
}

/* CPU seconds of the render alone, from the script's line JOB {... "user": 1.23 ...}; < 0: it said none. */
static double render_seconds(FILE *said) {
    char line[1024];
    rewind(said);
    while (fgets(line, sizeof line, said)) {
        const char *at = strncmp(line, "JOB ", 4) == 0 ? strstr(line, "\"user\":") : NULL;
        if (at) return strtod(at + 7, NULL);
    }
    return -1;
}

/* One picture by Cycles. */
static cau_result shoot(
    const Study *study, const Request *q, const volatile sig_atomic_t *stop, Shot *out, CauError *err) {
    char path[] = "/tmp/caustic-accuracy-XXXXXX";
    *out = (Shot){.photons = q->samples, .stated = -1};
    int fd = mkstemp(path);
    FILE *said = tmpfile();
    if (fd >= 0) close(fd);
    if (fd < 0 || !said)
        return error_set(err, CAU_ERROR_RESOURCE, "cannot make a temporary file: %s", strerror(errno));
    fflush(NULL);
    double began = now_s();
    pid_t pid = fork();
    if (pid == 0) become_blender(study, q, path, said);
    cau_result result =
        pid < 0 ? error_set(err, CAU_ERROR_RESOURCE, "cannot start a process: %s", strerror(errno))
                : measure_wait(pid, began, stop, "Blender", &out->cost, err);
    double alone = render_seconds(said);
    if (result == CAU_OK && alone >= 0) out->before_s = out->cost.cpu_s - alone;
    if (result == CAU_OK) result = picture_read(path, &out->width, &out->height, &out->rgb, err);
    if (result == CAU_OK &&
        (out->width != study->reference.width || out->height != study->reference.height)) {
        shot_free(out);
        result = error_set(err, CAU_ERROR_INPUT, "Blender rendered another size than was asked for");
    }
    fclose(said);
    unlink(path);
    return result;
}

static uint64_t samples_of(const Study *study, uint64_t budget) {
    uint64_t n = (uint64_t)study->reference.width * (uint64_t)study->reference.height;
    return budget < n ? 1 : (budget + n / 2) / n;
}

static cau_result run_rung(Study *study, Series *series, int rung, const Shot *plain,
    const volatile sig_atomic_t *stop, CauError *err) {
    const Options *o = study->options;
    size_t n = (size_t)plain->width * (size_t)plain->height;
    Request q = {"on", samples_of(study, o->ladder[rung]), o->seed + (uint64_t)rung + 1};
    if (series->count && series->rows[series->count - 1].shot.photons == q.samples) return CAU_OK;
    Row *row = &series->rows[series->count];
    *row = (Row){.budget = o->ladder[rung]};
    if (!o->quiet) fprintf(stderr, "Cycles, %" PRIu64 " samples per pixel\n", q.samples);
    CAU_TRY(shoot(study, &q, stop, &row->shot, err));
    for (size_t i = 0; i < 3 * n; i++) row->shot.rgb[i] -= plain->rgb[i];
    series->count++;
    return metrics_of(row->shot.rgb, study->reference.rgb, n, &row->metrics, err);
}

cau_result cycles_run(Study *study, const volatile sig_atomic_t *stop, CauError *err) {
    const Options *o = study->options;
    Request q = {"off", PLAIN_FACTOR * samples_of(study, o->ladder[o->rungs - 1]), o->seed + 1000003};
    Shot plain;
    if (!o->quiet) fprintf(stderr, "Cycles without caustics, %" PRIu64 " samples per pixel\n", q.samples);
    cau_result result = shoot(study, &q, stop, &plain, err);
    if (result == CAU_ERROR_INPUT) { /* no Blender, or a scene that it cannot show: the others still count */
        size_t used = strlen(study->left_out);
        snprintf(study->left_out + used, sizeof study->left_out - used,
            "%sCycles is left out: %.300s; is Blender installed, and \"%.100s\" scenes/blender_scenes.py?",
            used ? " " : "", err->text, o->cycles);
        error_clear(err);
        return CAU_OK;
    }
    if (result != CAU_OK) return result;
    Series *series = &study->series[study->count++];
    series->name = "Cycles";
    for (int i = 0; result == CAU_OK && i < o->rungs; i++)
        result = run_rung(study, series, i, &plain, stop, err);
    shot_free(&plain);
    return result;
}
