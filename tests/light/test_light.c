/* SPDX-License-Identifier: Apache-2.0 */
#include "lamps.h"

int main(void) { return run_unit_tests() + run_generic_tests(); }
