/* SPDX-License-Identifier: Apache-2.0 */
#include "render/scene/shape.h"

#include <string.h>

#define SHAPE(name) extern const ShapeKind shape_##name;
#include "render/scene/shapes.def"
#undef SHAPE

static const ShapeKind *const kinds[] = {
#define SHAPE(name) &shape_##name,
#include "render/scene/shapes.def"
#undef SHAPE
};

const ShapeKind *const *shape_kinds(size_t *count) {
    *count = sizeof kinds / sizeof kinds[0];
    return kinds;
}

const ShapeKind *shape_find(const char *name) {
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
        if (strcmp(kinds[i]->name, name) == 0) return kinds[i];
    return NULL;
}
