/* SPDX-License-Identifier: Apache-2.0 */
/* When a render has ended, when it will, and how large its passes are until then.
 *
 * A render of so many photons has passes of a known size. One that is to reach an error, or to take a time,
 * has rounds: passes of few photons first, so that what little does is not paid for with more; and when these
 * tell that it is done sooner so, passes that are larger, from the start. Nothing is kept of the small
 * ones but the picture until there is another: their kernels are wide, and their grids coarse. Where
 * that pays a round is a part of what the next one takes, so all that are left behind cost a fraction of it.
 */
#include "render/render_pass_state.h"

#include <stdlib.h>
#include <string.h>

/* In a render that is to take a time, passes that another round should have, and so many times as many as
 * there are it must take for another to begin: photons learn their kernels from a pass, so few large ones
 * have less error than many small ones. Passes become so many times as large at once, for few tell little of
 * many. */
#define ROUND_PASSES_TIMED 16.0
#define ROUND_LEAST_WAVES 4.0
#define ROUND_LEAST_PHOTONS 2.0
#define ROUND_GROWTH_MAX 16.0
/* A round of larger passes that gained less than this power of their size was the last. */
#define ROUND_EXPONENT_LEAST 0.25
/* The error is looked at after every thirty-second part of the passes, and told every so many seconds. */
enum { CHECK_PART = 32 };
#define REPORT_S 0.2

/* Fewer replicas cannot tell their own spread. Of wavefronts, which have no kernels wide enough to smooth
 * what few rays bring, twice as many are wanted before an error is believed. Of photons half will do where so
 * many values make the error (of four passes the pool at 960x540 has 15000, still life, whose foci are small,
 * 110 to 870); only large pictures can have them. */
enum { PASSES_TOLD = 8, PASSES_TOLD_WAVES = 16, PASSES_EARLY = 4 };
#define EARLY_VALUES 400.0

/* The same whether the render has gone on from a state or not. */
static uint64_t next_check(const cau_render *r, uint64_t passes) {
    uint64_t check = !r->view && render_pixel_count(r) >= RENDER_LARGE_PIXELS ? PASSES_EARLY : PASSES_TOLD;
    while (check <= passes) check += 1 + check / CHECK_PART;
    return check;
}

void limits_begin(PassState *s) {
    cau_render *r = s->r;
    if (render_has_rounds(r)) {
        r->pass_scale = fmax(r->pass_scale, 1);
        r->photons_per_pass = (uint32_t)fmin(r->pass_least * r->pass_scale, r->pass_most);
    }
    s->round = (Round){.started_s = render_clock_s(),
        .before = r->passes,
        .check = next_check(r, r->passes),
        .budget = BUDGET_AS_IS};
}

/* The next round ends when this one thought that it would, until it knows better. */
static void begin_again(PassState *s) {
    double end_s = render_clock_s() + s->round.left_s;
    s->r->stated = (PastErrors){0};
    limits_begin(s);
    s->round.end_s = end_s;
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
    r->past = (PastRound){growth, error};
    r->passes = 0;
    r->pass_scale = fmin(r->pass_scale * growth, (double)r->pass_most / r->pass_least);
    begin_again(s);
}

/* ---- how much is left ---- */

/* A round's first pass takes longer: it learns. */
static double pass_seconds(const PassState *s, double now_s) {
    const Round *round = &s->round;
    double passes = (double)(s->r->passes - round->before);
    return passes > 1 ? (now_s - round->learned_s) / (passes - 1) : now_s - round->started_s;
}

/* What learning takes, in passes. */
static double learning_passes(const PassState *s, double now_s) {
    return fmax((s->round.learned_s - s->round.started_s) / pass_seconds(s, now_s) - 1, 0);
}

/* Larger passes do not always help: what limits the error may be the same in each. */
static bool larger_paid(const PastRound *past, double error) {
    return !(past->error > 0) || !(error > 0) ||
           log(past->error / error) >= ROUND_EXPONENT_LEAST * log(past->growth);
}

double limits_growth_most(const cau_render *r) { return (double)r->pass_most / r->photons_per_pass; }

static double passes_told(const cau_render *r, const ErrorParts *e) {
    if (r->view) return PASSES_TOLD_WAVES;
    return e->values >= EARLY_VALUES && render_pixel_count(r) >= RENDER_LARGE_PIXELS ? PASSES_EARLY
                                                                                     : PASSES_TOLD;
}

/* Passes of the present size that the limit of time leaves. */
static double passes_in_time(const PassState *s, double now_s) {
    const cau_render *r = s->r;
    if (!(r->options.time_s > 0)) return INFINITY;
    return (r->options.time_s - (now_s - r->started_s)) / pass_seconds(s, now_s);
}

/* And all limits but that of the error. */
static double passes_left(const PassState *s, double now_s) {
    const cau_render *r = s->r;
    double left = passes_in_time(s, now_s);
    if (!r->options.photons) return left;
    return fmin(left, (double)(r->options.photons / r->photons_per_pass) - (double)r->passes);
}

/* How many times as large the passes of another round should be; 0: this one goes on. `times`: what this one
 * has to do in all, over what it did. Of what the passes told alone, or of the clock where a time is a
 * limit. */
static double growth_wanted(const PassState *s, double now_s, const ErrorParts *e, double *times) {
    const cau_render *r = s->r;
    double passes = (double)r->passes, growth = limits_growth_most(r), needed = INFINITY;
    bool larger = r->photons_per_pass < r->pass_most && larger_paid(&r->past, e->total);
    *times = 1;
    if (!render_has_rounds(r)) return 0;
    if (r->options.error > 0 && e->total > 0) {
        growth =
            forecast_round(e, passes, r->options.error, growth, passes_told(r, e), s->round.budget).growth;
        needed = forecast_passes(e, passes, r->options.error, 1, passes_told(r, e));
    }
    double left = passes_left(s, now_s), timed = passes_in_time(s, now_s);
    needed = fmin(needed, passes + left);
    if (isfinite(timed)) growth = fmin(growth, timed / (ROUND_PASSES_TIMED + learning_passes(s, now_s)));
    double least = render_waves_alone(r) ? ROUND_LEAST_WAVES : ROUND_LEAST_PHOTONS;
    if (isfinite(left) && needed < least * passes) growth = 0;
    *times = needed / passes;
    return larger && growth > 1 ? fmin(growth, ROUND_GROWTH_MAX) : 0;
}

/* Seconds until the error is met, as a look will find: at the end of this round, or of another that the next
 * look begins. */
static double error_left_s(const PassState *s, double now_s, const ErrorParts *e) {
    const cau_render *r = s->r;
    double passes = (double)r->passes, times, most = limits_growth_most(r);
    ErrorParts even = *e;
    Course course = forecast_course(e, passes, &s->r->stated);
    even.total = course.error;
    if (!(growth_wanted(s, now_s, e, &times) > 0)) most = 1;
    NextRound round =
        forecast_round(&even, passes, r->options.error, most, passes_told(r, e), s->round.budget);
    if (round.growth > 0)
        return pass_seconds(s, now_s) * (fmax(passes_told(r, e) - passes, 0) + round.cost +
                                            learning_passes(s, now_s) * round.growth_s);
    uint64_t look = s->round.check;
    double all = passes * pow(1 + round.cost / passes, 1 / course.speed);
    while ((double)look < all) look = next_check(r, look);
    return pass_seconds(s, now_s) * ((double)look - passes);
}

/* A few passes of a new round know less than the whole last one did, and those of a trial tell nothing of
 * what comes after it. */
static bool last_round_knows_better(const PassState *s) {
    return s->round.end_s > 0 && (s->r->passes < PASSES_EARLY || race_tries(s->r));
}

/* By whichever limit is met first; negative: not known. */
static double forecast_s(const PassState *s, double now_s, const ErrorParts *e) {
    const cau_render *r = s->r;
    double best = INFINITY, pass_s = pass_seconds(s, now_s);
    if (r->passes_share)
        best = pass_s * (double)(r->passes_share - r->passes);
    else
        best = pass_s * passes_left(s, now_s);
    if (r->options.error > 0 && last_round_knows_better(s))
        best = fmin(best, fmax(s->round.end_s - now_s, pass_s * (passes_told(r, e) - (double)r->passes)));
    else if (r->options.error > 0)
        best = e->total > 0 ? fmin(best, error_left_s(s, now_s, e)) : -1;
    return isfinite(best) && best >= 0 ? best : -1;
}

/* ---- after a pass ---- */

/* Of those there can be. */
static bool all_passes(const cau_render *r) {
    if (r->passes_wanted) return r->passes >= r->passes_share;
    return r->options.photons && !race_tries(r) && (r->passes + 1) * r->photons_per_pass > r->options.photons;
}

/* The next pass would end farther beyond it than the last one ended before it. How long passes take the first
 * one does not tell, for it learns; and of one alone no error is known. */
static bool time_is_up(const PassState *s, double now_s) {
    const cau_render *r = s->r;
    double next_s = r->passes - s->round.before > 1 ? pass_seconds(s, now_s) : 0;
    return r->options.time_s > 0 && now_s - r->started_s + 0.5 * next_s >= r->options.time_s;
}

/* Another round, of larger passes or of other estimators, where little is known of a long way. */
static cau_result next_round(PassState *s, double now_s, const ErrorParts *e, CauError *err) {
    cau_render *r = s->r;
    bool restart = false, tried = race_tries(r);
    if (!render_has_rounds(r)) return CAU_OK;
    if (!tried) s->round.budget = budget_look(r);
    double times, growth = growth_wanted(s, now_s, e, &times);
    /* What passes of this size would have had, for the next ones to be compared with. */
    CAU_TRY(race_step(s, e->total * s->round.budget.error, times, growth, &restart, err));
    if (restart) {
        budget_take(r, tried);
        begin_again(s);
    } else if (growth > 0) {
        if (tried) s->round.budget = budget_look(r);
        budget_take(r, true);
        start_over(s, growth, e->total * s->round.budget.error);
    }
    return CAU_OK;
}

static void remember(PastErrors *past, double passes, double error) {
    size_t next = (size_t)past->next % PAST_ERRORS; /* a state may say anything */
    past->items[next] = (PastError){passes, fmax(error, 0)};
    past->next = (double)(next + 1);
}

/* What is stated goes up and down, and to stop where it is low by chance would be to state too little: what
 * the last looks let expect has to do as well. A black picture says nothing of what larger passes might find.
 */
static bool error_met(const PassState *s, const ErrorParts *e) {
    const cau_render *r = s->r;
    double passes = (double)r->passes, error = r->options.error;
    if (!(error > 0) || passes < passes_told(r, e) || !(e->total <= error) || e->total < 0) return false;
    if (e->total == 0) return !render_has_rounds(r) || r->photons_per_pass >= r->pass_most;
    return forecast_course(e, passes, &s->r->stated).error <= error;
}

bool limits_met_already(const PassState *s) {
    const cau_render *r = s->r;
    if (all_passes(r)) return true;
    if (r->passes == 0 || next_check(r, r->passes - 1) != r->passes) return false;
    ErrorParts e = render_error_parts(r);
    return error_met(s, &e);
}

cau_result limits_met(PassState *s, bool *met, CauError *err) {
    cau_render *r = s->r;
    double now_s = render_clock_s();
    if (r->passes == s->round.before + 1) s->round.learned_s = now_s;
    *met = all_passes(r) || time_is_up(s, now_s);
    if (*met) return CAU_OK;
    /* The error costs a walk over all films: not after every short pass. Whether it will do is asked after
     * the same passes always, so that the picture does not depend on the machine. */
    bool check = r->passes == s->round.check || race_overspent(r);
    if (!check && now_s - s->round.reported_s < REPORT_S) return CAU_OK;
    s->round.reported_s = now_s;
    ErrorParts e = render_error_parts(r);
    s->round.left_s = forecast_s(s, now_s, &e);
    render_report(r, "rendering", e.total, s->round.left_s);
    if (!check) return CAU_OK;
    s->round.check = next_check(r, r->passes);
    *met = error_met(s, &e);
    if (r->options.error > 0) remember(&r->stated, (double)r->passes, e.total);
    bool told = (double)r->passes >= fmin(passes_told(r, &e), PASSES_TOLD) || race_overspent(r);
    return *met || !told ? CAU_OK : next_round(s, now_s, &e, err);
}
