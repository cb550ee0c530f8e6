/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Photons through the scene: where light that S or G has touched meets a receiver.
 *
 *  Two kinds of run, one per layer: for the direct layer a path ends at its first diffuse surface, for the
 *  indirect layer it goes on. A photon is decided by (key, index) alone; photons are traced in batches whose
 *  results are joined in batch order, so the bytes do not depend on the number of threads. */
#ifndef RENDER_TRACE_PHOTONS_H
#define RENDER_TRACE_PHOTONS_H

#include "core/tasks.h"
#include "render/emit/emit.h"
#include "render/trace/bent.h"

#include <stdatomic.h>

/** Light that arrived at a receiver. */
typedef struct Deposit {
    float position[3];
    float flux[3]; /**< of the whole run (already divided by the photons emitted), corrected: see photons.c */
    int16_t normal[2]; /**< octahedral, the geometric normal on the side that was hit */
    uint8_t diffuse, glossy,
        transmission; /**< scatterings without the receiver and without the one next to the light */
    uint8_t audience; /**< AUDIENCE_*: which eye points gather it */
} Deposit;

/** Scatterings up to which a smooth path is estimator W's. */
enum { PHOTONS_WAVE_DEPTH = 24 };

enum { AUDIENCE_ALL, AUDIENCE_SEEN }; /* SEEN: those that see it through glass or in mirrors */

/** Where the emitted flux went; scene flux units, uncorrected. emitted = landed + straight + absorbed +
 * escaped
 *  + cut + bent + dropped. In an indirect run light goes on after a receiver: `landed` is then what arrived
 * at receivers as indirect caustic light and is not part of the sum. */
typedef struct FluxAccount {
    Rgb emitted;  /**< left the light towards the targets, or a bent normal: see bent.h */
    Rgb landed;   /**< fell on receivers as caustic light */
    Rgb straight; /**< fell on receivers without S or G before: Cycles has it; or by a path of estimator W */
    Rgb absorbed; /**< taken by surfaces */
    Rgb escaped;  /**< left the scene */
    Rgb cut;      /**< ended by the scene's own bounce limits */
    Rgb bent;     /**< would be seen by a bent normal: bent.h has these paths */
    Rgb dropped;  /**< lost by us: depth cap, and the balance of the roulette */
    uint64_t photons, rays, deposits;
    uint64_t non_finite; /**< deposits refused because a value was NaN or Inf */
} FluxAccount;

void flux_account_add(FluxAccount *sum, const FluxAccount *part);

typedef struct PhotonRun {
    const Scene *scene;
    const TraceScene *trace;
    const Light *light;
    AimMix aim;
    const Aim *casters;        /**< where light goes from a diffuse surface before it has met S or G */
    const bool *waved;         /**< [object] smooth paths over such alone are estimator W's; NULL: none are */
    PathOwner owner;           /**< OWNER_DIRECT or OWNER_INDIRECT: which deposits are kept */
    bool physical;             /**< true: radiance scales with n^2 as in nature; false: as Cycles does */
    uint64_t key;              /**< random stream of this run */
    uint32_t photons;          /**< how many are emitted; may be 0 */
    const BentSet *bent;       /**< normals that bend; NULL: none do */
    const BentGuide *guide;    /**< where they find the light; NULL: they look evenly */
    uint32_t bent_photons;     /**< how many photons start there besides; 0 with bent NULL */
    FluxAccount *bent_account; /**< theirs; added to */
    const atomic_bool *cancel;
} PhotonRun;

/** Deposits of one run, owned; reused from run to run. Zero-initialise. */
typedef struct DepositList {
    Deposit *items;
    size_t count, capacity;
    struct PhotonBatch *batches;
    size_t batch_count;
} DepositList;

/** Traces a run. A cancelled run gives CAU_ERROR_CANCELLED and a list that must not be used. */
cau_result photons_trace(
    const PhotonRun *run, TaskPool *pool, DepositList *out, FluxAccount *account, CauError *err);
void deposits_free(DepositList *list);

void normal_encode(V3 n, int16_t out[2]);
V3 normal_decode(const int16_t n[2]);

#endif
