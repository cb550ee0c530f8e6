/* SPDX-License-Identifier: Apache-2.0 */
/* An object's "file". */
#include "render/scene/io/mesh_source.h"

#include "core/checked.h"

#include <stdio.h>
#include <strings.h>

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

/* Single precision as read is passed on as such, so that the scene stage can warn of lost digits. */
static cau_result hand_over(Reader *r, cau_item object, const char *here, const MeshTriangles *m) {
    size_t count = 3 * m->vertex_count;
    float *floats = m->doubles ? NULL : array_new(count, sizeof *floats);
    if (!m->doubles && !floats) return error_set(r->err, CAU_ERROR_RESOURCE, "%s: out of memory", here);
    for (size_t i = 0; floats && i < count; i++) floats[i] = (float)m->positions[i];
    cau_mesh mesh = {.size = sizeof mesh,
        .positions = floats ? (const void *)floats : m->positions,
        .positions_are_double = m->doubles,
        .vertex_count = m->vertex_count,
        .triangles = m->indices,
        .triangle_count = m->triangle_count,
        .normals = m->normals};
    cau_result result = cau_set_mesh(r->scene, object, &mesh);
    free(floats);
    return result;
}

static cau_result read_ply(Reader *r, const char *here, const char *path, MeshTriangles *out) {
    char *data = NULL;
    size_t size = 0;
    CAU_TRY(file_read(path, MESH_BYTES_MAX, here, &data, &size, r->err));
    cau_result result = ply_read(r, here, data, size, out);
    free(data);
    return result;
}

static cau_result load_mesh(
    Reader *r, cau_item object, const char *here, const char *path, MeshFormat format) {
    MeshTriangles m = {0};
    bool gltf = format == MESH_GLTF || format == MESH_GLB;
    cau_result result =
        format == MESH_PLY ? read_ply(r, here, path, &m) : mesh_import(r, here, path, gltf, &m);
    if (result == CAU_OK && m.split && !m.normals && !mesh_weld(&m))
        result = error_set(r->err, CAU_ERROR_RESOURCE, "%s: out of memory", here);
    if (result == CAU_OK) result = hand_over(r, object, here, &m);
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
