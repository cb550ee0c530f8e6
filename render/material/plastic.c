/* SPDX-License-Identifier: Apache-2.0 */
/* A GGX coat over a Lambert base. The base gets what the coat leaves towards the eye, 1 - E(eye). That is not
 * reciprocal, so a photon, whose wo is the eye's side, takes E(wo): the very factor that an eye path along
 * the same segments has. Or the base is Burley's lobe and gets everything, as in Blender's Principled up
 * to 3.6. */
#include "core/sampling.h"
#include "render/material/burley.h"
#include "render/material/coat.h"
#include "render/material/fresnel.h"
#include "render/material/microfacet.h"
#include "render/material/shading.h"

typedef struct PlasticParams {
    double color[3], roughness, specular, fresnel, base;
} PlasticParams;

typedef struct PlasticDerived {
    Coat coat;
    double burley_mean; /* burley_mean_albedo() */
} PlasticDerived;

_Static_assert(
    sizeof(PlasticDerived) <= MATERIAL_DERIVED_MAX * sizeof(double), "it must fit Material.derived");

enum { FRESNEL_SCHLICK, FRESNEL_DIELECTRIC };
static const char *const fresnel_terms[] = {"schlick", "dielectric", NULL};
enum { BASE_DIMMED, BASE_BURLEY };
static const char *const bases[] = {"dimmed", "burley", NULL};

static const Param params[] = {
    MATERIAL_COLOR(PlasticParams, color, 0.8, PARAM_REQUIRED, "albedo of the base"),
    MATERIAL_NUMBER(
        PlasticParams, roughness, 0.5, 0, 1, "of the coat; 0 is smooth; GGX with alpha = roughness squared"),
    MATERIAL_NUMBER(
        PlasticParams, specular, 0.5, 0, 1, "reflectance of the coat seen straight on, in units of 0.08"),
    {.name = "fresnel",
        .type = PARAM_CHOICE,
        .unit = "",
        .offset = offsetof(PlasticParams, fresnel),
        .max = 1,
        .choices = fresnel_terms,
        .help = "term of the coat: Schlick's, or the exact one of a dielectric (as in Principled)"},
    {.name = "base",
        .type = PARAM_CHOICE,
        .unit = "",
        .offset = offsetof(PlasticParams, base),
        .max = 1,
        .choices = bases,
        .help = "Lambert's lobe, dimmed by what the coat reflects; or Burley's, not dimmed (as in Principled "
                "up to "
                "Blender 3.6)"},
    MATERIAL_COMMON,
};

static const Coat *coat_of(const Material *m) { return &MATERIAL_DERIVED(PlasticDerived, m)->coat; }
static Rgb base_color(const Material *m) { return rgb_of(MATERIAL_PARAMS(PlasticParams, m)->color); }
static bool base_is_burley(const Material *m) {
    return MATERIAL_PARAMS(PlasticParams, m)->base == BASE_BURLEY;
}

static void prepare(Material *m) {
    const PlasticParams *p = MATERIAL_PARAMS(PlasticParams, m);
    PlasticDerived *derived = MATERIAL_DERIVED_MUTABLE(PlasticDerived, m);
    Coat *coat = &derived->coat;
    derived->burley_mean = burley_mean_albedo(p->roughness);
    coat_prepare(coat, 0.08 * p->specular, p->fresnel == FRESNEL_DIELECTRIC, ggx_alpha(p->roughness));
    m->lobes = LOBE_DIFFUSE;
    bool coated =
        p->specular > 0.0 || p->fresnel != FRESNEL_DIELECTRIC; /* Schlick's term of 0 is 1 at grazing */
    if (coated) m->lobes |= coat->alpha > 0.0 ? LOBE_GLOSSY : LOBE_SPECULAR;
}

/* What the base reflects relative to its colour, seen from `cos_eye`, where the coat reflects `coat_e`. */
static double base_albedo(const Material *m, double cos_eye, double coat_e) {
    if (base_is_burley(m)) return burley_albedo(MATERIAL_PARAMS(PlasticParams, m)->roughness, cos_eye);
    return 1.0 - coat_e;
}

/* Probability that sample() takes the coat, from what each lobe reflects. Kept off 0 and 1 while both may
 * matter: the coat reflects far more at grazing half vectors than its mean says. */
static double coat_probability(const Material *m, unsigned lobes, double cos_i) {
    unsigned both = lobes & m->lobes;
    if (!(both & LOBE_CASTING)) return 0.0;
    if (!(both & LOBE_DIFFUSE)) return 1.0;
    double coat_e = coat_albedo(coat_of(m), cos_i);
    double base = base_albedo(m, cos_i, coat_e) * rgb_mean(base_color(m));
    if (!(base > 0.0)) return 1.0;
    return clamp(coat_e / (coat_e + base), 0.05, 0.95);
}

/* The density with which sample() with these lobes draws the local direction o. */
static double density(const Coat *coat, V3 wi, V3 o, double p_coat) {
    double pdf = (1.0 - p_coat) * o.z / CAU_PI;
    if (coat->alpha > 0.0 && p_coat > 0.0)
        pdf += p_coat * ggx_reflect_pdf(wi, v3_normalize(v3_add(wi, o)), coat->alpha);
    return pdf;
}

/* The base relative to Lambert's lobe, between two local directions. */
static double base_lobe(const Material *m, V3 light, V3 eye) {
    if (base_is_burley(m)) return burley_lobe(MATERIAL_PARAMS(PlasticParams, m)->roughness, light, eye);
    return 1.0 - coat_albedo(coat_of(m), eye.z);
}

/* The coat's reflectance relative to its density: F G1(wo), or F of the mirror. */
static double coat_weight(const Coat *coat, V3 o, double c) {
    double f = coat_fresnel(coat, c);
    return coat->alpha > 0.0 ? f * ggx_g1(o, coat->alpha) : f;
}

static bool sample_coat(const Coat *coat, const ShadingFrame *f, const LocalFrame *l, const double u[3],
    double p_coat, ScatterSample *out) {
    bool rough = coat->alpha > 0.0;
    V3 h = rough ? ggx_sample(l->wi, coat->alpha, u[0], u[1]) : v3(0.0, 0.0, 1.0);
    double c = v3_dot(l->wi, h);
    V3 o = reflect_about(l->wi, h, c);
    if (!sample_direction(f, l, o, false, out)) return false;
    out->lobe = rough ? LOBE_GLOSSY : LOBE_SPECULAR;
    out->weight = rgb_grey(coat_weight(coat, o, c) / p_coat);
    out->pdf = rough ? density(coat, l->wi, o, p_coat) : 0.0;
    return true;
}

/* The weight belongs to the lobe drawn; the density is of wo by either, so that weights against other ways to
 * find wo (which evaluate both) add up. */
static bool sample(const Material *m, const ShadingFrame *f, V3 wi, const double u[3], unsigned lobes,
    bool from_light, ScatterSample *out) {
    const Coat *coat = coat_of(m);
    LocalFrame l;
    if (!(lobes & m->lobes) || !frame_valid(f, wi, &l)) return false;
    double p_coat = coat_probability(m, lobes, l.wi.z);
    if (u[2] < p_coat) return sample_coat(coat, f, &l, u, p_coat, out);
    V3 o = sample_cosine_cone(1.0, u[0], u[1]);
    if (!sample_direction(f, &l, o, false, out)) return false;
    double lobe = from_light ? base_lobe(m, l.wi, o) : base_lobe(m, o, l.wi);
    out->lobe = LOBE_DIFFUSE;
    out->weight = rgb_scale(base_color(m), lobe / (1.0 - p_coat));
    out->pdf = density(coat, l.wi, o, p_coat);
    return true;
}

static Rgb eval(const Material *m, const ShadingFrame *f, V3 wi, V3 wo, unsigned lobes, double *pdf) {
    const Coat *coat = coat_of(m);
    LocalFrame l;
    Rgb sum = rgb_grey(0.0);
    *pdf = 0.0;
    if (!(lobes & m->lobes) || !frame_valid(f, wi, &l)) return sum;
    V3 o = frame_to_local(&l, wo);
    if (!(o.z > 0.0) || !(v3_dot(wo, f->ng) > 0.0)) return sum;
    *pdf = density(coat, l.wi, o, coat_probability(m, lobes, l.wi.z));
    if (lobes & LOBE_DIFFUSE) sum = rgb_scale(base_color(m), base_lobe(m, o, l.wi) * o.z / CAU_PI);
    if (lobes & m->lobes & LOBE_GLOSSY) {
        V3 h = v3_normalize(v3_add(l.wi, o));
        double value = coat_weight(coat, o, v3_dot(l.wi, h)) * ggx_reflect_pdf(l.wi, h, coat->alpha);
        sum = rgb_add(sum, rgb_grey(value));
    }
    return sum;
}

static Rgb albedo(const Material *m, const ShadingFrame *f, V3 eye) {
    if (!(v3_dot(eye, f->ng) > 0.0)) return rgb_grey(0.0);
    double cos_eye = v3_dot(eye, frame_normal(f, eye));
    return rgb_scale(base_color(m), base_albedo(m, cos_eye, coat_albedo(coat_of(m), cos_eye)));
}

/* Deposits know where they are, not where they came from: Burley's lobe is split into a factor of the eye,
 * its albedo, and one of the light, the same over its mean. Energy and reciprocity stay exact. */
static double received(const Material *m, const ShadingFrame *f, V3 light) {
    if (!base_is_burley(m)) return 1.0;
    return burley_albedo(
               MATERIAL_PARAMS(PlasticParams, m)->roughness, v3_dot(light, frame_normal(f, light))) /
           MATERIAL_DERIVED(PlasticDerived, m)->burley_mean;
}

const MaterialKind material_plastic = {
    .name = "plastic",
    .help = "a coloured surface under a clear coat, the same on both sides",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(PlasticParams),
    .prepare = prepare,
    .sample = sample,
    .eval = eval,
    .albedo = albedo,
    .received = received,
};
