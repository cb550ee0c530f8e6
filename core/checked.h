/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Checked sizes and the only calls to the allocator.
 *
 *  Every size that comes from a file or a caller is multiplied here, so that an overflow becomes an error and
 *  never a small buffer. */
#ifndef CORE_CHECKED_H
#define CORE_CHECKED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static inline bool checked_mul(size_t a, size_t b, size_t *out) { return !__builtin_mul_overflow(a, b, out); }
static inline bool checked_add(size_t a, size_t b, size_t *out) { return !__builtin_add_overflow(a, b, out); }

/** `count` zeroed elements of `size` bytes, or NULL (overflow or out of memory). A count of 0 gives a valid,
 *  freeable pointer. The caller frees with free(). */
static inline void *array_new(size_t count, size_t size) {
    size_t bytes;
    if (!checked_mul(count, size, &bytes)) return NULL;
    return calloc(1, bytes ? bytes : 1);
}

/** Grows `*array` so that it holds at least `need` elements of `size` bytes; capacity doubles. Contents are
 *  kept, new elements are not initialised. False when out of memory: the old array stays valid. */
static inline bool array_reserve(void **array, size_t *capacity, size_t need, size_t size) {
    if (need <= *capacity) return true;
    size_t wanted = *capacity ? *capacity : 16;
    while (wanted < need)
        if (!checked_mul(wanted, 2, &wanted)) return false;
    size_t bytes;
    if (!checked_mul(wanted, size, &bytes)) return false;
    void *grown = realloc(*array, bytes);
    if (!grown) return false;
    *array = grown;
    *capacity = wanted;
    return true;
}

/** A copy of `text`, to be freed by the caller; NULL when out of memory. */
static inline char *string_copy(const char *text) {
    size_t bytes = strlen(text) + 1;
    char *copy = malloc(bytes);
    if (copy) memcpy(copy, text, bytes);
    return copy;
}

#endif
