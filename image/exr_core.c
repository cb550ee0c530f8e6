/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_core.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Larger than any picture known; a header that claims more is damage or an attack. */
enum { LARGEST_SIDE = 65536 };

static ExrCoreFile *file_of(exr_const_context_t context) {
    void *user = NULL;
    if (exr_get_user_data(context, &user) != EXR_ERR_SUCCESS) return NULL;
    return user;
}

static void keep_message(exr_const_context_t context, exr_result_t code, const char *message) {
    (void)code;
    ExrCoreFile *file = context ? file_of(context) : NULL;
    if (!file) return;
    while (atomic_flag_test_and_set(&file->text_busy)) continue;
    snprintf(file->text, sizeof file->text, "%s", message ? message : "");
    atomic_flag_clear(&file->text_busy);
}

/* While a file is written the library calls its handler with the context's lock held, and asking for the user
 * data would wait for that lock for ever. */
static void drop_message(exr_const_context_t context, exr_result_t code, const char *message) {
    (void)context;
    (void)code;
    (void)message;
}

static int64_t read_bytes(exr_const_context_t context, void *user, void *buffer, uint64_t bytes,
    uint64_t offset, exr_stream_error_func_ptr_t report) {
    (void)context;
    (void)report;
    ExrCoreFile *file = user;
    if (offset > INT64_MAX) return -1; /* an offset table may say anything */
    uint64_t done = 0;
    while (done < bytes) {
        ssize_t n = pread(file->fd, (char *)buffer + done, bytes - done, (off_t)(offset + done));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        done += (uint64_t)n;
    }
    return (int64_t)done;
}

static int64_t file_size(exr_const_context_t context, void *user) {
    (void)context;
    return ((ExrCoreFile *)user)->size;
}

static int64_t write_bytes(exr_const_context_t context, void *user, const void *buffer, uint64_t bytes,
    uint64_t offset, exr_stream_error_func_ptr_t report) {
    ExrCoreFile *file = user;
    uint64_t done = 0;
    while (done < bytes) {
        ssize_t n = pwrite(file->fd, (const char *)buffer + done, bytes - done, (off_t)(offset + done));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) {
            if (!file->write_errno) file->write_errno = n < 0 ? errno : ENOSPC;
            report(context, EXR_ERR_WRITE_IO, "%s", strerror(file->write_errno));
            return -1;
        }
        done += (uint64_t)n;
    }
    return (int64_t)done;
}

static exr_context_initializer_t initializer(ExrCoreFile *file) {
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_message;
    init.user_data = file;
    init.max_image_width = init.max_image_height = LARGEST_SIDE;
    init.max_tile_width = init.max_tile_height = LARGEST_SIDE;
    init.zip_level = 4; /* as OpenEXR from 3.2 on: a sixth less time than 6, one per cent more bytes */
    /* Rebuilding a lost chunk table would make a cut-off file look whole. */
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    return init;
}

cau_result exr_core_open_read(exr_context_t *out, ExrCoreFile *file, const char *path, CauError *err) {
    *out = NULL;
    /* O_NONBLOCK: a pipe named as a picture must not hang the open. */
    *file = (ExrCoreFile){.fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK), .text_busy = ATOMIC_FLAG_INIT};
    if (file->fd < 0)
        return error_set(
            err, CAU_ERROR_INPUT, "cannot open \"%s\": %s; check the name", path, strerror(errno));
    struct stat info;
    if (fstat(file->fd, &info) != 0 || !S_ISREG(info.st_mode)) {
        exr_core_close(out, file, path, NULL);
        return error_set(err, CAU_ERROR_INPUT, "\"%s\" is not a file: name an EXR picture", path);
    }
    file->size = info.st_size;
    exr_context_initializer_t init = initializer(file);
    init.read_fn = read_bytes;
    init.size_fn = file_size;
    exr_result_t code = exr_start_read(out, path, &init);
    if (code == EXR_ERR_SUCCESS) return CAU_OK;
    cau_result result = exr_core_error(file, code, "read the header of", path, err);
    exr_core_close(out, file, path, NULL);
    return result;
}

cau_result exr_core_open_write(exr_context_t *out, ExrCoreFile *file, const char *path, CauError *err) {
    *out = NULL;
    *file = (ExrCoreFile){
        .fd = open(path, O_WRONLY | O_TRUNC | O_CLOEXEC | O_NOFOLLOW), .text_busy = ATOMIC_FLAG_INIT};
    if (file->fd < 0)
        return error_set(err, CAU_ERROR_RESOURCE, "cannot write \"%s\": %s", path, strerror(errno));
    exr_context_initializer_t init = initializer(file);
    init.error_handler_fn = drop_message;
    init.write_fn = write_bytes;
    exr_result_t code = exr_start_write(out, path, EXR_WRITE_FILE_DIRECTLY, &init);
    if (code == EXR_ERR_SUCCESS) return CAU_OK;
    cau_result result = exr_core_error(file, code, "start writing", path, err);
    exr_core_close(out, file, path, NULL);
    return result;
}

cau_result exr_core_close(exr_context_t *context, ExrCoreFile *file, const char *path, CauError *err) {
    cau_result result = CAU_OK;
    if (*context) {
        exr_result_t code = exr_finish(context);
        *context = NULL;
        if (code != EXR_ERR_SUCCESS) result = exr_core_error(file, code, "finish", path, err);
    }
    if (file->fd >= 0 && close(file->fd) != 0 && result == CAU_OK)
        result = error_set(err, CAU_ERROR_RESOURCE, "cannot finish \"%s\": %s", path, strerror(errno));
    file->fd = -1;
    return result;
}

cau_result exr_core_error(
    ExrCoreFile *file, exr_result_t code, const char *doing, const char *path, CauError *err) {
    if (file->write_errno)
        return error_set(err, CAU_ERROR_RESOURCE,
            "cannot write \"%s\": %s; free some space or name another folder", path,
            strerror(file->write_errno));
    if (code == EXR_ERR_OUT_OF_MEMORY)
        return error_set(err, CAU_ERROR_RESOURCE, "cannot %s \"%s\": out of memory", doing, path);
    char text[EXR_CORE_TEXT_MAX];
    while (atomic_flag_test_and_set(&file->text_busy)) continue;
    memcpy(text, file->text, sizeof text);
    atomic_flag_clear(&file->text_busy);
    const char *reason = text[0] ? text : exr_get_default_error_message(code);
    /* The library sometimes begins with the name, which is there already. */
    size_t length = strlen(path);
    if (strncmp(reason, path, length) == 0 && reason[length] == ':') reason += length + 1;
    reason += strspn(reason, " ");
    bool reading = strncmp(doing, "read", 4) == 0;
    return error_set(err, CAU_ERROR_INPUT, "cannot %s \"%s\": %s%s", doing, path, reason,
        reading ? "; the file is damaged, cut off or no EXR: render or copy it again" : "");
}
