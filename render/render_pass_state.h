/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What a pass works on, shared by render_passes.c (the loop), render_kernels.c (how wide kernels are),
 *  render_look.c (eye paths of a pixel), render_waves.c (estimator W), render_limits.c (when it ends),
 *  render_forecast.c (what it has still to do), render_race.c (which estimator),
 *  render_budget.c (how many photons for a layer). */
#ifndef RENDER_RENDER_PASS_STATE_H
#define RENDER_RENDER_PASS_STATE_H

#include "render/render_internal.h"

/** What its photons make of a pass, over what it is now, when they are shared out between layers anew. */
typedef struct Budget {
    double error, cost;
} Budget;
#define BUDGET_AS_IS ((Budget){1, 1})

/* Passes of one size. */
typedef struct Round {
    double started_s, learned_s; /* learned_s: when its first pass was over */
    uint64_t before;             /* passes that it had when it was gone on with, from a state */
    uint64_t check;              /* the passes after which to ask whether it will do */
    double reported_s, left_s;   /* the last progress, and its forecast */
    double end_s;  /* when the last round thought that the render would end; 0: there was none */
    Budget budget; /* that another round would have */
} Round;

/* What a pass that checks estimator W works with; empty where there is none. */
typedef struct WaveCheck {
    double *bias;     /* [pixel] mean of the channels, of one group's lights */
    double *coarse;   /* [pixel][3] */
    DepositList rest; /* of one drawing */
} WaveCheck;

typedef struct PassState {
    cau_render *r;
    EyeRun eye;                     /* of the pass */
    EyePoints points, layer_points; /* of all layers, and of the one at hand */
    EyePoints trial_points;         /* of the first pass */
    SupportRows supports;
    KernelImages kernels;
    uint8_t *eye_paths; /* [pixel] scratch of look_closer() */
    WaveCheck waves;
    Round round;
    bool learning; /* the first pass is made for what it teaches alone */
    DepositList deposits;
    PhotonTree tree;
    PassImages images;
    ReferenceImages reference;
    double *reference_block;
    uint64_t key;
} PassState;

/** Makes what a check of estimator W works with. */
cau_result waves_prepare(PassState *s, CauError *err);
void waves_free(PassState *s);
/** Whether the pass at hand checks it. */
bool waves_check(const PassState *s);
/** Before the lights of a group. */
void waves_clear(PassState *s);
/** A light's wavefronts with coarser cells, the same whichever pass is at hand; adds the rays that a whole
 * replica would take to `rays`. */
cau_result waves_try(PassState *s, size_t light, const GatherRun *gather, const PassImages *images,
    double *rays, CauError *err);
/** One replica of a light's wavefronts, added to the images; what it leaves to photons joins the deposits,
 * but in a pass that checks: there it is gathered at once. */
cau_result waves_draw(PassState *s, size_t light, RenderGroup *group, const GatherRun *gather, CauError *err);

/** Makes what kernels say in a pass. */
cau_result kernels_prepare(PassState *s, CauError *err);
void kernels_free(PassState *s);
/** Before the lights of a group, when images are added to from the start. */
void kernels_clear(PassState *s);
/** Learns a layer's first radii on the deposits at hand, before these are gathered for the picture, and
 * readies `gather` and the supports for that. */
cau_result kernels_try(PassState *s, RenderGroup *group, int kind, GatherRun *gather, CauError *err);
/** Before the first pass of a layer of estimator W: learns how often its pixels that show glass or a mirror
 * want to be looked at. Nothing where there are none, or when it is known. */
cau_result look_learn(PassState *s, size_t group, CauError *err);
/** Lets a layer gather at more eye points where it has learned that few will not do: where kernels are
 * narrow, and where what is seen through glass or in mirrors differs. They are the layer's own, for it must
 * not depend on which others there are. */
cau_result look_closer(PassState *s, const RenderGroup *group, int kind, GatherRun *gather, CauError *err);

/** Forgets what a layer's kernels have learned. */
void kernels_restart(cau_render *r, size_t group, int kind);

/** Passes, `least` at least, after which a render would have an error that stated `e` after `passes` of them,
 * if they were `growth` times as large from the start. `e->total` is above 0. */
double forecast_passes(const ErrorParts *e, double passes, double error, double growth, double least);
/** The passes' growth, up to `most`, with which a render that starts over is done soonest; 0: it does not
 * pay. `cost` is what it has still to do either way, in passes of the present size. */
typedef struct NextRound {
    double growth, cost;
    double growth_s; /**< how many times as long its passes take */
} NextRound;
NextRound forecast_round(
    const ErrorParts *e, double passes, double error, double most, double least, Budget budget);
/** What a round's errors so far tell: the one at hand, evened by those of the last quarter of the passes, and
 * the power of what is expected of the passes with which errors have fallen. */
typedef struct Course {
    double error, speed;
} Course;
Course forecast_course(const ErrorParts *e, double passes, const PastErrors *past);

/** How many photons each layer should have in rounds to come, by what the passes tell. Returns what a pass of
 * the present size would then have of the present error and cost. */
Budget budget_look(cau_render *r);
/** Before a round: that it has them, or, in a trial of another estimator, as many for each layer. */
void budget_take(cau_render *r, bool learned);

/** How many times as large as now passes could be. */
double limits_growth_most(const cau_render *r);
/** Before the first pass of a round. */
void limits_begin(PassState *s);
/** After every pass: is the render done? Reports progress. What little is known may call for larger passes:
 * then all starts over with these. */
cau_result limits_met(PassState *s, bool *met, CauError *err);
/** After a check in a render to an error or a time, with the error of all layers so far: tries the other
 * estimators when the render has `times` as much to do in all as it did so far and wants passes `growth`
 * times as large (0: it does not), and decides after a trial. `restart`: the films are empty, the passes'
 * size is set. */
cau_result race_step(PassState *s, double error, double times, double growth, bool *restart, CauError *err);
/** Whether the passes at hand are such a trial's. */
bool race_tries(const cau_render *r);
/** Such a trial takes more than it is worth. */
bool race_overspent(const cau_render *r);
/** Before the first pass: a state that was gone on from may be all there is to do. Time is none that it took.
 */
bool limits_met_already(const PassState *s);

/** After a layer's pass: its kernels are learned for good. */
void kernels_settle(RenderGroup *group, int kind, bool tried);

#endif
