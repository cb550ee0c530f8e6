/* SPDX-License-Identifier: Apache-2.0 */
/* From the scene as described to the scene that is rendered: checked, placed, centred on its casters and
 * scaled to about one unit. The order: materials, then each object in the world, then scene space, then the
 * rest. */
#include "render/scene/scene_internal.h"

#include "core/checked.h"
#include "core/nearest.h"

#include <stdio.h>

/* Farther out, metres and float coordinates lose all meaning (Embree drops what is beyond 1.8e18). */
#define WORLD_MAX 1e15
#define SCENE_MAX 1e17

static void add_text(Warnings *w, const char *format, va_list args) {
    char text[CAU_ERROR_TEXT_MAX];
    vsnprintf(text, sizeof text, format, args);
    char *copy = string_copy(text);
    if (!copy || !array_reserve((void **)&w->texts, &w->capacity, w->count + 1, sizeof *w->texts)) {
        free(copy);
        w->lost = true;
        return;
    }
    w->texts[w->count++] = copy;
}

void warnings_add(Warnings *w, const char *format, ...) {
    va_list args;
    va_start(args, format);
    add_text(w, format, args);
    va_end(args);
}

cau_result scene_warn(Scene *scene, CauError *err, const char *format, ...) {
    Warnings w = {.texts = scene->warnings, .count = scene->warning_count, .capacity = scene->warning_count};
    va_list args;
    va_start(args, format);
    add_text(&w, format, args);
    va_end(args);
    scene->warnings = w.texts;
    scene->warning_count = w.count;
    return w.lost ? error_set(err, CAU_ERROR_RESOURCE, "out of memory for the scene's warnings") : CAU_OK;
}

static cau_result prepare_materials(struct cau_scene *source, CauError *err) {
    for (size_t i = 0; i < source->material_count; i++) {
        Material *m = &source->materials[i];
        char place[PLACE_TEXT_MAX];
        place_of_material(m, place);
        CAU_TRY(param_check_required(&m->kind->table, m->data, place, err));
        m->kind->prepare(m);
    }
    return CAU_OK;
}

static cau_result unknown_material(
    const struct cau_scene *source, const char *place, const char *name, CauError *err) {
    const char **known = array_new(source->material_count, sizeof *known);
    size_t n = known ? source->material_count : 0;
    for (size_t i = 0; i < n; i++) known[i] = source->materials[i].name;
    cau_result result = param_unknown(place, "material", name, known, n, err);
    free(known);
    return result;
}

static cau_result find_material(const struct cau_scene *source, size_t index, Object *o, CauError *err) {
    char place[PLACE_TEXT_MAX];
    place_of_object(index, place);
    if (!o->material_name)
        return error_set(err, CAU_ERROR_INPUT, "%s: object \"%s\" has no material; name one of \"materials\"",
            place, o->name);
    size_t found;
    if (!names_find(&source->material_names, o->material_name, &found))
        return unknown_material(source, place, o->material_name, err);
    o->material = (int)found;
    unsigned lobes = source->materials[found].lobes;
    o->casts = o->params.casts_caustics != 0 && (lobes & LOBE_CASTING);
    o->receives = o->params.receives_caustics != 0 && (lobes & LOBE_DIFFUSE);
    o->visibility = (unsigned)o->params.visible_to | (o->params.visible_to_camera != 0 ? VISIBLE_CAMERA : 0u);
    return CAU_OK;
}

static cau_result place_objects(struct cau_scene *source, Scene *out, CauError *err) {
    out->objects = array_new(source->object_count, sizeof *out->objects);
    if (!out->objects)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu objects", source->object_count);
    for (size_t i = 0; i < source->object_count; i++) {
        Object *o = &out->objects[i];
        *o = source->objects[i];
        o->mesh = (Mesh){0}; /* the source keeps its own */
        out->object_count = i + 1;
        CAU_TRY(find_material(source, i, o, err));
        CAU_TRY(normalise_shape(&source->objects[i], i, o, err));
        bool some = object_world_bounds(o, &o->bounds_min, &o->bounds_max);
        double far = 0;
        for (int c = 0; some && c < 2; c++) {
            V3 p = c ? o->bounds_max : o->bounds_min;
            far = fmax(far, fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z))));
        }
        if (!(far <= WORLD_MAX))
            return error_set(err, CAU_ERROR_INPUT,
                "objects[%zu]: object \"%s\" reaches %g m from the origin; the limit is %g m", i, o->name,
                far, WORLD_MAX);
    }
    return CAU_OK;
}

/* The box of the casters, or of everything when nothing casts. Lights have no part in it: a layer must not
 * change with the lights of other layers. */
static bool casters_box(const Scene *s, V3 *lo, V3 *hi) {
    bool any = false, casters = false;
    for (size_t i = 0; i < s->object_count; i++) casters |= s->objects[i].casts;
    for (size_t i = 0; i < s->object_count; i++) {
        const Object *o = &s->objects[i];
        if ((casters && !o->casts) || (!o->exact && o->mesh.vertex_count == 0)) continue;
        *lo = any ? v3_min(*lo, o->bounds_min) : o->bounds_min;
        *hi = any ? v3_max(*hi, o->bounds_max) : o->bounds_max;
        any = true;
    }
    return any;
}

/* The origin is the centre of the box on a grid of 1/32 of its size, so that a scene moved by a multiple of
 * the grid stays the same to the last bit although its bounds were rounded differently. Exact halves are
 * common and would tip either way: the grid is shifted to where they are not. */
static double snap(double x, double grid) { return floor(x / grid + 0.381966011250105) * grid; }

static void choose_space(Scene *s) {
    V3 lo, hi;
    s->origin_m = v3(0, 0, 0);
    s->units_per_m = 1;
    if (!casters_box(s, &lo, &hi)) return;
    double half = 0.5 * v3_length(v3_sub(hi, lo));
    int exponent;
    if (!(half > 1e-30)) return;
    frexp(half, &exponent);
    s->units_per_m = ldexp(1, -exponent);
    double grid = ldexp(1, exponent - 5);
    V3 centre = v3_scale(v3_add(lo, hi), 0.5);
    s->origin_m = v3(snap(centre.x, grid), snap(centre.y, grid), snap(centre.z, grid));
}

/* Translation minus origin first: where both are far away, the difference is exact. */
static Affine to_scene_space(const Scene *s, const Affine *world) {
    Affine a;
    V3 p = scene_from_world(s, affine_column(world, 3));
    const double offset[3] = {p.x, p.y, p.z};
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++) a.m[r][c] = world->m[r][c] * s->units_per_m;
        a.m[r][3] = offset[r];
    }
    return a;
}

static cau_result finish_object(
    Scene *s, size_t index, const Mesh *given, Warnings *warnings, CauError *err) {
    Object *o = &s->objects[index];
    o->local_to_scene = to_scene_space(s, &o->local_to_scene);
    o->mirrored = affine_determinant(&o->local_to_scene) < 0;
    o->scene_to_local = affine_inverse(&o->local_to_scene);
    if (!object_world_bounds(o, &o->bounds_min, &o->bounds_max)) {
        o->bounds_min = o->bounds_max = affine_column(&o->local_to_scene, 3);
        warnings_add(warnings, "object \"%s\" has no triangles", o->name);
    }
    double far = fmax(v3_length(o->bounds_min), v3_length(o->bounds_max));
    if (!(far <= SCENE_MAX))
        return error_set(err, CAU_ERROR_INPUT,
            "objects[%zu]: object \"%s\" reaches %g times as far as the casters are large; the limit is %g",
            index, o->name, far, SCENE_MAX);
    if (o->exact) return CAU_OK;
    CAU_TRY(normalise_mesh(o, warnings, err));
    return mesh_warn(o, given, &s->materials[o->material], warnings, err);
}

static void finish_bounds(Scene *s) {
    for (size_t i = 0; i < s->object_count; i++) {
        s->bounds_min = i ? v3_min(s->bounds_min, s->objects[i].bounds_min) : s->objects[i].bounds_min;
        s->bounds_max = i ? v3_max(s->bounds_max, s->objects[i].bounds_max) : s->objects[i].bounds_max;
    }
}

static void warn_of_nothing(const Scene *s, Warnings *w) {
    bool casts = false, receives = false;
    for (size_t i = 0; i < s->object_count; i++) {
        casts |= s->objects[i].casts;
        receives |= s->objects[i].receives;
    }
    if (!s->light_count) warnings_add(w, "the scene has no light, so there is no layer but the black sum");
    if (!casts) warnings_add(w, "no object of the scene casts caustics, so every layer is black");
    if (!receives) warnings_add(w, "no object of the scene receives caustics, so every layer is black");
}

static cau_result normalise(
    struct cau_scene *source, int width, int height, Scene *out, Warnings *warnings, CauError *err) {
    CAU_TRY(prepare_materials(source, err));
    CAU_TRY(place_objects(source, out, err));
    choose_space(out);
    out->materials = source->materials;
    out->material_count = source->material_count;
    out->bounces = source->bounces;
    for (size_t i = 0; i < out->object_count; i++)
        CAU_TRY(finish_object(out, i, &source->objects[i].mesh, warnings, err));
    finish_bounds(out);
    CAU_TRY(normalise_camera(source, width, height, out, err));
    CAU_TRY(normalise_lights(source, out, err));
    warn_of_nothing(out, warnings);
    if (warnings->lost) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the scene's warnings");
    return CAU_OK;
}

cau_result scene_normalise(
    struct cau_scene *source, int width_override, int height_override, Scene *out, CauError *err) {
    cau_result before = err ? err->code : CAU_OK;
    Warnings warnings = {0};
    *out = (Scene){.source = source};
    cau_result result = normalise(source, width_override, height_override, out, &warnings, err);
    out->warnings = warnings.texts;
    out->warning_count = warnings.count;
    if (result == CAU_OK) return CAU_OK;
    if (before == CAU_OK && source->source_path) error_prefix(err, "%s: ", source->source_path);
    scene_free(out);
    return result;
}

void scene_free(Scene *scene) {
    for (size_t i = 0; i < scene->object_count; i++) mesh_free(&scene->objects[i].mesh);
    for (size_t i = 0; i < scene->warning_count; i++) free(scene->warnings[i]);
    free(scene->objects);
    free(scene->lights);
    free(scene->warnings);
    *scene = (Scene){0};
}
