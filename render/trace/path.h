/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What every estimator must agree on: which paths are ours, Cycles' bounce limits, Cycles' conventions.
 *
 *  Cycles with caustics off drops every glossy or specular scattering that the camera path meets after a
 * diffuse one. Seen from the light: a path is ours when S or G comes before some D (L .. (S|G) .. D .. E).
 * With one D it is a direct caustic, with more an indirect one. */
#ifndef RENDER_TRACE_PATH_H
#define RENDER_TRACE_PATH_H

#include "render/trace/embree.h"

typedef enum PathOwner {
    OWNER_CYCLES,  /**< Cycles has it with caustics off: not ours */
    OWNER_DIRECT,  /**< layer caustics_<light> */
    OWNER_INDIRECT /**< layer caustics_<light>_ind */
} PathOwner;

/** The scatterings of a chain, in either direction. */
typedef struct Chain {
    unsigned diffuse, glossy, transmission; /**< counts; `glossy` are reflections, specular ones too */
    bool cast;    /**< light side: holds S or G. Eye side: the last scattering was D */
    bool dropped; /**< S or G stands on the light's side of a D */
} Chain;

/** A scattering added at the eye end of a light-side chain. */
static inline void chain_add_from_light(Chain *c, unsigned lobe, bool transmit) {
    if (lobe == LOBE_TRANSPARENT) return;
    if (lobe == LOBE_DIFFUSE) {
        c->diffuse++;
        if (c->cast) c->dropped = true;
        return;
    }
    c->cast = true;
    if (transmit)
        c->transmission++;
    else
        c->glossy++;
}

/** A scattering added at the light end of an eye-side chain. `cast` means here: left a diffuse closure. */
static inline void chain_add_from_eye(Chain *c, unsigned lobe, bool transmit) {
    if (lobe == LOBE_TRANSPARENT) return;
    if (lobe == LOBE_DIFFUSE) {
        c->diffuse++;
        c->cast = true;
        return;
    }
    if (c->cast) c->dropped = true;
    c->cast = false;
    if (transmit)
        c->transmission++;
    else
        c->glossy++;
}

/** The one ownership predicate: of a whole path, whichever end its chain was built from. */
static inline PathOwner chain_owner(const Chain *c) {
    if (!c->dropped) return OWNER_CYCLES;
    return c->diffuse == 1 ? OWNER_DIRECT : OWNER_INDIRECT;
}

/** Cycles' limits apply to the scatterings of a path without the one next to the light (Cycles 3.4,
 *  kernel/integrator/path_state.h: a path is stopped at the first surface after a count passes its limit). */
static inline bool bounces_allow(
    const BounceParams *b, unsigned diffuse, unsigned glossy, unsigned transmission) {
    return (b->diffuse < 0 || diffuse <= b->diffuse) && (b->glossy < 0 || glossy <= b->glossy) &&
           (b->transmission < 0 || transmission <= b->transmission) &&
           (b->total < 0 || diffuse + glossy + transmission <= b->total);
}

/** Cycles bends the normal of every closure so that the mirror direction of wi stays at least this high over
 * the surface (ensure_valid_reflection() of Cycles 3.4; checked by measurement: without it the glass of scene
 * d is 15 standard errors off in places). */
#define MIRROR_HEIGHT 0.01
/** That least height is never more than this share of wi's own. */
#define MIRROR_SHARE 0.9

/** The frame of a hit as seen from wi, which points away from the surface. Where an interpolated normal would
 *  mirror wi into the surface it is bent towards the geometric one, as Cycles does (shading_bend() in
 * path.c). */
ShadingFrame frame_from_hit(const Hit *hit, V3 wi);
/** Whether frame_from_hit() bends the normal ns for wi. ng and ns on wi's side. */
bool normal_bends(V3 ng, V3 ns, V3 wi);
/** Which directions bend a normal tilted by `tilt` (radians) from ng. Among those whose part in the plane of
 * the two normals has length r: the ones that stand less than this angle (radians, 0 to pi) over the side
 * away from ns. */
double bend_elevation(double tilt, double r);
/** The same with the interpolated normal as it is: for light carried from the lamp, which does not know yet
 * from where it will be seen. See light_is_seen(). */
ShadingFrame frame_from_light(const Hit *hit, V3 wi);

/** Whether an eye path has the scattering that light from wi made towards wo in this frame. Not where wi lies
 * behind the interpolated normal: seen from wo it would have left into the surface. */
static inline bool light_is_seen(const ShadingFrame *f, V3 wi) { return v3_dot(wi, f->ns) > 0; }
/** Whether, seen from wo, the normal would have been bent: such light is bent.h's. */
static inline bool light_is_bent(const ShadingFrame *f, V3 wo) {
    return v3_dot(wo, f->ng) >= 0 ? normal_bends(f->ng, f->ns, wo)
                                  : normal_bends(v3_neg(f->ng), v3_neg(f->ns), wo);
}

/** Correction of interpolated normals for light carried from the lamp (Veach 1996, eq. 5.19): with it photons
 *  agree with a path tracer that uses |w.ns|. */
static inline double shading_adjoint(const ShadingFrame *f, V3 wi, V3 wo) {
    double above = fabs(v3_dot(wi, f->ns)) * fabs(v3_dot(wo, f->ng));
    double below = fabs(v3_dot(wi, f->ng)) * fabs(v3_dot(wo, f->ns));
    return below > 0 ? above / below : 0;
}

/** The kind of ray that Cycles would have sent from a scattering of this kind (ray visibility). */
static inline unsigned visibility_after(unsigned lobe, bool transmit) {
    if (lobe == LOBE_DIFFUSE) return VISIBLE_DIFFUSE;
    return transmit ? VISIBLE_TRANSMISSION : VISIBLE_GLOSSY;
}

#endif
