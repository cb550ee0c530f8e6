/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Names to indices: a hash table, so that a scene of a hundred thousand objects is not searched for each. */
#ifndef RENDER_SCENE_NAMES_H
#define RENDER_SCENE_NAMES_H

#include <stdbool.h>
#include <stddef.h>

typedef struct NameEntry {
    const char *name; /**< borrowed: lives as long as what it names */
    size_t index;
} NameEntry;

typedef struct NameTable {
    NameEntry *entries;
    size_t count, capacity; /**< capacity is a power of two, or 0 */
} NameTable;

/** False when there is none of that name. */
bool names_find(const NameTable *table, const char *name, size_t *index);
/** The name must not be in the table yet. False when out of memory: the table is as before. */
bool names_add(NameTable *table, const char *name, size_t index);
void names_free(NameTable *table);

#endif
