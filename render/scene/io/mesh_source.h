/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Mesh files. OBJ and glTF through Assimp, which sees no file but the one named (and the buffers of a glTF).
 *  PLY by our own reader: Assimp 5.2 reads beyond the end of a cut-off binary PLY and crashes, fills missing
 * faces of a text one by repeating the last, and knows single precision only. */
#ifndef RENDER_SCENE_IO_MESH_SOURCE_H
#define RENDER_SCENE_IO_MESH_SOURCE_H

#include "render/scene/io/reader.h"

#include <stdbool.h>
#include <stdint.h>

#define MESH_BYTES_MAX ((size_t)2 << 30)

enum { POLYGON_CORNERS_MAX = 2048 };

/** The triangles of a file. */
typedef struct MeshTriangles {
    double *positions; /**< 3 * vertex_count */
    float *normals;    /**< 3 * vertex_count, or NULL */
    uint32_t *indices; /**< 3 * triangle_count */
    size_t vertex_count, triangle_count;
    bool doubles; /**< positions hold more than single precision */
    bool split;   /**< corners at one place are vertices of their own */
} MeshTriangles;

/** Reads OBJ or glTF; glTF's Y up becomes Z up. `place` begins the sentence of an error. */
cau_result mesh_import(Reader *r, const char *place, const char *path, bool y_up, MeshTriangles *out);
/** Reads PLY: text or binary, any order and type of properties. */
cau_result ply_read(Reader *r, const char *place, const char *data, size_t size, MeshTriangles *out);

/** Writes n - 2 triangles of a polygon of n >= 3 corners to `out`. */
cau_result polygon_triangulate(
    Reader *r, const char *place, const double *positions, const uint32_t *corners, size_t n, uint32_t *out);

/** Vertices at the same place become one; false when out of memory. */
bool mesh_weld(MeshTriangles *m);
void mesh_triangles_free(MeshTriangles *m);

#endif
