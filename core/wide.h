/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Loops over eight floats at once where the processor can. */
#ifndef CORE_WIDE_H
#define CORE_WIDE_H

/** Before a function: compiled for AVX2 too, and chosen when the program starts. The results are the same,
 * for nothing is contracted (cmake/options.cmake). Not under sanitizers, which are not there yet when that
 *  happens. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define CAU_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define CAU_SANITIZED 1
#endif
#endif
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(CAU_SANITIZED)
#define CAU_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define CAU_WIDE
#endif

/** Before what such a function calls in its loops: to be compiled with it. */
#define CAU_INLINE static inline __attribute__((always_inline))

/** Without fminf()'s and fmaxf()'s care for NaN, which costs a call. */
CAU_INLINE float wide_min(float a, float b) { return b < a ? b : a; }
CAU_INLINE float wide_max(float a, float b) { return b > a ? b : a; }

#endif
