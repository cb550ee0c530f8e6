/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The state of a render, shared by render.c (API and thread), render_passes.c, render_kernels.c,
 *  render_waves.c and render_probe.c. Only these carry a value from one pass to the next. */
#ifndef RENDER_RENDER_INTERNAL_H
#define RENDER_RENDER_INTERNAL_H

#include "caustics/render.h"
#include "render/analyse/plan.h"
#include "render/emit/emit.h"
#include "render/film/bandwidth.h"
#include "render/film/film.h"
#include "render/gather/reference.h"
#include "render/gather/wave/wave.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

/** Pictures of so many pixels are large: they know as much from fewer passes, and from a part of the pixels.
 */
#define RENDER_LARGE_PIXELS 65536.0
/** Photons that start at bent normals per photon of a lamp. */
#define RENDER_BENT_SHARE 0.25
/** An eye path of a wavefront's layer costs as much as this many of its rays. */
#define RENDER_RAYS_PER_LOOK 4.0

/** What the passes before the present, larger ones told; part of a render's state. */
typedef struct PastRound {
    double growth; /**< of the passes' size after them; 0: there were none */
    double error;  /**< of all layers */
} PastRound;

/** What a render to an error stated after so many passes of the present size: the last looks, in a ring; part
 * of its state, for they settle when it ends. */
typedef struct PastError {
    double passes, error;
} PastError;
enum { PAST_ERRORS = 32 };
typedef struct PastErrors {
    PastError items[PAST_ERRORS];
    double next; /**< a whole number */
} PastErrors;

/** What an error is made of. */
typedef enum ErrorPart { ERROR_WAVES, ERROR_PHOTONS, ERROR_PATHS, ERROR_PARTS } ErrorPart;
typedef struct ErrorParts {
    double total; /**< relative to the RMS; negative: not known */
    double noise[ERROR_PARTS],
        bias[ERROR_PARTS]; /**< sums of squares over the picture, of the layers drawn by each;
                              left-over photons of wavefronts count as these */
    double
        values; /**< that make the noise: the sum of their squares, squared, over the sum of these squared */
} ErrorParts;

/** Which estimator is the quicker one, by what rounds tell: render_race.c. All of it is part of a render's
 * state. */
typedef struct RaceTry {
    double switched;   /**< 1: its lights have the estimator that the plan did not choose */
    double cost_mrays; /**< of a pass of the plan's choice, millions of rays */
    double passes;     /**< that it had */
    double growth;     /**< of these, at most */
    ErrorParts error;  /**< that they reached; 0 in all: not known */
} RaceTry;
typedef struct Race {
    double stage;   /**< 0: the plan's choice; 1: the other estimator is tried; 2: decided */
    double scale;   /**< of the passes that the plan's choice was to have next */
    double mrays;   /**< that the trial was thought to take, millions */
    PastRound past; /**< of the plan's choice */
} Race;

/** One layer group: the lights that share a layer name. */
typedef struct RenderGroup {
    const char *name;
    bool direct, indirect;                    /**< rendered? */
    Film films[2];                            /**< [0] direct, [1] indirect; radiance */
    Film seen[1], irradiance[1], coverage[1]; /**< direct only, when asked for */
    double radius_scale[2];                   /**< mean radius that was learned; 0: not yet */
    Bandwidth kernels[2];                     /**< of estimator P's; what they say about their bias */
    uint8_t *looks; /**< [pixel] eye paths that a direct layer of estimator W wants; NULL: not known */
    FluxAccount accounts[2],
        bent[2];              /**< sums over passes, see photons.h; photons of lamps, of bent normals */
    FluxAccount wave_account; /**< of estimator W */
    uint64_t eye_points[2];   /**< at which layers were gathered: sums over passes */
    double share[2]; /**< photons of the indirect layer's passes over the direct one's, of which one has
                        photons_per_pass, the other fewer; 0: not known, as many. [1] in rounds to come. Part
                        of a render's state */
    RaceTry race;
} RenderGroup;

/** Every film of a group; those that it does not have are empty. A further film is a further line. */
enum { GROUP_FILMS = 8 };
static inline void group_films(RenderGroup *g, Film *out[GROUP_FILMS]) {
    Film *const all[GROUP_FILMS] = {&g->films[0], &g->films[1], g->seen, g->irradiance, g->coverage,
        &g->kernels[0].bias, &g->kernels[1].bias, &g->kernels[0].waves};
    memcpy(out, all, sizeof all);
}

static inline void group_accounts_clear(RenderGroup *g) {
    memset(g->accounts, 0, sizeof g->accounts);
    memset(g->bent, 0, sizeof g->bent);
    memset(&g->wave_account, 0, sizeof g->wave_account);
    memset(g->eye_points, 0, sizeof g->eye_points);
}

struct cau_render {
    cau_scene *source;
    cau_render_options options;
    CauError error;
    Scene scene;
    TraceScene *trace;
    TaskPool *pool;
    PixelFilter filter;
    Aim casters, surfaces;
    BentSet bent;
    BentGuide *guides; /**< [light] where bent mirrors show it; NULL: no mirror bends */
    Plan plan;
    bool planned;
    int region[4];
    RenderGroup *groups;
    size_t group_count;
    size_t *group_of_light;
    Film beauty;
    uint64_t passes_wanted; /**< of all shards; 0: no limit */
    uint64_t passes_share;  /**< of them ours, see options.shard_index */
    uint64_t pass;          /**< the number of the pass at hand among those of all shards */
    bool *joined;           /**< [shard] its state has been added; NULL: none was */
    unsigned joined_count;
    WaveView *view; /**< NULL: estimator W is not called for */
    bool *waved;    /**< [object] its smooth paths are estimator W's */
    uint32_t photons_per_pass;
    uint32_t photons_held;          /**< of a pass, at most: what they leave is held in memory */
    uint32_t pass_least, pass_most; /**< photons of a pass in a render that is limited by error or time */
    Race race;
    PastRound past;
    PastErrors stated;
    double pass_scale; /**< its passes have so many times as many as pass_least; 0: not known yet, or no such
                          render */
    uint64_t passes;   /**< that the films hold; of a stopped render some films may hold one more */
    atomic_bool cancel;
    pthread_t thread;
    bool running;
    pthread_mutex_t mutex;
    pthread_cond_t ended;
    bool has_ended;
    bool pause_wanted, paused; /**< between two passes, while another thread saves the state */
    cau_result result;
    cau_progress progress;
    double started_s;
};

/** Channels of all pixels, within the region or not. */
static inline size_t picture_values(const cau_render *r) {
    return 3 * (size_t)r->scene.camera.width * (size_t)r->scene.camera.height;
}

/** Caustic layers are wanted, not the beauty alone. */
static inline bool render_wants_caustics(const cau_render *r) {
    return !(r->options.layers & CAU_WANT_BEAUTY) || (r->options.layers & CAU_WANT_RADIANCE);
}

/** Limited by error or time, and at most by photons: its passes grow in rounds. Otherwise they are known
 * before the first. */
static inline bool render_has_rounds(const cau_render *r) {
    const cau_render_options *o = &r->options;
    return o->estimator != CAU_ESTIMATOR_R && (o->photons == 0 || o->error > 0 || o->time_s > 0);
}

/** No photons start at lamps: estimator W and photons that start at bent normals are all that is called for.
 */
bool render_waves_alone(const cau_render *r);
/** Estimator W draws a part of the layer: its kernels begin narrow, without a trial. */
bool render_waves_draw(const cau_render *r, size_t group, int kind);

/** Sends the probes and makes r->plan. */
cau_result render_probe(cau_render *r, CauError *err);

/** Of the region. */
double render_pixel_count(const cau_render *r);

/** Photons, or rays of wavefronts, of a first pass in a render that is limited by error or time. */
double render_pass_least(const cau_render *r, bool waves);

/** Makes what the plan's estimators work with; films are empty afterwards. Again after a switch. */
cau_result render_equip(cau_render *r, CauError *err);

/** The groups' lights as r->groups[].race says, all of which have the plan's estimators so far. */
cau_result race_resume(cau_render *r, CauError *err);

/** Between two passes: lets a thread that waits in cau_render_save() write the state. */
void render_pause(cau_render *r);

/** The shards that were joined are all there are; CAU_OK without any. */
cau_result render_check_joined(const cau_render *r, CauError *err);

/** Anything to render? */
bool render_has_layers(const cau_render *r);

/** Makes what films hold of estimator P's kernels. */
cau_result render_make_kernels(cau_render *r, CauError *err);

/** Renders passes until a limit is met or it is cancelled. */
cau_result render_passes(cau_render *r, CauError *err);

/** Whether photons that start at bent normals can find a light. */
static inline bool render_bent_found(const cau_render *r, const Light *light, bool indirect) {
    return r->bent.mirrors && (!light->delta || indirect || r->bent.rough);
}

/** [0] of the present passes, [1] of rounds to come. */
static inline double render_share(const RenderGroup *g, int when) {
    return g->share[when] > 0 ? g->share[when] : 1;
}

/** Photons of a layer's pass, or rays of its wavefronts. */
static inline uint32_t render_layer_photons(const cau_render *r, size_t group, int kind) {
    double share = render_share(&r->groups[group], 0);
    return (uint32_t)fmax(fmin(kind ? share : 1 / share, 1) * r->photons_per_pass, 1);
}

/** How many of them a pass has. */
static inline uint32_t render_bent_photons(const cau_render *r, size_t light, bool indirect) {
    const LightPlan *plan = &r->plan.lights[light];
    double share = !indirect && plan->wave && !plan->photons ? plan->bent : RENDER_BENT_SHARE;
    return render_bent_found(r, &r->scene.lights[light], indirect)
               ? (uint32_t)fmin(
                     render_layer_photons(r, r->group_of_light[light], indirect) * share, r->photons_held)
               : 0;
}

/** Photons of a pass of wavefronts, at most `most`: of more, what is seen through glass and in mirrors would
 * not be looked at as often as it should (render_look.c). Needs the view. */
double look_pass_most(const cau_render *r, double most);

/** Seconds of a steady clock. */
double render_clock_s(void);

/** Error of the sum of all layers so far: RMS of its standard error over its RMS; negative: not known. */
double render_total_error(const cau_render *r);

/** The same with what it is made of; of all layers, and of one alone. */
ErrorParts render_error_parts(const cau_render *r);
ErrorParts render_layer_parts(const cau_render *r, size_t group, int kind);

/** Stores progress under the mutex. */
void render_report(cau_render *r, const char *stage, double error, double remaining_s);

#endif
