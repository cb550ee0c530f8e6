/* SPDX-License-Identifier: Apache-2.0 */
/* How fast photons fly, measured against bare Embree on the same rays, and where a pass spends its time.
 *
 *   throughput SCENE.json [PASSES]
 *
 * Runs the real passes on one thread. The linker hands the calls of their stages to the wrappers below
 * (--wrap), which read the CPU clock around the true function. The first photon run of each light and layer
 * is repeated with its rays written down, and the rays are sent through trace_nearest() alone, and through
 * rtcIntersect1() alone: which, in a scene with exact shapes, calls our intersection of them.
 */
#include "render/trace/embree.c"

#include "caustics/scene_file.h"
#include "core/checked.h"
#include "render/render_internal.h"

#include <stdio.h>
#include <time.h>

enum { REPEATS = 5, RUNS_MAX = 64 };

static double cpu_s(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- the clock of the stages ---- */

enum { EYE, PHOTONS, TREE, GATHER, FILM, STAGES };
static const char *const stage_names[STAGES] = {"eye paths", "photons", "tree", "gather", "film"};
static double stage_s[STAGES][2]; /* [stage][indirect]; of eye paths [0] holds both */
static double bench_s;            /* spent on the measurements themselves */
static int kind_now;
static bool clock_runs; /* the clock stands while the plan is made */

static void stop(int stage, int kind, double start) {
    if (clock_runs) stage_s[stage][kind] += cpu_s() - start;
}

/* ---- rays of a run ---- */

static Ray *rays;
static size_t ray_count, ray_capacity;
static bool recording;

bool __wrap_trace_nearest(const TraceScene *scene, const Ray *ray, Hit *hit);
bool __wrap_trace_nearest(const TraceScene *scene, const Ray *ray, Hit *hit) {
    if (recording) {
        if (!array_reserve((void **)&rays, &ray_capacity, ray_count + 1, sizeof *rays)) exit(4);
        rays[ray_count++] = *ray;
    }
    return trace_nearest(scene, ray, hit);
}

/* The least of a few repeats: other programs can only add. */
static double bare_embree_s(const TraceScene *scene) {
    struct RTCRayHit *ready = array_new(ray_count, sizeof *ready);
    if (!ready) exit(4);
    double best = INFINITY;
    for (int repeat = 0; repeat < REPEATS; repeat++) {
        for (size_t i = 0; i < ray_count; i++) {
            ready[i].ray = rtc_ray(&rays[i]);
            ready[i].hit.geomID = ready[i].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        }
        double start = cpu_s();
        for (size_t i = 0; i < ray_count; i++) {
            ExactQuery q;
            query_init(&q, scene, &rays[i]);
            rtc_intersect(scene->rtc, &q, &ready[i]);
        }
        best = fmin(best, cpu_s() - start);
    }
    free(ready);
    return best;
}

static double nearest_s(const TraceScene *scene) {
    double best = INFINITY;
    for (int repeat = 0; repeat < REPEATS; repeat++) {
        double start = cpu_s();
        for (size_t i = 0; i < ray_count; i++) {
            Hit hit;
            trace_nearest(scene, &rays[i], &hit);
        }
        best = fmin(best, cpu_s() - start);
    }
    return best;
}

/* ---- wrappers ---- */

cau_result __real_photons_trace(const PhotonRun *, TaskPool *, DepositList *, FluxAccount *, CauError *);
cau_result __wrap_photons_trace(const PhotonRun *, TaskPool *, DepositList *, FluxAccount *, CauError *);
cau_result __real_eye_trace(const EyeRun *, TaskPool *, EyePoints *, CauError *);
cau_result __wrap_eye_trace(const EyeRun *, TaskPool *, EyePoints *, CauError *);
cau_result __real_photon_tree_build(PhotonTree *, const Deposit *, size_t, CauError *);
cau_result __wrap_photon_tree_build(PhotonTree *, const Deposit *, size_t, CauError *);
cau_result __real_gather_photons(
    const GatherRun *, SupportRows *, const PhotonTree *, TaskPool *, const PassImages *, CauError *);
cau_result __wrap_gather_photons(
    const GatherRun *, SupportRows *, const PhotonTree *, TaskPool *, const PassImages *, CauError *);
void __real_film_add(Film *, const double *);
void __wrap_film_add(Film *, const double *);

static void measure_run(const PhotonRun *run, TaskPool *pool) {
    DepositList deposits = {0};
    FluxAccount account = {0};
    CauError error = {0};
    double photons = INFINITY;
    for (int repeat = 0; repeat < REPEATS; repeat++) {
        double start = cpu_s();
        if (__real_photons_trace(run, pool, &deposits, &account, &error) != CAU_OK) exit(1);
        photons = fmin(photons, cpu_s() - start);
    }
    ray_count = 0;
    recording = true;
    if (__real_photons_trace(run, pool, &deposits, &account, &error) != CAU_OK) exit(1);
    recording = false;
    deposits_free(&deposits);
    double bare = bare_embree_s(run->trace), nearest_alone = nearest_s(run->trace), n = (double)ray_count;
    printf("| %s, %s | %.2f | %.2f | %.2f | %.2f | %.2f | %.0f %% |\n", run->light->name,
        run->owner == OWNER_DIRECT ? "direct" : "indirect", run->photons / photons * 1e-6, n / run->photons,
        n / photons * 1e-6, n / nearest_alone * 1e-6, n / bare * 1e-6, 100 * bare / photons);
}

/* The first time that this light's run of this kind is met. */
static bool is_new(const PhotonRun *run) {
    static struct {
        const Light *light;
        PathOwner owner;
    } met[RUNS_MAX];
    static size_t count;
    for (size_t i = 0; i < count; i++)
        if (met[i].light == run->light && met[i].owner == run->owner) return false;
    if (count == RUNS_MAX) return false;
    met[count].light = run->light;
    met[count++].owner = run->owner;
    return true;
}

cau_result __wrap_photons_trace(
    const PhotonRun *run, TaskPool *pool, DepositList *out, FluxAccount *account, CauError *err) {
    kind_now = run->owner == OWNER_INDIRECT;
    double start = cpu_s();
    cau_result result = __real_photons_trace(run, pool, out, account, err);
    stop(PHOTONS, kind_now, start);
    if (!clock_runs || !is_new(run)) return result;
    start = cpu_s();
    measure_run(run, pool);
    bench_s += cpu_s() - start;
    return result;
}

cau_result __wrap_eye_trace(const EyeRun *run, TaskPool *pool, EyePoints *out, CauError *err) {
    kind_now = 0; /* the direct layers come first */
    double start = cpu_s();
    cau_result result = __real_eye_trace(run, pool, out, err);
    stop(EYE, 0, start);
    return result;
}

cau_result __wrap_photon_tree_build(PhotonTree *tree, const Deposit *items, size_t count, CauError *err) {
    double start = cpu_s();
    cau_result result = __real_photon_tree_build(tree, items, count, err);
    stop(TREE, kind_now, start);
    return result;
}

cau_result __wrap_gather_photons(const GatherRun *run, SupportRows *supports, const PhotonTree *tree,
    TaskPool *pool, const PassImages *out, CauError *err) {
    double start = cpu_s();
    cau_result result = __real_gather_photons(run, supports, tree, pool, out, err);
    stop(GATHER, kind_now, start);
    return result;
}

void __wrap_film_add(Film *film, const double *image) {
    double start = cpu_s();
    __real_film_add(film, image);
    stop(FILM, kind_now, start);
}

/* ---- the render ---- */

static int fail(cau_context *context) {
    fprintf(stderr, "throughput: %s\n", context ? cau_error_text(context) : "out of memory");
    return 1;
}

static void show_stages(uint64_t passes, double total) {
    double known = 0;
    printf("\n| stage | direct ms | indirect ms | share |\n|---|---|---|---|\n");
    for (int k = 0; k < STAGES; k++) {
        double sum = stage_s[k][0] + stage_s[k][1];
        known += sum;
        printf("| %s | %.1f | ", stage_names[k], 1e3 * stage_s[k][0] / (double)passes);
        if (k == EYE)
            printf("both");
        else
            printf("%.1f", 1e3 * stage_s[k][1] / (double)passes);
        printf(" | %.1f %% |\n", 100 * sum / total);
    }
    printf("| rest | %.1f | both | %.1f %% |\n", 1e3 * (total - known) / (double)passes,
        100 * (total - known) / total);
    printf("| a pass | %.1f | both | 100 %% |\n", 1e3 * total / (double)passes);
}

int main(int argc, char **argv) {
    if (argc < 2 || argc > 3) return fprintf(stderr, "usage: throughput SCENE.json [PASSES]\n"), 2;
    uint64_t passes = argc > 2 ? strtoull(argv[2], NULL, 10) : 8;
    cau_context *context = NULL;
    cau_scene *scene = NULL;
    cau_render *render = NULL;
    cau_render_options options = cau_render_defaults();
    options.threads = 1;
    options.photons = 131072 * passes;
    if (cau_context_create(&context) != CAU_OK || cau_scene_load_file(context, argv[1], &scene) != CAU_OK ||
        cau_render_create(scene, &options, &render) != CAU_OK || cau_render_plan(render) != CAU_OK)
        return fail(context);
    printf("| run | Mphotons/s | rays each | Mrays/s | by trace_nearest() alone | by rtcIntersect1() alone | "
           "share |\n"
           "|---|---|---|---|---|---|---|\n");
    clock_runs = true;
    double start = cpu_s();
    if (cau_render_start(render) != CAU_OK || cau_render_wait(render, 1, NULL, NULL) != CAU_OK)
        return fail(context);
    show_stages(render->passes, cpu_s() - start - bench_s);
    cau_render_destroy(&render);
    cau_scene_destroy(&scene);
    cau_context_destroy(&context);
    free(rays);
    return 0;
}
