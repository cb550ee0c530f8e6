/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Scenes from files, in libcaustics-io. The format: docs/scene-reference.md. */
#ifndef CAUSTICS_SCENE_FILE_H
#define CAUSTICS_SCENE_FILE_H

#include "caustics/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Reads a scene file (JSON) and the meshes it names, which must lie in its folder or below. Strict: an
 * unknown or repeated key, a wrong type or a value out of range is an error that says where, and nearest
 * names. On failure *out is NULL. */
CAU_API cau_result cau_scene_load_file(cau_context *context, const char *path, cau_scene **out);

#ifdef __cplusplus
}
#endif
#endif
