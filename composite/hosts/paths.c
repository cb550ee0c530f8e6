/* SPDX-License-Identifier: Apache-2.0 */
/* File names: as they were recorded, as they can be opened, as a script says them. */
#include "composite/hosts/hosts.h"
#include "core/frames.h"

#include "core/checked.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FILE_MAX_BYTES = 64 << 20 };

static cau_result no_memory(CauError *err) {
    return error_set(err, CAU_ERROR_RESOURCE, "out of memory for file names");
}

cau_result host_read_file(char **out, size_t *size, const char *path, CauError *err) {
    struct stat info;
    FILE *file = fopen(path, "rbe");
    if (!file || fstat(fileno(file), &info) != 0 || !S_ISREG(info.st_mode) || info.st_size > FILE_MAX_BYTES) {
        if (file) fclose(file);
        return error_set(err, CAU_ERROR_INPUT, "cannot read \"%s\": %s", path,
            file ? "it is not a file of at most 64 MiB" : strerror(errno));
    }
    *size = (size_t)info.st_size;
    *out = malloc(*size + 1);
    if (*out) {
        *size = fread(*out, 1, *size, file);
        (*out)[*size] = '\0';
    }
    fclose(file);
    return *out ? CAU_OK : no_memory(err);
}

/* The number's place: the last run of digits in the file's name that is this frame. */
static bool find_frame(const char *path, int frame, size_t *begin, size_t *length) {
    const char *slash = strrchr(path, '/');
    size_t first = slash ? (size_t)(slash + 1 - path) : 0;
    for (size_t end = strlen(path); end > first; end--) {
        size_t at = end;
        while (at > first && isdigit((unsigned char)path[at - 1])) at--;
        if (at < end && end - at < 10 && atoi(path + at) == frame) {
            *begin = at;
            *length = end - at;
            return true;
        }
        if (at < end) end = at + 1;
    }
    return false;
}

cau_result host_find_input(char **out, const char *recorded, const char *file, CauError *err) {
    const char *slash = strrchr(file, '/');
    size_t folder = slash ? (size_t)(slash + 1 - file) : 0, room = folder + strlen(recorded) + 1;
    *out = access(recorded, R_OK) == 0 ? string_copy(recorded) : malloc(room);
    if (!*out) return no_memory(err);
    if (access(recorded, R_OK) == 0) return CAU_OK;
    snprintf(*out, room, "%.*s%s", (int)folder, file, recorded);
    if (recorded[0] != '/' && access(*out, R_OK) == 0) return CAU_OK;
    free(*out);
    *out = NULL;
    return error_set(err, CAU_ERROR_INPUT,
        "\"%s\" was made from \"%s\", which is neither here nor beside it: run this where it was made", file,
        recorded);
}

/* Absolute, without "." and "..", links left as they are. NULL when out of memory. */
static char *absolute(const char *path) {
    char folder[PATH_MAX];
    if (path[0] == '/' || !getcwd(folder, sizeof folder)) folder[0] = '\0';
    size_t room = strlen(folder) + strlen(path) + 2, used = 0;
    char *whole = malloc(room), *out = malloc(room);
    if (whole && out) {
        snprintf(whole, room, "%s/%s", folder, path);
        char *rest = whole;
        for (char *piece; (piece = strsep(&rest, "/"));) {
            if (!*piece || strcmp(piece, ".") == 0) continue;
            if (strcmp(piece, "..") == 0) {
                while (used > 0 && out[--used] != '/') {
                }
                continue;
            }
            out[used++] = '/';
            size_t n = strlen(piece);
            memcpy(out + used, piece, n);
            used += n;
        }
        out[used] = '\0';
    } else {
        free(out);
        out = NULL;
    }
    free(whole);
    return out;
}

/* The frame's number becomes ####. */
static char *as_pattern(char *path, int frame) {
    size_t begin, length;
    char *has_place = path ? frame_name(path, frame) : NULL;
    free(has_place);
    if (!path || has_place || !find_frame(path, frame, &begin, &length)) return path;
    memset(path + begin, '#', length);
    return path;
}

static cau_result set_path(
    HostPath *out, const HostPlan *plan, const char *path, const char *script, CauError *err) {
    char *whole = absolute(path), *from = script ? absolute(script) : NULL;
    if (plan->has_frames) whole = as_pattern(whole, plan->first);
    char *slash = from ? strrchr(from, '/') : NULL;
    size_t folder = slash ? (size_t)(slash + 1 - from) : 0;
    *out = (HostPath){.path = whole};
    if (whole && folder > 1 && strncmp(whole, from, folder) == 0) {
        memmove(whole, whole + folder, strlen(whole + folder) + 1);
        out->relative = true;
    }
    free(from);
    return whole ? CAU_OK : no_memory(err);
}

cau_result host_paths(HostPlan *plan, const char *file, const char *caustics, const char *beauty,
    const char *script, CauError *err) {
    CAU_TRY(set_path(&plan->caustics_path, plan, caustics ? caustics : file, script, err));
    return beauty ? set_path(&plan->beauty_path, plan, beauty, script, err) : CAU_OK;
}
