/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_scan.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct Scan {
    int fd;
    int64_t at, end;
} Scan;

/* Types of one size. What is not here is checked below, or only has to fit in the file. */
static const struct {
    const char *type;
    int32_t size;
} fixed[] = {{"int", 4}, {"float", 4}, {"double", 8}, {"box2i", 16}, {"box2f", 16}, {"chromaticities", 32},
    {"compression", 1}, {"envmap", 1}, {"deepImageState", 1}, {"keycode", 28}, {"lineOrder", 1}, {"m33f", 36},
    {"m33d", 72}, {"m44f", 64}, {"m44d", 128}, {"rational", 8}, {"tiledesc", 9}, {"timecode", 8}, {"v2i", 8},
    {"v2f", 8}, {"v2d", 16}, {"v3i", 12}, {"v3f", 12}, {"v3d", 24}};

static bool get(const Scan *s, int64_t at, void *out, size_t count) {
    return at >= 0 && at <= s->end - (int64_t)count && pread(s->fd, out, count, (off_t)at) == (ssize_t)count;
}

/* A name of at most 255 letters; *length without the zero. */
static bool get_name(const Scan *s, int64_t at, char name[256], int64_t *length) {
    ssize_t n = at < s->end ? pread(s->fd, name, 256, (off_t)at) : 0;
    const char *zero = n > 0 ? memchr(name, 0, (size_t)n) : NULL;
    if (zero) *length = zero - name;
    return zero != NULL;
}

static bool check_channels(const Scan *s, int64_t at, int64_t end) {
    char name[256];
    int64_t length;
    while (at < end && get_name(s, at, name, &length) && length > 0) at += length + 1 + 16;
    return at == end - 1; /* the empty name */
}

static bool check_strings(const Scan *s, int64_t at, int64_t end) {
    int32_t length;
    while (at < end) {
        if (!get(s, at, &length, sizeof length) || length < 0 || length > end - at - 4) return false;
        at += 4 + length;
    }
    return at == end;
}

static bool check_preview(const Scan *s, int64_t at, int32_t size) {
    uint32_t sides[2];
    return size >= 8 && get(s, at, sides, sizeof sides) &&
           (uint64_t)sides[0] * sides[1] == (uint64_t)(size - 8) / 4 && size % 4 == 0;
}

static bool check_value(const Scan *s, const char *type, int64_t at, int32_t size) {
    if (size < 0 || size > s->end - at) return false;
    for (size_t i = 0; i < sizeof fixed / sizeof *fixed; i++)
        if (strcmp(type, fixed[i].type) == 0) return size == fixed[i].size;
    if (strcmp(type, "chlist") == 0) return check_channels(s, at, at + size);
    if (strcmp(type, "stringvector") == 0) return check_strings(s, at, at + size);
    if (strcmp(type, "preview") == 0) return check_preview(s, at, size);
    return true;
}

/* One header; *empty when there was none. */
static bool check_header(Scan *s, bool *empty) {
    char name[256], type[256];
    int64_t length;
    *empty = true;
    for (;;) {
        if (!get_name(s, s->at, name, &length)) return false;
        s->at += length + 1;
        if (length == 0) return true;
        *empty = false;
        int32_t size;
        if (!get_name(s, s->at, type, &length) || !get(s, s->at + length + 1, &size, sizeof size))
            return false;
        s->at += length + 1 + (int64_t)sizeof size;
        if (!check_value(s, type, s->at, size)) return false;
        s->at += size;
    }
}

static bool check_headers(Scan *s) {
    enum { MULTI_PART = 0x1000 };
    uint32_t start[2];
    bool empty;
    if (!get(s, 0, start, sizeof start)) return false;
    s->at = sizeof start;
    if (!check_header(s, &empty)) return false;
    while (start[1] & MULTI_PART && !empty)
        if (!check_header(s, &empty)) return false;
    return true;
}

cau_result exr_scan(const char *path, CauError *err) {
    struct stat info;
    Scan s = {.fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    if (s.fd < 0)
        return error_set(
            err, CAU_ERROR_INPUT, "cannot open \"%s\": %s; check the name", path, strerror(errno));
    s.end = fstat(s.fd, &info) == 0 ? info.st_size : 0;
    bool good = check_headers(&s);
    close(s.fd);
    return good ? CAU_OK
                : error_set(err, CAU_ERROR_INPUT,
                      "cannot read \"%s\": a size in its header cannot be right: the file is damaged", path);
}
