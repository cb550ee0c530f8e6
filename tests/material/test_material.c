/* SPDX-License-Identifier: Apache-2.0 */
#include "cases.h"

int main(void) {
    return run_generic_tests() + run_glass_tests() + run_coat_tests() + run_burley_tests() +
           run_normal_tests();
}
