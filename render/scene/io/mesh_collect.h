/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Assimp's tree of nodes into one mesh. */
#ifndef RENDER_SCENE_IO_MESH_COLLECT_H
#define RENDER_SCENE_IO_MESH_COLLECT_H

#include "render/scene/io/mesh_source.h"

#include <assimp/scene.h>

/** All nodes in place; with `y_up`, Y up becomes Z up. */
cau_result mesh_collect(
    Reader *r, const char *place, const struct aiScene *scene, bool y_up, MeshTriangles *out);

#endif
