/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Mesh files through Assimp, which sees no file but the one named (and the buffers of a glTF). */
#ifndef RENDER_SCENE_IO_MESH_SOURCE_H
#define RENDER_SCENE_IO_MESH_SOURCE_H

#include "render/scene/io/reader.h"

#include <assimp/scene.h>
#include <stdbool.h>

/** Reads the file. `place` begins the sentence of an error; release with aiReleaseImport(). */
cau_result mesh_import(Reader *r, const char *place, const char *path, const struct aiScene **out);

/** A PLY header's counts against the size of the file: Assimp would believe them. Counts are 0 for other
 * files. */
cau_result ply_counts(
    Reader *r, const char *place, const char *data, size_t size, size_t *vertices, size_t *faces);

/** The triangles of a scene, all nodes in place. */
typedef struct MeshTriangles {
    double *positions; /**< 3 * vertex_count */
    float *normals;    /**< 3 * vertex_count, or NULL */
    uint32_t *indices; /**< 3 * triangle_count */
    size_t vertex_count, triangle_count;
    bool moved; /**< a node's matrix was applied: positions are no longer floats */
} MeshTriangles;

/** Collects the triangles; glTF's Y up becomes Z up. `triangulated`: Assimp has split the polygons already.
 */
cau_result mesh_collect(
    Reader *r, const char *place, const struct aiScene *scene, bool y_up, MeshTriangles *out);
/** Vertices at the same place become one. */
bool mesh_weld(MeshTriangles *m);
void mesh_triangles_free(MeshTriangles *m);

#endif
