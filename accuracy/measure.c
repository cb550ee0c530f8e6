/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/measure.h"

#include "caustics/scene_file.h"
#include "core/checked.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* What the child says before its pixels. */
typedef struct Said {
    cau_result result;
    char error[CAU_ERROR_TEXT_MAX];
    int width, height, waved;
    uint64_t photons;
    double stated, before_s;
} Said;

double now_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double seconds(struct timeval t) { return (double)t.tv_sec + 1e-6 * (double)t.tv_usec; }

static double own_cpu_s(void) {
    struct rusage u;
    getrusage(RUSAGE_SELF, &u);
    return seconds(u.ru_utime) + seconds(u.ru_stime);
}

void shot_free(Shot *shot) {
    free(shot->rgb);
    *shot = (Shot){0};
}

cau_result measure_wait(pid_t pid, double began_s, const volatile sig_atomic_t *stop, const char *what,
    Cost *out, CauError *err) {
    struct rusage u;
    int status;
    if (*stop) kill(pid, SIGTERM); /* the signal came before there was a child */
    while (wait4(pid, &status, 0, &u) < 0) {
        if (errno != EINTR)
            return error_set(err, CAU_ERROR_RESOURCE, "cannot wait for %s: %s", what, strerror(errno));
        if (*stop) kill(pid, SIGTERM);
    }
    *out = (Cost){seconds(u.ru_utime) + seconds(u.ru_stime), now_s() - began_s, u.ru_maxrss};
    if (*stop) return error_set(err, CAU_ERROR_CANCELLED, "cancelled during %s", what);
    if (WIFSIGNALED(status))
        return error_set(err, CAU_ERROR_RESOURCE, "%s was ended by signal %d (%s)", what, WTERMSIG(status),
            strsignal(WTERMSIG(status)));
    if (WEXITSTATUS(status) != 0)
        return error_set(err, CAU_ERROR_INPUT, "%s ended with exit code %d", what, WEXITSTATUS(status));
    return CAU_OK;
}

/* Adds up the layers that belong to the picture. NULL when out of memory. */
static float *sum_layers(cau_render *render, int width, int height, cau_result *result) {
    size_t n = (size_t)width * (size_t)height * 3;
    float *sum = array_new(n, sizeof *sum), *one = array_new(n, sizeof *one);
    *result = sum && one ? CAU_OK : CAU_ERROR_RESOURCE;
    for (size_t i = 0; *result == CAU_OK && i < cau_render_layer_count(render); i++) {
        int kind = cau_render_layer(render, i).kind;
        if (kind != CAU_LAYER_RADIANCE && kind != CAU_LAYER_INDIRECT) continue;
        *result = cau_render_pixels(render, i, one);
        for (size_t k = 0; k < n; k++) sum[k] += one[k];
    }
    free(one);
    return sum;
}

static cau_result render_in_child(cau_render *render, bool plan_only, Said *said, float **rgb) {
    cau_result result = cau_render_plan(render);
    if (result != CAU_OK) return result;
    said->before_s = own_cpu_s();
    said->waved = strstr(cau_render_explain(render), "(W)") != NULL;
    if (plan_only) return CAU_OK;
    result = cau_render_start(render);
    if (result == CAU_OK) result = cau_render_wait(render, 0.1, NULL, NULL);
    if (result != CAU_OK) return result;
    cau_render_size(render, &said->width, &said->height);
    said->photons = cau_render_poll(render).photons_per_light;
    said->stated = cau_render_error(render);
    *rgb = sum_layers(render, said->width, said->height, &result);
    return result;
}

/* The child's whole life. */
static void child(const char *path, const cau_render_options *options, bool plan_only, FILE *out) {
    cau_context *context = NULL;
    cau_scene *scene = NULL;
    cau_render *render = NULL;
    float *rgb = NULL;
    Said said = {.stated = -1};
    said.result = cau_context_create(&context);
    if (said.result == CAU_OK) said.result = cau_scene_load_file(context, path, &scene);
    if (said.result == CAU_OK) said.result = cau_render_create(scene, options, &render);
    if (said.result == CAU_OK) said.result = render_in_child(render, plan_only, &said, &rgb);
    if (said.result != CAU_OK)
        snprintf(said.error, sizeof said.error, "%s", context ? cau_error_text(context) : "out of memory");
    size_t n = said.result == CAU_OK ? (size_t)said.width * (size_t)said.height * 3 : 0;
    bool ok = fwrite(&said, sizeof said, 1, out) == 1 && (n == 0 || fwrite(rgb, sizeof *rgb, n, out) == n);
    ok &= fflush(out) == 0;
    free(rgb);
    cau_render_destroy(&render);
    cau_scene_destroy(&scene);
    cau_context_destroy(&context);
    _exit(ok ? 0 : 1);
}

static cau_result hear(FILE *file, Shot *out, CauError *err) {
    static const char lost[] = "a render's result did not arrive; is the disk of the temporary folder full?";
    Said said;
    rewind(file);
    if (fread(&said, sizeof said, 1, file) != 1) return error_set(err, CAU_ERROR_RESOURCE, "%s", lost);
    if (said.result != CAU_OK) return error_set(err, said.result, "%s", said.error);
    size_t n = (size_t)said.width * (size_t)said.height * 3;
    *out = (Shot){.width = said.width,
        .height = said.height,
        .photons = said.photons,
        .stated = said.stated,
        .before_s = said.before_s,
        .waved = said.waved,
        .cost = out->cost};
    if (n == 0) return CAU_OK;
    out->rgb = array_new(n, sizeof *out->rgb);
    if (!out->rgb) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for a picture");
    if (fread(out->rgb, sizeof *out->rgb, n, file) == n) return CAU_OK;
    shot_free(out);
    return error_set(err, CAU_ERROR_RESOURCE, "%s", lost);
}

cau_result measure_render(const char *scene, const cau_render_options *options, bool plan_only,
    const volatile sig_atomic_t *stop, Shot *out, CauError *err) {
    *out = (Shot){0};
    FILE *file = tmpfile();
    if (!file) return error_set(err, CAU_ERROR_RESOURCE, "cannot make a temporary file: %s", strerror(errno));
    fflush(NULL);
    double began = now_s();
    pid_t pid = fork();
    if (pid == 0) {
        signal(SIGINT, SIG_DFL);
        signal(SIGTERM, SIG_DFL);
        child(scene, options, plan_only, file);
    }
    cau_result result =
        pid < 0 ? error_set(err, CAU_ERROR_RESOURCE, "cannot start a process: %s", strerror(errno))
                : measure_wait(pid, began, stop, "a render", &out->cost, err);
    if (result == CAU_OK) result = hear(file, out, err);
    fclose(file);
    return result;
}
