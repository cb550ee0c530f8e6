/* SPDX-License-Identifier: Apache-2.0 */
/* What a render to an error is thought to have still to do. */
#include "render/render_pass_state.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

/* The squared error that forecast_passes() solved for, by paths: their noise falls with the square root. */
static void paths_take_the_square(void **state) {
    (void)state;
    ErrorParts e = {.total = 0.1, .noise[ERROR_PATHS] = 3};
    assert_true(fabs(forecast_passes(&e, 20, 0.05, 1, 8) / 80 - 1) < 1e-4);
    assert_true(fabs(forecast_passes(&e, 20, 0.1, 1, 8) / 20 - 1) < 1e-4);
    assert_true(fabs(forecast_passes(&e, 20, 0.02, 4, 8) / 125 - 1) < 1e-4);
}

/* What was reached already, and what larger passes would reach with fewer than the least. */
static void the_least_is_kept(void **state) {
    (void)state;
    ErrorParts e = {.total = 0.1, .noise[ERROR_PHOTONS] = 1, .bias[ERROR_PHOTONS] = 1};
    assert_true(forecast_passes(&e, 20, 0.5, 1, 8) == 8);
    assert_true(forecast_passes(&e, 20, 0.099, 16, 16) == 16);
}

/* More of whatever part takes longer; an error of bias that passes do not lower is never met. */
static void parts_fall_as_they_do(void **state) {
    (void)state;
    ErrorParts noise = {.total = 0.1, .noise[ERROR_WAVES] = 1},
               photons = {.total = 0.1, .noise[ERROR_PHOTONS] = 1},
               bias = {.total = 0.1, .bias[ERROR_WAVES] = 1};
    double waves = forecast_passes(&noise, 8, 0.05, 1, 8);
    assert_true(waves > 8 && waves < forecast_passes(&photons, 8, 0.05, 1, 8));
    assert_true(forecast_passes(&bias, 8, 0.05, 1, 8) > 1e6);
}

/* Far from the goal larger passes pay, the more the farther; near it, or where they may not grow, none. */
static void rounds_grow_with_the_way(void **state) {
    (void)state;
    ErrorParts e = {.total = 0.1, .noise[ERROR_WAVES] = 1, .bias[ERROR_WAVES] = 1};
    assert_true(forecast_round(&e, 8, 0.095, 16, 8, BUDGET_AS_IS).growth == 0);
    assert_true(forecast_round(&e, 8, 0.02, 1, 8, BUDGET_AS_IS).growth == 0);
    double before = 1;
    for (double error = 0.06; error > 0.03; error -= 0.01) {
        NextRound round = forecast_round(&e, 8, error, 16, 8, BUDGET_AS_IS);
        assert_true(round.growth > before && round.growth <= 16);
        assert_true(round.cost < forecast_passes(&e, 8, error, 1, 8) - 8);
        before = round.growth;
    }
    ErrorParts photons = {.total = 0.1, .noise[ERROR_PHOTONS] = 1, .bias[ERROR_PHOTONS] = 1};
    assert_true(forecast_round(&photons, 8, 0.03, 16, 8, BUDGET_AS_IS).growth > 1);
}

/* What passes of one size never meet calls for larger ones, however large these had to be. */
static void what_does_not_fall_wants_larger_passes(void **state) {
    (void)state;
    ErrorParts e = {.total = 0.04, .noise[ERROR_WAVES] = 9, .bias[ERROR_WAVES] = 1};
    double far = forecast_round(&e, 8, 0.002, 1000, 16, BUDGET_AS_IS).growth;
    assert_true(far > 16 && far <= 1000);
    assert_true(forecast_round(&e, 8, 0.002, 16, 16, BUDGET_AS_IS).growth > 8);
    assert_true(forecast_round(&e, 8, 1e-5, 16, 16, BUDGET_AS_IS).growth > 8);
}

/* Errors that jump about a course are evened, by those of the last quarter of the passes. */
static void the_past_evens(void **state) {
    (void)state;
    ErrorParts e = {.total = 0.1 * sqrt(10.0 / 40), .noise[ERROR_PATHS] = 1};
    PastErrors past = {{{30, 0.1 * sqrt(1.0 / 3) * 1.3}, {36, 0.1 * sqrt(10.0 / 36) / 1.3}}, 2};
    Course course = forecast_course(&e, 40, &past);
    assert_true(fabs(course.error / e.total - 1) < 0.03 && fabs(course.speed - 1) < 0.3);
    past.items[1].error *= 1.3 * 1.3;
    assert_true(forecast_course(&e, 40, &past).error > 1.1 * e.total);
}

/* A course that falls faster than its parts is taken for it the more the longer it is. */
static void the_past_tells_the_speed(void **state) {
    (void)state;
    double before = 1;
    for (double first = 32; first >= 8; first /= 2) {
        ErrorParts e = {.total = 0.1, .noise[ERROR_PATHS] = 1};
        PastErrors past = {.next = PAST_ERRORS};
        for (int i = 0; i < PAST_ERRORS; i++) {
            double passes = first + (40 - first) * i / PAST_ERRORS;
            past.items[i] = (PastError){passes, 0.1 * pow(40 / passes, 0.7)};
        }
        double speed = forecast_course(&e, 40, &past).speed;
        assert_true(speed > before && speed < 1.4);
        before = speed;
    }
    assert_true(before > 1.25);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(paths_take_the_square),
        cmocka_unit_test(the_least_is_kept), cmocka_unit_test(parts_fall_as_they_do),
        cmocka_unit_test(rounds_grow_with_the_way), cmocka_unit_test(what_does_not_fall_wants_larger_passes),
        cmocka_unit_test(the_past_evens), cmocka_unit_test(the_past_tells_the_speed)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
