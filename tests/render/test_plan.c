/* SPDX-License-Identifier: Apache-2.0 */
/* What the plan gives to wavefronts. */
#include "render/analyse/plan.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

/* Costs as probed, of scenes in which forced renders showed the quicker estimator (bench/plan). */
static void calm_casters_are_waved(void **state) {
    (void)state;
    const WaveCost noisy_ball = {54, 0.023, 0.032}, superquadric = {24, 0.042, 5.95}, gem = {49, 0.21, 0.051},
                   stack_of_faces = {304, 0.32, 0.21}, untried = {0};
    assert_true(plan_wave_pays(&noisy_ball));
    assert_true(plan_wave_pays(&superquadric));
    assert_true(plan_wave_pays(&gem));
    assert_true(plan_wave_pays(&stack_of_faces));
    assert_true(plan_wave_pays(&untried));
}

/* As fine as a wavefront's grid, though little is left over and few rays are taken. */
static void chaotic_casters_are_photons(void **state) {
    (void)state;
    const WaveCost noisy_balls[] = {{39, 0.029, 19.3}, {96, 0.11, 7.66}, {223, 0.41, 18}};
    for (size_t i = 0; i < sizeof noisy_balls / sizeof *noisy_balls; i++)
        assert_false(plan_wave_pays(&noisy_balls[i]));
}

/* Foci of wide lamps are photons'; what has none, and lamps that seem small, wavefronts'. */
static void wide_lights_are_photons_at_foci(void **state) {
    (void)state;
    const WaveCost superquadric = {53, 0.041, 0.21}, hammered = {4, 0.013, 2.6}, sheet = {5, 0.011, 0.0055},
                   box = {31, 0.041, 0.02};
    assert_true(plan_blur_pays(&superquadric, 0.33, 64));
    assert_false(plan_blur_pays(&superquadric, 1.7, 320));
    assert_false(plan_blur_pays(&hammered, 1.8, 64));
    assert_true(plan_blur_pays(&box, 1.7, 320));
    assert_true(plan_blur_pays(&sheet, 3.7, 64));
    assert_false(plan_blur_pays(&sheet, 30, 64));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(calm_casters_are_waved),
        cmocka_unit_test(chaotic_casters_are_photons), cmocka_unit_test(wide_lights_are_photons_at_foci)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
