/* SPDX-License-Identifier: Apache-2.0 */
/* Brightness: what Cycles 3.4.1 was measured to make of the same lights (figures with their digits from
 * renders of 256 samples), and what the definitions say. */
#include "lamps.h"

#include <math.h>

static double seen(const Lamp *l, V3 from) {
    LightSample s;
    V3 dir = v3_normalize(v3_sub(l->light.position, from));
    return l->light.kind->hit(&l->light, from, dir, &s) ? s.value.g : 0.0;
}

static const V3 UP = {0, 0, 1};

static void figures_measured_in_cycles(void **state) {
    (void)state;
    V3 below = v3(0, 0, -2), aside = v3(0, -0.5, -4);
    Lamp sun = make_lamp("sun", "strength", 3.0, "angle_deg", 0.5, NULL);
    expect_near(&sun, "irradiance", irradiance(&sun.light, below, UP, 16), 2.99985, 2e-4);
    expect_near(
        &sun, "tilted 60", irradiance(&sun.light, below, v3(sin(CAU_PI / 3), 0, 0.5), 16), 1.49995, 1e-4);
    Lamp world = make_lamp("world", "strength", 1.0, NULL);
    expect_near(&world, "irradiance", irradiance(&world.light, below, UP, 400), 3.14154, 1e-3);
    Lamp point = make_lamp("point", "power_w", 100.0, NULL);
    expect_near(&point, "irradiance", irradiance(&point.light, below, UP, 1), 1.98934, 1e-4);
    Lamp ball = make_lamp("point", "power_w", 100.0, "radius_m", 0.1, NULL);
    expect_near(&ball, "radiance", seen(&ball, v3(0, -4, 0)), 253.30444, 3e-3);
    Lamp spot = make_lamp("spot", "power_w", 100.0, "radius_m", 0.1, "cone_deg", 60.0, "blend", 0.0, NULL);
    expect_near(&spot, "radiance at 7.125 degrees", seen(&spot, aside), 251.34657, 3e-3);
    Lamp even = make_lamp(
        "spot", "power_w", 100.0, "radius_m", 0.1, "cone_deg", 60.0, "blend", 0.0, "falloff", 1.0, NULL);
    expect_near(&even, "radiance at 7.125 degrees in 4.2", seen(&even, aside), 253.30444, 3e-3);
    for (double blend = 0.0; blend < 0.2; blend += 0.15) {
        Lamp axis = make_lamp("spot", "power_w", 100.0, "cone_deg", 60.0, "blend", blend, NULL);
        expect_near(&axis, "irradiance on the axis", irradiance(&axis.light, below, UP, 1), 1.98934, 1e-4);
    }
}

static void areas_measured_in_cycles(void **state) {
    (void)state;
    V3 below = v3(0, 0, -2), aside = v3(0, -0.5, -4);
    Lamp square = make_lamp("area", "power_w", 100.0, "size", 0.1, NULL);
    expect_near(&square, "irradiance", irradiance(&square.light, below, UP, 16), 6.24424, 1e-3);
    expect_near(&square, "radiance", seen(&square, aside), 2500.0, 1e-9);
    expect_near(&square, "from behind", seen(&square, v3(0, -0.5, 4)), 0.0, 0.0);
    Lamp disk = make_lamp("area", "power_w", 100.0, "size", 0.1, "shape", 1.0, NULL);
    expect_near(&disk, "radiance", seen(&disk, aside), 3183.1, 0.01);
    Lamp narrow = make_lamp("area", "power_w", 100.0, "size", 0.1, "spread_deg", 60.0, NULL);
    expect_near(&narrow, "radiance", seen(&narrow, aside), 21038.775, 0.5);
    Lamp rect = make_lamp("area", "power_w", 100.0, "size", 0.2, NULL);
    Affine wide = affine_identity();
    wide.m[0][0] = 2.0;
    place_lamp(&rect, &wide, 1.0);
    expect_near(&rect, "radiance, scaled to .4 by .2", seen(&rect, aside), 312.5, 1e-9);
}

/* Row 9: irradiance is E for every angle, where 1 - cos would be wrong or zero. */
static void sun_is_exact_at_every_angle(void **state) {
    (void)state;
    for (double angle = 180.0; angle > 1e-9; angle *= 0.6) {
        Lamp sun = make_lamp("sun", "strength", 3.0, "angle_deg", angle, NULL);
        expect_near(&sun, "irradiance", irradiance(&sun.light, v3(0, 0, 0), UP, 200), 3.0, 3e-4);
    }
}

static void balls_keep_their_irradiance(void **state) {
    (void)state;
    for (double r = 1.9; r > 1e-7; r *= 0.3) {
        Lamp ball = make_lamp("point", "power_w", 100.0, "radius_m", r, NULL);
        double want = 100.0 / (4.0 * CAU_PI * 4.0);
        if (r < 1.0)
            expect_near(
                &ball, "irradiance", irradiance(&ball.light, v3(0, 0, -2), UP, 200), want, 2e-4 * want);
        LightSample s;
        expect_true(
            &ball, "no light inside", !ball.light.kind->sample(&ball.light, v3(0, 0, 0.9 * r), 0.5, 0.5, &s));
    }
}

/* Spread narrows and keeps the flux, down to a fraction of a degree. */
static void spread_keeps_the_flux(void **state) {
    (void)state;
    Rng rng = rng_make(5);
    for (double spread = 180.0; spread > 0.01; spread *= 0.55)
        for (double shape = 0.0; shape < 2.0; shape += 1.0) {
            Lamp l = make_lamp("area", "power_w", 100.0, "spread_deg", spread, "shape", shape, NULL);
            expect_near(&l, "flux", emitted_flux(&l.light, 200, &rng), 25.0 * CAU_PI, 0.1);
        }
}

/* Flux of a spot by quadrature over its cone. */
static double spot_share(double cone_deg, double blend) {
    double ch = cos(0.5 * cone_deg * CAU_PI / 180.0), sum = 0.0;
    const int n = 20000;
    for (int i = 0; i < n; i++) {
        double c = ch + (1.0 - ch) * (i + 0.5) / n, t = blend > 0.0 ? (c - ch) / ((1.0 - ch) * blend) : 1.0;
        t = clamp(t, 0.0, 1.0);
        sum += c * t * t * (3.0 - 2.0 * t);
    }
    return 0.5 * (1.0 - ch) * sum / n;
}

static void flux_is_what_the_definition_says(void **state) {
    (void)state;
    Rng rng = rng_make(6);
    for (double r = 0.0; r < 0.5; r += 0.2) {
        Lamp point = make_lamp("point", "power_w", 100.0, "radius_m", r, NULL);
        expect_near(&point, "flux", emitted_flux(&point.light, 300, &rng), 100.0, 0.1);
        for (double cone = 20.0; cone < 180.0; cone += 70.0)
            for (double blend = 0.0; blend < 1.0; blend += 0.45) {
                Lamp spot = make_lamp(
                    "spot", "power_w", 100.0, "radius_m", r, "cone_deg", cone, "blend", blend, NULL);
                double want = 100.0 * spot_share(cone, blend);
                expect_near(&spot, "flux", emitted_flux(&spot.light, 400, &rng), want, 0.01 * want);
            }
    }
}

/* In a scene of other units the irradiance is the same and the flux is scaled. */
static void units_of_length_do_not_matter(const Lamp *l, Rng *rng) {
    if (l->light.infinite) return;
    V3 p = v3_add(l->light.position, v3_scale(l->light.n, 3.0 * l->units_per_m));
    double here = irradiance(&l->light, p, v3_neg(l->light.n), 100), flux = emitted_flux(&l->light, 100, rng);
    Lamp other = *l;
    place_lamp(&other, &l->to_scene, 1e-3);
    p = v3_add(other.light.position, v3_scale(other.light.n, 3e-3));
    expect_near(l, "irradiance", irradiance(&other.light, p, v3_neg(other.light.n), 100), here, 1e-3 * here);
    double scaled = emitted_flux(&other.light, 100, rng) * square(l->units_per_m / 1e-3);
    expect_near(l, "flux", scaled, flux, 0.05 * flux);
}

static void scene_units(void **state) {
    (void)state;
    for_each_lamp(units_of_length_do_not_matter);
}

static void colors_multiply(const Lamp *l, Rng *rng) {
    Lamp red = *l;
    double color[3] = {1.0, 0.5, 0.0};
    assert_int_equal(
        param_set(&red.source.kind->table, red.source.data, "t", "color", color, 3, NULL), CAU_OK);
    place_lamp(&red, &l->to_scene, l->units_per_m);
    V3 p = lit_point(l, 3.0, rng);
    LightSample a, b;
    bool ok = l->light.kind->sample(&l->light, p, 0.4, 0.6, &a),
         ok2 = red.light.kind->sample(&red.light, p, 0.4, 0.6, &b);
    expect_true(l, "same light", ok == ok2);
    if (!ok) return;
    expect_near(l, "red", b.value.r, a.value.r, 1e-12 * a.value.r);
    expect_near(l, "green", b.value.g, 0.5 * a.value.g, 1e-12 * a.value.g);
    expect_near(l, "blue", b.value.b, 0.0, 0.0);
}

static void color_multiplies_every_light(void **state) {
    (void)state;
    for_each_lamp(colors_multiply);
}

static void bad_lights_are_told(void **state) {
    (void)state;
    CauError err = {0};
    Lamp area = make_lamp("area", NULL);
    double zero[2] = {0.0, 1.0}, negative = -1.0;
    const ParamTable *table = &area.source.kind->table;
    assert_int_equal(param_set(table, area.source.data, "area", "size", zero, 2, &err), CAU_ERROR_INPUT);
    error_clear(&err);
    assert_int_equal(
        param_set(table, area.source.data, "area", "power_w", &negative, 1, &err), CAU_ERROR_INPUT);
    error_clear(&err);
    for (int k = 0; k < 3; k++) area.to_scene.m[k][1] = area.to_scene.m[k][0];
    assert_int_equal(try_lamp(&area, &err), CAU_ERROR_INPUT);
    error_clear(&err);
    Lamp sun = make_lamp("sun", NULL);
    for (int k = 0; k < 3; k++) sun.to_scene.m[k][2] = 0.0;
    assert_int_equal(try_lamp(&sun, &err), CAU_ERROR_INPUT);
    error_clear(&err);
    Lamp tiny = make_lamp("sun", "angle_deg", 1.0, NULL);
    double angle = 1e-170;
    assert_int_equal(
        param_set(&tiny.source.kind->table, tiny.source.data, "s", "angle_deg", &angle, 1, &err), CAU_OK);
    assert_int_equal(try_lamp(&tiny, &err), CAU_ERROR_INPUT);
}

int run_unit_tests(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(figures_measured_in_cycles),
        cmocka_unit_test(areas_measured_in_cycles),
        cmocka_unit_test(sun_is_exact_at_every_angle),
        cmocka_unit_test(balls_keep_their_irradiance),
        cmocka_unit_test(spread_keeps_the_flux),
        cmocka_unit_test(flux_is_what_the_definition_says),
        cmocka_unit_test(scene_units),
        cmocka_unit_test(color_multiplies_every_light),
        cmocka_unit_test(bad_lights_are_told),
    };
    return cmocka_run_group_tests_name("brightness", tests, NULL, NULL);
}
