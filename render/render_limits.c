/* SPDX-License-Identifier: Apache-2.0 */
/* When a render has ended, when it will, and how large its passes are until then.
 *
 * A render of so many photons has passes of a known size. One that is to reach an error, or to take a time,
 * has rounds: passes of few photons first, so that what little does is not paid for with more; and when these
 * tell that it takes many times as much, passes that are larger, from the start. Nothing is kept of the small
 * ones but the picture until there is another: their kernels are wide, and their grids coarse. A round takes
 * several times what the last one took, so all that are left behind cost a fraction of it. */
#include "render/render_pass_state.h"

#include <stdlib.h>
#include <string.h>

/* Powers of the passes with which an error falls until the round tells better, and within which it tells:
 * wavefronts and paths have noise alone, photons bias, too. */
#define EXPONENT_NOISE 0.5
#define EXPONENT_PHOTONS 0.42
#define EXPONENT_MIN 0.3
#define EXPONENT_MAX 0.6
/* Passes that are so many times as large take that power of it as long: part of their time is eye paths. */
#define PASS_TIME_EXPONENT 0.65
/* Powers of the photons with which it falls from round to round, measured on the bundled scenes: wavefronts,
 * which get finer too, and photons, whose error is noise for the most part. */
#define ROUND_EXPONENT_WAVES 0.6
#define ROUND_EXPONENT_PHOTONS 0.45
/* Passes that a round should have, and so many times as many as there are it must take for another to begin:
 * photons learn their kernels from a pass, so few large ones have less error than many small ones. Passes are
 * so many times as large at most, for few tell little of many. */
#define ROUND_PASSES_WAVES 16.0
#define ROUND_PASSES_PHOTONS 6.0
#define ROUND_PASSES_TIMED 16.0
#define ROUND_LEAST_WAVES 4.0
#define ROUND_LEAST_PHOTONS 2.0
#define ROUND_GROWTH_MAX 16.0
#define ROUND_EXPONENT_LEAST 0.25
/* The error is looked at after every sixteenth part of the passes, and told every so many seconds. */
enum { CHECK_PART = 16 };
#define REPORT_S 0.2

/* Fewer replicas cannot tell their own spread. Of wavefronts, which have no kernels wide enough to smooth
 * what few rays bring, twice as many are wanted before an error is believed. */
enum { PASSES_TOLD = 8, PASSES_TOLD_WAVES = 16 };

static bool has_rounds(const cau_render *r) {
    return r->options.photons == 0 && r->options.estimator != CAU_ESTIMATOR_R;
}

/* The same whether the render has gone on from a state or not. */
static uint64_t next_check(uint64_t passes) {
    uint64_t check = PASSES_TOLD;
    while (check <= passes) check += 1 + check / CHECK_PART;
    return check;
}

void limits_begin(PassState *s) {
    cau_render *r = s->r;
    if (has_rounds(r)) {
        r->pass_scale = fmax(r->pass_scale, 1);
        r->photons_per_pass = (uint32_t)fmin(r->pass_least * r->pass_scale, r->pass_most);
    }
    s->round = (Round){.started_s = render_clock_s(), .before = r->passes, .check = next_check(r->passes)};
}

/* As before the first pass. */
static void start_over(PassState *s, double growth, double error) {
    cau_render *r = s->r;
    for (size_t g = 0; g < r->group_count; g++) {
        RenderGroup *group = &r->groups[g];
        Film *films[GROUP_FILMS];
        group_films(group, films);
        for (size_t f = 0; f < GROUP_FILMS; f++) film_restart(films[f]);
        for (int kind = 0; kind < 2; kind++)
            if (kind ? group->indirect : group->direct) kernels_restart(r, g, kind);
        group_accounts_clear(group);
        free(group->looks);
        group->looks = NULL;
    }
    s->last = (PastRound){growth, error, render_clock_s() + s->round.left_s};
    r->passes = 0;
    r->pass_scale = fmin(r->pass_scale * growth, (double)r->pass_most / r->pass_least);
    limits_begin(s);
}

/* ---- how much is left ---- */

static double pass_seconds(const PassState *s, double now_s) {
    return (now_s - s->round.started_s) / (double)(s->r->passes - s->round.before);
}

/* Larger passes do not always help: what limits the error may be the same in each. */
static bool larger_paid(const PassState *s, double error) {
    return !(s->last.error > 0) || !(error > 0) ||
           log(s->last.error / error) >= ROUND_EXPONENT_LEAST * log(s->last.growth);
}

/* How many times as large the passes of another round should be; 0: this one goes on. */
static double growth_wanted(const PassState *s, double now_s, double error, double *times) {
    const cau_render *r = s->r;
    bool waves = render_waves_alone(r);
    double passes = (double)r->passes, growth = ROUND_GROWTH_MAX, needed = INFINITY;
    *times = 1;
    if (!has_rounds(r) || r->photons_per_pass >= r->pass_most || !larger_paid(s, error)) return 0;
    if (r->options.error > 0 && error > 0) {
        double exponent = waves ? ROUND_EXPONENT_WAVES : ROUND_EXPONENT_PHOTONS;
        needed = passes * pow(error / r->options.error, 1 / exponent);
        growth = fmin(growth, needed / (waves ? ROUND_PASSES_WAVES : ROUND_PASSES_PHOTONS));
    }
    if (r->options.time_s > 0) {
        double left = (r->options.time_s - (now_s - r->started_s)) / pass_seconds(s, now_s);
        needed = fmin(needed, passes + left);
        growth = fmin(growth, left / ROUND_PASSES_TIMED);
    }
    *times = needed / passes;
    return needed >= (waves ? ROUND_LEAST_WAVES : ROUND_LEAST_PHOTONS) * passes && growth > 1 ? growth : 0;
}

/* From what the round stated at half its passes or less. */
static double exponent_so_far(PassState *s, double error) {
    const cau_render *r = s->r;
    PastError *past = s->round.past;
    bool noise = r->options.estimator == CAU_ESTIMATOR_R || render_waves_alone(r);
    double expected = noise ? EXPONENT_NOISE : EXPONENT_PHOTONS;
    double passes = (double)r->passes, ratio = past[0].passes > 0 ? passes / past[0].passes : 1;
    double found = ratio >= 2 && error > 0 ? log(past[0].error / error) / log(ratio) : expected;
    if (error > 0 && r->passes >= 4 && (past[1].passes == 0 || passes >= 2 * past[1].passes)) {
        past[0] = past[1];
        past[1] = (PastError){passes, error};
    }
    return clamp(found, EXPONENT_MIN, EXPONENT_MAX);
}

/* Seconds until the error is met: what is left of this round, or it and another. */
static double error_left_s(PassState *s, double now_s, double error) {
    const cau_render *r = s->r;
    double passes = (double)r->passes, pass_s = pass_seconds(s, now_s);
    double least = fmax((r->view ? PASSES_TOLD_WAVES : PASSES_TOLD) - passes, 0), times,
           growth = growth_wanted(s, now_s, error, &times);
    double needed = passes * pow(error / r->options.error, 1 / exponent_so_far(s, error));
    if (growth > 0) return pass_s * (least + needed * pow(growth, PASS_TIME_EXPONENT - 1));
    return pass_s * fmax(needed - passes, least);
}

/* By whichever limit is met first; negative: not known. A few passes of a new round know less than the whole
 * last one did. */
static double forecast_s(PassState *s, double now_s, double error) {
    const cau_render *r = s->r;
    double best = INFINITY;
    if (r->passes_share) best = pass_seconds(s, now_s) * (double)(r->passes_share - r->passes);
    if (r->options.time_s > 0) best = fmin(best, r->options.time_s - (now_s - r->started_s));
    if (r->options.error > 0 && s->last.end_s > 0 && r->passes < PASSES_TOLD / 2)
        best = fmin(best, s->last.end_s - now_s);
    else if (r->options.error > 0 && error > 0)
        best = fmin(best, error_left_s(s, now_s, error));
    return isfinite(best) ? fmax(best, 0) : -1;
}

/* ---- after a pass ---- */

bool limits_all_passes(const cau_render *r) { return r->passes_wanted && r->passes >= r->passes_share; }

/* The next pass would end farther beyond it than the last one ended before it. */
static bool time_is_up(const PassState *s, double now_s) {
    const cau_render *r = s->r;
    return r->options.time_s > 0 && now_s - r->started_s + 0.5 * pass_seconds(s, now_s) >= r->options.time_s;
}

/* Another round, of larger passes or of other estimators, where little is known of a long way. */
static cau_result next_round(PassState *s, double now_s, double error, CauError *err) {
    double times, growth = growth_wanted(s, now_s, error, &times);
    bool restart = false;
    if (has_rounds(s->r)) CAU_TRY(race_step(s, error, times, growth, &restart, err));
    if (restart) {
        s->last.end_s = render_clock_s() + s->round.left_s;
        limits_begin(s);
    } else if (growth > 0)
        start_over(s, growth, error);
    return CAU_OK;
}

cau_result limits_met(PassState *s, bool *met, CauError *err) {
    cau_render *r = s->r;
    double now_s = render_clock_s();
    *met = limits_all_passes(r) || time_is_up(s, now_s);
    if (*met) return CAU_OK;
    /* The error costs a walk over all films: not after every short pass. Whether it will do is asked after
     * the same passes always, so that the picture does not depend on the machine. */
    bool check = r->passes == s->round.check;
    if (!check && now_s - s->round.reported_s < REPORT_S) return CAU_OK;
    s->round.reported_s = now_s;
    double error = render_total_error(r);
    s->round.left_s = forecast_s(s, now_s, error);
    render_report(r, "rendering", error, s->round.left_s);
    if (!check) return CAU_OK;
    s->round.check = next_check(r->passes);
    /* A black picture says nothing of what larger passes might find. */
    bool largest = !has_rounds(r) || r->photons_per_pass >= r->pass_most;
    bool told = r->passes >= (r->view ? PASSES_TOLD_WAVES : PASSES_TOLD);
    *met =
        r->options.error > 0 && told && error <= r->options.error && (error > 0 || (error == 0 && largest));
    return *met ? CAU_OK : next_round(s, now_s, error, err);
}
