/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The body of point and spot lights: a point; or a sphere of uniform radiance seen from outside; or a disk
 * that faces whatever it lights, as in Cycles up to 3.x and with *Soft Falloff*: from a distance d a sphere
 * of radius r lights a surface that faces it by I / d^2, a disk by I / (d^2 + r^2) (measured:
 * docs/blender.md). */
#ifndef RENDER_LIGHT_BALL_H
#define RENDER_LIGHT_BALL_H

#include "render/light/light_common.h"

/** Radius in scene units (0: a point); intensity P / (4 pi), or radiance P / (4 pi^2 r^2) with a radius: a
 *  sphere's intensity is radiance times pi r^2. The kind's own values begin at BALL_DERIVED. */
enum { BALL_RADIUS, BALL_VALUE, BALL_DISK, BALL_DERIVED };

enum { BODY_SPHERE, BODY_DISK };

/** The row of a kind's table. */
#define BALL_BODY(struct_type)                                                                               \
    {                                                                                                        \
        .name = "body", .type = PARAM_CHOICE, .unit = "", .offset = offsetof(struct_type, body), .max = 1,   \
        .choices = ball_bodies,                                                                              \
        .help =                                                                                              \
            "of a lamp with a radius: a sphere, or a disk that faces what it lights, as in Cycles up to "    \
            "3.x and with Soft Falloff"                                                                      \
    }
extern const char *const ball_bodies[];

cau_result ball_prepare(double power_w, double radius_m, double body, double flux_scale, Light *out,
    const char *owner, CauError *err);

/** As LightKind.sample and .hit, before any attenuation by direction. */
bool ball_sample(const Light *l, V3 p, double u, double v, LightSample *out);
bool ball_hit(const Light *l, V3 p, V3 dir, LightSample *out);

/** As LightKind.starts. */
double ball_starts(const Light *l, V3 dir, V3 place);

/** The start of a photon at the body's surface, in the direction of a unit normal, drawn with `pdf` per area.
 */
void ball_start(const Light *l, V3 normal, double pdf, EmitStart *out);

/** As LightKind.emit. */
Rgb ball_emit(const Light *l, const EmitStart *start, V3 dir);

#endif
