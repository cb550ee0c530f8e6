/* SPDX-License-Identifier: Apache-2.0 */
/* An object's "file". */
#include "render/scene/io/mesh_source.h"

#include "core/checked.h"
#include "core/param.h"

#include <assimp/cimport.h>
#include <stdio.h>
#include <strings.h>

#define MESH_BYTES_MAX ((size_t)2 << 30)

typedef enum MeshFormat { MESH_PLY, MESH_OBJ, MESH_GLTF, MESH_GLB } MeshFormat;

static cau_result find_format(Reader *r, const char *place, const char *name, MeshFormat *out) {
    static const char *const endings[] = {".ply", ".obj", ".gltf", ".glb"};
    const char *dot = strrchr(name, '.');
    for (int i = 0; dot && i < 4; i++)
        if (strcasecmp(dot, endings[i]) == 0) {
            *out = (MeshFormat)i;
            return CAU_OK;
        }
    return error_set(
        r->err, CAU_ERROR_INPUT, "%s.file is \"%s\"; it must end in .ply, .obj, .gltf or .glb", place, name);
}

/* What Assimp would take on trust. */
static cau_result check_header(
    Reader *r, const char *here, const char *path, MeshFormat format, size_t *vertices, size_t *faces) {
    char *data = NULL;
    size_t size = 0;
    *vertices = *faces = 0;
    CAU_TRY(file_read(path, MESH_BYTES_MAX, here, &data, &size, r->err));
    cau_result result = CAU_OK;
    if (format == MESH_PLY) result = ply_counts(r, here, data, size, vertices, faces);
    if (format == MESH_OBJ && memchr(data, '\0', size))
        result = error_set(r->err, CAU_ERROR_INPUT, "%s: not a text file, as OBJ is", here);
    free(data);
    return result;
}

static cau_result check_complete(
    Reader *r, const char *here, const struct aiScene *scene, size_t vertices, size_t faces) {
    size_t have_vertices = 0, have_faces = 0;
    for (unsigned m = 0; m < scene->mNumMeshes; m++) {
        have_vertices += scene->mMeshes[m]->mNumVertices;
        have_faces += scene->mMeshes[m]->mNumFaces;
    }
    if (have_vertices < vertices || have_faces < faces)
        return error_set(r->err, CAU_ERROR_INPUT,
            "%s: holds %zu of %zu vertices and %zu of %zu faces; the file is cut off", here, have_vertices,
            vertices, have_faces, faces);
    return CAU_OK;
}

/* Single precision as read is passed on as such, so that the scene stage can warn of lost digits. */
static cau_result hand_over(Reader *r, cau_item object, const char *here, MeshTriangles *m, bool moved) {
    size_t count = 3 * m->vertex_count;
    float *floats = moved ? NULL : array_new(count, sizeof *floats);
    if (!moved && !floats) return error_set(r->err, CAU_ERROR_RESOURCE, "%s: out of memory", here);
    for (size_t i = 0; floats && i < count; i++) floats[i] = (float)m->positions[i];
    cau_mesh mesh = {.size = sizeof mesh,
        .positions = floats ? (const void *)floats : m->positions,
        .positions_are_double = moved,
        .vertex_count = m->vertex_count,
        .triangles = m->indices,
        .triangle_count = m->triangle_count,
        .normals = m->normals};
    cau_result result = cau_set_mesh(r->scene, object, &mesh);
    free(floats);
    return result;
}

static cau_result load_mesh(
    Reader *r, cau_item object, const char *here, const char *path, MeshFormat format) {
    const struct aiScene *scene = NULL;
    MeshTriangles m = {0};
    size_t vertices, faces;
    CAU_TRY(check_header(r, here, path, format, &vertices, &faces));
    CAU_TRY(mesh_import(r, here, path, &scene));
    bool gltf = format == MESH_GLTF || format == MESH_GLB;
    cau_result result = check_complete(r, here, scene, vertices, faces);
    if (result == CAU_OK) result = mesh_collect(r, here, scene, gltf, &m);
    aiReleaseImport(scene);
    if (result == CAU_OK && !m.normals && !mesh_weld(&m))
        result = error_set(r->err, CAU_ERROR_RESOURCE, "%s: out of memory", here);
    if (result == CAU_OK) result = hand_over(r, object, here, &m, gltf && m.moved);
    mesh_triangles_free(&m);
    return result;
}

cau_result reader_mesh_file(Reader *r, cau_item object, const char *place, const char *name) {
    char *path, here[READER_PLACE_MAX];
    MeshFormat format = MESH_PLY;
    CAU_TRY(find_format(r, place, name, &format));
    CAU_TRY(reader_resolve(r, place, "file", name, &path));
    snprintf(here, sizeof here, "%s.file \"%.200s\"", place, name);
    cau_result result = load_mesh(r, object, here, path, format);
    free(path);
    return result;
}
