/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Lights, with Blender's units as Cycles 3.4 was measured to use them. One file per kind plus one line in
 *  lights.def.
 *
 *  A kind knows its emission only; aiming at casters is the emit stage's. Finite lights emit from points,
 *  infinite ones (sun, world) from directions. Scene space: see scene.h. */
#ifndef RENDER_LIGHT_LIGHT_H
#define RENDER_LIGHT_LIGHT_H

#include "core/error.h"
#include "core/param.h"
#include "core/vec.h"

#include <stdint.h>

struct LightKind;

enum { LIGHT_DATA_MAX = 160 };

/** A light as described. */
typedef struct LightSource {
    const struct LightKind *kind;
    char *name, *group; /**< group: NULL means the light's own name */
    double data[LIGHT_DATA_MAX / 8];
    double matrix[16];
    int placed;
    double casts_caustics;
} LightSource;

/** A light in scene space. */
typedef struct Light {
    const struct LightKind *kind;
    const char *name, *layer; /**< borrowed; layer: the group, or the name */
    uint64_t stream;          /**< identity in the random streams: a hash of the name */
    bool casts;
    Rgb color;
    V3 position, u, v, n; /**< n: unit, the direction it shines along; u, v: half axes of an area */
    double derived[8];    /**< what prepare() computed */
    bool infinite;        /**< sun and world: emits from directions */
    bool delta;           /**< no extent: a path cannot hit it */
} Light;

/** Light arriving at a point from a drawn place on a light. */
typedef struct LightSample {
    V3 dir;          /**< unit, from the point to the light */
    double distance; /**< scene units, INFINITY for infinite lights */
    Rgb value;       /**< radiance; delta lights: irradiance on a facing surface */
    double pdf;      /**< per steradian; 1 for delta lights */
} LightSample;

/** Where a photon starts: a point (finite) or a direction of travel (infinite). */
typedef struct EmitStart {
    V3 position; /**< finite lights */
    V3 normal;   /**< finite lights: emitter's normal there, or 0 for delta points */
    V3 dir;      /**< infinite lights: direction of travel */
    double pdf;  /**< per area (finite with extent), per steradian (infinite with extent), 1 for delta */
    /** 0, or the radius (scene units) of a ball that touches `position` from within, normal outward: light on
     *  a line through it may start anywhere between the ball's two sides. See LightKind.starts. */
    double body_radius;
} EmitStart;

/** The middle of its body. */
static inline V3 emit_middle(const EmitStart *start) {
    return v3_mad(start->position, -start->body_radius, start->normal);
}

/** Where light on a line through `start` begins at the earliest. */
static inline V3 emit_origin(const EmitStart *start, V3 dir) {
    double chord = 2.0 * start->body_radius * fmax(0.0, v3_dot(start->normal, dir));
    return v3_mad(start->position, -chord, dir);
}

/** What a lamp's light has met on its way to the first surface that it lights, in LightKind.starts' terms. */
typedef enum LightFirst {
    LIGHT_LIT,    /**< this is the surface */
    LIGHT_BEFORE, /**< the light for what comes after starts beyond it, perhaps: go on from there */
    LIGHT_UNLIT   /**< nothing on this line is lit */
} LightFirst;

typedef struct LightKind {
    const char *name, *help;
    ParamTable table;
    size_t data_size;
    /** From description to scene space: matrix (already in scene space: columns u, v, -n, position), powers
     *  (`flux_scale` = units_per_m squared). Checks what a table cannot say. */
    cau_result (*prepare)(const LightSource *source, const Affine *to_scene, double flux_scale, Light *out,
        const char *owner, CauError *err);
    /** Draws a direction from p towards the light. False: no light reaches p. */
    bool (*sample)(const Light *l, V3 p, double u, double v, LightSample *out);
    /** Radiance arriving along a ray from p in direction dir, if it meets the light; fills the same fields as
     *  sample(), pdf being the density with which sample() would have drawn dir. NULL for delta-only kinds.
     */
    bool (*hit)(const Light *l, V3 p, V3 dir, LightSample *out);
    /** Finite, may be NULL (all light starts at EmitStart.position): how far back from a place the light that
     *  meets it in a direction of travel starts. INFINITY: nothing on this line lights the place nor what
     * lies beyond it; negative: the place lies before where light on this line may start. */
    double (*starts)(const Light *l, V3 dir, V3 place);
    /** Draws the start of a photon. */
    void (*emit_start)(const Light *l, double u, double v, EmitStart *out);
    /** Finite: radiant intensity per emitting area (radiance times cosine), or intensity for delta points,
     *  leaving `start` in `dir`. Infinite: radiance, or irradiance for a delta sun. */
    Rgb (*emit)(const Light *l, const EmitStart *start, V3 dir);
    /** Finite lights: draws a direction over all that `start` emits to; returns its density per steradian. */
    double (*emit_direction)(const Light *l, const EmitStart *start, double u, double v, V3 *dir);
    double (*emit_direction_pdf)(const Light *l, const EmitStart *start, V3 dir);
} LightKind;

/** Asked of every surface on a line from emit_origin() until one is lit. `passed`: how far along `dir` the
 * last one lies that was BEFORE; -INFINITY at first. */
static inline LightFirst light_first(const Light *l, V3 dir, V3 place, double *passed) {
    if (!l->kind->starts) return LIGHT_LIT;
    double along = v3_dot(place, dir), back = l->kind->starts(l, dir, place);
    if (back < 0.0) {
        *passed = along;
        return LIGHT_BEFORE;
    }
    return along - back > *passed ? LIGHT_LIT : LIGHT_UNLIT;
}

const LightKind *light_find(const char *name);
const LightKind *const *light_kinds(size_t *count);

#endif
