/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Random numbers that come from (seed, stream, pass, index, dimension), never from a thread.
 *
 *  Two kinds: Owen-scrambled Sobol points for the first few dimensions of a photon or a pixel, and a counter
 *  hash for every later decision.
 *  Sources: Sobol direction numbers of Joe and Kuo 2008 (dimensions 1 to 4); hashed Owen scrambling of Burley
 *  2020, "Practical Hash-based Owen Scrambling", JCGT 9(4), with the permutation of Laine and Karras 2011;
 *  the 64-bit mixer is the finaliser of SplitMix64 (Steele et al. 2014). */
#ifndef CORE_RNG_H
#define CORE_RNG_H

#include <stdint.h>

static inline uint64_t rng_mix(uint64_t x) {
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

static inline uint64_t rng_combine(uint64_t a, uint64_t b) { return rng_mix(a ^ rng_mix(b)); }

/** 53 random bits as a double in [0, 1). */
static inline double rng_unit(uint64_t bits) { return (double)(bits >> 11) * 0x1p-53; }

/** A stream of independent uniform numbers. */
typedef struct Rng {
    uint64_t key, counter;
} Rng;

static inline Rng rng_make(uint64_t key) { return (Rng){key, 0}; }
static inline double rng_next(Rng *rng) {
    return rng_unit(rng_mix(rng->key + 0xd1342543de82ef95u * ++rng->counter));
}

/** FNV-1a of a name: the identity of a light in the random streams, so that a layer does not depend on which
 *  other lights the scene holds. */
static inline uint64_t rng_hash_text(const char *text) {
    uint64_t h = 0xcbf29ce484222325u;
    for (; *text; text++) h = (h ^ (unsigned char)*text) * 0x100000001b3u;
    return rng_mix(h);
}

enum { SOBOL_DIMENSIONS = 4 };

/** Point `index` of the scrambled sequence `key`, dimension in [0, SOBOL_DIMENSIONS), in [0, 1). The order of
 *  the points is scrambled too, so that sequences of different keys are independent. */
double sobol_owen(uint32_t index, unsigned dimension, uint64_t key);
/** All dimensions of the point, for little more than one of them costs. */
void sobol_owen_point(uint32_t index, uint64_t key, double out[SOBOL_DIMENSIONS]);

/** Numbers for the scatterings of a path: the first few get a scrambled sequence each (independent scrambles
 * of the same points, "padding"), later ones are plain random. */
typedef struct PathNumbers {
    Rng rng;
    uint64_t key;
    uint32_t index;
    unsigned depth, dimension;
    double point[SOBOL_DIMENSIONS]; /* of this depth; made when its first number is asked for */
} PathNumbers;

enum { PATH_SOBOL_DEPTH = 6 };

/** `index` is the path's number in the sequence that `key` names. */
static inline PathNumbers path_numbers(uint64_t key, uint32_t index) {
    return (PathNumbers){.rng = rng_make(rng_combine(key, index)), .key = key, .index = index};
}
/** Moves to the next scattering. */
static inline void path_numbers_next(PathNumbers *n) {
    n->depth++;
    n->dimension = 0;
}
static inline double path_number(PathNumbers *n) {
    if (n->depth >= PATH_SOBOL_DEPTH || n->dimension >= SOBOL_DIMENSIONS) return rng_next(&n->rng);
    if (n->dimension == 0)
        sobol_owen_point(n->index, n->key + 0x9e3779b97f4a7c15u * (n->depth + 1), n->point);
    return n->point[n->dimension++];
}

#endif
