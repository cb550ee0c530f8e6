/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The generator of docs/scene-reference.md and docs/scene.schema.json: both loop over the parameter tables.
 */
#ifndef RENDER_SCENE_REFERENCE_H
#define RENDER_SCENE_REFERENCE_H

#include "core/param.h"

#include <stdbool.h>

/** A default outside the limits stands for "not given". */
bool reference_has_default(const Param *p);

void reference_markdown(void);
/** 0, or 1 when out of memory. */
int reference_schema(void);

#endif
