/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gather/photon_tree.h"

#include "core/checked.h"
#include "core/wide.h"

typedef struct SortKey {
    uint64_t code;
    uint32_t index;
} SortKey;

enum { CODE_BITS = 21, RADIX_BITS = 11, RADIX = 1 << RADIX_BITS, RADIX_PASSES = 6 };

/* Spreads 21 bits so that two zero bits follow each. */
static uint64_t spread(uint64_t x) {
    x &= 0x1fffffu;
    x = (x | x << 32) & 0x1f00000000ffffu;
    x = (x | x << 16) & 0x1f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    x = (x | x << 2) & 0x1249249249249249u;
    return x;
}

static uint64_t quantise(float p, float lo, double scale) {
    double q = ((double)p - (double)lo) * scale;
    return (uint64_t)clamp(q, 0, (double)((1u << CODE_BITS) - 1));
}

static void make_keys(SortKey *keys, const Deposit *items, size_t count) {
    float lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            lo[k] = wide_min(lo[k], items[i].position[k]);
            hi[k] = wide_max(hi[k], items[i].position[k]);
        }
    double size = 0;
    for (int k = 0; k < 3; k++) size = fmax(size, (double)hi[k] - (double)lo[k]);
    double scale = size > 0 ? (double)((1u << CODE_BITS) - 1) / size : 0;
    for (size_t i = 0; i < count; i++) {
        const float *p = items[i].position;
        keys[i] = (SortKey){spread(quantise(p[0], lo[0], scale)) | spread(quantise(p[1], lo[1], scale)) << 1 |
                                spread(quantise(p[2], lo[2], scale)) << 2,
            (uint32_t)i};
    }
}

/* Stable least-significant-digit radix sort; the result is back in `keys` after an even number of passes. */
static void sort_keys(SortKey *keys, SortKey *scratch, size_t count) {
    for (unsigned pass = 0; pass < RADIX_PASSES; pass++) {
        size_t start[RADIX] = {0}, sum = 0;
        unsigned shift = pass * RADIX_BITS;
        for (size_t i = 0; i < count; i++) start[(keys[i].code >> shift) & (RADIX - 1)]++;
        for (size_t d = 0; d < RADIX; d++) {
            size_t n = start[d];
            start[d] = sum;
            sum += n;
        }
        for (size_t i = 0; i < count; i++) scratch[start[(keys[i].code >> shift) & (RADIX - 1)]++] = keys[i];
        SortKey *swap = keys;
        keys = scratch;
        scratch = swap;
    }
}

static void fill_leaf(TreeLeaf *leaf, const Deposit *items, size_t count) {
    for (size_t i = 0; i < TREE_WIDTH; i++)
        for (int k = 0; k < 3; k++) leaf->place[k][i] = i < count ? items[i].position[k] : INFINITY;
}

/* The box of one leaf or node below becomes child `i`. */
static void box_of_leaf(TreeBoxes *b, size_t i, const TreeLeaf *leaf, size_t count) {
    for (int k = 0; k < 3; k++)
        for (size_t c = 0; c < count; c++) {
            b->lo[k][i] = wide_min(b->lo[k][i], leaf->place[k][c]);
            b->hi[k][i] = wide_max(b->hi[k][i], leaf->place[k][c]);
        }
}

static void box_of_boxes(TreeBoxes *b, size_t i, const TreeBoxes *below) {
    for (int k = 0; k < 3; k++)
        for (size_t c = 0; c < TREE_WIDTH; c++) {
            b->lo[k][i] = wide_min(b->lo[k][i], below->lo[k][c]);
            b->hi[k][i] = wide_max(b->hi[k][i], below->hi[k][c]);
        }
}

static void fill_boxes(PhotonTree *tree, unsigned level, size_t node) {
    TreeBoxes *b = &tree->boxes[level - 1][node];
    for (int k = 0; k < 3; k++)
        for (size_t c = 0; c < TREE_WIDTH; c++) {
            b->lo[k][c] = INFINITY;
            b->hi[k][c] = -INFINITY;
        }
    size_t first = node * TREE_WIDTH;
    for (size_t i = 0; i < TREE_WIDTH && first + i < tree->box_count[level - 1]; i++) {
        size_t deposits = tree->count - (level == 1 ? (first + i) * TREE_WIDTH : 0);
        if (level == 1)
            box_of_leaf(b, i, &tree->leaves[first + i], deposits < TREE_WIDTH ? deposits : TREE_WIDTH);
        else
            box_of_boxes(b, i, &tree->boxes[level - 2][first + i]);
    }
}

static bool build_levels(PhotonTree *tree) {
    tree->levels = 0;
    if (tree->count == 0) return true;
    size_t n = (tree->count + TREE_WIDTH - 1) / TREE_WIDTH;
    if (!array_reserve((void **)&tree->leaves, &tree->leaf_capacity, n, sizeof(TreeLeaf))) return false;
    for (size_t i = 0; i < n; i++)
        fill_leaf(&tree->leaves[i], tree->items + i * TREE_WIDTH, tree->count - i * TREE_WIDTH);
    tree->box_count[tree->levels++] = n;
    while (n > 1) {
        unsigned level = tree->levels++;
        n = (n + TREE_WIDTH - 1) / TREE_WIDTH;
        if (!array_reserve(
                (void **)&tree->boxes[level - 1], &tree->box_capacity[level - 1], n, sizeof(TreeBoxes)))
            return false;
        tree->box_count[level] = n;
        for (size_t i = 0; i < n; i++) fill_boxes(tree, level, i);
    }
    return true;
}

cau_result photon_tree_build(PhotonTree *tree, const Deposit *items, size_t count, CauError *err) {
    tree->count = count;
    bool ok = count <= UINT32_MAX &&
              array_reserve((void **)&tree->items, &tree->item_capacity, count, sizeof *items) &&
              array_reserve((void **)&tree->keys, &tree->key_capacity, count, sizeof(SortKey)) &&
              array_reserve((void **)&tree->scratch, &tree->scratch_capacity, count, sizeof(SortKey));
    if (ok && count > 0) {
        make_keys(tree->keys, items, count);
        sort_keys(tree->keys, tree->scratch, count);
        for (size_t i = 0; i < count; i++) tree->items[i] = items[tree->keys[i].index];
    }
    if (!ok || !build_levels(tree)) {
        tree->count = 0;
        tree->levels = 0;
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory to sort %zu photon deposits", count);
    }
    return CAU_OK;
}

void photon_tree_free(PhotonTree *tree) {
    free(tree->items);
    free(tree->keys);
    free(tree->scratch);
    free(tree->leaves);
    for (unsigned i = 0; i < TREE_LEVELS_MAX; i++) free(tree->boxes[i]);
    *tree = (PhotonTree){0};
}

typedef struct Query {
    const PhotonTree *tree;
    float center[3], radius2;
    TreeVisit *visit;
    void *data;
} Query;

/* One bit for each of the squared distances that is near enough. */
CAU_INLINE unsigned within(const float *d2, float radius2) {
    unsigned near = 0;
    for (unsigned i = 0; i < TREE_WIDTH; i++) near |= d2[i] <= radius2 ? 1u << i : 0;
    return near;
}

CAU_INLINE float gap(float lo, float p, float hi) { return wide_max(wide_max(lo - p, p - hi), 0); }

CAU_INLINE void visit_leaf(const Query *q, size_t leaf) {
    const TreeLeaf *l = &q->tree->leaves[leaf];
    float d2[TREE_WIDTH];
    for (int i = 0; i < TREE_WIDTH; i++) {
        float x = l->place[0][i] - q->center[0], y = l->place[1][i] - q->center[1],
              z = l->place[2][i] - q->center[2];
        d2[i] = x * x + y * y + z * z;
    }
    for (unsigned near = within(d2, q->radius2); near; near &= near - 1) {
        unsigned i = (unsigned)__builtin_ctz(near);
        q->visit(q->data, &q->tree->items[leaf * TREE_WIDTH + i], (double)d2[i]);
    }
}

CAU_WIDE static void visit_node(const Query *q, unsigned level, size_t node) {
    if (level == 0) {
        visit_leaf(q, node);
        return;
    }
    const TreeBoxes *b = &q->tree->boxes[level - 1][node];
    float d2[TREE_WIDTH];
    for (int i = 0; i < TREE_WIDTH; i++) {
        float x = gap(b->lo[0][i], q->center[0], b->hi[0][i]),
              y = gap(b->lo[1][i], q->center[1], b->hi[1][i]),
              z = gap(b->lo[2][i], q->center[2], b->hi[2][i]);
        d2[i] = x * x + y * y + z * z;
    }
    for (unsigned near = within(d2, q->radius2); near; near &= near - 1)
        visit_node(q, level - 1, node * TREE_WIDTH + (unsigned)__builtin_ctz(near));
}

void photon_tree_query(const PhotonTree *tree, V3 center, double radius, TreeVisit *visit, void *data) {
    if (tree->levels == 0) return;
    Query q = {
        tree, {(float)center.x, (float)center.y, (float)center.z}, (float)(radius * radius), visit, data};
    visit_node(&q, tree->levels - 1, 0);
}
