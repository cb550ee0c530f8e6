/* SPDX-License-Identifier: Apache-2.0 */
/* What the plan gives to wavefronts. */
#include "render/analyse/plan.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

/* Costs as probed, of scenes in which forced renders showed the quicker estimator (bench/plan). */
static void smooth_casters_are_waved(void **state) {
    (void)state;
    const WaveCost ball = {34, 0.018}, superquadric = {124, 0.084}, gem = {77, 0.27}, untried = {0, 0};
    assert_true(plan_wave_pays(&ball));
    assert_true(plan_wave_pays(&superquadric));
    assert_true(plan_wave_pays(&gem));
    assert_true(plan_wave_pays(&untried));
}

static void dear_casters_are_photons(void **state) {
    (void)state;
    const WaveCost gem = {149, 0.38}, ring_of_facets = {55, 0.62}, rough_ball = {195, 0.99};
    assert_false(plan_wave_pays(&gem));
    assert_false(plan_wave_pays(&ring_of_facets));
    assert_false(plan_wave_pays(&rough_ball));
}

/* Foci of wide lamps are photons'; what has none, and lamps that seem small, wavefronts'. */
static void wide_lights_are_photons_at_foci(void **state) {
    (void)state;
    const WaveCost superquadric = {53, 0.041}, water = {5, 0.011}, box = {31, 0.041};
    assert_true(plan_blur_pays(&superquadric, 0.33, 64));
    assert_false(plan_blur_pays(&superquadric, 1.7, 320));
    assert_true(plan_blur_pays(&box, 1.7, 320));
    assert_true(plan_blur_pays(&water, 3.7, 64));
    assert_false(plan_blur_pays(&water, 30, 64));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(smooth_casters_are_waved),
        cmocka_unit_test(dear_casters_are_photons), cmocka_unit_test(wide_lights_are_photons_at_foci)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
