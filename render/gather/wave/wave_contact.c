/* SPDX-License-Identifier: Apache-2.0 */
/* Where something stands on a receiver: a triangle of light on its far side must not light what is seen on
 * the near one, within the same subpixel, through a thin wall. */
#include "render/gather/wave/wave_internal.h"

/* How far over the surface a ray along it goes, in its lengths. */
#define LIFT 0.02

bool wave_on_this_side(
    const TraceScene *trace, const WaveView *v, const WaveSubpixel *p, double x, double y) {
    V3 n = v3((double)p->normal[0], (double)p->normal[1], (double)p->normal[2]),
       from = v3((double)p->position[0], (double)p->position[1], (double)p->position[2]);
    V3 to = wave_seen_at(&v->scene->camera, from, n, (x + v->x0) / v->scale, (y + v->y0) / v->scale);
    return trace_sees_along(trace, from, to, n, LIFT * v3_length(v3_sub(to, from)));
}

void wave_mark_contact(WaveView *v, const TraceScene *trace, size_t at, double x, double y, double size) {
    WaveSubpixel *p = &v->subpixels[at];
    if (p->receiver == WAVE_NOTHING) return;
    for (int k = 0; k < 9; k++) {
        if (k == 4 ||
            wave_on_this_side(trace, v, p, x + (k % 3 - 1) * 0.5 * size, y + (k / 3 - 1) * 0.5 * size))
            continue;
        p->receiver |= WAVE_CONTACT;
        return;
    }
}
