/* SPDX-License-Identifier: Apache-2.0 */
#include "core/file_atomic.h"

#include "core/checked.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static uint64_t random_tag(void) {
    uint64_t tag = 0;
    if (getrandom(&tag, sizeof tag, GRND_NONBLOCK) != (ssize_t)sizeof tag)
        tag = (uint64_t)time(NULL) * 0x9e3779b97f4a7c15u ^ (uint64_t)getpid();
    return tag;
}

cau_result file_atomic_begin(FileAtomic *out, const char *path, CauError *err) {
    *out = (FileAtomic){0};
    if (!path[0]) return error_set(err, CAU_ERROR_INPUT, "the output file name is empty: give one with -o");
    struct stat info;
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        return error_set(
            err, CAU_ERROR_INPUT, "cannot write \"%s\": it is a folder; name a file in it", path);
    size_t length = strlen(path) + 32;
    out->path = string_copy(path);
    out->temp_path = malloc(length);
    if (!out->path || !out->temp_path) {
        file_atomic_abort(out);
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the name of \"%s\"", path);
    }
    for (int attempt = 0; attempt < 16; attempt++) {
        snprintf(out->temp_path, length, "%s.%016llx.tmp", path, (unsigned long long)random_tag());
        int fd = open(out->temp_path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (fd >= 0) {
            close(fd);
            return CAU_OK;
        }
        if (errno != EEXIST) break;
    }
    int cause = errno;
    free(out->temp_path);
    out->temp_path = NULL;
    file_atomic_abort(out);
    return error_set(err, CAU_ERROR_RESOURCE,
        "cannot write beside \"%s\": %s; choose a folder that exists and is writable", path, strerror(cause));
}

static void sync_folder(const char *path) {
    char *copy = string_copy(path);
    if (!copy) return;
    int fd = open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0) {
        fsync(fd); /* best effort: some file systems refuse to sync a folder */
        close(fd);
    }
    free(copy);
}

cau_result file_atomic_commit(FileAtomic *file, CauError *err) {
    int fd = open(file->temp_path, O_RDONLY | O_CLOEXEC);
    int failed = fd < 0 || fsync(fd) != 0;
    int cause = errno;
    if (fd >= 0 && close(fd) != 0 && !failed) {
        failed = 1;
        cause = errno;
    }
    if (!failed && rename(file->temp_path, file->path) != 0) {
        failed = 1;
        cause = errno;
    }
    if (failed) {
        cau_result result = error_set(err, CAU_ERROR_RESOURCE,
            "cannot finish writing \"%s\": %s; the old file, if any, is untouched", file->path,
            strerror(cause));
        file_atomic_abort(file);
        return result;
    }
    sync_folder(file->path);
    free(file->temp_path);
    file->temp_path = NULL;
    file_atomic_abort(file);
    return CAU_OK;
}

void file_atomic_abort(FileAtomic *file) {
    if (file->temp_path) unlink(file->temp_path);
    free(file->temp_path);
    free(file->path);
    *file = (FileAtomic){0};
}

cau_result file_write_atomic(const char *path, const void *data, size_t bytes, CauError *err) {
    FileAtomic file;
    CAU_TRY(file_atomic_begin(&file, path, err));
    int fd = open(file.temp_path, O_WRONLY | O_CLOEXEC | O_NOFOLLOW);
    size_t done = 0;
    int cause = fd < 0 ? errno : 0;
    while (!cause && done < bytes) {
        ssize_t n = write(fd, (const char *)data + done, bytes - done);
        if (n > 0)
            done += (size_t)n;
        else if (n < 0 && errno != EINTR)
            cause = errno;
    }
    if (fd >= 0 && close(fd) != 0 && !cause) cause = errno;
    if (cause) {
        file_atomic_abort(&file);
        return error_set(
            err, CAU_ERROR_RESOURCE, "cannot write %zu bytes to \"%s\": %s", bytes, path, strerror(cause));
    }
    return file_atomic_commit(&file, err);
}
