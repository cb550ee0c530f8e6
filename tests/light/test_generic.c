/* SPDX-License-Identifier: Apache-2.0 */
/* What must hold for every kind of light: its ways of giving light agree with each other. */
#include "lamps.h"

#include <math.h>

static const double distances[] = {0.55, 1.0, 4.0, 50.0};
#define DISTANCES (sizeof distances / sizeof *distances)

static void hit_agrees(const Lamp *l, Rng *rng) {
    const LightKind *kind = l->light.kind;
    int drawn = 0;
    for (size_t k = 0; k < DISTANCES; k++)
        for (int i = 0; i < 300; i++) {
            V3 p = lit_point(l, distances[k], rng);
            LightSample s, h;
            /* Off the rim, where rounding decides. */
            double u = 1e-6 + (1 - 2e-6) * rng_next(rng), v = 1e-6 + (1 - 2e-6) * rng_next(rng);
            if (!kind->sample(&l->light, p, u, v, &s)) continue;
            expect_near(l, "length of the direction", v3_length(s.dir), 1.0, 1e-9);
            expect_true(
                l, "finite", rgb_finite(s.value) && isfinite(s.pdf) && s.pdf > 0.0 && s.distance > 0.0);
            expect_true(l, "infinite", isinf(s.distance) == l->light.infinite);
            bool ok = kind->hit && kind->hit(&l->light, p, s.dir, &h);
            expect_true(l, "a drawn direction hits the light, unless it is a point", ok == !l->light.delta);
            if (!ok) continue;
            drawn++;
            /* A spot's soft edge magnifies the rounding of the direction. */
            expect_near(l, "value", h.value.g, s.value.g, 1e-6 * s.value.g + 1e-9 * l->light.derived[1]);
            expect_near(l, "density", h.pdf / s.pdf, 1.0, 1e-9);
            if (!l->light.infinite) expect_near(l, "distance", h.distance / s.distance, 1.0, 1e-6);
        }
    expect_true(l, "some light reaches the points", l->light.delta || drawn > 0);
}

static void sample_and_hit_agree(void **state) {
    (void)state;
    for_each_lamp(hit_agrees);
}

/* The density against the map: pdf times the area that (u, v) spans on the sphere is 1. */
static void map_density(const Lamp *l, Rng *rng) {
    if (l->light.delta) return;
    const double h = 1e-5;
    for (size_t k = 0; k < DISTANCES; k++)
        for (int i = 0; i < 40; i++) {
            V3 p = lit_point(l, distances[k], rng);
            double u = 0.05 + 0.9 * rng_next(rng), v = 0.05 + 0.9 * rng_next(rng);
            if (fabs(fabs(2 * u - 1) - fabs(2 * v - 1)) < 1e-3) continue;
            LightSample s, a, b, c, d;
            bool (*draw)(const Light *, V3, double, double, LightSample *) = l->light.kind->sample;
            if (!draw(&l->light, p, u, v, &s) || !draw(&l->light, p, u + h, v, &a) ||
                !draw(&l->light, p, u - h, v, &b) || !draw(&l->light, p, u, v + h, &c) ||
                !draw(&l->light, p, u, v - h, &d))
                continue;
            V3 span = v3_cross(v3_sub(a.dir, b.dir), v3_sub(c.dir, d.dir));
            expect_near(l, "density times area", s.pdf * v3_length(span) / (4 * h * h), 1.0, 1e-3);
        }
}

static void density_is_that_of_the_map(void **state) {
    (void)state;
    for_each_lamp(map_density);
}

/* Irradiance by rays that happen to hit the light: nothing of it lies outside what sample() draws. */
static void blind_rays(const Lamp *l, Rng *rng) {
    if (l->light.delta) return;
    V3 p = lit_point(l, 0.6, rng), n = v3_neg(l->light.n);
    double sum = 0.0, sum2 = 0.0;
    const int count = 60000;
    for (int i = 0; i < count; i++) {
        V3 dir = unit_vector(rng);
        LightSample s;
        double x = l->light.kind->hit(&l->light, p, dir, &s)
                       ? s.value.g * fmax(0.0, v3_dot(dir, n)) * 4 * CAU_PI
                       : 0;
        sum += x;
        sum2 += x * x;
    }
    double mean = sum / count, error = sqrt(fmax(0.0, sum2 / count - mean * mean) / count);
    double want = irradiance(&l->light, p, n, 200);
    if (!(mean > 0.0) || error > 0.1 * want) return; /* too small a light to be met by chance */
    expect_near(l, "irradiance by chance hits", mean, want, 4.5 * error + 2e-3 * want);
}

static void nothing_is_missed(void **state) {
    (void)state;
    for_each_lamp(blind_rays);
}

/* Irradiance from the emitting side: by points of the light (or directions of travel) and emit(). */
static void emission(const Lamp *l, Rng *rng) {
    const LightKind *kind = l->light.kind;
    V3 p = lit_point(l, 1.5, rng), n = v3_neg(l->light.n);
    double sum = 0.0, sum2 = 0.0;
    const int count = 60000;
    for (int i = 0; i < count; i++) {
        EmitStart start;
        kind->emit_start(&l->light, rng_next(rng), rng_next(rng), &start);
        V3 to = l->light.infinite ? start.dir : v3_sub(p, start.position);
        double d2 = l->light.infinite ? 1.0 : v3_dot(to, to);
        V3 dir = v3_scale(to, 1.0 / sqrt(v3_dot(to, to)));
        double x = kind->emit(&l->light, &start, dir).g * fmax(0.0, -v3_dot(dir, n)) / (d2 * start.pdf);
        sum += x;
        sum2 += x * x;
    }
    double mean = sum / count, error = sqrt(fmax(0.0, sum2 / count - mean * mean) / count);
    double want = irradiance(&l->light, p, n, 200);
    expect_near(l, "irradiance by emission", mean, want, 4.5 * error + 3e-3 * want);
}

static void emission_and_sample_agree(void **state) {
    (void)state;
    for_each_lamp(emission);
}

/* emit_direction() covers all that emit() emits to, with the density that emit_direction_pdf() gives. */
static void directions(const Lamp *l, Rng *rng) {
    const LightKind *kind = l->light.kind;
    expect_true(l, "finite lights draw directions",
        l->light.infinite ? !kind->emit_direction : kind->emit_direction && kind->emit_direction_pdf);
    if (l->light.infinite) return;
    double total = 0.0;
    const int count = 20000;
    for (int i = 0; i < count; i++) {
        EmitStart start;
        V3 dir;
        kind->emit_start(&l->light, rng_next(rng), rng_next(rng), &start);
        expect_true(l, "start", v3_finite(start.position) && start.pdf > 0.0);
        double pdf = kind->emit_direction(&l->light, &start, rng_next(rng), rng_next(rng), &dir);
        expect_near(l, "length", v3_length(dir), 1.0, 1e-9);
        if (!rgb_black(kind->emit(&l->light, &start, dir)))
            expect_near(l, "density", kind->emit_direction_pdf(&l->light, &start, dir) / pdf, 1.0, 1e-6);
        dir = unit_vector(rng);
        pdf = kind->emit_direction_pdf(&l->light, &start, dir);
        total += 4 * CAU_PI * pdf / count;
        if (!rgb_black(kind->emit(&l->light, &start, dir))) expect_true(l, "covered", pdf > 0.0);
    }
    expect_near(l, "integral of the density", total, 1.0, 0.1);
}

static void emitted_directions_are_covered(void **state) {
    (void)state;
    for_each_lamp(directions);
}

/* Anything may be asked of a light. */
static void fuzz(const Lamp *l, Rng *rng) {
    const LightKind *kind = l->light.kind;
    static const double edges[] = {0.0, 1.0 - 0x1p-53, 0.5, 0x1p-53};
    for (int i = 0; i < 2000; i++) {
        double scale = pow(10.0, 12.0 * rng_next(rng) - 8.0);
        V3 p = i % 50 == 0 ? l->light.position : v3_mad(l->light.position, scale, unit_vector(rng)), dir;
        double u = i % 3 ? rng_next(rng) : edges[i % 4], v = i % 5 ? rng_next(rng) : edges[i / 4 % 4];
        LightSample s;
        if (kind->sample(&l->light, p, u, v, &s))
            expect_true(l, "finite sample",
                rgb_finite(s.value) && isfinite(s.pdf) && s.pdf > 0 && v3_finite(s.dir) && s.distance > 0);
        if (kind->hit && kind->hit(&l->light, p, unit_vector(rng), &s))
            expect_true(
                l, "finite hit", rgb_finite(s.value) && isfinite(s.pdf) && s.pdf > 0 && s.distance > 0);
        EmitStart start;
        kind->emit_start(&l->light, u, v, &start);
        expect_true(l, "finite start", v3_finite(start.position) && v3_finite(start.dir) && start.pdf > 0);
        expect_true(l, "finite emission", rgb_finite(kind->emit(&l->light, &start, unit_vector(rng))));
        if (kind->emit_direction)
            expect_true(l, "finite direction",
                isfinite(kind->emit_direction(&l->light, &start, u, v, &dir)) && v3_finite(dir));
    }
}

static void nothing_is_ever_nan(void **state) {
    (void)state;
    for_each_lamp(fuzz);
}

static void kinds_are_complete(void **state) {
    (void)state;
    size_t n;
    const LightKind *const *kinds = light_kinds(&n);
    assert_true(n >= 5);
    for (size_t k = 0; k < n; k++) {
        const LightKind *kind = kinds[k];
        assert_ptr_equal(light_find(kind->name), kind);
        assert_true(kind->prepare && kind->sample && kind->emit_start && kind->emit &&
                    kind->data_size <= LIGHT_DATA_MAX);
        assert_string_equal(kind->table.params[0].name, "color");
        assert_int_equal(kind->table.params[0].offset, 0);
        for (size_t i = 0; i < kind->table.count; i++) {
            const Param *p = &kind->table.params[i];
            assert_true(p->help && p->unit && p->offset + param_components(p) * 8 <= kind->data_size);
        }
    }
    assert_null(light_find("mesh"));
}

int run_generic_tests(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kinds_are_complete),
        cmocka_unit_test(sample_and_hit_agree),
        cmocka_unit_test(density_is_that_of_the_map),
        cmocka_unit_test(nothing_is_missed),
        cmocka_unit_test(emission_and_sample_agree),
        cmocka_unit_test(emitted_directions_are_covered),
        cmocka_unit_test(nothing_is_ever_nan),
    };
    return cmocka_run_group_tests_name("every light", tests, NULL, NULL);
}
