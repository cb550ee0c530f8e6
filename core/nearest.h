/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  "Did you mean": the nearest known name for an unknown one. */
#ifndef CORE_NEAREST_H
#define CORE_NEAREST_H

#include <stddef.h>

/** The index of the name with the smallest edit distance to `wanted` (upper and lower case count half); one
 *  that begins with `wanted` is nearer than any other typing error. Ties go to the first. -1 when `count` is
 * 0. */
int nearest_name(const char *wanted, const char *const *names, size_t count);

#endif
