/* SPDX-License-Identifier: Apache-2.0 */
#include "render/light/light.h"

#include "render/light/light_common.h"

#include <string.h>

#define LIGHT(name) extern const LightKind light_##name;
#include "render/light/lights.def"
#undef LIGHT

static const LightKind *const kinds[] = {
#define LIGHT(name) &light_##name,
#include "render/light/lights.def"
#undef LIGHT
};

const LightKind *const *light_kinds(size_t *count) {
    *count = sizeof kinds / sizeof kinds[0];
    return kinds;
}

const LightKind *light_find(const char *name) {
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
        if (strcmp(kinds[i]->name, name) == 0) return kinds[i];
    return NULL;
}

cau_result light_place(
    const LightSource *source, const Affine *to_scene, Light *out, const char *owner, CauError *err) {
    V3 axis = v3_neg(affine_column(to_scene, 2));
    double length = v3_length(axis);
    out->position = affine_column(to_scene, 3);
    if (!(length > 0.0) || !isfinite(length) || !v3_finite(out->position))
        return error_set(err, CAU_ERROR_INPUT, "%s: the matrix is singular or not finite", owner);
    out->n = v3_scale(axis, 1.0 / length);
    v3_frame(out->n, &out->u, &out->v);
    out->color = rgb(source->data[0], source->data[1], source->data[2]);
    memset(out->derived, 0, sizeof out->derived);
    out->infinite = out->delta = false;
    return CAU_OK;
}

cau_result light_check(const Light *light, double brightness, const char *owner, CauError *err) {
    if (isfinite(brightness * rgb_max(light->color))) return CAU_OK;
    return error_set(err, CAU_ERROR_INPUT,
        "%s: the light is too small for its power: its radiance is not a finite number; make it larger, or a "
        "point or sun of size 0",
        owner);
}
