/* SPDX-License-Identifier: Apache-2.0 */
/* Assimp with its hands tied: it may open the mesh file, and for glTF the .bin buffers in the scene's folder.
 * Otherwise a material library named in an OBJ could be any file of the machine. */
#include "render/scene/io/mesh_collect.h"

#include "core/checked.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <stdio.h>

typedef struct Sandbox {
    Reader *reader;
    const char *place, *path;
} Sandbox;

typedef struct OpenFile {
    char *data;
    size_t size, at;
} OpenFile;

static OpenFile *open_file(struct aiFile *file) { return (OpenFile *)(void *)file->UserData; }

static size_t read_bytes(struct aiFile *file, char *out, size_t size, size_t count) {
    OpenFile *f = open_file(file);
    if (size == 0) return 0;
    size_t items = (f->size - f->at) / size;
    if (items > count) items = count;
    memcpy(out, f->data + f->at, items * size);
    f->at += items * size;
    return items;
}

static size_t write_nothing(struct aiFile *file, const char *data, size_t size, size_t count) {
    (void)file;
    (void)data;
    (void)size;
    (void)count;
    return 0;
}

static void flush_nothing(struct aiFile *file) { (void)file; }
static size_t tell(struct aiFile *file) { return open_file(file)->at; }
static size_t file_size(struct aiFile *file) { return open_file(file)->size; }

static enum aiReturn seek(struct aiFile *file, size_t offset, enum aiOrigin origin) {
    OpenFile *f = open_file(file);
    size_t base = origin == aiOrigin_SET ? 0 : (origin == aiOrigin_CUR ? f->at : f->size), target;
    if (!checked_add(base, offset, &target) || target > f->size) return aiReturn_FAILURE;
    f->at = target;
    return aiReturn_SUCCESS;
}

static bool allowed(const Sandbox *s, const char *name) {
    if (strcmp(name, s->path) == 0) return true;
    size_t n = strlen(name);
    if (n < 4 || strcmp(name + n - 4, ".bin") != 0) return false;
    char *real = realpath(name, NULL);
    bool inside = real && path_inside(s->reader->folder, real);
    free(real);
    return inside;
}

static struct aiFile *open_one(struct aiFileIO *io, const char *name, const char *mode) {
    Sandbox *s = (Sandbox *)(void *)io->UserData;
    if (mode[0] != 'r' || !allowed(s, name)) return NULL;
    struct aiFile *file = array_new(1, sizeof *file);
    OpenFile *f = array_new(1, sizeof *f);
    if (!file || !f) error_set(s->reader->err, CAU_ERROR_RESOURCE, "%s: out of memory", s->place);
    if (!file || !f ||
        file_read(name, MESH_BYTES_MAX, s->place, &f->data, &f->size, s->reader->err) != CAU_OK) {
        free(file);
        free(f);
        return NULL;
    }
    *file = (struct aiFile){.ReadProc = read_bytes,
        .WriteProc = write_nothing,
        .TellProc = tell,
        .FileSizeProc = file_size,
        .SeekProc = seek,
        .FlushProc = flush_nothing,
        .UserData = (char *)(void *)f};
    return file;
}

static void close_one(struct aiFileIO *io, struct aiFile *file) {
    (void)io;
    if (!file) return;
    free(open_file(file)->data);
    free(open_file(file));
    free(file);
}

cau_result mesh_import(Reader *r, const char *place, const char *path, bool y_up, MeshTriangles *out) {
    Sandbox sandbox = {r, place, path};
    struct aiFileIO io = {.OpenProc = open_one, .CloseProc = close_one, .UserData = (char *)(void *)&sandbox};
    const struct aiScene *scene = aiImportFileEx(path, 0, &io);
    if (!scene) { /* where opening the file failed, that error stands already and this one is not recorded */
        error_set(r->err, CAU_ERROR_INPUT, "%s: not a readable mesh file: %.300s", place, aiGetErrorString());
        return r->err->code;
    }
    cau_result result = mesh_collect(r, place, scene, y_up, out);
    aiReleaseImport(scene);
    return result;
}
