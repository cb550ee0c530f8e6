/* SPDX-License-Identifier: Apache-2.0 */
#include "core/rng.h"

/* What four direction numbers make of each value of four bits. */
#define NIBBLE(a, b, c, d)                                                                                   \
    {                                                                                                        \
        0, a, b, (a) ^ (b), c, (a) ^ (c), (b) ^ (c), (a) ^ (b) ^ (c), d, (a) ^ (d), (b) ^ (d),               \
            (a) ^ (b) ^ (d), (c) ^ (d), (a) ^ (c) ^ (d), (b) ^ (c) ^ (d), (a) ^ (b) ^ (c) ^ (d)              \
    }

/* Direction numbers, most significant bit first, of dimensions 2 to 4 (Joe and Kuo 2008: primitive
 * polynomials and initial numbers (s=1,a=0,m=1), (s=2,a=1,m=1 3), (s=3,a=1,m=1 3 1)), by four; dimension 1 is
 * van der Corput. */
static const uint32_t sobol_nibbles[SOBOL_DIMENSIONS - 1][8][16] = {
    {NIBBLE(0x80000000u, 0xc0000000u, 0xa0000000u, 0xf0000000u),
        NIBBLE(0x88000000u, 0xcc000000u, 0xaa000000u, 0xff000000u),
        NIBBLE(0x80800000u, 0xc0c00000u, 0xa0a00000u, 0xf0f00000u),
        NIBBLE(0x88880000u, 0xcccc0000u, 0xaaaa0000u, 0xffff0000u),
        NIBBLE(0x80008000u, 0xc000c000u, 0xa000a000u, 0xf000f000u),
        NIBBLE(0x88008800u, 0xcc00cc00u, 0xaa00aa00u, 0xff00ff00u),
        NIBBLE(0x80808080u, 0xc0c0c0c0u, 0xa0a0a0a0u, 0xf0f0f0f0u),
        NIBBLE(0x88888888u, 0xccccccccu, 0xaaaaaaaau, 0xffffffffu)},
    {NIBBLE(0x80000000u, 0xc0000000u, 0x60000000u, 0x90000000u),
        NIBBLE(0xe8000000u, 0x5c000000u, 0x8e000000u, 0xc5000000u),
        NIBBLE(0x68800000u, 0x9cc00000u, 0xee600000u, 0x55900000u),
        NIBBLE(0x80680000u, 0xc09c0000u, 0x60ee0000u, 0x90550000u),
        NIBBLE(0xe8808000u, 0x5cc0c000u, 0x8e606000u, 0xc5909000u),
        NIBBLE(0x6868e800u, 0x9c9c5c00u, 0xeeee8e00u, 0x5555c500u),
        NIBBLE(0x8000e880u, 0xc0005cc0u, 0x60008e60u, 0x9000c590u),
        NIBBLE(0xe8006868u, 0x5c009c9cu, 0x8e00eeeeu, 0xc5005555u)},
    {NIBBLE(0x80000000u, 0xc0000000u, 0x20000000u, 0x50000000u),
        NIBBLE(0xf8000000u, 0x74000000u, 0xa2000000u, 0x93000000u),
        NIBBLE(0xd8800000u, 0x25400000u, 0x59e00000u, 0xe6d00000u),
        NIBBLE(0x78080000u, 0xb40c0000u, 0x82020000u, 0xc3050000u),
        NIBBLE(0x208f8000u, 0x51474000u, 0xfbea2000u, 0x75d93000u),
        NIBBLE(0xa0858800u, 0x914e5400u, 0xdbe79e00u, 0x25db6d00u),
        NIBBLE(0x58800080u, 0xe54000c0u, 0x79e00020u, 0xb6d00050u),
        NIBBLE(0x800800f8u, 0xc00c0074u, 0x200200a2u, 0x50050093u)}};

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

static inline uint32_t owen_scramble(uint32_t x, uint32_t seed) {
    return reverse_bits(permute(reverse_bits(x), seed));
}

double sobol_owen(uint32_t index, unsigned dimension, uint64_t key) {
    uint32_t shuffled = owen_scramble(index, (uint32_t)rng_mix(key));
    uint32_t x = 0;
    if (dimension == 0) {
        x = reverse_bits(shuffled);
    } else {
        const uint32_t(*nibbles)[16] = sobol_nibbles[dimension - 1];
        for (unsigned i = 0; i < 8; i++) x ^= nibbles[i][shuffled >> 4 * i & 15];
    }
    return (double)owen_scramble(x, (uint32_t)rng_mix(key + dimension + 1)) * 0x1p-32;
}
