/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Inside photons.h: the batches that photons are traced in, and how they become one list. */
#ifndef RENDER_TRACE_DEPOSITS_H
#define RENDER_TRACE_DEPOSITS_H

#include "render/trace/photons.h"

enum { PHOTONS_PER_BATCH = 1024 };

typedef struct PhotonBatch {
    Deposit *items;
    size_t count, capacity;
    FluxAccount account;
    bool out_of_memory;
} PhotonBatch;

static inline size_t photon_batches(uint32_t photons) {
    return (photons + (size_t)PHOTONS_PER_BATCH - 1) / PHOTONS_PER_BATCH;
}

/** Joins the batches in their order, the lamp's before those of bent normals. */
cau_result deposits_join(const PhotonRun *run, DepositList *out, FluxAccount *account, CauError *err);

#endif
