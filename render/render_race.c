/* SPDX-License-Identifier: Apache-2.0 */
/* Which estimator is the quicker one, by what rounds tell.
 *
 * The plan chooses by probes, and is wrong now and then: by tenfold where a mesh is bumpy or a light meets
 * many interfaces. A render to an error or a time that has long to go after its first round affords a round
 * of the other estimator, and whichever then promises the error for less goes on. What it takes is counted in
 * rays, not in seconds, for the picture must not depend on the machine. */
#include "render/render_pass_state.h"

/* Passes of a trial, and the share of what the plan's choice has still to do that it may cost. */
#define TRIAL_PASSES 8.0
#define TRIAL_SHARE 0.25
/* Rays of a wavefront's pass over those of its corners: cells are split, and some passes draw it twice. */
#define SPLIT_RAYS 2.5
/* Beyond this blur places on a light are what wavefronts lack, however smooth the caster is. */
#define TRIAL_BLUR_MAX 2.5
/* What one promises must be so many times better: neither knows its error well. */
#define MARGIN 1.2
/* Powers of the rays with which errors fall from here on. */
#define EXPONENT_WAVES 0.55
#define EXPONENT_PHOTONS 0.4

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

static double group_cost(const cau_render *r, const RenderGroup *g) {
    double rays = (double)(g->accounts[0].rays + g->wave_account.rays);
    size_t pixels = (size_t)r->scene.camera.width * (size_t)r->scene.camera.height;
    double looks = 0;
    for (size_t i = 0; g->looks && i < pixels; i++) looks += g->looks[i];
    return 1e-6 * (rays + RENDER_RAYS_PER_LOOK * looks * (double)r->passes);
}

/* Rays, in millions, until the error is met. */
static double cost_until(double cost, double error, double target, bool waves) {
    if (!(error > 0)) return INFINITY;
    return cost * pow(fmax(error / target, 1), 1 / (waves ? EXPONENT_WAVES : EXPONENT_PHOTONS));
}

/* What a trial of the other estimator takes; infinite where there is none worth it. */
static double trial_cost(const cau_render *r, size_t g) {
    bool waves = group_chosen(r, g);
    double cost = 0, least = render_pass_least(r, !waves);
    for (size_t i = 0; i < r->scene.light_count; i++) {
        const LightPlan *plan = &r->plan.lights[i];
        if (r->group_of_light[i] != g || !plan->may_wave || plan->chosen != waves) continue;
        if (!waves && plan->blur_pixels > TRIAL_BLUR_MAX) return INFINITY;
        cost += 1e-6 * TRIAL_PASSES * least * (waves ? plan->photon_rays : SPLIT_RAYS * plan->wave_rays);
    }
    return cost > 0 ? cost : INFINITY;
}

/* The films' estimators have changed: all starts over. */
static cau_result switched(PassState *s, double scale, CauError *err) {
    cau_render *r = s->r;
    r->passes = 0;
    r->pass_scale = scale;
    r->past = (PastRound){0};
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

/* The error that choices are compared at: what is wanted, or one well below those reached. */
static double target_of(const cau_render *r, double a, double b) {
    if (r->options.error > 0) return r->options.error;
    return 0.25 * fmin(a > 0 ? a : 1, b > 0 ? b : 1);
}

bool race_tries(const cau_render *r) { return r->race.stage == RACE_TRIED; }

/* `times`: what the plan's choice needs in all, over what it took, where a time is the limit. */
static cau_result race_try(
    PassState *s, double error, double times, double growth, bool *restart, CauError *err) {
    cau_render *r = s->r;
    double cost = 0, left = 0;
    for (size_t g = 0; g < r->group_count; g++) {
        RenderGroup *group = &r->groups[g];
        if (!group->direct) continue;
        group->race = (RaceTry){0, group_cost(r, group), fmax(render_layer_error(group, 0), 0)};
        double took = group->race.cost_mrays, all = r->options.time_s > 0 ? took * times : INFINITY;
        if (r->options.error > 0)
            all = fmin(all, cost_until(took, group->race.error, r->options.error, group_chosen(r, g)));
        left += all - took;
        double trial = trial_cost(r, g);
        group->race.switched = isfinite(trial);
        if (group->race.switched > 0) cost += trial;
    }
    if (!(cost > 0) || cost > TRIAL_SHARE * left) {
        for (size_t g = 0; g < r->group_count; g++) r->groups[g].race.switched = 0;
        return CAU_OK;
    }
    for (size_t g = 0; g < r->group_count; g++) group_use(r, g, r->groups[g].race.switched > 0);
    r->race = (Race){RACE_TRIED, r->pass_scale * growth, fmax(error, 0)};
    *restart = true;
    return switched(s, 1, err);
}

/* The better of the two, for an error that the render is to reach, or one that is well below both. */
static cau_result race_decide(PassState *s, bool *restart, CauError *err) {
    cau_render *r = s->r;
    r->race.stage = RACE_DECIDED;
    for (size_t g = 0; g < r->group_count; g++) {
        RenderGroup *group = &r->groups[g];
        RaceTry *race = &group->race;
        if (!(race->switched > 0)) continue;
        bool waves = !group_chosen(r, g);
        double error = render_layer_error(group, 0), target = target_of(r, race->error, error);
        double now = cost_until(group_cost(r, group), error, target, waves);
        if (MARGIN * now < cost_until(race->cost_mrays, race->error, target, !waves)) continue;
        group_use(r, g, false);
        *restart = true;
    }
    if (!*restart) return CAU_OK;
    CAU_TRY(switched(s, r->race.scale, err));
    bool other = false;
    for (size_t g = 0; g < r->group_count; g++) other |= r->groups[g].race.switched > 0;
    if (!other) r->past = (PastRound){r->race.scale, r->race.error};
    return CAU_OK;
}

cau_result race_step(PassState *s, double error, double times, double growth, bool *restart, CauError *err) {
    *restart = false;
    if (s->r->race.stage == RACE_TRIED) return race_decide(s, restart, err);
    if (s->r->race.stage == RACE_OPEN && growth > 0 && isfinite(times))
        return race_try(s, error, times, growth, restart, err);
    return CAU_OK;
}
