/* SPDX-License-Identifier: Apache-2.0 */
/* The state of a render in a file: written beside and renamed, so that a kill at any moment leaves the last
 * one. */
#include "caustics/render_file.h"
#include "core/file_atomic.h"
#include "render/scene/scene.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

static int write_bytes(void *data, const void *bytes, size_t size) {
    return fwrite(bytes, 1, size, data) == size ? 0 : -1;
}

static int read_bytes(void *data, void *bytes, size_t size) {
    return fread(bytes, 1, size, data) == size ? 0 : -1;
}

cau_result cau_render_save_file(cau_render *render, cau_scene *scene, const char *path) {
    CauError *err = &scene->context->error;
    FileAtomic file;
    CAU_TRY(file_atomic_begin(&file, path, err));
    FILE *out = fopen(file.temp_path, "wb");
    int cause = errno;
    cau_result result = out ? cau_render_save(render, write_bytes, out) : CAU_ERROR_RESOURCE;
    if (out && result != CAU_OK) cause = errno;
    if (out && fclose(out) != 0 && result == CAU_OK) {
        cause = errno;
        result = CAU_ERROR_RESOURCE;
    }
    if (result == CAU_OK) return file_atomic_commit(&file, err);
    file_atomic_abort(&file);
    if (result == CAU_ERROR_CANCELLED) return result;
    error_clear(err);
    return error_set(err, result, "cannot write the checkpoint \"%s\": %s; the old one, if any, is untouched",
        path, strerror(cause));
}

typedef cau_result (*TakeState)(cau_render *render, const char *name, cau_state_read read, void *data);

static cau_result read_file(cau_render *render, cau_scene *scene, const char *path, TakeState take) {
    CauError *err = &scene->context->error;
    FILE *in = fopen(path, "rb");
    struct stat info;
    if (!in) return error_set(err, CAU_ERROR_INPUT, "cannot open \"%s\": %s", path, strerror(errno));
    cau_result result = CAU_OK;
    if (fstat(fileno(in), &info) != 0 || !S_ISREG(info.st_mode))
        result = error_set(err, CAU_ERROR_INPUT, "\"%s\" is not a regular file", path);
    if (result == CAU_OK) result = take(render, path, read_bytes, in);
    if (result == CAU_OK && fgetc(in) != EOF)
        result = error_set(err, CAU_ERROR_INPUT,
            "\"%s\" is damaged: it goes on after its end; delete it and render anew, or use a copy", path);
    fclose(in);
    return result;
}

cau_result cau_render_load_file(cau_render *render, cau_scene *scene, const char *path) {
    return read_file(render, scene, path, cau_render_load);
}

cau_result cau_render_join_file(cau_render *render, cau_scene *scene, const char *path) {
    return read_file(render, scene, path, cau_render_join);
}
