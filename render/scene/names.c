/* SPDX-License-Identifier: Apache-2.0 */
#include "render/scene/names.h"

#include "core/checked.h"
#include "core/rng.h"

static NameEntry *slot(const NameTable *t, const char *name) {
    size_t i = (size_t)rng_hash_text(name) & (t->capacity - 1);
    while (t->entries[i].name && strcmp(t->entries[i].name, name) != 0) i = (i + 1) & (t->capacity - 1);
    return &t->entries[i];
}

bool names_find(const NameTable *table, const char *name, size_t *index) {
    if (!table->capacity) return false;
    const NameEntry *e = slot(table, name);
    if (e->name) *index = e->index;
    return e->name != NULL;
}

/* At most half full, so that a search ends soon. */
static bool grow(NameTable *table) {
    NameTable bigger = {NULL, table->count, table->capacity ? table->capacity * 2 : 32};
    bigger.entries = array_new(bigger.capacity, sizeof *bigger.entries);
    if (!bigger.entries) return false;
    for (size_t i = 0; i < table->capacity; i++)
        if (table->entries[i].name) *slot(&bigger, table->entries[i].name) = table->entries[i];
    free(table->entries);
    *table = bigger;
    return true;
}

bool names_add(NameTable *table, const char *name, size_t index) {
    if (table->count >= table->capacity / 2 && !grow(table)) return false;
    *slot(table, name) = (NameEntry){name, index};
    table->count++;
    return true;
}

void names_free(NameTable *table) {
    free(table->entries);
    *table = (NameTable){0};
}
