/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Deposits in Morton order under a tree of boxes.
 *
 *  Any radius can be asked for, no deposit is ever met twice, equal positions cost nothing special, and
 * nothing depends on a cell size in metres. Leaves hold 8 deposits, nodes 8 children, in implicit arrays. */
#ifndef RENDER_GATHER_PHOTON_TREE_H
#define RENDER_GATHER_PHOTON_TREE_H

#include "render/trace/photons.h"

enum { TREE_WIDTH = 8, TREE_LEVELS_MAX = 16 };

typedef struct TreeBox {
    float lo[3], hi[3];
} TreeBox;

/** Zero-initialise; reused from build to build. */
typedef struct PhotonTree {
    Deposit *items; /* in Morton order */
    size_t count, item_capacity;
    TreeBox *boxes[TREE_LEVELS_MAX]; /* [0]: one box per 8 deposits */
    size_t box_count[TREE_LEVELS_MAX], box_capacity[TREE_LEVELS_MAX];
    unsigned levels;
    struct SortKey *keys, *scratch;
    size_t key_capacity, scratch_capacity;
} PhotonTree;

/** Sorts a copy of the deposits. Equal positions keep their order. */
cau_result photon_tree_build(PhotonTree *tree, const Deposit *items, size_t count, CauError *err);
void photon_tree_free(PhotonTree *tree);

/** Called for each deposit within `radius` of the centre, always in the same order. */
typedef void TreeVisit(void *data, const Deposit *deposit, double distance2);
void photon_tree_query(const PhotonTree *tree, V3 center, double radius, TreeVisit *visit, void *data);

#endif
