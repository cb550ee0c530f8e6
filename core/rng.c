/* SPDX-License-Identifier: Apache-2.0 */
#include "core/rng.h"

/* A point of the sequence, its bits reversed: the scramble wants them so. */
typedef struct Bits {
    uint32_t of[SOBOL_DIMENSIONS];
} Bits;

/* What four direction numbers make of the value n of four bits. */
#define SUM(n, a, b, c, d) (((n)&1 ? (a) : 0u) ^ ((n)&2 ? (b) : 0u) ^ ((n)&4 ? (c) : 0u) ^ ((n)&8 ? (d) : 0u))
/* Dimension 1 is van der Corput: the bits themselves. */
#define POINT(i, n, a, b, c, d, e, f, g, h, j, k, l, m)                                                      \
    {                                                                                                        \
        { (n##u) << 4 * (i), SUM(n, a, b, c, d), SUM(n, e, f, g, h), SUM(n, j, k, l, m) }                    \
    }
#define NIBBLE(i, ...)                                                                                       \
    {                                                                                                        \
        POINT(i, 0, __VA_ARGS__), POINT(i, 1, __VA_ARGS__), POINT(i, 2, __VA_ARGS__),                        \
            POINT(i, 3, __VA_ARGS__), POINT(i, 4, __VA_ARGS__), POINT(i, 5, __VA_ARGS__),                    \
            POINT(i, 6, __VA_ARGS__), POINT(i, 7, __VA_ARGS__), POINT(i, 8, __VA_ARGS__),                    \
            POINT(i, 9, __VA_ARGS__), POINT(i, 10, __VA_ARGS__), POINT(i, 11, __VA_ARGS__),                  \
            POINT(i, 12, __VA_ARGS__), POINT(i, 13, __VA_ARGS__), POINT(i, 14, __VA_ARGS__),                 \
            POINT(i, 15, __VA_ARGS__)                                                                        \
    }

/* Direction numbers, bits reversed, of dimensions 2 to 4 (Joe and Kuo 2008: primitive polynomials and initial
 * numbers (s=1,a=0,m=1), (s=2,a=1,m=1 3), (s=3,a=1,m=1 3 1)), by four bits of the point's number. All
 * dimensions of a point lie together, for they are wanted together. */
static const Bits sobol_nibbles[8][16] = {
    NIBBLE(0, 0x00000001u, 0x00000003u, 0x00000005u, 0x0000000fu, 0x00000001u, 0x00000003u, 0x00000006u,
        0x00000009u, 0x00000001u, 0x00000003u, 0x00000004u, 0x0000000au),
    NIBBLE(1, 0x00000011u, 0x00000033u, 0x00000055u, 0x000000ffu, 0x00000017u, 0x0000003au, 0x00000071u,
        0x000000a3u, 0x0000001fu, 0x0000002eu, 0x00000045u, 0x000000c9u),
    NIBBLE(2, 0x00000101u, 0x00000303u, 0x00000505u, 0x00000f0fu, 0x00000116u, 0x00000339u, 0x00000677u,
        0x000009aau, 0x0000011bu, 0x000002a4u, 0x0000079au, 0x00000b67u),
    NIBBLE(3, 0x00001111u, 0x00003333u, 0x00005555u, 0x0000ffffu, 0x00001601u, 0x00003903u, 0x00007706u,
        0x0000aa09u, 0x0000101eu, 0x0000302du, 0x00004041u, 0x0000a0c3u),
    NIBBLE(4, 0x00010001u, 0x00030003u, 0x00050005u, 0x000f000fu, 0x00010117u, 0x0003033au, 0x00060671u,
        0x000909a3u, 0x0001f104u, 0x0002e28au, 0x000457dfu, 0x000c9baeu),
    NIBBLE(5, 0x00110011u, 0x00330033u, 0x00550055u, 0x00ff00ffu, 0x00171616u, 0x003a3939u, 0x00717777u,
        0x00a3aaaau, 0x0011a105u, 0x002a7289u, 0x0079e7dbu, 0x00b6dba4u),
    NIBBLE(6, 0x01010101u, 0x03030303u, 0x05050505u, 0x0f0f0f0fu, 0x01170001u, 0x033a0003u, 0x06710006u,
        0x09a30009u, 0x0100011au, 0x030002a7u, 0x0400079eu, 0x0a000b6du),
    NIBBLE(7, 0x11111111u, 0x33333333u, 0x55555555u, 0xffffffffu, 0x16160017u, 0x3939003au, 0x77770071u,
        0xaaaa00a3u, 0x1f001001u, 0x2e003003u, 0x45004004u, 0xc900a00au)};

static inline uint32_t reverse_bits(uint32_t x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    return __builtin_bswap32(x);
}

/* A random tree permutation of the bits, from the least significant up (Laine and Karras 2011, with the
 * constants improved by Vegdahl 2021). */
static inline uint32_t permute(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

static inline uint32_t shuffle(uint32_t index, uint64_t key) {
    return reverse_bits(permute(reverse_bits(index), (uint32_t)rng_mix(key)));
}

static inline uint32_t dimension_seed(uint64_t key, unsigned dimension) {
    return (uint32_t)rng_mix(key + dimension + 1);
}

double sobol_owen(uint32_t index, unsigned dimension, uint64_t key) {
    uint32_t shuffled = shuffle(index, key), x = 0;
    for (unsigned i = 0; i < 8; i++) x ^= sobol_nibbles[i][shuffled >> 4 * i & 15].of[dimension];
    return (double)reverse_bits(permute(x, dimension_seed(key, dimension))) * 0x1p-32;
}

void sobol_owen_point(uint32_t index, uint64_t key, double out[SOBOL_DIMENSIONS]) {
    uint32_t shuffled = shuffle(index, key);
    Bits x = sobol_nibbles[0][shuffled & 15];
    for (unsigned i = 1; i < 8; i++) {
        const Bits *nibble = &sobol_nibbles[i][shuffled >> 4 * i & 15];
        for (unsigned d = 0; d < SOBOL_DIMENSIONS; d++) x.of[d] ^= nibble->of[d];
    }
    for (unsigned d = 0; d < SOBOL_DIMENSIONS; d++) x.of[d] = permute(x.of[d], dimension_seed(key, d));
    for (unsigned d = 0; d < SOBOL_DIMENSIONS; d++) x.of[d] = reverse_bits(x.of[d]);
    for (unsigned d = 0; d < SOBOL_DIMENSIONS; d++) out[d] = (double)x.of[d] * 0x1p-32;
}
