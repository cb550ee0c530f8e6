/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Materials: how a surface scatters. One file per kind plus one line in materials.def.
 *
 *  Directions point away from the surface. `wi` is where the path came from, `wo` where it goes on. A kind
 *  answers in the shading frame's terms; the correction of interpolated normals for light transport (Veach
 * 1996, "Non-symmetric scattering in light transport algorithms") is the tracer's, so that a kind knows
 * nothing of it. Radiance is never scaled by the square of the index: photons carry flux, eye paths follow
 * Cycles. */
#ifndef RENDER_MATERIAL_MATERIAL_H
#define RENDER_MATERIAL_MATERIAL_H

#include "core/error.h"
#include "core/param.h"
#include "core/vec.h"

/** Lobes, and the events that sampling them makes. */
enum {
    LOBE_DIFFUSE = 1,
    LOBE_GLOSSY = 2,      /**< rough reflection or refraction: has a density */
    LOBE_SPECULAR = 4,    /**< perfect reflection or refraction */
    LOBE_TRANSPARENT = 8, /**< straight through, not a scattering */
    LOBE_CASTING = LOBE_GLOSSY | LOBE_SPECULAR,
    LOBE_ALL = 15
};

/** A point on a surface as seen from wi. ng and ns point to wi's side. */
typedef struct ShadingFrame {
    V3 ng, ns;  /**< geometric and shading normal, unit */
    bool front; /**< wi is on the front side */
} ShadingFrame;

typedef struct ScatterSample {
    V3 wo;
    Rgb weight;    /**< f |cos| / pdf, the choice of lobe included */
    double pdf;    /**< per steradian; 0 for specular and transparent */
    unsigned lobe; /**< exactly one LOBE_* */
    bool transmit; /**< wo is on the other side */
    double eta;    /**< n(wo side) / n(wi side); 1 unless refracted */
} ScatterSample;

enum { MATERIAL_DATA_MAX = 160, MATERIAL_DERIVED_MAX = 80 };

struct MaterialKind;

typedef struct Material {
    const struct MaterialKind *kind;
    char *name;
    double data[MATERIAL_DATA_MAX / 8];   /**< the kind's parameters, as its table says */
    double derived[MATERIAL_DERIVED_MAX]; /**< what prepare() made of them */
    unsigned lobes;                       /**< what this instance can do at all */
} Material;

typedef struct MaterialKind {
    const char *name, *help;
    ParamTable table;
    size_t data_size;
    /** Fills m->derived and m->lobes from m->data. */
    void (*prepare)(Material *m);
    /** Draws wo among `lobes`. False: the path ends here (absorbed). u: three uniform numbers. `from_light`
     * is true when wi points towards the light (photons): then wo is the eye's side. */
    bool (*sample)(const Material *m, const ShadingFrame *f, V3 wi, const double u[3], unsigned lobes,
        bool from_light, ScatterSample *out);
    /** Smooth interfaces that both reflect and refract: the share of light from wi that is reflected;
     * sample() reflects when u[2] is less than it. NULL: one way on. */
    double (*reflected)(const Material *m, const ShadingFrame *f, V3 wi);
    /** f |wo.ns| of the lobes with a density (diffuse, glossy) for an eye path, and the density with which
     *  sample() with the same `lobes` would draw wo. NULL: none. */
    Rgb (*eval)(const Material *m, const ShadingFrame *f, V3 wi, V3 wo, unsigned lobes, double *pdf);
    /** The Lambert albedo that a receiver shows towards `eye` (unit). NULL: not a receiver. */
    Rgb (*albedo)(const Material *m, const ShadingFrame *f, V3 eye);
    /** What albedo() leaves out: how much of the light from `light` counts at a receiver, about 1. NULL: all.
     */
    double (*received)(const Material *m, const ShadingFrame *f, V3 light);
    /** Fraction of light passed straight through, for shadow rays. NULL: opaque. */
    Rgb (*transparency)(const Material *m);
} MaterialKind;

/** Keeps all the light that meets it; it has no lobes. */
extern const Material material_black;

/** How much of the light from `light` counts at a receiver of this material. */
static inline double material_received(const Material *m, const ShadingFrame *f, V3 light) {
    return m->kind->received ? m->kind->received(m, f, light) : 1.0;
}

const MaterialKind *material_find(const char *name);
const MaterialKind *const *material_kinds(size_t *count);

#endif
