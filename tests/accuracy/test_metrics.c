/* SPDX-License-Identifier: Apache-2.0 */
/* The figures of caustic-accuracy on pictures whose answer can be written down. */
#include "accuracy/metrics.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

enum { PIXELS = 200, VALUES = 3 * PIXELS };

static void fill(float *rgb, float value) {
    for (int i = 0; i < VALUES; i++) rgb[i] = value;
}

static void equal(double x, double y) { assert_true(fabs(x - y) <= 1e-6 * fabs(y)); }

/* One part in ten too bright everywhere: (0.1 t)^2 / (1.01 t^2). */
static void test_scaled(void **state) {
    (void)state;
    float x[VALUES], t[VALUES];
    Metrics m;
    fill(x, 2.2f);
    fill(t, 2);
    assert_int_equal(metrics_of(x, t, PIXELS, &m, NULL), CAU_OK);
    equal(m.rel_mse, 0.01 / 1.01);
    equal(m.trimmed_rel_mse, 0.01 / 1.01);
    equal(m.nrmse, 0.1);
    equal(m.energy, 1.1);
}

/* Two wild pixels of 200 are the 1 % that is trimmed; a third stays. */
static void test_trimmed(void **state) {
    (void)state;
    float x[VALUES], t[VALUES];
    Metrics m;
    fill(x, 1);
    fill(t, 1);
    for (int i = 0; i < 6; i++) x[i] = 101;
    assert_int_equal(metrics_of(x, t, PIXELS, &m, NULL), CAU_OK);
    equal(m.rel_mse, 2 * 1e4 / 1.01 / PIXELS);
    assert_true(m.trimmed_rel_mse == 0);
    for (int i = 6; i < 9; i++) x[i] = 2;
    assert_int_equal(metrics_of(x, t, PIXELS, &m, NULL), CAU_OK);
    equal(m.trimmed_rel_mse, 1 / 1.01 / (PIXELS - 2));
}

static void test_refused(void **state) {
    (void)state;
    float x[VALUES], t[VALUES];
    Metrics m;
    CauError err = {0};
    fill(x, 1);
    fill(t, 0);
    assert_int_equal(metrics_check_reference(t, PIXELS, "t", &err), CAU_ERROR_INPUT);
    fill(t, 1);
    assert_int_equal(metrics_check_reference(t, PIXELS, "t", &err), CAU_OK);
    x[VALUES - 1] = NAN;
    assert_int_equal(metrics_of(x, t, PIXELS, &m, NULL), CAU_ERROR_INTERNAL);
    assert_int_equal(metrics_check_reference(x, PIXELS, "x", NULL), CAU_ERROR_INPUT);
}

static void test_exponent(void **state) {
    (void)state;
    double x[5] = {1, 2, 4, 8, 16}, y[5];
    for (int i = 0; i < 5; i++) y[i] = 3 * pow(x[i], -2.0 / 3);
    equal(metrics_exponent(x, y, 5), 2.0 / 3);
    assert_true(isnan(metrics_exponent(x, y, 1)));
    y[2] = 0; /* no logarithm: left out */
    equal(metrics_exponent(x, y, 5), 2.0 / 3);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_scaled), cmocka_unit_test(test_trimmed),
        cmocka_unit_test(test_refused), cmocka_unit_test(test_exponent)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
