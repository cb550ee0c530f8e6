/* SPDX-License-Identifier: Apache-2.0 */
#include "composite/cli/arguments.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <stdlib.h>

static bool read_int(const char **at, int *out) {
    if (!isdigit((unsigned char)**at)) return false;
    char *end;
    errno = 0;
    long v = strtol(*at, &end, 10);
    if (errno || v > INT_MAX / 2) return false;
    *out = (int)v;
    *at = end;
    return true;
}

cau_result frames_parse(const char *text, int *first, int *last, int *step, CauError *err) {
    const char *at = text;
    *step = 1;
    bool ok = read_int(&at, first);
    *last = *first;
    if (ok && *at == '-') ok = (at++, read_int(&at, last));
    if (ok && *at == 'x') ok = (at++, read_int(&at, step));
    if (ok && !*at && *last >= *first && *step >= 1) return CAU_OK;
    return error_set(err, CAU_ERROR_USAGE,
        "--frames: \"%s\" is not a range: write 1-240, or 1-240x2 for every second frame", text);
}
