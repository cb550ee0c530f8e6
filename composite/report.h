/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  `list` and `check`: what a file holds, and what is wrong with it. */
#ifndef COMPOSITE_REPORT_H
#define COMPOSITE_REPORT_H

#include "core/error.h"

typedef struct Report {
    void (*line)(void *user, const char *text);
    void *user;
    CauError *err;
} Report;

void report_line(const Report *report, const char *format, ...) __attribute__((format(printf, 2, 3)));

cau_result report_list(const Report *report, const char *file);
/** The same and more as JSON, in one call of `line`. */
cau_result report_list_json(const Report *report, const char *file);
/** Every difference between two files, in header and pixels. */
cau_result report_diff(const Report *report, const char *a, const char *b);
/** Which source of the colour space, in words. */
const char *report_tag_source(int source);
cau_result report_check(const Report *report, const char *file);

#endif
