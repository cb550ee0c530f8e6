/* SPDX-License-Identifier: Apache-2.0 */
#include "core/rng.h"

/* Direction numbers, most significant bit first, of the first four dimensions (Joe and Kuo 2008):
 * dimension 1 is van der Corput; the others come from the primitive polynomials and initial numbers
 * (s=1,a=0,m=1), (s=2,a=1,m=1 3), (s=3,a=1,m=1 3 1). */
typedef struct SobolSeed {
    unsigned degree, polynomial, m[3];
} SobolSeed;

static uint32_t sobol_direction(unsigned dimension, unsigned bit) {
    static const SobolSeed seeds[3] = {{1, 0, {1, 0, 0}}, {2, 1, {1, 3, 0}}, {3, 1, {1, 3, 1}}};
    if (dimension == 0) return 0x80000000u >> bit;
    const SobolSeed *s = &seeds[dimension - 1];
    uint32_t v[32];
    for (unsigned i = 0; i <= bit; i++) {
        if (i < s->degree) {
            v[i] = (uint32_t)s->m[i] << (31 - i);
            continue;
        }
        v[i] = v[i - s->degree] ^ (v[i - s->degree] >> s->degree);
        for (unsigned k = 1; k < s->degree; k++)
            if ((s->polynomial >> (s->degree - 1 - k)) & 1u) v[i] ^= v[i - k];
    }
    return v[bit];
}

static uint32_t reverse_bits(uint32_t x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    return __builtin_bswap32(x);
}

/* A random tree permutation of the bits, from the least significant up (Laine and Karras 2011, with the
 * constants improved by Vegdahl 2021). */
static uint32_t permute(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

static uint32_t owen_scramble(uint32_t x, uint32_t seed) { return reverse_bits(permute(reverse_bits(x), seed)); }

double sobol_owen(uint32_t index, unsigned dimension, uint64_t key) {
    uint32_t shuffled = owen_scramble(index, (uint32_t)rng_mix(key));
    uint32_t x = 0;
    if (dimension == 0) {
        x = reverse_bits(shuffled);
    } else {
        for (unsigned bit = 0; shuffled; bit++, shuffled >>= 1)
            if (shuffled & 1u) x ^= sobol_direction(dimension, bit);
    }
    return (double)owen_scramble(x, (uint32_t)rng_mix(key + dimension + 1)) * 0x1p-32;
}
