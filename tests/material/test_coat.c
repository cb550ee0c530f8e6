/* SPDX-License-Identifier: Apache-2.0 */
/* Plastic: the table of its coat's albedo, and the choice between its lobes. */
#include "cases.h"

#include "render/material/coat.h"
#include "render/material/fresnel.h"

#include <math.h>

/* Reflected share by a fine lattice through sample(). */
static double reflected(const Material *m, const ShadingFrame *f, V3 wi) {
    enum { POINTS = 4181, STEP = 2584 };
    double sum = 0.0;
    for (int i = 0; i < POINTS; i++) {
        double u[3] = {(i + 0.5) / POINTS, (double)((long)i * STEP % POINTS) / POINTS, 0.5};
        ScatterSample s;
        if (m->kind->sample(m, f, wi, u, LOBE_GLOSSY, false, &s)) sum += s.weight.g;
    }
    return sum / POINTS;
}

/* Between the nodes of the table too. */
static void coat_table_is_accurate(void **state) {
    (void)state;
    Rng rng = rng_make(11);
    const double roughness[] = {0.0101, 0.03, 0.1, 0.3, 0.6, 1.0}, specular[] = {0.0, 0.5, 1.0};
    for (size_t i = 0; i < 6; i++)
        for (size_t k = 0; k < 6; k++) {
            Material m =
                make_material("plastic", "roughness", roughness[i], "specular", specular[k % 3], NULL);
            CauError err = {0};
            if (k >= 3) param_set_choice(&m.kind->table, m.data, "test", "fresnel", "dielectric", &err);
            assert_int_equal(err.text[0], 0);
            m.kind->prepare(&m);
            ShadingFrame f = make_frame(&rng, true, 0.0);
            for (double c = 1.0; c > 1e-3; c *= 0.77) {
                V3 wi = direction_at(&f, c, &rng);
                double e = 1.0 - m.kind->albedo(&m, &f, wi).g;
                expect_near(NULL, "directional albedo", e, reflected(&m, &f, wi), 1e-3);
            }
        }
}

static void smooth_coat_is_schlick(void **state) {
    (void)state;
    Coat coat;
    coat_prepare(&coat, 0.04, false, 0.0);
    for (double c = 0.0; c <= 1.0; c += 0.01)
        expect_near(NULL, "E", coat_albedo(&coat, c), schlick(0.04, c), 1e-15);
}

static void smooth_dielectric_coat_is_fresnel(void **state) {
    (void)state;
    Coat coat;
    coat_prepare(&coat, 0.04, true, 0.0);
    for (double c = 0.0; c <= 1.0; c += 0.01)
        expect_near(NULL, "E", coat_albedo(&coat, c), fresnel_dielectric(c, 1.5).reflectance, 1e-14);
    coat_prepare(&coat, 0.0, true, 0.0); /* specular 0: nothing is there */
    expect_near(NULL, "E", coat_albedo(&coat, 0.5), 0.0, 1e-15);
}

/* One lobe asked for: no weight of a choice. Both: the same energy per lobe. */
static void masks_do_not_change_the_light(const Case *c, Rng *rng) {
    if ((c->m.lobes & LOBE_DIFFUSE) == 0 || (c->m.lobes & LOBE_CASTING) == 0) return;
    for (int i = 0; i < 4; i++) {
        ShadingFrame f = make_frame(rng, true, 0.0);
        V3 wi = direction_at(&f, 0.05 + 0.3 * i, rng);
        Shares both = sample_shares(&c->m, &f, wi, LOBE_ALL, 6, 2000);
        Shares base = sample_shares(&c->m, &f, wi, LOBE_DIFFUSE, 6, 1);
        Shares coat = sample_shares(&c->m, &f, wi, LOBE_CASTING, 6, 1);
        expect_true(c, "only the base", rgb_black(base.reflected) && rgb_black(coat.diffuse));
        expect_near(c, "base", both.diffuse.g, base.diffuse.g, 0.004 * base.diffuse.g + 1e-9);
        expect_near(c, "coat", both.reflected.g, coat.reflected.g, 0.03 * coat.reflected.g);
    }
}

static void lobes_can_be_masked(void **state) {
    (void)state;
    for_each_case(masks_do_not_change_the_light);
}

int run_coat_tests(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coat_table_is_accurate),
        cmocka_unit_test(smooth_coat_is_schlick),
        cmocka_unit_test(smooth_dielectric_coat_is_fresnel),
        cmocka_unit_test(lobes_can_be_masked),
    };
    return cmocka_run_group_tests_name("coat", tests, NULL, NULL);
}
