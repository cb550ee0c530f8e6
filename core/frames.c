/* SPDX-License-Identifier: Apache-2.0 */
#include "core/frames.h"

#include <ctype.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool frame_place(const char *pattern, size_t *begin, size_t *length, int *digits) {
    const char *hash = strchr(pattern, '#');
    if (hash) {
        *begin = (size_t)(hash - pattern);
        *length = strspn(hash, "#");
        *digits = *length < 20 ? (int)*length : 20;
        return true;
    }
    for (const char *p = strchr(pattern, '%'); p; p = strchr(p + 1, '%')) {
        const char *end = p + 1;
        while (isdigit((unsigned char)*end) && end - p < 4) end++;
        if (*end != 'd') continue;
        *begin = (size_t)(p - pattern);
        *length = (size_t)(end - p) + 1;
        *digits = atoi(p + 1);
        return *digits <= 20;
    }
    return false;
}

char *frame_name(const char *pattern, int frame) {
    size_t begin, length;
    int digits;
    if (!frame_place(pattern, &begin, &length, &digits)) return NULL;
    size_t room = strlen(pattern) + 32;
    char *name = malloc(room);
    if (name)
        snprintf(name, room, "%.*s%0*d%s", (int)begin, pattern, digits, frame, pattern + begin + length);
    return name;
}

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
