/* SPDX-License-Identifier: Apache-2.0 */
#include "render/material/material.h"

#include <string.h>

#define MATERIAL(name) extern const MaterialKind material_##name;
#include "render/material/materials.def"
#undef MATERIAL

static const MaterialKind *const kinds[] = {
#define MATERIAL(name) &material_##name,
#include "render/material/materials.def"
#undef MATERIAL
};

const MaterialKind *const *material_kinds(size_t *count) {
    *count = sizeof kinds / sizeof kinds[0];
    return kinds;
}

const MaterialKind *material_find(const char *name) {
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
        if (strcmp(kinds[i]->name, name) == 0) return kinds[i];
    return NULL;
}
