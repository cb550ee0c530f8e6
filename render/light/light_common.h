/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What every kind of light shares. */
#ifndef RENDER_LIGHT_LIGHT_COMMON_H
#define RENDER_LIGHT_LIGHT_COMMON_H

#include "core/sampling.h"
#include "render/light/light.h"

/** A sane limit for powers and lengths: far beyond any lamp, far below what a float layer can hold. */
#define LIGHT_VALUE_MAX 1e15

/** `color` is the first row of every kind's table, and first in its struct. */
#define LIGHT_COLOR                                                                                          \
    {                                                                                                        \
        .name = "color", .type = PARAM_COLOR, .unit = "", .offset = 0, .def = {1, 1, 1}, .min = 0,           \
        .max = LIGHT_VALUE_MAX, .help = "multiplies the light"                                               \
    }

#define LIGHT_NUMBER(struct_type, field, unit_, default_, min_, max_, flags_, help_)                         \
    {                                                                                                        \
        .name = #field, .type = PARAM_NUMBER, .unit = (unit_), .offset = offsetof(struct_type, field),       \
        .def = {default_}, .min = (min_), .max = (max_), .flags = (flags_), .help = (help_)                  \
    }

#define LIGHT_PARAMS(struct_type, source) ((const struct_type *)(const void *)(source)->data)

static inline double radians(double degrees) { return degrees * (CAU_PI / 180.0); }

/** 1 - cos(a), without the cancellation that makes a real sun 0.25 % wrong and a small one infinite. */
static inline double one_minus_cos(double a) { return 2.0 * square(sin(0.5 * a)); }

/** A direction about the unit axis from one about +z. */
static inline V3 about_axis(V3 local, V3 axis) {
    V3 s, t;
    v3_frame(axis, &s, &t);
    return v3_normalize(v3_from_frame(local, s, t, axis));
}

/** Clears *out's kind-dependent part and fills colour, position and the direction the light shines along. */
cau_result light_place(
    const LightSource *source, const Affine *to_scene, Light *out, const char *owner, CauError *err);

/** Error unless the light's brightness (times its colour) came out finite. */
cau_result light_check(const Light *light, double brightness, const char *owner, CauError *err);

#endif
