/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Rendering a scene's caustics, in memory.
 *
 *  cau_render_create() takes a scene, cau_render_start() begins in a thread of its own, cau_render_poll()
 * reads the progress, cau_render_cancel() asks it to stop, cau_render_wait() joins it; callbacks run on the
 * thread that waits, never on another. The layers can be read when it has ended, cancelled or not.
 *
 *  Same scene, options and seed give the same bytes on any number of threads. */
#ifndef CAUSTICS_RENDER_H
#define CAUSTICS_RENDER_H

#include "caustics/layers.h"
#include "caustics/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cau_render cau_render;

enum { CAU_ESTIMATOR_AUTO = 0, CAU_ESTIMATOR_P = 1, CAU_ESTIMATOR_R = 2, CAU_ESTIMATOR_W = 3 };
/** Which layers are wanted (a bit mask). */
enum {
    CAU_WANT_RADIANCE = 1,   /**< direct caustics, always there */
    CAU_WANT_INDIRECT = 2,   /**< indirect caustics: force them */
    CAU_WANT_IRRADIANCE = 4, /**< _E at receivers the camera hits first, and _S of what is seen otherwise */
    CAU_WANT_ERROR = 8,      /**< standard error per pixel */
    CAU_WANT_BEAUTY = 16,    /**< estimator R only: what Cycles renders with caustics off */
    CAU_WANT_BIAS = 32       /**< size of the bias per pixel, of P's kernels and W's triangles */
};
enum { CAU_SHARDS_MAX = 65536 };
enum { CAU_INDIRECT_AUTO = 0, CAU_INDIRECT_ON = 1, CAU_INDIRECT_OFF = 2 };

typedef struct cau_render_options {
    size_t size;      /**< sizeof(cau_render_options) */
    uint64_t photons; /**< per light; 0: no limit by photons. Alone they settle the passes before the first;
                         beside time or error they are the most. Estimator R: camera paths of the picture */
    double time_s;    /**< wall seconds; 0: no limit. It ends within half a pass of them */
    double error;     /**< RMSE over RMS of the layers' pixels, total over lights; 0: no limit */
    uint64_t seed;
    unsigned threads;  /**< 0: one per processor */
    int width, height; /**< 0: as in the scene */
    int region[4];     /**< x0, y0, x1, y1 in pixels, exclusive ends; all 0: the whole picture */
    int estimator;     /**< CAU_ESTIMATOR_*; W: wavefronts wherever they can be had; auto: where they pay */
    unsigned layers;   /**< CAU_WANT_* */
    int indirect;      /**< CAU_INDIRECT_* */
    int physical_radiance; /**< 1: radiance scales with n^2 at interfaces as in nature; 0: as Cycles does */
    size_t memory_bytes;   /**< budget; 0: 2 GiB */
    unsigned shard_index, shard_count; /**< render share 1 .. count of the photons, at most CAU_SHARDS_MAX and
                                          as many as there are passes; both 0: the whole */
} cau_render_options;

/** Defaults: 4 million photons per light, automatic everything. */
CAU_API cau_render_options cau_render_defaults(void);

typedef struct cau_progress {
    uint64_t passes, photons_per_light; /**< of the picture: a render that is not limited by photons may begin
                                           anew with larger passes */
    double error; /**< so far, as in cau_render_options.error; negative: not yet known */
    double elapsed_s;
    double remaining_s; /**< forecast; negative: not known */
    const char *stage;  /**< "probing", "rendering", "done" */
} cau_progress;

/** Normalises the scene and builds the ray tracing tree. The scene must outlive the render and stay
 * unchanged. */
CAU_API cau_result cau_render_create(cau_scene *scene, const cau_render_options *options, cau_render **out);
CAU_API void cau_render_destroy(cau_render **render);

/** Probes the scene and makes the plan, without rendering. Implied by start. */
CAU_API cau_result cau_render_plan(cau_render *render);
/** The plan in words, one sentence a line. Valid as long as the render. */
CAU_API const char *cau_render_explain(const cau_render *render);

CAU_API cau_result cau_render_start(cau_render *render);
CAU_API cau_progress cau_render_poll(cau_render *render);
/** Asks the render to stop soon (within half a second). May be called from a signal handler or any thread. */
CAU_API void cau_render_cancel(cau_render *render);
/** Waits for the end, calling `report` on this thread every `interval_s` seconds. Returns CAU_OK or
 *  CAU_ERROR_CANCELLED (layers hold the finished passes) or an error. */
CAU_API cau_result cau_render_wait(cau_render *render, double interval_s,
    void (*report)(void *data, const cau_progress *progress), void *data);

/** 64-bit hash of all that settles what a render gives: scene, options (all but the threads), version,
 * compiler. */
CAU_API uint64_t cau_render_stamp(const cau_render *render);

/** Takes `size` bytes of a state; 0: taken, else the saving fails. */
typedef int (*cau_state_write)(void *data, const void *bytes, size_t size);
/** Gives the next `size` bytes of a state, all of them; 0: given, else the state is taken as cut off. */
typedef int (*cau_state_read)(void *data, void *bytes, size_t size);

/** Gives the state of a render to `write`: all that cau_render_load() needs to go on to the same bytes as an
 *  uninterrupted render. While the render runs, it waits for the end of a pass, which goes on when the state
 * is written; so call it from the thread that waits. `write` runs on the calling thread. A render that was
 * stopped while it probed has no state yet: CAU_ERROR_CANCELLED. The state is a function of scene, options
 * and passes, in the byte order of this machine. */
CAU_API cau_result cau_render_save(cau_render *render, cau_state_write write, void *data);

/** Before cau_render_start(): goes on from a state of the same scene, photons, seed, shard and whatever else
 *  settles the bytes; limits of time and error, photons beside these, and threads may differ. `name` says in
 * messages where the state comes from. What differs is CAU_ERROR_INPUT and named with both values; damage is
 * CAU_ERROR_INPUT. After an error the render can only be destroyed. */
CAU_API cau_result cau_render_load(cau_render *render, const char *name, cau_state_read read, void *data);

/** Adds the state of a finished shard to a render that is none itself. When all have been added, in any
 * order, cau_render_start() has nothing left to do, and the layers are those of one render of the whole;
 * shards that are missing are an error of cau_render_wait(). Otherwise as cau_render_load(). */
CAU_API cau_result cau_render_join(cau_render *render, const char *name, cau_state_read read, void *data);

CAU_API void cau_render_size(const cau_render *render, int *width, int *height);
/** The rendered region: x0, y0, x1, y1 in pixels, exclusive ends. */
CAU_API void cau_render_region(const cau_render *render, int out[4]);

/** The kinds of the extra layers that CAU_WANT_BEAUTY asks for; they are not part of any caustics file. */
enum { CAU_LAYER_BEAUTY = 100, CAU_LAYER_BEAUTY_ERROR = 101 };

/** One layer of the result. */
typedef struct cau_layer {
    const char *light; /**< the light's or group's name as in the scene */
    int kind;          /**< a cau_layer_kind, or CAU_LAYER_BEAUTY... */
    int indirect;      /**< 1: belongs to the indirect layer (its error) */
} cau_layer;
CAU_API size_t cau_render_layer_count(const cau_render *render);
CAU_API cau_layer cau_render_layer(const cau_render *render, size_t index);
/** Copies width * height * 3 floats, row by row from the top. */
CAU_API cau_result cau_render_pixels(const cau_render *render, size_t index, float *out);

/** Where one light's flux went, in watts (W; world and sun: as far as it was aimed at the targets). */
typedef struct cau_flux {
    double emitted, landed, straight, absorbed, escaped, cut, dropped;
    double bent; /**< handed over to photons that start at bent normals, see direct_bent */
    uint64_t photons, rays, deposits, non_finite;
} cau_flux;

/** What one layer group's figures are. */
typedef struct cau_light_report {
    const char *light;
    double relative_error_direct,
        relative_error_indirect; /**< noise and bias, RMS over RMS; < 0: not rendered; 1: nothing found */
    double mean_direct, mean_indirect;   /**< mean of the pixels' channels */
    cau_flux direct, indirect;           /**< of photons that start at the lamp */
    cau_flux direct_bent, indirect_bent; /**< of those that start where Cycles bends a normal; 0: none do */
    double bias_direct, bias_indirect;   /**< the bias in the relative error; < 0: not rendered */
    const char *estimator_direct; /**< of smooth paths in the direct layer, at the end: "W", "P" or "R"; "":
                                     not rendered. The plan says what it was at first. */
} cau_light_report;
CAU_API size_t cau_render_light_count(const cau_render *render);
CAU_API cau_light_report cau_render_light(const cau_render *render, size_t index);
/** Root mean square error (noise and bias) over root mean square of the sum of all
 *  layers; < 0: not known. */
CAU_API double cau_render_error(const cau_render *render);
/** Warnings about the scene, one sentence each; NULL past the last. */
CAU_API const char *cau_render_warning(const cau_render *render, size_t index);
/** 64-bit hash of the scene's content. */
CAU_API uint64_t cau_scene_hash(const cau_scene *scene);

#ifdef __cplusplus
}
#endif
#endif
