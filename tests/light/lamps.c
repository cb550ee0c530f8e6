/* SPDX-License-Identifier: Apache-2.0 */
#include "lamps.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { SEED = 4711 };

static void set(Lamp *l, const char *key, double value) {
    const Param *p = param_find(&l->source.kind->table, key);
    if (!p) fail_msg("no parameter %s", key);
    double v[3] = {value, value, value};
    CauError err = {0};
    cau_result r = p->type == PARAM_CHOICE ? param_set_choice(&l->source.kind->table, l->source.data, "test",
                                                 key, p->choices[(int)value], &err)
                                           : param_set(&l->source.kind->table, l->source.data, "test", key, v,
                                                 param_components(p), &err);
    if (r != CAU_OK) fail_msg("%s", err.text);
}

cau_result try_lamp(Lamp *l, CauError *err) {
    Affine m = l->to_scene;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) m.m[i][j] *= l->units_per_m;
    l->light = (Light){.kind = l->source.kind, .name = "lamp", .layer = "lamp", .casts = true};
    return l->light.kind->prepare(&l->source, &m, square(l->units_per_m), &l->light, "lights.lamp", err);
}

void place_lamp(Lamp *l, const Affine *to_world, double units_per_m) {
    CauError err = {0};
    l->to_scene = *to_world;
    l->units_per_m = units_per_m;
    if (try_lamp(l, &err) != CAU_OK) fail_msg("%s", err.text);
}

Lamp make_lamp(const char *kind, ...) {
    Lamp l = {.source = {.kind = light_find(kind)}, .units_per_m = 1.0};
    const ParamTable *table = &l.source.kind->table;
    param_defaults(table, l.source.data);
    for (size_t i = 0; i < table->count; i++)
        if (table->params[i].flags & PARAM_REQUIRED)
            set(&l, table->params[i].name, table->params[i].type == PARAM_CHOICE ? 0.0 : 1.0);
    snprintf(l.label, sizeof l.label, "%s", kind);
    va_list args;
    va_start(args, kind);
    for (const char *key; (key = va_arg(args, const char *));) {
        double value = va_arg(args, double);
        set(&l, key, value);
        size_t n = strlen(l.label);
        snprintf(l.label + n, sizeof l.label - n, " %s=%g", key, value);
    }
    va_end(args);
    Affine id = affine_identity();
    place_lamp(&l, &id, 1.0);
    return l;
}

V3 unit_vector(Rng *rng) {
    double z = 2.0 * rng_next(rng) - 1.0, phi = 2.0 * CAU_PI * rng_next(rng), s = sqrt(1.0 - z * z);
    return v3(s * cos(phi), s * sin(phi), z);
}

Affine random_pose(Rng *rng, double scale) {
    V3 n = unit_vector(rng), s, t, p = v3_scale(unit_vector(rng), 3.0 * rng_next(rng));
    v3_frame(n, &s, &t);
    Affine a = {{{s.x, t.x, n.x, 0}, {s.y, t.y, n.y, 0}, {s.z, t.z, n.z, 0}}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) a.m[i][j] *= scale;
    a.m[0][3] = p.x;
    a.m[1][3] = p.y;
    a.m[2][3] = p.z;
    return a;
}

void for_each_lamp(void (*visit)(const Lamp *l, Rng *rng)) {
    Rng rng = rng_make(SEED);
    Lamp lamps[] = {
        make_lamp("sun", "strength", 3.0, "angle_deg", 0.0, NULL),
        make_lamp("sun", "strength", 3.0, "angle_deg", 0.5, NULL),
        make_lamp("sun", "strength", 3.0, "angle_deg", 90.0, NULL),
        make_lamp("sun", "strength", 3.0, "angle_deg", 180.0, NULL),
        make_lamp("world", "strength", 2.0, NULL),
        make_lamp("point", "power_w", 100.0, NULL),
        make_lamp("point", "power_w", 100.0, "radius_m", 0.01, NULL),
        make_lamp("point", "power_w", 100.0, "radius_m", 0.5, NULL),
        make_lamp("spot", "power_w", 100.0, "cone_deg", 60.0, "blend", 0.0, NULL),
        make_lamp("spot", "power_w", 100.0, "cone_deg", 170.0, "blend", 1.0, NULL),
        make_lamp("spot", "power_w", 100.0, "cone_deg", 60.0, "radius_m", 0.3, NULL),
        make_lamp("spot", "power_w", 100.0, "cone_deg", 180.0, "radius_m", 0.1, NULL),
        make_lamp("spot", "power_w", 100.0, "cone_deg", 90.0, "radius_m", 0.1, "falloff", 1.0, NULL),
        make_lamp("area", "power_w", 100.0, "size", 0.1, NULL),
        make_lamp("area", "power_w", 100.0, "size", 2.0, NULL),
        make_lamp("area", "power_w", 100.0, "size", 1.0, "shape", 1.0, NULL),
        make_lamp("area", "power_w", 100.0, "size", 1.0, "spread_deg", 120.0, NULL),
        make_lamp("area", "power_w", 100.0, "size", 1.0, "shape", 1.0, "spread_deg", 60.0, NULL),
    };
    for (size_t i = 0; i < sizeof lamps / sizeof *lamps; i++)
        for (int pose = 0; pose < 3; pose++) {
            Affine a = random_pose(&rng, pose == 1 ? 0.7 : 1.0);
            if (pose == 2) /* mirrored and sheared */
                for (int k = 0; k < 3; k++) a.m[k][0] = 0.4 * a.m[k][1] - 1.3 * a.m[k][0];
            place_lamp(&lamps[i], &a, pose == 0 ? 1.0 : 2.5);
            size_t n = strlen(lamps[i].label);
            snprintf(lamps[i].label + n, sizeof lamps[i].label - n, " pose %d", pose);
            visit(&lamps[i], &rng);
            lamps[i].label[n] = '\0';
        }
}

V3 lit_point(const Lamp *l, double distance, Rng *rng) {
    const Light *light = &l->light;
    V3 s, t;
    v3_frame(light->n, &s, &t);
    double d = distance * l->units_per_m, x = 0.3 * (2.0 * rng_next(rng) - 1.0),
           y = 0.3 * (2.0 * rng_next(rng) - 1.0);
    return v3_add(light->position, v3_scale(v3_from_frame(v3(x, y, 1.0), s, t, light->n), d));
}

void expect_true(const Lamp *l, const char *what, bool ok) {
    if (!ok) fail_msg("%s (seed %d): %s", l ? l->label : "", SEED, what);
}

void expect_near(const Lamp *l, const char *what, double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance))
        fail_msg("%s (seed %d): %s is %.12g, not %.12g +- %g", l ? l->label : "", SEED, what, got, want,
            tolerance);
}

double irradiance(const Light *l, V3 p, V3 n, int per_axis) {
    double sum = 0.0;
    for (int i = 0; i < per_axis; i++)
        for (int j = 0; j < per_axis; j++) {
            LightSample s;
            if (!l->kind->sample(l, p, (i + 0.5) / per_axis, (j + 0.5) / per_axis, &s)) continue;
            sum += s.value.g * fmax(0.0, v3_dot(s.dir, n)) / s.pdf;
        }
    return sum / ((double)per_axis * per_axis);
}

double emitted_flux(const Light *l, int per_axis, Rng *rng) {
    double sum = 0.0;
    for (int i = 0; i < per_axis; i++)
        for (int j = 0; j < per_axis; j++) {
            EmitStart start;
            V3 dir;
            l->kind->emit_start(l, rng_next(rng), rng_next(rng), &start);
            double u = (i + rng_next(rng)) / per_axis, v = (j + rng_next(rng)) / per_axis;
            double pdf = l->kind->emit_direction(l, &start, u, v, &dir);
            if (pdf > 0.0) sum += l->kind->emit(l, &start, dir).g / (start.pdf * pdf);
        }
    return sum / ((double)per_axis * per_axis);
}
