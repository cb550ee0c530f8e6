/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Casters that lie on a receiver, face to face: a glass on a table. */
#ifndef RENDER_TRACE_CONTACT_H
#define RENDER_TRACE_CONTACT_H

#include "render/trace/embree.h"

/** Distance (scene space) below which two parallel faces are one. */
#define CONTACT_DISTANCE 1e-6

/** Sets touched[object] for every receiver that a caster's triangles lie on. */
void contacts_find(const TraceScene *trace, const Scene *scene, bool *touched);

#endif
