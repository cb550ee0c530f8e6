/* SPDX-License-Identifier: Apache-2.0 */
/* What looks would find, without drawing it: tells how noisy a wavefront is. */
#include "render/gather/wave/wave_internal.h"

static double square_of(Rgb w) { return square(fmax(fabs(w.r), fmax(fabs(w.g), fabs(w.b)))); }

/* A path that the ray found and a triangle has claimed: as wave_rest.c puts it. */
static double moved(
    const WaveCells *c, const WaveLanding *found, const WaveClaim *claim, const WaveCorner *ray) {
    double extent = 0;
    WaveLanding at = wave_interpolate(c, claim, ray->u, ray->v, &extent);
    if (wave_same_place(c, &at, extent, found))
        return square_of(rgb_add(found->weight, rgb_scale(claim->weight, -1)));
    return square_of(found->weight) + square_of(claim->weight);
}

static double difference(const WaveCells *c, const WaveCorner *ray) {
    const WaveLanding *found = &c->landings.items[ray->first];
    bool met[WAVE_CLAIMED_MAX] = {false};
    double sum = 0;
    for (uint32_t i = 0; i < ray->count; i++) {
        const WaveClaim *claim = wave_claimed(c, found[i].path);
        bool first = claim && !met[claim - c->claims];
        sum += first ? moved(c, &found[i], claim, ray) : square_of(found[i].weight);
        if (first) met[claim - c->claims] = true;
    }
    for (size_t i = 0; i < c->claim_count; i++)
        if (!met[i]) sum += square_of(c->claims[i].weight);
    return sum;
}

void wave_measure(WaveCells *c, const WaveCorner *ray, double area, double chance, double whole) {
    c->out->looked++;
    c->out->looked_flux += area * whole;
    c->out->found += square(area) * difference(c, ray) / chance;
}
