/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "image/half.h"

/* Between every two neighbours: the middle goes to the even one, anything off it to the nearer, however
 * little. */
static void a_double_is_rounded_once(void **state) {
    (void)state;
    for (uint16_t h = 0; h < 0x7bff; h++) {
        double low = (double)half_to_float(h), high = (double)half_to_float((uint16_t)(h + 1));
        double middle = (low + high) / 2;
        assert_int_equal(half_from_double(low), h);
        assert_int_equal(half_from_double(middle), h + (h & 1));
        assert_int_equal(half_from_double(nextafter(middle, high)), h + 1);
        assert_int_equal(half_from_double(nextafter(middle, low)), h);
        assert_int_equal(half_from_double(-nextafter(middle, high)), (h + 1) | 0x8000);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_double_is_rounded_once)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
