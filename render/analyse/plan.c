/* SPDX-License-Identifier: Apache-2.0 */
#include "render/analyse/plan.h"

#include "core/checked.h"

#include <stdarg.h>
#include <stdio.h>

typedef struct Text {
    char *bytes;
    size_t length, capacity;
    bool failed;
} Text;

__attribute__((format(printf, 2, 3))) static void say(Text *t, const char *format, ...) {
    va_list args;
    va_start(args, format);
    va_list again;
    va_copy(again, args);
    int n = vsnprintf(NULL, 0, format, args);
    va_end(args);
    if (n < 0 || !array_reserve((void **)&t->bytes, &t->capacity, t->length + (size_t)n + 1, 1)) {
        t->failed = true;
        va_end(again);
        return;
    }
    vsnprintf(t->bytes + t->length, (size_t)n + 1, format, again);
    va_end(again);
    t->length += (size_t)n;
}

static bool casts(const Scene *s, const Object *o) {
    return o->casts && (s->materials[o->material].lobes & LOBE_CASTING) &&
           (o->exact || o->mesh.triangle_count);
}

static bool receives(const Scene *s, const Object *o) {
    return o->receives && (s->materials[o->material].lobes & LOBE_DIFFUSE) &&
           (o->exact || o->mesh.triangle_count);
}

bool plan_scene_can_have_caustics(const Scene *scene) {
    bool caster = false, receiver = false, light = false;
    for (size_t i = 0; i < scene->object_count; i++) {
        caster |= casts(scene, &scene->objects[i]);
        receiver |= receives(scene, &scene->objects[i]);
    }
    for (size_t i = 0; i < scene->light_count; i++) light |= scene->lights[i].casts;
    return caster && receiver && light;
}

/* The light's own contribution to the view, with its caustics. */
static double own_mean(const LightProbe *p) { return p->cycles_mean + p->direct_mean + p->indirect_mean; }

/* Upper 95 % bound of a mean estimated from probes; nothing seen in n tries may still be 3 / n (rule of
 * three) of what all the tries together could have brought. */
static double upper_bound(double mean, double error, uint64_t deposits, uint64_t probes, double own) {
    if (deposits == 0) return probes ? own * 3.0 / (double)probes : 0;
    return mean + 1.645 * error;
}

/* Distance between the places on a light, in pixels where their light lands: farther apart each would show
 * its own picture. */
#define PLACE_PIXELS 1.5
/* A wavefront's light is exact but for what single rays mend between its corners. Where a surface is as rough
 * as its grid is fine they have to move nearly all of the light, each as much as many photons would; beyond
 * this variance, in that of as many photons as there are triangles, photons are quicker. It is the mean over
 * a light's smooth casters: one estimator for all of them, or the light would pay for both. */
#define WAVE_NOISE_MAX 6.0
/* Each place on a light draws its own picture, and what a focus lacks in places is noise that photons do not
 * have. So lights that blur their caustics over more pixels than this are estimator P's, but for casters
 * without foci (flat faces, calm water), whose wavefronts are cheap and quiet: the rays of a corner, times
 * the square of the blur, times the share that is left or the variance, up to these shares of the picture's
 * width, for with more pixels photons are dearer. All four limits are set on the even seeds of bench/plan;
 * docs/benchmarks.md says what they do to others. */
#define WAVE_BLUR_MAX 1.15
#define WAVE_BLUR_LEFT_MAX 0.0125
#define WAVE_BLUR_NOISE_MAX 0.0375
/* Photons that start at bent normals take this share of what the rays of estimator W take, when they carry
 * BENT_SHARE_FULL of the light; less with the square root of what they carry (the variance of a sum of such
 * photons goes with it), but never none: probes may miss what a narrow light lets them find. */
#define BENT_PHOTONS 0.25
#define BENT_SHARE_FULL 0.01
#define BENT_LEAST (1.0 / 16)
/* A render that has rounds begins with photons where a corner takes so many times the rays of one: they may
 * be done before wavefronts are past their first round, and a trial (render_race.c) puts right what is not.
 */
#define WAVE_DEAR_AT_FIRST 5.0
/* What estimator W may leave out of its long paths; beyond it photons carry them. */
#define DEEP_SHARE 1e-4

bool plan_wave_pays(const WaveCost *cost) { return cost->noise <= WAVE_NOISE_MAX; }

bool plan_blur_pays(const WaveCost *cost, double blur_pixels, int width) {
    double rays = cost->rays * square(blur_pixels);
    return blur_pixels <= WAVE_BLUR_MAX || (rays * cost->left <= WAVE_BLUR_LEFT_MAX * width &&
                                               rays * cost->noise <= WAVE_BLUR_NOISE_MAX * width);
}

/* What a wavefront to all casters costs, by what of the light meets each. */
static WaveCost mean_cost(const Scene *scene, const LightProbe *probe, const bool *waved) {
    WaveCost mean = {0};
    double hits = 0;
    for (size_t i = 0; probe->wave && i < scene->object_count; i++) {
        double met = waved[i] ? (double)probe->object_hits[i] : 0;
        mean.rays += met * probe->wave[i].rays;
        mean.left += met * probe->wave[i].left;
        mean.noise += met * probe->wave[i].noise;
        hits += met;
    }
    if (hits > 0) mean = (WaveCost){mean.rays / hits, mean.left / hits, mean.noise / hits};
    return mean;
}

/* W for the smooth paths of lights that are seen as small from the casters, P for what holds a rough
 * scattering, long chains, and casters that W cannot follow. */
static void plan_estimator(LightPlan *plan, const Scene *scene, const Light *light, const LightProbe *probe,
    const PlanChoice *choice) {
    bool world = light->infinite && strcmp(light->kind->name, "world") == 0, waved = false;
    bool photons = probe->deep_share > DEEP_SHARE;
    for (size_t i = 0; i < scene->object_count; i++) {
        if (!casts(scene, &scene->objects[i])) continue;
        waved |= choice->waved[i];
        photons |= !choice->waved[i] || (scene->materials[scene->objects[i].material].lobes & LOBE_GLOSSY);
    }
    plan->places = fmax(1, square(probe->blur_pixels / PLACE_PIXELS));
    WaveCost cost = mean_cost(scene, probe, choice->waved);
    plan->wave_rays = cost.rays;
    plan->wave_noise = cost.noise;
    bool small = choice->estimator == PLAN_ESTIMATOR_W ||
                 (plan_wave_pays(&cost) && plan_blur_pays(&cost, probe->blur_pixels, scene->camera.width));
    bool possible = plan->direct && choice->estimator != PLAN_ESTIMATOR_P && waved && !world;
    plan->may_wave = possible && choice->estimator == PLAN_ESTIMATOR_AUTO;
    double dear = choice->rounds ? WAVE_DEAR_AT_FIRST : PLAN_WAVE_DEAR;
    bool waits = plan->may_wave && cost.rays > dear * probe->photon_rays;
    plan->wave = plan->chosen = possible && small && !waits;
    plan->photons_beside = photons;
    plan->photons = plan->direct && (!plan->wave || photons);
    plan->blur_pixels = probe->blur_pixels;
    plan->photon_rays = probe->photon_rays;
    plan->bent = BENT_PHOTONS * clamp(sqrt(probe->bent_share / BENT_SHARE_FULL), BENT_LEAST, 1) *
                 fmax(1, cost.rays / fmax(1, probe->photon_rays));
}

void plan_use(LightPlan *plan, bool wave) {
    plan->wave = wave;
    plan->photons = !wave || plan->photons_beside;
}

/* Casters that the probes saw little of may still be met: none gets less than this part of an even share. */
#define SHARE_LEAST 0.1

static cau_result plan_shares(
    LightPlan *plan, const Scene *scene, const LightProbe *probe, const bool *waved, CauError *err) {
    double hits = 0, casters = 0, sum = 0;
    if (!plan->wave && !plan->may_wave) return CAU_OK;
    plan->share = array_new(scene->object_count, sizeof *plan->share);
    if (!plan->share) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the plan");
    for (size_t i = 0; i < scene->object_count; i++) {
        casters += waved[i];
        if (waved[i]) hits += (double)probe->object_hits[i];
    }
    for (size_t i = 0; i < scene->object_count; i++) {
        if (!waved[i]) continue;
        double met = hits > 0 ? (double)probe->object_hits[i] / hits : 0;
        sum += plan->share[i] = fmax(met, SHARE_LEAST / casters);
    }
    for (size_t i = 0; i < scene->object_count; i++) plan->share[i] /= sum;
    return CAU_OK;
}

static void plan_light(
    LightPlan *plan, const Scene *scene, const Light *light, const LightProbe *p, const PlanChoice *choices) {
    int choice = choices->indirect;
    double own = own_mean(p);
    plan->direct = light->casts && p->direct_deposits > 0;
    plan->indirect = false;
    plan->left_out_share = 0;
    if (!light->casts) return;
    plan_estimator(plan, scene, light, p, choices);
    double bound = upper_bound(p->indirect_mean, p->indirect_error, p->indirect_deposits, p->probes, own);
    double share = own > 0 ? bound / own : 0;
    bool some = p->indirect_deposits > 0;
    plan->indirect =
        some && choice != PLAN_INDIRECT_OFF && (choice == PLAN_INDIRECT_ON || share > PLAN_LEAVE_OUT);
    if (!plan->indirect) plan->left_out_share += share;
    if (!plan->direct && own > 0)
        plan->left_out_share +=
            upper_bound(p->direct_mean, p->direct_error, p->direct_deposits, p->probes, own) / own;
}

static const char *caster_words(const Material *m) {
    bool rough = m->lobes & LOBE_GLOSSY;
    if (m->lobes & LOBE_DIFFUSE) return rough ? "rough coat" : "smooth coat";
    if (strcmp(m->kind->name, "glass") == 0)
        return rough ? "reflects and refracts, rough" : "reflects and refracts";
    return rough ? "reflects, rough" : "reflects";
}

static void explain_light(
    Text *t, const Scene *s, const Light *l, const LightProbe *p, const LightPlan *plan, const bool *waved) {
    double own = own_mean(p), percent = own > 0 ? 100 / own : 0;
    if (!l->casts) {
        say(t, "Light \"%s\": told not to cast caustics; its layer is black.\n", l->name);
        return;
    }
    if (!plan->direct)
        say(t,
            "Light \"%s\": no caustic reaches the view; direct layer left out, below %.2g %% of the light's "
            "own"
            " contribution.\n",
            l->name, p->probes ? 300.0 / (double)p->probes : 0);
    else
        say(t,
            "Light \"%s\": direct caustics by %s, about %.2g %% of the light's own contribution to "
            "the"
            " view.\n",
            l->name,
            !plan->wave     ? "photons (P)"
            : plan->photons ? "wavefronts (W), the rest by photons (P)"
                            : "wavefronts (W)",
            p->direct_mean * percent);
    if (plan->direct)
        say(t, "  A photon takes %.3g rays; the light's extent spreads it over %.2g pixels.\n",
            p->photon_rays, p->blur_pixels);
    if (plan->indirect)
        say(t, "Light \"%s\": indirect caustics by photons (P), about %.2g %%.\n", l->name,
            p->indirect_mean * percent);
    else
        say(t, "Light \"%s\": indirect caustics left out, at most %.2g %%.\n", l->name,
            100 * plan->left_out_share);
    for (size_t i = 0; p->object_hits && i < s->object_count; i++) {
        const Object *o = &s->objects[i];
        if (!casts(s, o) || p->object_hits[i] == 0) continue;
        say(t, "  \"%s\" on \"%s\": %s; %.3g %% of the aimed light meets it first; by %s.\n", l->name,
            o->name, caster_words(&s->materials[o->material]),
            100.0 * (double)p->object_hits[i] / (double)p->probes,
            plan->wave && waved[i] ? "wavefronts" : "photons");
        if (p->wave && p->wave[i].rays > 0)
            say(t,
                "    A wavefront takes %.3g rays a corner, leaves %.2g %% of its light to photons and has "
                "%.2g "
                "times the variance of as many of them.\n",
                p->wave[i].rays, 100 * p->wave[i].left, p->wave[i].noise);
    }
}

static void explain_scene(Text *t, const Scene *s) {
    size_t casters = 0, receivers = 0;
    unsigned lobes = 0;
    for (size_t i = 0; i < s->object_count; i++) {
        casters += casts(s, &s->objects[i]);
        receivers += receives(s, &s->objects[i]);
        if (casts(s, &s->objects[i])) lobes |= s->materials[s->objects[i].material].lobes;
    }
    say(t, "%zu light%s, %zu caster%s, %zu receiver%s.\n", s->light_count, s->light_count == 1 ? "" : "s",
        casters, casters == 1 ? "" : "s", receivers, receivers == 1 ? "" : "s");
    if (s->light_count == 0) say(t, "There is no light: the layers are black.\n");
    if (casters == 0) say(t, "Nothing in this scene reflects or refracts: the layers are black.\n");
    if (receivers == 0)
        say(t, "Nothing in this scene receives (no diffuse surface): the layers are black.\n");
    say(t, "Not needed: %s%sdispersion, absorption, textures, bump, volumes.\n",
        lobes & LOBE_SPECULAR ? "" : "smooth chains, ", lobes & LOBE_GLOSSY ? "" : "rough lobes, ");
}

cau_result plan_make(
    Plan *out, const Scene *scene, const LightProbe *probes, const PlanChoice *choice, CauError *err) {
    *out = (Plan){.light_count = scene->light_count};
    out->lights = array_new(scene->light_count, sizeof *out->lights);
    Text text = {0};
    if (out->lights) {
        explain_scene(&text, scene);
        for (size_t i = 0; i < scene->light_count && probes; i++) {
            plan_light(&out->lights[i], scene, &scene->lights[i], &probes[i], choice);
            if (plan_shares(&out->lights[i], scene, &probes[i], choice->waved, err) != CAU_OK)
                text.failed = true;
            explain_light(&text, scene, &scene->lights[i], &probes[i], &out->lights[i], choice->waved);
        }
    }
    out->text = text.bytes;
    if (out->lights && !text.failed) return CAU_OK;
    plan_free(out);
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the plan of %zu lights", scene->light_count);
}

void plan_free(Plan *plan) {
    for (size_t i = 0; plan->lights && i < plan->light_count; i++) free(plan->lights[i].share);
    free(plan->lights);
    free(plan->text);
    *plan = (Plan){0};
}
