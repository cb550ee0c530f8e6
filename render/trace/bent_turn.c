/* SPDX-License-Identifier: Apache-2.0 */
/* Photons turned by normals that the direction they leave in would bend. */
#include "render/trace/bent.h"
#include "render/trace/bent_between.h"

enum { BISECTIONS = 40 };

/* How many photons look for a bent way through, where there is a sharp one, where a rough lobe may reach one,
 * elsewhere. */
#define CROSS_SHARP 1
#define CROSS_NEAR 0.5
#define CROSS_FAR 0.02
/* All directions that bend, pi sin^2(tilt) of the projected solid angle, see one arc as wide as the lobe,
 * just over the face. Little light arrives there, and about sin^2(tilt) / (alpha height) as much goes on. In
 * the mean these many photons per unit of it share it, fewer where the light stands higher than a lobe
 * reaches. */
#define REFLECT_SHARE 0.25
#define REFLECT_MAX 4000
#define REACH_SMOOTH 0.02
#define REACH_ALPHA 1
/* Share of the directions drawn evenly among all that bend: what bounds the weight of those in no lobe. */
#define EVEN_CROSS 0.5
#define EVEN_REFLECT 0.25
/* Step for the derivative of the light's direction by that of the eye. */
#define STEP 1e-6

/* Refracts w about n, which stands on w's side; eta = n(other side) / n(w's side). */
static bool refract(V3 w, V3 n, double eta, V3 *out) {
    double c = v3_dot(w, n), g = c * c + (eta - 1) * (eta + 1);
    if (!(c > 0) || !(g > 0)) return false;
    *out = v3_normalize(v3_mad(v3_scale(w, -1 / eta), (c - sqrt(g)) / eta, n));
    return true;
}

static double mirror_height(V3 ng, V3 n, V3 w) { return 2 * v3_dot(n, w) * v3_dot(n, ng) - v3_dot(w, ng); }

/* Light refracted by the normal at t leaves so low that it would bend it further, or not at all. */
static bool too_far(const Between *b, V3 wi, double eta, double t, V3 *out) {
    V3 n = normal_between(b, t);
    return !refract(wi, v3_neg(n), eta, out) || v3_dot(*out, b->ng) <= 0 || normal_bends(b->ng, n, *out);
}

/* The normal that light from wi, refracted, bends just to itself, between ng, which nothing bends, and ns.
 * Returns how many photons should look for it. */
static double find_through(const Between *b, V3 wi, double reach, BentTurn *out) {
    bool rough = out->alpha > 0;
    V3 dir, ns = normal_between(b, b->tilt);
    if (!too_far(b, wi, out->eta, b->tilt, &dir)) {
        bool near = mirror_height(b->ng, ns, dir) < reach;
        return !rough ? 0 : near ? CROSS_NEAR : CROSS_FAR;
    }
    if (too_far(b, wi, out->eta, 0, &dir)) return rough ? CROSS_FAR : 0;
    double low = 0, high = b->tilt;
    for (int i = 0; i < BISECTIONS; i++) {
        double middle = 0.5 * (low + high);
        if (too_far(b, wi, out->eta, middle, &dir))
            high = middle;
        else
            low = middle;
    }
    out->through = v3_neg(normal_between(b, low));
    return CROSS_SHARP;
}

BentTurn bent_prepare(const BentSet *set, const Hit *hit, const ShadingFrame *frame, V3 wi) {
    const struct BentObject *o = &set->objects[hit->object];
    BentTurn out = {.through = frame->ns, .alpha = o->alpha};
    Between b;
    double height = v3_dot(wi, frame->ng), reach = REACH_SMOOTH + REACH_ALPHA * o->alpha;
    if (!(height > 0) || !between(v3_neg(frame->ng), v3_neg(frame->ns), &b)) return out;
    if (o->eta != 0) {
        out.eta = frame->front ? o->eta : 1 / o->eta;
        out.cross = find_through(&b, wi, reach, &out);
    }
    if (o->alpha > 0)
        out.reflect = fmin(REFLECT_MAX,
            REFLECT_SHARE * square(sin(b.tilt)) / (o->alpha * height) * fmin(1, square(reach / height)));
    return out;
}

/* How many steradians of the light one steradian seen from wo holds. */
static double light_per_seen(const Hit *hit, V3 wo, double eta) {
    V3 s, t, to[3];
    v3_frame(wo, &s, &t);
    for (int k = 0; k < 3; k++) {
        V3 w = k == 0 ? wo : v3_normalize(v3_mad(wo, STEP, k == 1 ? s : t));
        ShadingFrame f = frame_from_hit(hit, w);
        if (!refract(w, f.ns, eta, &to[k])) return 0;
    }
    return v3_length(v3_cross(v3_sub(to[1], to[0]), v3_sub(to[2], to[0]))) / (STEP * STEP);
}

static bool cross_smooth(const BentTurn *c, const Hit *hit, const ShadingFrame *frame, V3 wi,
    const double u[4], ScatterSample *out) {
    ShadingFrame f = {frame->ng, c->through, frame->front};
    const Material *m = hit->material;
    if (!m->kind->sample(m, &f, wi, u, LOBE_SPECULAR, true, out) || !out->transmit) return false;
    if (!light_is_bent(frame, out->wo)) return false;
    double density = light_per_seen(hit, out->wo, 1 / c->eta);
    if (!(density > 0)) return false;
    double factor = fabs(v3_dot(out->wo, hit->ng)) * square(c->eta) / (fabs(v3_dot(wi, hit->ng)) * density);
    out->weight = rgb_scale(out->weight, factor);
    return true;
}

static bool cross_rough(const BentTurn *c, const Hit *hit, const ShadingFrame *frame, V3 wi,
    const double u[4], ScatterSample *out) {
    ShadingFrame f = {frame->ng, c->through, frame->front};
    const Material *m = hit->material;
    V3 ng = v3_neg(frame->ng), ns = v3_neg(frame->ns), dir;
    if (u[3] < EVEN_CROSS) {
        if (!bent_direction(ng, ns, u[0], u[1], &dir)) return false;
    } else {
        if (!m->kind->sample(m, &f, wi, u, LOBE_GLOSSY, true, out) || !out->transmit) return false;
        dir = out->wo;
    }
    if (!(v3_dot(dir, ng) > 0) || !normal_bends(ng, ns, dir)) return false;
    double lobe, ignored;
    m->kind->eval(m, &f, wi, dir, LOBE_GLOSSY, &lobe);
    ShadingFrame seen = frame_from_hit(hit, dir);
    Rgb value = m->kind->eval(m, &seen, dir, wi, LOBE_GLOSSY, &ignored);
    double pdf = EVEN_CROSS * bent_direction_pdf(ng, ns, dir) + (1 - EVEN_CROSS) * lobe;
    double factor = v3_dot(dir, ng) * square(c->eta) / (fabs(v3_dot(wi, ng)) * pdf);
    *out = (ScatterSample){dir, rgb_scale(value, factor), pdf, LOBE_GLOSSY, true, c->eta};
    return !rgb_black(out->weight);
}

/* Half vectors: along the plane of the two normals even, as all that is bent is mirrored to one height;
 * across it as slopes of GGX are (their marginal: alpha^2 / (2 (alpha^2 + s^2)^(3/2))). */
static V3 half_sample(const Between *b, double alpha, double u, double v) {
    double w = clamp(2 * v - 1, -1 + 1e-12, 1 - 1e-12), slope = alpha * w / sqrt(1 - w * w);
    V3 n = normal_between(b, -alpha + u * (b->tilt + 2 * alpha));
    return v3_normalize(v3_mad(n, slope, v3_cross(b->ng, b->side)));
}

static double half_pdf(const Between *b, double alpha, V3 h) {
    double across = v3_dot(h, v3_cross(b->ng, b->side)), along = sqrt(fmax(0, 1 - across * across));
    double t = atan2(v3_dot(h, b->side), v3_dot(h, b->ng));
    if (!(along > 0) || t < -alpha || t > b->tilt + alpha) return 0;
    double slope = across / along, e = alpha * alpha + slope * slope;
    return alpha * alpha / (2 * e * sqrt(e)) * (1 + slope * slope) / (along * (b->tilt + 2 * alpha));
}

static bool reflect_rough(const BentTurn *c, const Hit *hit, const ShadingFrame *frame, V3 wi,
    const double u[4], ScatterSample *out) {
    Between b;
    V3 dir;
    if (!between(frame->ng, frame->ns, &b)) return false;
    if (u[3] < EVEN_REFLECT) {
        if (!bent_direction(frame->ng, frame->ns, u[0], u[1], &dir)) return false;
    } else {
        V3 h = half_sample(&b, c->alpha, u[0], u[1]);
        dir = v3_mad(v3_neg(wi), 2 * v3_dot(wi, h), h);
        if (!(v3_dot(wi, h) > 0)) return false;
    }
    double z = v3_dot(dir, frame->ng), ignored;
    if (!(z > 0) || !normal_bends(frame->ng, frame->ns, dir)) return false;
    V3 h = v3_normalize(v3_add(wi, dir));
    double pdf = (1 - EVEN_REFLECT) * half_pdf(&b, c->alpha, h) / (4 * v3_dot(wi, h)) +
                 EVEN_REFLECT * bent_direction_pdf(frame->ng, frame->ns, dir);
    ShadingFrame seen = frame_from_hit(hit, dir);
    Rgb value = hit->material->kind->eval(hit->material, &seen, dir, wi, LOBE_GLOSSY, &ignored);
    double factor = z / (v3_dot(wi, frame->ng) * pdf);
    *out = (ScatterSample){dir, rgb_scale(value, factor), pdf, LOBE_GLOSSY, false, 1};
    return !rgb_black(out->weight);
}

bool bent_turn(const BentTurn *turn, const Hit *hit, const ShadingFrame *frame, V3 wi, bool cross,
    const double u[4], ScatterSample *out) {
    bool (*way)(const BentTurn *, const Hit *, const ShadingFrame *, V3, const double[4], ScatterSample *) =
        !cross            ? reflect_rough
        : turn->alpha > 0 ? cross_rough
                          : cross_smooth;
    return way(turn, hit, frame, wi, u, out) && rgb_finite(out->weight);
}
