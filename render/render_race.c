/* SPDX-License-Identifier: Apache-2.0 */
/* Which estimator is the quicker one, by what passes tell.
 *
 * The plan chooses by probes, and is wrong now and then: by tenfold where a mesh is bumpy or a light meets
 * many interfaces. A render to an error or a time that has long to go affords some passes of the other
 * estimator, and whichever then promises the error for less goes on. What it takes is counted in rays, not in
 * seconds, for the picture must not depend on the machine. */
#include "render/render_pass_state.h"

/* Passes of a trial, and the share of what the plan's choice has still to do that it may cost: as much as
 * pays when it wins every other time, as wavefronts do that are quiet, and less for others. Half of what the
 * choice did counts too, which would be in vain where it is right and has no larger passes to begin with
 * anyway. */
#define TRIAL_PASSES 8.0
#define TRIAL_SHARE 0.45
#define TRIAL_SHARE_NOISY 0.25
#define NOISE_QUIET 0.3
#define VAIN_SHARE 0.5
/* Rays of a wavefront's pass over those of its corners: cells are split, and some passes draw it twice. */
#define SPLIT_RAYS 2.5
/* Eye paths of a pass of few photons over these: some look closer where kernels are narrow. */
#define LOOKS_PER_PHOTON 4.0
/* A trial that takes so many times what was thought is lost. */
#define TRIAL_MOST 3.0
/* Beyond this blur places on a light are what wavefronts lack, however smooth the caster is. */
#define TRIAL_BLUR_MAX 2.5
/* What one promises must be so many times better: neither knows its error well. */
#define MARGIN 1.2
/* What an error is that they are compared at, in parts of the lower one that is known: where time is the
 * limit, and at least where another error is. */
#define TARGET_TIMED 0.25
#define TARGET_NEAREST 0.125

enum { RACE_OPEN, RACE_TRIED, RACE_DECIDED };

/* Whether the plan chose wavefronts for any of a group's lights. */
static bool group_chosen(const cau_render *r, size_t g) {
    for (size_t i = 0; i < r->scene.light_count; i++)
        if (r->group_of_light[i] == g && r->plan.lights[i].chosen) return true;
    return false;
}

/* Its lights as the plan chose; or else all by photons where any had wavefronts, all that may by wavefronts
 * where none had. */
static void group_use(cau_render *r, size_t g, bool other) {
    bool chosen = group_chosen(r, g);
    r->groups[g].race.switched = other;
    for (size_t i = 0; i < r->scene.light_count; i++) {
        LightPlan *plan = &r->plan.lights[i];
        if (r->group_of_light[i] == g && plan->may_wave) plan_use(plan, other ? !chosen : plan->chosen);
    }
}

/* Of its direct layer so far, in millions of rays. Wavefronts are drawn into every pixel. */
static double group_cost(const cau_render *r, size_t group) {
    const RenderGroup *g = &r->groups[group];
    double rays = (double)(g->accounts[0].rays + g->wave_account.rays), looks = (double)g->eye_points[0];
    if (render_waves_draw(r, group, 0)) looks += render_pixel_count(r) * (double)r->passes;
    return 1e-6 * (rays + RENDER_RAYS_PER_LOOK * looks);
}

/* What the present passes of a group tell; of the error's parts their shares alone. */
static RaceTry told(const cau_render *r, size_t g) {
    RaceTry t = {.passes = (double)r->passes, .growth = limits_growth_most(r)};
    t.cost_mrays = group_cost(r, g) / t.passes;
    ErrorParts e = render_layer_parts(r, g, 0);
    double sum = 0;
    for (int i = 0; i < ERROR_PARTS; i++) sum += e.noise[i] + e.bias[i];
    if (!(e.total > 0) || !(sum > 0)) return t;
    for (int i = 0; i < ERROR_PARTS; i++) {
        t.error.noise[i] = e.noise[i] / sum;
        t.error.bias[i] = e.bias[i] / sum;
    }
    t.error.total = e.total;
    return t;
}

/* Millions of rays until the error is met; infinite where nothing is known. `kept`: the passes so far are
 * there to go on with. */
static double left_of(const RaceTry *t, double target, bool kept) {
    if (!(t->error.total > 0)) return INFINITY;
    NextRound next = forecast_round(&t->error, t->passes, target, t->growth, TRIAL_PASSES, BUDGET_AS_IS);
    if (next.growth > 0) return t->cost_mrays * next.cost;
    return t->cost_mrays * (next.cost + (kept ? 0 : t->passes));
}

/* What a trial of the other estimator takes; infinite where there is none worth it. */
static double trial_cost(const cau_render *r, size_t g) {
    bool waves = group_chosen(r, g);
    double rays = 0, least = render_pass_least(r, !waves);
    double looks = waves ? LOOKS_PER_PHOTON * least : render_pixel_count(r);
    for (size_t i = 0; i < r->scene.light_count; i++) {
        const LightPlan *plan = &r->plan.lights[i];
        if (r->group_of_light[i] != g || !plan->may_wave || plan->chosen != waves) continue;
        if (!waves && plan->blur_pixels > TRIAL_BLUR_MAX) return INFINITY;
        rays += least * (waves ? plan->photon_rays : SPLIT_RAYS * plan->wave_rays);
    }
    return rays > 0 ? 1e-6 * TRIAL_PASSES * (rays + RENDER_RAYS_PER_LOOK * looks) : INFINITY;
}

static double trial_share(const cau_render *r) {
    for (size_t i = 0; i < r->scene.light_count; i++) {
        const LightPlan *plan = &r->plan.lights[i];
        bool tried = r->groups[r->group_of_light[i]].race.switched > 0 && plan->may_wave && !plan->chosen;
        if (tried && plan->wave_noise > NOISE_QUIET) return TRIAL_SHARE_NOISY;
    }
    return TRIAL_SHARE;
}

/* The films' estimators have changed: all starts over. */
static cau_result switched(PassState *s, double scale, PastRound past, CauError *err) {
    cau_render *r = s->r;
    r->passes = 0;
    r->pass_scale = scale;
    r->past = past;
    for (size_t g = 0; g < r->group_count; g++) group_accounts_clear(&r->groups[g]);
    CAU_TRY(render_equip(r, err));
    waves_free(s);
    s->waves = (WaveCheck){0};
    return waves_prepare(s, err);
}

cau_result race_resume(cau_render *r, CauError *err) {
    bool any = false;
    for (size_t g = 0; g < r->group_count; g++) {
        bool other = r->groups[g].race.switched > 0;
        any |= other;
        group_use(r, g, other);
    }
    return any ? render_equip(r, err) : CAU_OK;
}

/* The error that choices are compared at: what is wanted, or one well below those reached, for few passes
 * tell nothing of one that is far below. */
static double target_of(const cau_render *r, double a, double b) {
    double least = fmin(a > 0 ? a : 1, b > 0 ? b : 1);
    return r->options.error > 0 ? fmax(r->options.error, TARGET_NEAREST * least) : TARGET_TIMED * least;
}

bool race_tries(const cau_render *r) { return r->race.stage == RACE_TRIED; }

bool race_overspent(const cau_render *r) {
    double cost = 0;
    for (size_t g = 0; race_tries(r) && g < r->group_count; g++)
        if (r->groups[g].race.switched > 0) cost += group_cost(r, g);
    return cost > TRIAL_MOST * r->race.mrays;
}

/* What the plan's choice has still to do in all, where time or photons are a limit as well: `times` what it
 * did. */
static double race_left(const cau_render *r, const RaceTry *t, double times) {
    bool ends = r->options.time_s > 0 || r->options.photons;
    double left = ends ? t->cost_mrays * t->passes * (times - 1) : INFINITY;
    return r->options.error > 0 ? fmin(left, left_of(t, r->options.error, true)) : left;
}

static cau_result race_try(
    PassState *s, double error, double times, double growth, bool *restart, CauError *err) {
    cau_render *r = s->r;
    double cost = 0, left = 0, in_vain = 0;
    for (size_t g = 0; g < r->group_count; g++) {
        RenderGroup *group = &r->groups[g];
        if (!group->direct) continue;
        group->race = told(r, g);
        left += race_left(r, &group->race, times);
        in_vain += growth > 0 ? 0 : group->race.cost_mrays * group->race.passes;
        double trial = trial_cost(r, g);
        group->race.switched = isfinite(trial);
        if (group->race.switched > 0) cost += trial;
    }
    if (!(cost > 0) || !isfinite(left) || cost + VAIN_SHARE * in_vain > trial_share(r) * left) {
        for (size_t g = 0; g < r->group_count; g++) r->groups[g].race.switched = 0;
        return CAU_OK;
    }
    for (size_t g = 0; g < r->group_count; g++) group_use(r, g, r->groups[g].race.switched > 0);
    PastRound past = growth > 0 ? (PastRound){growth, fmax(error, 0)} : r->past;
    r->race = (Race){RACE_TRIED, r->pass_scale * fmax(growth, 1), cost, past};
    *restart = true;
    return switched(s, 1, (PastRound){0}, err);
}

/* The better of the two, for an error that the render is to reach, or one that is well below both. */
static cau_result race_decide(PassState *s, bool *restart, CauError *err) {
    cau_render *r = s->r;
    bool lost = race_overspent(r), other = false;
    r->race.stage = RACE_DECIDED;
    for (size_t g = 0; g < r->group_count; g++) {
        RaceTry *first = &r->groups[g].race, now = told(r, g);
        if (!(first->switched > 0)) continue;
        double target = target_of(r, first->error.total, now.error.total);
        bool better = !lost && MARGIN * left_of(&now, target, true) < left_of(first, target, false);
        other |= better;
        if (better) continue;
        group_use(r, g, false);
        *restart = true;
    }
    return *restart ? switched(s, r->race.scale, other ? (PastRound){0} : r->race.past, err) : CAU_OK;
}

cau_result race_step(PassState *s, double error, double times, double growth, bool *restart, CauError *err) {
    *restart = false;
    if (s->r->race.stage == RACE_TRIED) return race_decide(s, restart, err);
    return s->r->race.stage == RACE_OPEN ? race_try(s, error, times, growth, restart, err) : CAU_OK;
}
