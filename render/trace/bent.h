/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Light that leaves where Cycles bends a normal.
 *
 *  An interpolated normal is bent by the direction that it is *seen* from (path.h), which a photon does not
 * know. Two ways to make these paths, by what the bent vertex does:
 *
 *  - rough, or smooth and refracting: photons take it on their way, in a direction that is looked for
 * (bent_turn());
 *  - a smooth mirror: all that it shows comes from one height over the face, so a photon that arrives along a
 * given line would find it with probability zero. Of a path's vertices of this kind the one nearest to the
 * receiver is drawn (bent_start()), with the direction that it is seen from; the light is looked for
 * backwards from there, as an eye path would, mostly where light of the lamp has been seen to graze the face
 * (BentGuide); and what is found goes on from there as a photon.
 *
 *  Photons that scatter by an unbent normal leave out what would bend it (`FluxAccount.bent`), so each path
 * is made once. */
#ifndef RENDER_TRACE_BENT_H
#define RENDER_TRACE_BENT_H

#include "render/emit/emit.h"
#include "render/trace/path.h"

typedef struct BentTriangle {
    int object;
    uint32_t primitive;
    double area; /* scene units */
    double last; /**< sum of the weights up to and with this one */
} BentTriangle;

/** What of a scene bends. Zero when nothing does. */
typedef struct BentSet {
    struct BentObject {
        bool bends;
        double eta;        /**< n(behind) / n(in front) of its faces; 0: it does not refract */
        double alpha;      /**< of its microfacets; 0: smooth */
    } * objects;           /**< [object]; NULL: nothing bends */
    BentTriangle *mirrors; /**< triangles of smooth surfaces */
    size_t mirror_count;
    bool rough; /**< some caster is: through it a light without extent can be found backwards */
} BentSet;

/** Objects whose normals bend too rarely to matter are left out: then nothing is allocated, and photons treat
 * them as if nothing bent. */
cau_result bent_create(BentSet *out, const Scene *scene, CauError *err);
void bent_free(BentSet *set);

/** A smooth surface's face that light of a lamp grazes. */
typedef struct BentSeed {
    uint64_t face; /**< 2 * index in BentSet.mirrors, + 1 for the back */
    float azimuth; /**< of the direction towards the light, about the normal of that side, radians */
} BentSeed;

/** Where in bent mirrors a lamp can be found, learned from light that comes from it; see bent_guide.c. Empty:
 *  it is looked for evenly. */
typedef struct BentGuide {
    BentSeed *seeds; /**< in the order of the faces, owned */
    size_t count;
    bool out_of_memory;
} BentGuide;

/** What a search for light needs to know of its run. */
typedef struct BentRun {
    const BentSet *set;
    const BentGuide *guide; /**< of this light; NULL: none */
    const Scene *scene;
    const TraceScene *trace;
    const Light *light;
    bool diffuse;  /**< the way to the light may hold diffuse surfaces */
    bool physical; /**< as in PhotonRun */
    uint64_t key;  /**< random stream */
} BentRun;

/** Light that leaves a bent vertex. */
typedef struct BentStart {
    Hit hit;
    V3 dir;             /**< unit */
    Rgb flux;           /**< of this one photon; the caller divides by their number */
    Chain chain, first; /**< light-side chain with this vertex; its scattering next to the light */
} BentStart;

/** Sends photons of the run's light (its `guide` is not looked at) and notes what they graze. Deterministic.
 * Any thread. */
void bent_guide_create(BentGuide *out, const BentRun *run, const Aim *casters);
void bent_guide_free(BentGuide *guide);
/** Draws a direction in which the face is seen to mirror light like the seed's: evenly in its azimuth and in
 * the bent normal between ng and ns. False: none. */
bool bent_guide_direction(const BentSeed *seed, V3 ng, V3 ns, double u, double v, V3 *dir);
/** The density, per area and steradian, with which a seed drawn evenly, a place drawn evenly on its face and
 * that function give a place on this face and dir. `bent`: the normal as seen from dir. area: of the
 * triangle. */
double bent_guide_pdf(const BentGuide *guide, uint64_t face, double area, V3 ng, V3 ns, V3 bent, V3 dir);

/** Photon `index` of the stream. False: no light was found; it still counts. Adds to *rays. Any thread. */
bool bent_start(const BentRun *run, uint32_t index, BentStart *out, uint64_t *rays);

/** Draws a direction that bends the normal ns, evenly in the projected solid angle. False: there is none. */
bool bent_direction(V3 ng, V3 ns, double u, double v, V3 *dir);
/** Per steradian, the density with which it would draw dir. */
double bent_direction_pdf(V3 ng, V3 ns, V3 dir);

/** Light about to leave by a bent normal. */
typedef struct BentTurn {
    V3 through;            /**< the normal, on the light's side, that light refracted by it bends just so */
    double eta;            /**< n(other side) / n(light's side) */
    double alpha;          /**< of the object */
    double cross, reflect; /**< how many photons should try bent_turn(), in the mean; 0: nothing to find */
} BentTurn;

/** For light from wi; frame: frame_from_light(). */
BentTurn bent_prepare(const BentSet *set, const Hit *hit, const ShadingFrame *frame, V3 wi);
/** Draws where the light goes on, through the surface (`cross`) or not. The weight carries all corrections of
 * interpolated normals. u: three numbers, and one for the choice of a strategy. False: nowhere. */
bool bent_turn(const BentTurn *turn, const Hit *hit, const ShadingFrame *frame, V3 wi, bool cross,
    const double u[4], ScatterSample *out);

#endif
