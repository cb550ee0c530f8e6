/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gather/photon_tree.h"

#include "core/checked.h"

typedef struct SortKey {
    uint64_t code;
    uint32_t index;
} SortKey;

enum { CODE_BITS = 21, RADIX_BITS = 11, RADIX = 1 << RADIX_BITS, RADIX_PASSES = 6 };

/* Without fminf()'s care for NaN, which costs a call; deposits are finite. */
static float lower(float a, float b) { return b < a ? b : a; }
static float higher(float a, float b) { return b > a ? b : a; }

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
            lo[k] = fminf(lo[k], items[i].position[k]);
            hi[k] = fmaxf(hi[k], items[i].position[k]);
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

static void box_of_deposits(TreeBox *b, const Deposit *items, size_t count) {
    *b = (TreeBox){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            b->lo[k] = lower(b->lo[k], items[i].position[k]);
            b->hi[k] = higher(b->hi[k], items[i].position[k]);
        }
}

static void box_of_boxes(TreeBox *b, const TreeBox *children, size_t count) {
    *b = children[0];
    for (size_t i = 1; i < count; i++)
        for (int k = 0; k < 3; k++) {
            b->lo[k] = lower(b->lo[k], children[i].lo[k]);
            b->hi[k] = higher(b->hi[k], children[i].hi[k]);
        }
}

static bool build_boxes(PhotonTree *tree) {
    tree->levels = 0;
    size_t below = tree->count;
    while (below > 0 && (tree->levels == 0 || below > 1)) {
        unsigned level = tree->levels++;
        size_t n = (below + TREE_WIDTH - 1) / TREE_WIDTH;
        if (!array_reserve((void **)&tree->boxes[level], &tree->box_capacity[level], n, sizeof(TreeBox)))
            return false;
        tree->box_count[level] = n;
        for (size_t i = 0; i < n; i++) {
            size_t first = i * TREE_WIDTH, some = below - first < TREE_WIDTH ? below - first : TREE_WIDTH;
            if (level == 0)
                box_of_deposits(&tree->boxes[0][i], tree->items + first, some);
            else
                box_of_boxes(&tree->boxes[level][i], tree->boxes[level - 1] + first, some);
        }
        below = n;
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
    if (!ok || !build_boxes(tree)) {
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
    for (unsigned i = 0; i < TREE_LEVELS_MAX; i++) free(tree->boxes[i]);
    *tree = (PhotonTree){0};
}

typedef struct Query {
    const PhotonTree *tree;
    float center[3], radius2;
    TreeVisit *visit;
    void *data;
} Query;

static bool box_near(const TreeBox *b, const Query *q) {
    float d2 = 0;
    for (int k = 0; k < 3; k++) {
        float below = b->lo[k] - q->center[k], above = q->center[k] - b->hi[k];
        float d = below > above ? below : above;
        d2 += d > 0 ? d * d : 0;
    }
    return d2 <= q->radius2;
}

static void visit_leaf(const Query *q, size_t leaf) {
    size_t first = leaf * TREE_WIDTH, last = first + TREE_WIDTH;
    if (last > q->tree->count) last = q->tree->count;
    for (size_t i = first; i < last; i++) {
        const Deposit *d = &q->tree->items[i];
        float x = d->position[0] - q->center[0], y = d->position[1] - q->center[1],
              z = d->position[2] - q->center[2];
        float d2 = x * x + y * y + z * z;
        if (d2 <= q->radius2) q->visit(q->data, d, (double)d2);
    }
}

static void visit_node(const Query *q, unsigned level, size_t node) {
    if (!box_near(&q->tree->boxes[level][node], q)) return;
    if (level == 0) {
        visit_leaf(q, node);
        return;
    }
    size_t first = node * TREE_WIDTH, last = first + TREE_WIDTH;
    if (last > q->tree->box_count[level - 1]) last = q->tree->box_count[level - 1];
    for (size_t i = first; i < last; i++) visit_node(q, level - 1, i);
}

void photon_tree_query(const PhotonTree *tree, V3 center, double radius, TreeVisit *visit, void *data) {
    if (tree->levels == 0) return;
    Query q = {
        tree, {(float)center.x, (float)center.y, (float)center.z}, (float)(radius * radius), visit, data};
    visit_node(&q, tree->levels - 1, 0);
}
