/* SPDX-License-Identifier: Apache-2.0 */
/* Files that a scene names: where they may lie, and reading them whole. */
#include "core/checked.h"
#include "render/scene/io/reader.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>

int path_inside(const char *folder, const char *path) {
    size_t n = strlen(folder);
    if (strncmp(folder, path, n) != 0) return 0;
    return path[n] == '/' || (n > 0 && folder[n - 1] == '/');
}

static bool has_parent_step(const char *name) {
    for (const char *p = name; p; p = strchr(p, '/')) {
        if (*p == '/') p++;
        if (strncmp(p, "..", 2) == 0 && (p[2] == '/' || p[2] == '\0')) return true;
    }
    return false;
}

cau_result reader_resolve(Reader *r, const char *place, const char *key, const char *name, char **out) {
    for (const char *c = name; *c; c++)
        if ((unsigned char)*c < 32 || *c == 127)
            return error_set(
                r->err, CAU_ERROR_INPUT, "%s.%s \"%s\" holds a control character", place, key, name);
    if (!*name || *name == '/' || has_parent_step(name))
        return error_set(r->err, CAU_ERROR_INPUT,
            "%s.%s is \"%s\"; it must be a path relative to the scene file that stays in its folder", place,
            key, name);
    size_t bytes = strlen(r->folder) + strlen(name) + 2;
    char *joined = array_new(bytes, 1);
    if (!joined) return error_set(r->err, CAU_ERROR_RESOURCE, "%s: out of memory", place);
    snprintf(joined, bytes, "%s/%s", r->folder, name);
    char *real = realpath(joined, NULL);
    int reason = errno;
    free(joined);
    if (!real)
        return error_set(
            r->err, CAU_ERROR_INPUT, "%s.%s \"%s\" cannot be opened: %s", place, key, name, strerror(reason));
    if (!path_inside(r->folder, real)) {
        free(real);
        return error_set(r->err, CAU_ERROR_INPUT,
            "%s.%s is \"%s\", a link that leaves the scene file's folder; copy the file into it", place, key,
            name);
    }
    *out = real;
    return CAU_OK;
}

static cau_result read_all(
    int file, size_t size, const char *place, char **data, size_t *got, CauError *err) {
    char *buffer = size < SIZE_MAX ? malloc(size + 1) : NULL;
    if (!buffer) return error_set(err, CAU_ERROR_RESOURCE, "%s: out of memory for %zu bytes", place, size);
    size_t have = 0;
    while (have < size) {
        ssize_t n = read(file, buffer + have, size - have);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) {
            free(buffer);
            return error_set(err, CAU_ERROR_INPUT, "%s: reading failed: %s", place, strerror(errno));
        }
        if (n == 0) break; /* it became shorter meanwhile: the parser will say what is missing */
        have += (size_t)n;
    }
    buffer[have] = '\0';
    *data = buffer;
    *got = have;
    return CAU_OK;
}

cau_result file_read(
    const char *path, size_t limit, const char *place, char **data, size_t *size, CauError *err) {
    /* Not blocking: opening a pipe for reading would wait for a writer. */
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) return error_set(err, CAU_ERROR_INPUT, "%s: cannot be opened: %s", place, strerror(errno));
    struct stat info;
    cau_result result = CAU_OK;
    if (fstat(file, &info) != 0 || !S_ISREG(info.st_mode))
        result = error_set(err, CAU_ERROR_INPUT, "%s: not a regular file", place);
    else if (info.st_size < 0 || (uintmax_t)info.st_size > limit)
        result = error_set(err, CAU_ERROR_INPUT, "%s: the file has %jd bytes; the limit is %zu", place,
            (intmax_t)info.st_size, limit);
    else
        result = read_all(file, (size_t)info.st_size, place, data, size, err);
    close(file);
    return result;
}
