/* SPDX-License-Identifier: Apache-2.0 */
/* Contexts, scenes, and adding things to them. What is stored on things: scene_items.c. */
#include "render/scene/scene_internal.h"

#include "core/checked.h"
#include "core/nearest.h"

#include <stdio.h>

enum { KINDS_MAX = 64 };

const char *cau_version(void) { return CAUSTICS_VERSION; }

cau_result cau_context_create(cau_context **out) {
    if (!out) return CAU_ERROR_USAGE;
    *out = array_new(1, sizeof **out);
    return *out ? CAU_OK : CAU_ERROR_RESOURCE;
}

void cau_context_destroy(cau_context **context) {
    if (!context) return;
    free(*context);
    *context = NULL;
}

const char *cau_error_text(const cau_context *context) { return context ? context->error.text : ""; }
cau_result cau_error_code(const cau_context *context) {
    return context ? context->error.code : CAU_ERROR_USAGE;
}

void cau_error_clear(cau_context *context) {
    if (context) error_clear(&context->error);
}

cau_result cau_scene_create(cau_context *context, cau_scene **out) {
    if (out) *out = NULL;
    if (!context || !out) return CAU_ERROR_USAGE;
    cau_scene *s = array_new(1, sizeof *s);
    if (s) s->color_space = string_copy(scene_color_spaces[0]);
    if (!s || !s->color_space) {
        free(s);
        return error_set(&context->error, CAU_ERROR_RESOURCE, "out of memory for a scene");
    }
    s->context = context;
    param_defaults(&camera_table, &s->camera);
    param_defaults(&filter_table, &s->filter);
    param_defaults(&world_table, &s->world);
    param_defaults(&bounces_table, &s->bounces);
    *out = s;
    return CAU_OK;
}

static void object_free(Object *o) {
    if (o->shape) param_free(&o->shape->table, o->shape_data);
    free(o->shape_data);
    mesh_free(&o->mesh);
    free(o->name);
    free(o->material_name);
}

static void light_source_free(LightSource *l) {
    param_free(&l->kind->table, l->data);
    free(l->name);
    free(l->group);
}

static void material_free(Material *m) {
    param_free(&m->kind->table, m->data);
    free(m->name);
}

void cau_scene_destroy(cau_scene **scene) {
    if (!scene || !*scene) return;
    cau_scene *s = *scene;
    for (size_t i = 0; i < s->object_count; i++) object_free(&s->objects[i]);
    for (size_t i = 0; i < s->light_count; i++) light_source_free(&s->lights[i]);
    for (size_t i = 0; i < s->material_count; i++) material_free(&s->materials[i]);
    free(s->objects);
    free(s->lights);
    free(s->materials);
    names_free(&s->material_names);
    names_free(&s->object_names);
    names_free(&s->light_names);
    free(s->world_group);
    free(s->color_space);
    free(s->source_path);
    free(s);
    *scene = NULL;
}

static cau_result out_of_memory(cau_scene *s, const char *place) {
    return error_set(&s->context->error, CAU_ERROR_RESOURCE, "%s: out of memory", place);
}

static cau_result check_name(cau_scene *s, const NameTable *names, const char *place, const char *name) {
    CauError *err = &s->context->error;
    if (!name || !*name) return error_set(err, CAU_ERROR_INPUT, "%s: the name is empty; give one", place);
    size_t bytes = strlen(name), i;
    if (bytes > NAME_BYTES_MAX)
        return error_set(err, CAU_ERROR_INPUT, "%s: the name \"%.40s...\" has %zu bytes; the limit is %d",
            place, name, bytes, NAME_BYTES_MAX);
    for (i = 0; i < bytes; i++)
        if ((unsigned char)name[i] < 32 || name[i] == 127)
            return error_set(
                err, CAU_ERROR_INPUT, "%s: the name \"%s\" holds a control character", place, name);
    if (names_find(names, name, &i))
        return error_set(
            err, CAU_ERROR_INPUT, "%s: the name \"%s\" is taken; names must be unique", place, name);
    return CAU_OK;
}

static cau_result unknown_type(
    cau_scene *s, const char *place, const char *what, const char *type, int family) {
    const char *known[KINDS_MAX];
    size_t n = 0;
    for (const char *name; n < KINDS_MAX && (name = cau_type_name(family, n)); n++) known[n] = name;
    if (strcmp(type, "emission") == 0)
        return error_set(&s->context->error, CAU_ERROR_UNSUPPORTED,
            "%s.type: not yet supported: \"emission\" (mesh lights); use an area light", place);
    return param_unknown(place, what, type, known, n, &s->context->error);
}

cau_result cau_add_material(cau_scene *s, const char *name, const char *type, cau_item *out) {
    if (!s || !type || !out) return CAU_ERROR_USAGE;
    char place[PLACE_TEXT_MAX];
    CAU_TRY(check_name(s, &s->material_names, "materials", name));
    Material m = {.kind = material_find(type)};
    place_of_material(&(Material){.name = (char *)(uintptr_t)name}, place);
    if (!m.kind) return unknown_type(s, place, "material type", type, CAU_TYPES_OF_MATERIALS);
    if (!array_reserve((void **)&s->materials, &s->material_capacity, s->material_count + 1, sizeof m) ||
        !(m.name = string_copy(name)))
        return out_of_memory(s, place);
    if (!names_add(&s->material_names, m.name, s->material_count)) {
        free(m.name);
        return out_of_memory(s, place);
    }
    param_defaults(&m.kind->table, m.data);
    s->materials[s->material_count] = m;
    *out = item_make(ITEM_MATERIAL, s->material_count++);
    return CAU_OK;
}

cau_result cau_add_light(cau_scene *s, const char *name, const char *type, cau_item *out) {
    if (!s || !type || !out) return CAU_ERROR_USAGE;
    char place[PLACE_TEXT_MAX];
    place_of_light(s->light_count, place);
    CAU_TRY(check_name(s, &s->light_names, place, name));
    LightSource l = {.kind = strcmp(type, "world") == 0 ? NULL : light_find(type)};
    if (!l.kind) return unknown_type(s, place, "light type", type, CAU_TYPES_OF_LIGHTS);
    if (!array_reserve((void **)&s->lights, &s->light_capacity, s->light_count + 1, sizeof l) ||
        !(l.name = string_copy(name)))
        return out_of_memory(s, place);
    if (!names_add(&s->light_names, l.name, s->light_count)) {
        free(l.name);
        return out_of_memory(s, place);
    }
    param_defaults(&light_table, &l);
    param_defaults(&l.kind->table, l.data);
    s->lights[s->light_count] = l;
    *out = item_make(ITEM_LIGHT, s->light_count++);
    return CAU_OK;
}

cau_result cau_add_object(cau_scene *s, const char *name, cau_item *out) {
    if (!s || !out) return CAU_ERROR_USAGE;
    char place[PLACE_TEXT_MAX];
    place_of_object(s->object_count, place);
    CAU_TRY(check_name(s, &s->object_names, place, name));
    Object o = {.material = -1};
    if (!array_reserve((void **)&s->objects, &s->object_capacity, s->object_count + 1, sizeof o) ||
        !(o.name = string_copy(name)))
        return out_of_memory(s, place);
    if (!names_add(&s->object_names, o.name, s->object_count)) {
        free(o.name);
        return out_of_memory(s, place);
    }
    param_defaults(&object_table, &o.params);
    s->objects[s->object_count] = o;
    *out = item_make(ITEM_OBJECT, s->object_count++);
    return CAU_OK;
}

cau_result cau_add_shape(cau_scene *s, cau_item object, const char *type, cau_item *out) {
    if (!s || !type || !out) return CAU_ERROR_USAGE;
    ItemView view;
    CAU_TRY(item_view(s, object, &view));
    CauError *err = &s->context->error;
    if (view.kind != ITEM_OBJECT)
        return error_set(err, CAU_ERROR_USAGE, "%s: cau_add_shape() needs an object", view.place);
    Object *o = &s->objects[view.index];
    if (o->shape || o->mesh.positions)
        return error_set(
            err, CAU_ERROR_INPUT, "%s: object \"%s\" has a shape already; give one", view.place, o->name);
    const ShapeKind *kind = shape_find(type);
    char place[PLACE_TEXT_MAX + 8];
    snprintf(place, sizeof place, "%s.shape", view.place);
    if (!kind) return unknown_type(s, place, "shape type", type, CAU_TYPES_OF_SHAPES);
    void *data = array_new(1, kind->data_size);
    if (!data) return out_of_memory(s, place);
    param_defaults(&kind->table, data);
    o->shape = kind;
    o->shape_data = data;
    *out = item_make(ITEM_SHAPE, view.index);
    return CAU_OK;
}

const char *cau_type_name(int family, size_t index) {
    size_t count;
    if (family == CAU_TYPES_OF_MATERIALS) {
        const MaterialKind *const *kinds = material_kinds(&count);
        return index < count ? kinds[index]->name : NULL;
    }
    if (family == CAU_TYPES_OF_SHAPES) {
        const ShapeKind *const *kinds = shape_kinds(&count);
        return index < count ? kinds[index]->name : NULL;
    }
    if (family != CAU_TYPES_OF_LIGHTS) return NULL;
    const LightKind *const *kinds = light_kinds(&count);
    for (size_t i = 0; i < count;
         i++) /* the world is a light inside, but a part of the scene to the caller */
        if (strcmp(kinds[i]->name, "world") != 0 && index-- == 0) return kinds[i]->name;
    return NULL;
}
