/* SPDX-License-Identifier: Apache-2.0 */
/* Fresnel and glass: the cases where the textbook formula goes wrong. */
#include "cases.h"

#include "render/material/fresnel.h"

#include <math.h>

/* Against the textbook's sum of s and p, in a range where it is sound. */
static void fresnel_matches_the_textbook(void **state) {
    (void)state;
    for (double eta = 0.5; eta < 3.0; eta += 0.23)
        for (double c = 0.05; c <= 1.0; c += 0.05) {
            double sin_t = sqrt(1.0 - c * c) / eta;
            if (sin_t >= 0.999) continue;
            double ct = cos(asin(sin_t)), s = (c - eta * ct) / (c + eta * ct),
                   p = (ct - eta * c) / (ct + eta * c);
            Fresnel f = fresnel_dielectric(c, eta);
            expect_near(NULL, "reflectance", f.reflectance, 0.5 * (s * s + p * p), 1e-12);
            expect_near(NULL, "cosine", f.cos_t, ct, 1e-12);
        }
    expect_near(NULL, "ior 1.5 straight on", fresnel_dielectric(1.0, 1.5).reflectance, 0.04, 1e-15);
}

/* No interface, no reflection, at any angle: the usual form says 1 at grazing angles. */
static void no_interface_reflects_nothing(void **state) {
    (void)state;
    for (double c = 1.0; c > 1e-12; c *= 0.7) {
        Fresnel f = fresnel_dielectric(c, 1.0);
        assert_true(f.reflectance == 0.0);
        expect_near(NULL, "cosine", f.cos_t, c, 4e-16 * c);
    }
    for (double d = 1e-3; d > 1e-13; d *= 0.1) {
        assert_true(fresnel_dielectric(0.5, 1.0 + d).reflectance < 16.0 * d * d);
        assert_true(fresnel_dielectric(0.5, 1.0 - d).reflectance < 16.0 * d * d);
    }
}

static void ior_one_moves_nothing(void **state) {
    (void)state;
    Rng rng = rng_make(7);
    for (double roughness = 0.0; roughness < 1.0; roughness += 0.45) {
        Material m = make_material("glass", "ior", 1.00005, "roughness", roughness, NULL);
        assert_int_equal(m.lobes, LOBE_SPECULAR);
        for (int i = 0; i < 100; i++) {
            ShadingFrame f = make_frame(&rng, i & 1, 0.0);
            V3 wi = direction_at(&f, rng_next(&rng), &rng);
            double u[3];
            random_u(&rng, u);
            ScatterSample s;
            assert_true(m.kind->sample(&m, &f, wi, u, LOBE_ALL, false, &s));
            assert_true(s.wo.x == -wi.x && s.wo.y == -wi.y && s.wo.z == -wi.z && s.transmit && s.eta == 1.0);
            assert_true(s.lobe == LOBE_SPECULAR && s.weight.g == 1.0);
        }
    }
    Material near = make_material("glass", "ior", 1.00011, NULL);
    ShadingFrame f = make_frame(&rng, true, 0.0);
    V3 wi = direction_at(&f, 0.7, &rng);
    ScatterSample s;
    assert_true(near.kind->sample(&near, &f, wi, (double[]){0.5, 0.5, 0.5}, LOBE_ALL, false, &s));
    assert_true(v3_length(v3_add(s.wo, wi)) < 3e-4);
}

/* A few ulps round the critical angle: finite, monotone, R + T = 1, and sample() agrees with the decision. */
static void total_reflection_is_decided_once(void **state) {
    (void)state;
    const double iors[] = {1.0002, 1.1, 1.33, 1.5, 2.4, 9.9};
    Rng rng = rng_make(8);
    for (size_t k = 0; k < sizeof iors / sizeof *iors; k++) {
        Material m = make_material("glass", "ior", iors[k], NULL);
        double eta = 1.0 / iors[k], c = sqrt((1.0 - eta) * (1.0 + eta)), last = 2.0;
        for (int i = 0; i < 8; i++) c = nextafter(c, 0.0);
        for (int i = -8; i <= 8; i++, c = nextafter(c, 1.0)) {
            Fresnel f = fresnel_dielectric(c, eta);
            assert_true(f.reflectance >= 0.0 && f.reflectance <= 1.0 && isfinite(f.cos_t));
            assert_true((f.cos_t == 0.0) == (f.reflectance == 1.0));
            assert_true(f.reflectance <= last + 4e-16);
            last = f.reflectance;
            ShadingFrame frame = make_frame(&rng, false, 0.0);
            Shares s = sample_shares(&m, &frame, direction_at(&frame, c, &rng), LOBE_ALL, 1, 1000);
            expect_near(NULL, "R + T", s.total.g, 1.0, 1e-12);
        }
        assert_true(last < 1.0);
    }
}

/* Snell's law in the directions, and the index that the sample reports. */
static void refraction_obeys_snell(void **state) {
    (void)state;
    Rng rng = rng_make(9);
    for (int i = 0; i < 2000; i++) {
        double ior = 0.5 + 2.0 * rng_next(&rng);
        Material m = make_material("glass", "ior", ior, NULL);
        ShadingFrame f = make_frame(&rng, i & 1, 0.2 * (i & 2));
        V3 wi = direction_at(&f, 0.01 + 0.99 * rng_next(&rng), &rng);
        ScatterSample s;
        double u[3] = {0.5, 0.5, 1.0 - 0x1p-53};
        if (v3_dot(wi, f.ng) <= 0.0 || !m.kind->sample(&m, &f, wi, u, LOBE_ALL, i & 1, &s) || !s.transmit)
            continue;
        double eta = f.front ? ior : 1.0 / ior;
        expect_near(NULL, "eta", s.eta, eta, 1e-15);
        V3 k = v3_add(v3_cross(wi, f.ns), v3_scale(v3_cross(s.wo, f.ns), eta));
        expect_near(NULL, "tangential momentum", v3_length(k), 0.0, 1e-14 * (1.0 + eta));
    }
}

/* f(a, b) / n_b^2 is symmetric, for reflection and for transmission; not where facets give light back. */
static void reciprocal(const Case *c, Rng *rng) {
    if (!c->m.kind->eval || !(c->m.lobes & LOBE_GLOSSY) || (c->m.lobes & LOBE_DIFFUSE)) return;
    if (case_gives_back(c)) return;
    for (int i = 0; i < 300; i++) {
        ShadingFrame f = make_frame(rng, rng_next(rng) < 0.5, 0.0);
        V3 a = direction_at(&f, 0.05 + 0.95 * rng_next(rng), rng);
        double u[3], pa, pb;
        random_u(rng, u);
        ScatterSample s;
        if (!c->m.kind->sample(&c->m, &f, a, u, LOBE_ALL, false, &s)) continue;
        double ca = v3_dot(a, f.ns), cb = fabs(v3_dot(s.wo, f.ns));
        if (cb < 1e-3) continue;
        ShadingFrame g = frame_from(&f, s.transmit);
        double ab = c->m.kind->eval(&c->m, &f, a, s.wo, LOBE_ALL, &pa).g / cb;
        double ba = c->m.kind->eval(&c->m, &g, s.wo, a, LOBE_ALL, &pb).g / ca;
        expect_near(c, "reciprocity", ba * s.eta * s.eta, ab, 1e-4 * ab);
    }
}

static void rough_surfaces_are_reciprocal(void **state) {
    (void)state;
    for_each_case(reciprocal);
}

static Material multiple(double roughness, double ior, double grey) {
    Material m = make_material("glass", "roughness", roughness, "ior", ior, NULL);
    CauError err = {0};
    double color[3] = {grey, grey, grey};
    assert_int_equal(param_set_choice(&m.kind->table, m.data, "test", "facets", "multiple", &err), CAU_OK);
    assert_int_equal(param_set(&m.kind->table, m.data, "test", "color", color, 3, &err), CAU_OK);
    m.kind->prepare(&m);
    return m;
}

/* White rough glass in a white room is white, from both sides; tinted glass loses more to every meeting. */
static void facets_lose_nothing(void **state) {
    (void)state;
    const double roughness[] = {0.05, 0.3, 0.5, 1.0}, iors[] = {0.7, 1.2, 1.5, 2.4};
    Rng rng = rng_make(12);
    for (size_t i = 0; i < 16; i++) {
        Material white = multiple(roughness[i / 4], iors[i % 4], 1.0);
        Material grey = multiple(roughness[i / 4], iors[i % 4], 0.5);
        Material single = make_material("glass", "roughness", roughness[i / 4], "ior", iors[i % 4], NULL);
        for (double c = 1.0; c > 5e-3; c *= 0.6)
            for (int front = 0; front < 2; front++) {
                ShadingFrame f = make_frame(&rng, front, 0.0);
                V3 eye = direction_at(&f, c, &rng);
                Shares w = sample_shares(&white, &f, eye, LOBE_ALL, 48, 100);
                Shares g = sample_shares(&grey, &f, eye, LOBE_ALL, 48, 100);
                expect_near(NULL, "white", w.total.g, 1.0, 0.012);
                Shares once = sample_shares(&single, &f, eye, LOBE_ALL, 48, 100);
                expect_true(NULL, "grey", g.total.g < 0.503 && g.total.g > 0.5 * once.total.g - 0.003);
            }
    }
}

/* What GGX lost of light from 60 degrees at a roughness of 0.5, and gives back. */
static void facets_give_back_much(void **state) {
    (void)state;
    Rng rng = rng_make(13);
    Material single = make_material("glass", "roughness", 0.5, NULL), both = multiple(0.5, 1.5, 1.0);
    ShadingFrame f = make_frame(&rng, true, 0.0);
    V3 eye = direction_at(&f, 0.5, &rng);
    double lost = sample_shares(&single, &f, eye, LOBE_ALL, 48, 100).total.g;
    assert_true(lost < 0.97 && lost > 0.9);
    expect_near(NULL, "all", sample_shares(&both, &f, eye, LOBE_ALL, 48, 100).total.g, 1.0, 0.004);
}

static void limits_are_told(void **state) {
    (void)state;
    const MaterialKind *glass = material_find("glass");
    Material m = make_material("glass", NULL);
    CauError err = {0};
    double ior = 0.0, color[3] = {1.2, 1, 1};
    assert_int_equal(param_set(&glass->table, m.data, "glass", "ior", &ior, 1, &err), CAU_ERROR_INPUT);
    error_clear(&err);
    assert_int_equal(param_set(&glass->table, m.data, "glass", "color", color, 3, &err), CAU_ERROR_INPUT);
    const char *later[] = {"abbe", "absorption", "priority", "normal", "bump"};
    for (size_t i = 0; i < 5; i++) {
        error_clear(&err);
        assert_int_equal(
            param_set(&glass->table, m.data, "glass", later[i], &ior, 1, &err), CAU_ERROR_UNSUPPORTED);
    }
}

int run_glass_tests(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fresnel_matches_the_textbook),
        cmocka_unit_test(no_interface_reflects_nothing),
        cmocka_unit_test(ior_one_moves_nothing),
        cmocka_unit_test(total_reflection_is_decided_once),
        cmocka_unit_test(refraction_obeys_snell),
        cmocka_unit_test(rough_surfaces_are_reciprocal),
        cmocka_unit_test(facets_lose_nothing),
        cmocka_unit_test(facets_give_back_much),
        cmocka_unit_test(limits_are_told),
    };
    return cmocka_run_group_tests_name("glass", tests, NULL, NULL);
}
