/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What every kind of material shares: its local frame, and the rows that no kind supports yet. */
#ifndef RENDER_MATERIAL_SHADING_H
#define RENDER_MATERIAL_SHADING_H

#include "render/material/material.h"

/** The local frame of a scattering: z is the shading normal. */
typedef struct LocalFrame {
    V3 s, t, n;
    V3 wi; /**< in the frame; wi.z > 0 */
} LocalFrame;

/** The normal to shade with: an interpolated normal may face away from wi near silhouettes; there the
 * geometric one takes its place. */
static inline V3 frame_normal(const ShadingFrame *f, V3 wi) {
    return v3_dot(wi, f->ns) < 1e-4 ? f->ng : f->ns;
}

/** Fills the local frame. False: wi does not see the surface at all. */
static inline bool frame_valid(const ShadingFrame *f, V3 wi, LocalFrame *out) {
    out->n = frame_normal(f, wi);
    v3_frame(out->n, &out->s, &out->t);
    out->wi = v3_to_frame(wi, out->s, out->t, out->n);
    return out->wi.z > 0.0;
}

static inline V3 frame_to_world(const LocalFrame *l, V3 local) {
    return v3_from_frame(local, l->s, l->t, l->n);
}
static inline V3 frame_to_local(const LocalFrame *l, V3 world) {
    return v3_to_frame(world, l->s, l->t, l->n);
}

/** Stores a drawn local direction. False when the shading and the geometric normal disagree about its side:
 *  such light is absorbed (as Cycles does), for following it would leak through the surface. */
static inline bool sample_direction(
    const ShadingFrame *f, const LocalFrame *l, V3 local, bool transmit, ScatterSample *out) {
    out->wo = frame_to_world(l, local);
    out->transmit = transmit;
    out->eta = 1.0;
    double side = transmit ? -1.0 : 1.0;
    return side * local.z > 0.0 && side * v3_dot(out->wo, f->ng) > 0.0;
}

static inline Rgb rgb_of(const double c[3]) { return rgb(c[0], c[1], c[2]); }

/** A reflectance. Above 1 a surface would make energy, and chains of bounces would not converge. */
#define MATERIAL_COLOR(struct_type, field, default_, flags_, help_)                                          \
    {                                                                                                        \
        .name = #field, .type = PARAM_COLOR, .unit = "", .offset = offsetof(struct_type, field),             \
        .def = {default_, default_, default_}, .min = 0, .max = 1, .flags = (flags_), .help = (help_)        \
    }

#define MATERIAL_NUMBER(struct_type, field, default_, min_, max_, help_)                                     \
    {                                                                                                        \
        .name = #field, .type = PARAM_NUMBER, .unit = "", .offset = offsetof(struct_type, field),            \
        .def = {default_}, .min = (min_), .max = (max_), .help = (help_)                                     \
    }

#define MATERIAL_UNSUPPORTED(name_, type_, help_)                                                            \
    { .name = (name_), .type = (type_), .unit = "", .flags = PARAM_UNSUPPORTED, .help = (help_) }

/** Rows that every table ends with. */
#define MATERIAL_COMMON                                                                                      \
    MATERIAL_UNSUPPORTED("normal", PARAM_VEC3, "a normal map"),                                              \
        MATERIAL_UNSUPPORTED("bump", PARAM_NUMBER, "a bump map")

/** A kind's parameters and what prepare() derived from them, as its own structs of doubles. */
#define MATERIAL_PARAMS(struct_type, m) ((const struct_type *)(const void *)(m)->data)
#define MATERIAL_DERIVED(struct_type, m) ((const struct_type *)(const void *)(m)->derived)
#define MATERIAL_DERIVED_MUTABLE(struct_type, m) ((struct_type *)(void *)(m)->derived)

#endif
