/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Casters that lie on a receiver, face to face: a glass on a table.
 *
 *  Where two faces are one, rounding would decide which of them a ray meets first. In Cycles the receiver is
 * met first, and what it scatters then meets the two faces in turn, always at distance 0, until its bounces
 * are used up (measured: docs/cycles.md). Light that gets there stays there: between such faces it is dark.
 */
#ifndef RENDER_TRACE_CONTACT_H
#define RENDER_TRACE_CONTACT_H

#include "render/trace/embree.h"

/** Distance (scene space) below which two parallel faces are one. */
#define CONTACT_DISTANCE 1e-6

/** Where an object touches others. */
typedef struct Contact {
    bool caster, receiver; /**< it lies on a receiver; a caster lies on it */
    int on;                /**< of a caster: a receiver that it lies on */
    V3 lo, hi; /**< of a caster, scene space: around the faces that lie on receivers, a little larger */
} Contact;

/** Fills contacts[object]; returns whether any two objects touch. */
bool contacts_find(const TraceScene *trace, const Scene *scene, Contact *contacts);

/** Whether a point may be on a face of a caster that lies on a receiver. */
static inline bool contacts_near(const Contact *contacts, size_t count, V3 p) {
    for (size_t i = 0; i < count; i++) {
        const Contact *c = &contacts[i];
        if (c->caster && p.x >= c->lo.x && p.y >= c->lo.y && p.z >= c->lo.z && p.x <= c->hi.x &&
            p.y <= c->hi.y && p.z <= c->hi.z)
            return true;
    }
    return false;
}

#endif
