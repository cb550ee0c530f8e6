/* SPDX-License-Identifier: Apache-2.0 */
/* cau_scene_load_file(): the outline of a scene file. */
#include "render/scene/io/reader.h"

#include "core/checked.h"
#include "core/param.h"
#include "render/scene/scene.h"

#include <ctype.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>

/* A parsed document takes about ten times its text. */
#define SCENE_BYTES_MAX ((size_t)64 << 20)

static cau_result each_key(
    Reader *r, cau_item item, const char *place, const json_t *object, const char *const *skip) {
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)object, key, value) {
        size_t i = 0;
        while (skip[i] && strcmp(skip[i], key) != 0) i++;
        if (!skip[i]) CAU_TRY(reader_value(r, item, place, key, value));
    }
    return CAU_OK;
}

static const char *const no_skip[] = {NULL};

static cau_result read_part(Reader *r, cau_item item, const char *place, const json_t *object) {
    if (!json_is_object(object)) return reader_wrong_type(r, place, "", "an object {...}", object);
    return each_key(r, item, place, object, no_skip);
}

static cau_result read_camera(Reader *r, const json_t *camera) {
    static const char *const skip[] = {"filter", NULL};
    if (!json_is_object(camera)) return reader_wrong_type(r, "camera", "", "an object {...}", camera);
    CAU_TRY(each_key(r, CAU_CAMERA, "camera", camera, skip));
    const json_t *filter = json_object_get(camera, "filter");
    return filter ? read_part(r, CAU_FILTER, "camera.filter", filter) : CAU_OK;
}

static void material_place(const char *name, char out[READER_PLACE_MAX]) {
    bool plain = true;
    for (const char *c = name; *c; c++) plain &= isalnum((unsigned char)*c) || *c == '_' || *c == '-';
    snprintf(out, READER_PLACE_MAX, plain ? "materials.%.255s" : "materials[\"%.255s\"]", name);
}

static cau_result read_material(Reader *r, const char *name, const json_t *material) {
    static const char *const skip[] = {"type", NULL};
    char place[READER_PLACE_MAX];
    const char *type;
    cau_item item;
    material_place(name, place);
    if (!json_is_object(material)) return reader_wrong_type(r, place, "", "an object {...}", material);
    CAU_TRY(reader_text(r, place, material, "type", &type));
    CAU_TRY(cau_add_material(r->scene, name, type, &item));
    return each_key(r, item, place, material, skip);
}

static cau_result read_materials(Reader *r, const json_t *materials) {
    const char *name;
    json_t *material;
    if (!json_is_object(materials))
        return reader_wrong_type(r, "materials", "", "an object {...}", materials);
    json_object_foreach((json_t *)(uintptr_t)materials, name, material)
        CAU_TRY(read_material(r, name, material));
    return CAU_OK;
}

static cau_result read_object(Reader *r, const char *place, const json_t *object) {
    static const char *const skip[] = {"name", "shape", "file", NULL};
    const char *name, *file;
    cau_item item;
    CAU_TRY(reader_text(r, place, object, "name", &name));
    CAU_TRY(cau_add_object(r->scene, name, &item));
    CAU_TRY(each_key(r, item, place, object, skip));
    const json_t *shape = json_object_get(object, "shape");
    if (shape && json_object_get(object, "file"))
        return error_set(r->err, CAU_ERROR_INPUT,
            "%s: object \"%s\" has both \"shape\" and \"file\"; give one", place, name);
    if (shape) return reader_shape(r, item, place, shape);
    if (!json_object_get(object, "file"))
        return error_set(r->err, CAU_ERROR_INPUT,
            "%s: object \"%s\" has neither \"shape\" nor \"file\"; give one", place, name);
    CAU_TRY(reader_text(r, place, object, "file", &file));
    return reader_mesh_file(r, item, place, file);
}

static cau_result read_light(Reader *r, const char *place, const json_t *light) {
    static const char *const skip[] = {"name", "type", NULL};
    const char *name, *type;
    cau_item item;
    CAU_TRY(reader_text(r, place, light, "name", &name));
    CAU_TRY(reader_text(r, place, light, "type", &type));
    CAU_TRY(cau_add_light(r->scene, name, type, &item));
    return each_key(r, item, place, light, skip);
}

typedef cau_result ReadEntry(Reader *r, const char *place, const json_t *entry);

static cau_result read_list(Reader *r, const char *key, const json_t *list, ReadEntry *read) {
    if (!json_is_array(list)) return reader_wrong_type(r, key, "", "a list", list);
    for (size_t i = 0; i < json_array_size(list); i++) {
        char place[READER_PLACE_MAX];
        const json_t *entry = json_array_get(list, i);
        snprintf(place, sizeof place, "%s[%zu]", key, i);
        if (!json_is_object(entry)) return reader_wrong_type(r, place, "", "an object {...}", entry);
        CAU_TRY(read(r, place, entry));
    }
    return CAU_OK;
}

static cau_result read_color_space(Reader *r, const json_t *value) {
    if (!json_is_string(value)) return reader_wrong_type(r, "color_space", "", "a text", value);
    return cau_set_color_space(r->scene, json_string_value(value));
}

static cau_result check_version(Reader *r, const json_t *root) {
    const json_t *version = json_object_get(root, "caustics_scene");
    if (!version)
        return error_set(r->err, CAU_ERROR_INPUT,
            "\"caustics_scene\" is missing; a scene file says \"caustics_scene\": 1 at its top");
    if (!json_is_number(version)) return reader_wrong_type(r, "caustics_scene", "", "the number 1", version);
    if (json_number_value(version) != 1)
        return error_set(r->err, CAU_ERROR_INPUT, "caustics_scene is %g; this version reads 1",
            json_number_value(version));
    return CAU_OK;
}

static cau_result check_keys(Reader *r, const json_t *root) {
    static const char *const known[] = {
        "caustics_scene", "color_space", "camera", "bounces", "world", "materials", "objects", "lights"};
    const size_t count = sizeof known / sizeof known[0];
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)root, key, value) {
        size_t i = 0;
        while (i < count && strcmp(known[i], key) != 0) i++;
        if (i == count) return param_unknown("scene", "key", key, known, count, r->err);
    }
    if (!json_object_get(root, "camera"))
        return error_set(r->err, CAU_ERROR_INPUT, "scene: no camera; add \"camera\": {\"look\": ..., ...}");
    return CAU_OK;
}

static cau_result read_scene(Reader *r, const json_t *root) {
    if (!json_is_object(root)) return reader_wrong_type(r, "scene", "", "an object {...}", root);
    CAU_TRY(check_version(r, root));
    CAU_TRY(check_keys(r, root));
    const json_t *part;
    if ((part = json_object_get(root, "color_space"))) CAU_TRY(read_color_space(r, part));
    if ((part = json_object_get(root, "camera"))) CAU_TRY(read_camera(r, part));
    if ((part = json_object_get(root, "bounces"))) CAU_TRY(read_part(r, CAU_BOUNCES, "bounces", part));
    if ((part = json_object_get(root, "world"))) CAU_TRY(read_part(r, CAU_WORLD, "world", part));
    if ((part = json_object_get(root, "materials"))) CAU_TRY(read_materials(r, part));
    if ((part = json_object_get(root, "objects"))) CAU_TRY(read_list(r, "objects", part, read_object));
    if ((part = json_object_get(root, "lights"))) CAU_TRY(read_list(r, "lights", part, read_light));
    return CAU_OK;
}

static cau_result parse(Reader *r, json_t **out) {
    char *text = NULL;
    size_t size = 0;
    CAU_TRY(file_read(r->path, SCENE_BYTES_MAX, "scene file", &text, &size, r->err));
    json_error_t at;
    if (size >= 4 && memcmp(text, "glTF", 4) == 0)
        error_set(r->err, CAU_ERROR_UNSUPPORTED,
            "not yet supported: a glTF file as the scene; name it as an object's \"file\" in a scene file");
    else if (!(*out = json_loadb(text, size, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &at)))
        error_set(r->err, CAU_ERROR_INPUT, "line %d, column %d: %s", at.line, at.column, at.text);
    else if (json_is_object(*out) && json_object_get(*out, "asset") &&
             !json_object_get(*out, "caustics_scene"))
        error_set(r->err, CAU_ERROR_UNSUPPORTED,
            "not yet supported: a glTF file as the scene; name it as an object's \"file\" in a scene file");
    free(text);
    return r->err->code;
}

static cau_result open_folder(Reader *r) {
    char *copy = string_copy(r->path);
    if (!copy) return error_set(r->err, CAU_ERROR_RESOURCE, "out of memory");
    r->folder = realpath(dirname(copy), NULL);
    free(copy);
    if (!r->folder) return error_set(r->err, CAU_ERROR_INPUT, "cannot be opened: its folder does not exist");
    return CAU_OK;
}

static cau_result load(Reader *r) {
    json_t *root = NULL;
    r->c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (!r->c_locale) return error_set(r->err, CAU_ERROR_RESOURCE, "out of memory");
    CAU_TRY(open_folder(r));
    cau_result result = parse(r, &root);
    if (result == CAU_OK) result = cau_scene_create(r->context, &r->scene);
    if (result == CAU_OK) result = read_scene(r, root);
    json_decref(root);
    if (result == CAU_OK && !(r->scene->source_path = string_copy(r->path)))
        result = error_set(r->err, CAU_ERROR_RESOURCE, "out of memory");
    return result;
}

cau_result cau_scene_load_file(cau_context *context, const char *path, cau_scene **out) {
    if (out) *out = NULL;
    if (!context || !path || !out) return CAU_ERROR_USAGE;
    /* Read with a record of its own: an older error of the context must not make this one look failed. */
    CauError older = context->error;
    error_clear(&context->error);
    Reader r = {.context = context, .err = &context->error, .path = path};
    cau_result result = load(&r);
    free(r.folder);
    if (r.c_locale) freelocale(r.c_locale);
    if (result == CAU_OK)
        *out = r.scene;
    else {
        cau_scene_destroy(&r.scene);
        error_prefix(&context->error, "%s: ", path);
    }
    if (older.code != CAU_OK) context->error = older;
    return result;
}
