/* SPDX-License-Identifier: Apache-2.0 */
/* What is stored on the items of a scene. An item is its kind in the top four bits and its index below; the
 * four parts that every scene has are kind 0. */
#include "render/scene/scene_internal.h"

#include "core/checked.h"
#include "core/nearest.h"

#include <ctype.h>
#include <stdio.h>

enum { KIND_SHIFT = 28, KEYS_MAX = 64 };

_Static_assert((int)CAU_PARAM_PART == (int)PARAM_PART && (int)CAU_PARAM_LIST == (int)PARAM_LIST &&
                   (int)CAU_PARAM_MATRIX == (int)PARAM_MATRIX && (int)CAU_PARAM_BOOL == (int)PARAM_BOOL &&
                   (int)CAU_PARAM_OR_FILE == (int)PARAM_OR_FILE &&
                   (int)CAU_PARAM_WHOLE == (int)PARAM_POSITIVE_INT,
    "the public constants are those of core/param.h");

cau_item item_make(ItemKind kind, size_t index) {
    return (cau_item)((uint32_t)kind << KIND_SHIFT) | (cau_item)index;
}

void place_of_object(size_t index, char out[PLACE_TEXT_MAX]) {
    snprintf(out, PLACE_TEXT_MAX, "objects[%zu]", index);
}

void place_of_light(size_t index, char out[PLACE_TEXT_MAX]) {
    snprintf(out, PLACE_TEXT_MAX, "lights[%zu]", index);
}

void place_of_material(const Material *m, char out[PLACE_TEXT_MAX]) {
    bool plain = true;
    for (const char *c = m->name; *c; c++)
        if (!isalnum((unsigned char)*c) && *c != '_' && *c != '-') plain = false;
    snprintf(out, PLACE_TEXT_MAX, plain ? "materials.%s" : "materials[\"%s\"]", m->name);
}

static void view_table(ItemView *v, const ParamTable *table, void *data) {
    v->tables[v->table_count] = table;
    v->data[v->table_count++] = data;
}

static bool view_part(struct cau_scene *s, cau_item item, ItemView *v) {
    static const char *const places[] = {"", "camera", "camera.filter", "world", "bounces"};
    const ParamTable *const tables[] = {NULL, &camera_table, &filter_table, &world_table, &bounces_table};
    void *const data[] = {NULL, &s->camera, &s->filter, &s->world, &s->bounces};
    if (item < CAU_CAMERA || item > CAU_BOUNCES) return false;
    v->kind = ITEM_PART;
    v->index = item;
    view_table(v, tables[item], data[item]);
    snprintf(v->place, sizeof v->place, "%s", places[item]);
    return true;
}

static bool view_object(struct cau_scene *s, ItemView *v) {
    if (v->index >= s->object_count) return false;
    Object *o = &s->objects[v->index];
    place_of_object(v->index, v->place);
    if (v->kind == ITEM_OBJECT) {
        view_table(v, &object_table, &o->params);
        return true;
    }
    if (!o->shape) return false;
    view_table(v, &o->shape->table, o->shape_data);
    strcat(v->place, ".shape"); /* the longest index leaves room */
    return true;
}

bool item_find(struct cau_scene *s, cau_item item, ItemView *v) {
    *v = (ItemView){.kind = (ItemKind)(item >> KIND_SHIFT), .index = item & ((1u << KIND_SHIFT) - 1)};
    switch (v->kind) {
    case ITEM_NONE:
        return view_part(s, item, v);
    case ITEM_MATERIAL: {
        if (v->index >= s->material_count) return false;
        Material *m = &s->materials[v->index];
        place_of_material(m, v->place);
        view_table(v, &m->kind->table, m->data);
        return true;
    }
    case ITEM_LIGHT: {
        if (v->index >= s->light_count) return false;
        LightSource *l = &s->lights[v->index];
        place_of_light(v->index, v->place);
        view_table(v, &l->kind->table, l->data);
        view_table(v, &light_table, l);
        return true;
    }
    case ITEM_OBJECT:
    case ITEM_SHAPE:
        return view_object(s, v);
    default:
        return false;
    }
}

cau_result item_view(struct cau_scene *scene, cau_item item, ItemView *out) {
    if (item_find(scene, item, out)) return CAU_OK;
    return error_set(&scene->context->error, CAU_ERROR_USAGE, "item %u is not in this scene", (unsigned)item);
}

/* The table that holds the key, and the key; an error that names the nearest of all tables. */
cau_result item_key(
    struct cau_scene *s, const ItemView *v, const char *key, size_t *table, const Param **param) {
    const char *known[KEYS_MAX];
    size_t n = 0;
    for (size_t t = 0; t < v->table_count; t++) {
        *param = param_find(v->tables[t], key);
        *table = t;
        if (*param) return CAU_OK;
        for (size_t i = 0; i < v->tables[t]->count && n < KEYS_MAX; i++)
            known[n++] = v->tables[t]->params[i].name;
    }
    return param_unknown(v->place, "key", key, known, n, &s->context->error);
}

/* A host knows its objects and lights by name, the place in the file does not say it. */
static cau_result add_name(struct cau_scene *s, const ItemView *v, cau_result before, cau_result result) {
    CauError *err = &s->context->error;
    if (before != CAU_OK || result == CAU_OK) return result;
    size_t used = strlen(err->text), room = sizeof err->text - used;
    if (v->kind == ITEM_OBJECT || v->kind == ITEM_SHAPE)
        snprintf(err->text + used, room, " (object \"%s\")", s->objects[v->index].name);
    else if (v->kind == ITEM_LIGHT)
        snprintf(err->text + used, room, " (light \"%s\")", s->lights[v->index].name);
    return result;
}

static int *placed_of(struct cau_scene *s, const ItemView *v) {
    if (v->kind == ITEM_OBJECT) return &s->objects[v->index].placed;
    if (v->kind == ITEM_LIGHT) return &s->lights[v->index].placed;
    return v->kind == ITEM_PART && v->index == CAU_CAMERA ? &s->camera_placed : NULL;
}

/* A thing is placed in one way; placing it again in the same way moves it. */
static cau_result check_placement(struct cau_scene *s, const ItemView *v, int way) {
    static const char *const ways[] = {"", "matrix", "look", "position, scale or rotation_deg"};
    int *placed = placed_of(s, v);
    if (!placed || way == PLACED_NOT || *placed == PLACED_NOT || *placed == way) return CAU_OK;
    return error_set(&s->context->error, CAU_ERROR_INPUT, "%s is placed by both %s and %s; give one of them",
        v->place, ways[*placed], ways[way]);
}

static int placement_of_key(const ItemView *v, const Param *p) {
    if (p->type == PARAM_MATRIX) return PLACED_BY_MATRIX;
    if (v->kind != ITEM_OBJECT) return PLACED_NOT;
    bool part = strcmp(p->name, "position") == 0 || strcmp(p->name, "scale") == 0 ||
                strcmp(p->name, "rotation_deg") == 0;
    return part ? PLACED_BY_PARTS : PLACED_NOT;
}

static cau_result set_numbers(
    struct cau_scene *s, const ItemView *v, const char *key, const double *values, size_t count) {
    size_t table = 0;
    const Param *p = NULL;
    CAU_TRY(item_key(s, v, key, &table, &p));
    int way = placement_of_key(v, p);
    CAU_TRY(check_placement(s, v, way));
    CAU_TRY(param_set(v->tables[table], v->data[table], v->place, key, values, count, &s->context->error));
    if (way != PLACED_NOT) *placed_of(s, v) = way;
    return CAU_OK;
}

cau_result cau_set(cau_scene *scene, cau_item item, const char *key, const double *values, size_t count) {
    if (!scene || !key || (!values && count)) return CAU_ERROR_USAGE;
    ItemView v;
    cau_result before = scene->context->error.code;
    CAU_TRY(item_view(scene, item, &v));
    return add_name(scene, &v, before, set_numbers(scene, &v, key, values, count));
}

cau_result cau_set_choice(cau_scene *scene, cau_item item, const char *key, const char *word) {
    if (!scene || !key || !word) return CAU_ERROR_USAGE;
    ItemView v;
    size_t t = 0;
    const Param *p = NULL;
    cau_result before = scene->context->error.code;
    CAU_TRY(item_view(scene, item, &v));
    cau_result result = item_key(scene, &v, key, &t, &p);
    if (result == CAU_OK)
        result = param_set_choice(v.tables[t], v.data[t], v.place, key, word, &scene->context->error);
    return add_name(scene, &v, before, result);
}

cau_result cau_set_flags(
    cau_scene *scene, cau_item item, const char *key, const char *const *words, size_t count) {
    if (!scene || !key || (!words && count)) return CAU_ERROR_USAGE;
    ItemView v;
    size_t t = 0;
    const Param *p = NULL;
    cau_result before = scene->context->error.code;
    CAU_TRY(item_view(scene, item, &v));
    cau_result result = item_key(scene, &v, key, &t, &p);
    if (result == CAU_OK)
        result = param_set_flags(v.tables[t], v.data[t], v.place, key, words, count, &scene->context->error);
    return add_name(scene, &v, before, result);
}

/* Where a text of that item is kept, or NULL. */
static char **text_slot(struct cau_scene *s, const ItemView *v, const char *key) {
    if (v->kind == ITEM_OBJECT && strcmp(key, "material") == 0) return &s->objects[v->index].material_name;
    if (strcmp(key, "group") != 0) return NULL;
    if (v->kind == ITEM_LIGHT) return &s->lights[v->index].group;
    return v->kind == ITEM_PART && v->index == CAU_WORLD ? &s->world_group : NULL;
}

static cau_result store_text(
    struct cau_scene *s, const char *place, const char *key, const char *text, char **slot) {
    CauError *err = &s->context->error;
    size_t bytes = strlen(text);
    if (bytes == 0 || bytes > NAME_BYTES_MAX)
        return error_set(err, CAU_ERROR_INPUT, "%s.%s has %zu bytes; it must have 1 to %d", place, key, bytes,
            NAME_BYTES_MAX);
    for (const char *c = text; *c; c++)
        if ((unsigned char)*c < 32 || *c == 127)
            return error_set(
                err, CAU_ERROR_INPUT, "%s.%s \"%s\" holds a control character", place, key, text);
    char *copy = string_copy(text);
    if (!copy) return error_set(err, CAU_ERROR_RESOURCE, "%s: out of memory", place);
    free(*slot);
    *slot = copy;
    return CAU_OK;
}

static cau_result set_text(struct cau_scene *s, const ItemView *v, const char *key, const char *text) {
    size_t t = 0;
    const Param *p = NULL;
    char **slot = text_slot(s, v, key);
    if (slot) return store_text(s, v->place, key, text, slot);
    CAU_TRY(item_key(s, v, key, &t, &p));
    if (p->flags & PARAM_UNSUPPORTED)
        return param_set_choice(v->tables[t], v->data[t], v->place, key, text, &s->context->error);
    return error_set(&s->context->error, CAU_ERROR_INPUT, "%s.%s cannot be set as a text", v->place, key);
}

cau_result cau_set_text(cau_scene *scene, cau_item item, const char *key, const char *text) {
    if (!scene || !key || !text) return CAU_ERROR_USAGE;
    ItemView v;
    cau_result before = scene->context->error.code;
    CAU_TRY(item_view(scene, item, &v));
    return add_name(scene, &v, before, set_text(scene, &v, key, text));
}

static cau_result set_look(struct cau_scene *s, const ItemView *v, const double from[3], const double to[3]) {
    CauError *err = &s->context->error;
    double matrix[16], *target = NULL;
    if (v->kind == ITEM_OBJECT) target = s->objects[v->index].params.matrix;
    if (v->kind == ITEM_LIGHT) target = s->lights[v->index].matrix;
    if (v->kind == ITEM_PART && v->index == CAU_CAMERA) target = s->camera.matrix;
    if (!target)
        return error_set(
            err, CAU_ERROR_USAGE, "%s cannot look; a camera, a light or an object can", v->place);
    for (int i = 0; i < 3; i++)
        if (!(fabs(from[i]) <= 1e12) || !(fabs(to[i]) <= 1e12))
            return error_set(err, CAU_ERROR_INPUT,
                "%s.look holds %g; it must be a number from -1e12 to 1e12 m", v->place,
                fabs(from[i]) <= 1e12 ? to[i] : from[i]);
    CAU_TRY(check_placement(s, v, PLACED_BY_LOOK));
    if (!matrix_look(from, to, matrix))
        return error_set(err, CAU_ERROR_INPUT,
            "%s.look goes from %g %g %g to the same point; \"to\" must be another", v->place, from[0],
            from[1], from[2]);
    memcpy(target, matrix, sizeof matrix);
    *placed_of(s, v) = PLACED_BY_LOOK;
    return CAU_OK;
}

cau_result cau_set_look(cau_scene *scene, cau_item item, const double from[3], const double to[3]) {
    if (!scene || !from || !to) return CAU_ERROR_USAGE;
    ItemView v;
    cau_result before = scene->context->error.code;
    CAU_TRY(item_view(scene, item, &v));
    return add_name(scene, &v, before, set_look(scene, &v, from, to));
}

cau_result cau_set_color_space(cau_scene *scene, const char *name) {
    if (!scene || !name) return CAU_ERROR_USAGE;
    size_t count = 0;
    for (; scene_color_spaces[count]; count++)
        if (strcmp(name, scene_color_spaces[count]) == 0)
            return store_text(scene, "scene", "color_space", name, &scene->color_space);
    return param_unknown("scene", "color_space", name, scene_color_spaces, count, &scene->context->error);
}
