/* SPDX-License-Identifier: Apache-2.0 */
#include "cases.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SEED = 20240611, RANDOM_PER_RUNG = 3 };

static void set(Material *m, const char *key, const double *v, size_t n) {
    CauError err = {0};
    if (param_set(&m->kind->table, m->data, "test", key, v, n, &err) != CAU_OK) fail_msg("%s", err.text);
}

static void set_number(Material *m, const char *key, double value) { set(m, key, &value, 1); }

/* One of a choice's words, u in [0, 1). */
static void set_choice(Material *m, const Param *p, double u) {
    size_t count = 0;
    while (p->choices[count]) count++;
    CauError err = {0};
    const char *word = p->choices[(size_t)(u * (double)count)];
    if (param_set_choice(&m->kind->table, m->data, "test", p->name, word, &err) != CAU_OK)
        fail_msg("%s", err.text);
}

static void white_defaults(Material *m, const MaterialKind *kind) {
    *m = (Material){.kind = kind};
    param_defaults(&kind->table, m->data);
    for (size_t i = 0; i < kind->table.count; i++) {
        const Param *p = &kind->table.params[i];
        if (p->type == PARAM_COLOR && param_is_stored(p)) set(m, p->name, (double[]){1, 1, 1}, 3);
    }
}

Material make_material(const char *kind, ...) {
    Material m;
    white_defaults(&m, material_find(kind));
    va_list args;
    va_start(args, kind);
    for (const char *key; (key = va_arg(args, const char *));) set_number(&m, key, va_arg(args, double));
    va_end(args);
    m.kind->prepare(&m);
    return m;
}

static void randomise(Material *m, Rng *rng) {
    const ParamTable *table = &m->kind->table;
    for (size_t i = 0; i < table->count; i++) {
        const Param *p = &table->params[i];
        if (!param_is_stored(p)) continue;
        if (p->type == PARAM_CHOICE) {
            set_choice(m, p, rng_next(rng));
            continue;
        }
        double v[3];
        for (int c = 0; c < 3; c++) v[c] = p->min + (p->max - p->min) * rng_next(rng);
        if (strcmp(p->name, "ior") == 0 && rng_next(rng) < 0.7) v[0] = 0.6 + 1.8 * rng_next(rng);
        if (strcmp(p->name, "roughness") != 0) set(m, p->name, v, param_components(p));
    }
}

void for_each_case(void (*visit)(const Case *c, Rng *rng)) {
    static const double ladder[] = {0.0, 0.0101, 0.05, 0.2, 0.5, 0.75, 1.0};
    Rng rng = rng_make(SEED);
    size_t kinds;
    for (size_t k = 0; k < (material_kinds(&kinds), kinds); k++) {
        const MaterialKind *kind = material_kinds(&kinds)[k];
        bool rough = param_find(&kind->table, "roughness") != NULL;
        for (size_t r = 0; r < (rough ? sizeof ladder / sizeof *ladder : 1); r++)
            for (int i = 0; i <= RANDOM_PER_RUNG; i++) {
                Case c = {.roughness = rough ? ladder[r] : -1.0};
                white_defaults(&c.m, kind);
                if (i > 0) randomise(&c.m, &rng);
                if (rough) set_number(&c.m, "roughness", ladder[r]);
                kind->prepare(&c.m);
                snprintf(c.label, sizeof c.label, "%s, roughness %g, variant %d, seed %d", kind->name,
                    c.roughness, i, SEED);
                visit(&c, &rng);
            }
    }
}

bool case_is_burley(const Case *c) {
    return c->m.kind->received &&
           c->m.kind->received(&c->m, &(ShadingFrame){.ng = {0, 0, 1}, .ns = {0, 0, 1}}, v3(0, 0, 1)) != 1.0;
}

bool case_gives_back(const Case *c) {
    const Param *p = param_find(&c->m.kind->table, "facets");
    return p && *(const double *)(const void *)((const char *)c->m.data + p->offset) > 0.0;
}

void expect_true(const Case *c, const char *what, bool ok) {
    if (!ok) fail_msg("%s: %s", c ? c->label : "", what);
}

void expect_near(const Case *c, const char *what, double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%s: %s is %.12g, not %.12g +- %g", c ? c->label : "", what, got, want, tolerance);
}

V3 random_direction(Rng *rng) {
    double z = 2.0 * rng_next(rng) - 1.0, phi = 2.0 * CAU_PI * rng_next(rng), s = sqrt(1.0 - z * z);
    return v3(s * cos(phi), s * sin(phi), z);
}

static V3 tilted(V3 n, double cos_t, Rng *rng) {
    V3 s, t;
    v3_frame(n, &s, &t);
    double phi = 2.0 * CAU_PI * rng_next(rng), sin_t = sqrt(fmax(0.0, 1.0 - cos_t * cos_t));
    return v3_normalize(v3_from_frame(v3(sin_t * cos(phi), sin_t * sin(phi), cos_t), s, t, n));
}

ShadingFrame make_frame(Rng *rng, bool front, double tilt) {
    V3 ng = random_direction(rng);
    return (ShadingFrame){.ng = ng, .ns = tilt > 0.0 ? tilted(ng, cos(tilt), rng) : ng, .front = front};
}

V3 direction_at(const ShadingFrame *f, double cos_i, Rng *rng) { return tilted(f->ns, cos_i, rng); }

ShadingFrame frame_from(const ShadingFrame *f, bool transmit) {
    if (!transmit) return *f;
    return (ShadingFrame){v3_neg(f->ng), v3_neg(f->ns), !f->front};
}

Shares sample_shares(
    const Material *m, const ShadingFrame *f, V3 wi, unsigned lobes, int per_axis, int choices) {
    Shares sum = {0};
    double scale = 1.0 / ((double)per_axis * per_axis * choices);
    for (int i = 0; i < per_axis; i++)
        for (int j = 0; j < per_axis; j++)
            for (int k = 0; k < choices; k++) {
                double u[3] = {(i + 0.5) / per_axis, (j + 0.5) / per_axis, (k + 0.5) / choices};
                ScatterSample s;
                if (!m->kind->sample(m, f, wi, u, lobes, false, &s)) continue;
                Rgb w = rgb_scale(s.weight, scale);
                Rgb *to = s.lobe == LOBE_DIFFUSE ? &sum.diffuse
                          : s.transmit           ? &sum.transmitted
                                                 : &sum.reflected;
                *to = rgb_add(*to, w);
                sum.total = rgb_add(sum.total, w);
            }
    return sum;
}

void random_u(Rng *rng, double u[3]) {
    for (int i = 0; i < 3; i++) u[i] = rng_next(rng);
}
