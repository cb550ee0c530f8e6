/* SPDX-License-Identifier: Apache-2.0 */
/* Burley's lobe: its closed integrals against quadrature, and the split that receivers use. */
#include "cases.h"

#include "core/sampling.h"
#include "render/material/burley.h"

#include <math.h>

static const double roughness[] = {0.0, 0.3, 0.5, 1.0};

static V3 at(double z, double phi) {
    double s = sqrt(1.0 - z * z);
    return v3(s * cos(phi), s * sin(phi), z);
}

/* Midpoints in z^2 (by cosine) and in the angle around. */
static double mean_over_light(double r, V3 eye) {
    enum { N = 400, M = 48 };
    double sum = 0.0;
    for (int i = 0; i < N; i++)
        for (int k = 0; k < M; k++)
            sum += burley_lobe(r, at(sqrt((i + 0.5) / N), 2.0 * CAU_PI * (k + 0.5) / M), eye);
    return sum / (N * M);
}

static void albedo_is_the_integral(void **state) {
    (void)state;
    for (size_t i = 0; i < 4; i++)
        for (double z = 0.0; z <= 1.0; z += 0.125)
            expect_near(NULL, "albedo", burley_albedo(roughness[i], z),
                mean_over_light(roughness[i], at(z, 1.0)), 2e-4);
}

static void mean_is_the_integral(void **state) {
    (void)state;
    enum { N = 2000 };
    for (size_t i = 0; i < 4; i++) {
        double sum = 0.0;
        for (int k = 0; k < N; k++) sum += burley_albedo(roughness[i], sqrt((k + 0.5) / N));
        expect_near(NULL, "mean albedo", burley_mean_albedo(roughness[i]), sum / N, 2e-5);
    }
}

/* By hand from the paper's own form: F_D90 = 0.5 + 2 r cos^2 of the angle between light and half vector. */
static void lobe_is_the_papers(void **state) {
    (void)state;
    V3 a = at(0.3, 0.2), b = at(0.15, 2.0), h = v3_normalize(v3_add(a, b));
    double fd90 = 0.5 + 2.0 * 0.7 * square(v3_dot(a, h));
    double want = (1.0 + (fd90 - 1.0) * pow(0.7, 5)) * (1.0 + (fd90 - 1.0) * pow(0.85, 5));
    expect_near(NULL, "lobe", burley_lobe(0.7, a, b), want, 1e-12);
    expect_near(NULL, "the other way round", burley_lobe(0.7, b, a), want, 1e-12);
}

/* Light from everywhere: what receivers show of it, albedo times received, is all that the base sends. */
static void split_keeps_the_energy(void **state) {
    (void)state;
    enum { N = 4000 };
    for (size_t i = 0; i < 4; i++) {
        Material m = make_material("plastic", "roughness", roughness[i], NULL);
        CauError err = {0};
        param_set_choice(&m.kind->table, m.data, "test", "base", "burley", &err);
        m.kind->prepare(&m);
        ShadingFrame f = {.ng = {0, 0, 1}, .ns = {0, 0, 1}, .front = true};
        double sum = 0.0;
        for (int k = 0; k < N; k++) sum += material_received(&m, &f, at(sqrt((k + 0.5) / N), 0.0));
        expect_near(NULL, "received of light from everywhere", sum / N, 1.0, 2e-5);
        expect_near(
            NULL, "albedo", m.kind->albedo(&m, &f, at(0.4, 0.0)).g, burley_albedo(roughness[i], 0.4), 1e-12);
    }
}

int run_burley_tests(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(albedo_is_the_integral),
        cmocka_unit_test(mean_is_the_integral),
        cmocka_unit_test(lobe_is_the_papers),
        cmocka_unit_test(split_keeps_the_energy),
    };
    return cmocka_run_group_tests_name("burley", tests, NULL, NULL);
}
