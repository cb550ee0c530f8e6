/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Deposits in Morton order under a tree of boxes.
 *
 *  Any radius can be asked for, no deposit is ever met twice, equal positions cost nothing special, and
 * nothing depends on a cell size in metres. Leaves hold 8 deposits, nodes 8 children, in implicit arrays;
 * what is tested lies coordinate by coordinate, so that the compiler tests four at once. */
#ifndef RENDER_GATHER_PHOTON_TREE_H
#define RENDER_GATHER_PHOTON_TREE_H

#include "render/trace/photons.h"

enum { TREE_WIDTH = 8, TREE_LEVELS_MAX = 16 };

/** Places of a leaf's deposits, infinite where there is none. */
typedef struct TreeLeaf {
    float place[3][TREE_WIDTH];
} TreeLeaf;

/** Boxes of a node's children, from infinity to minus infinity where there is none. */
typedef struct TreeBoxes {
    float lo[3][TREE_WIDTH], hi[3][TREE_WIDTH];
} TreeBoxes;

/** Zero-initialise; reused from build to build. */
typedef struct PhotonTree {
    Deposit *items; /* in Morton order */
    size_t count, item_capacity;
    TreeLeaf *leaves;
    size_t leaf_capacity;
    TreeBoxes *boxes[TREE_LEVELS_MAX]; /* [level - 1], of the nodes of a level above the leaves */
    size_t box_capacity[TREE_LEVELS_MAX];
    size_t box_count[TREE_LEVELS_MAX]; /* [level] leaves or nodes; one at the top */
    unsigned levels;                   /* the leaves too */
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
