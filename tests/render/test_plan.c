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
    const WaveCost ball = {34, 0.018}, bottle = {188, 0.13}, ring_of_facets = {55, 0.62}, untried = {0, 0};
    assert_true(plan_wave_pays(&ball, 1));
    assert_true(plan_wave_pays(&ball, 4));
    assert_true(plan_wave_pays(&bottle, 1));
    assert_true(plan_wave_pays(&ring_of_facets, 1));
    assert_true(plan_wave_pays(&untried, 4));
}

static void dear_casters_are_photons(void **state) {
    (void)state;
    const WaveCost gem = {149, 0.38}, wide = {94, 0.6}, narrow = {40, 0.7};
    assert_false(plan_wave_pays(&gem, 1));
    assert_false(plan_wave_pays(&wide, 6));
    assert_true(plan_wave_pays(&narrow, 1)); /* a wider lamp makes it dear */
    assert_false(plan_wave_pays(&narrow, 5));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(smooth_casters_are_waved), cmocka_unit_test(dear_casters_are_photons)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
