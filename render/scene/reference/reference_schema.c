/* SPDX-License-Identifier: Apache-2.0 */
/* JSON Schema 2020-12. jansson's "o" takes NULL for a failure, so only the end is checked. */
#include "render/scene/reference/reference.h"
#include "render/scene/scene.h"

#include <jansson.h>
#include <math.h>
#include <string.h>

static json_t *number_schema(const Param *p) {
    json_t *s = json_pack("{ss}", "type", p->flags & PARAM_POSITIVE_INT ? "integer" : "number");
    json_object_set_new(s, p->flags & PARAM_MIN_EXCLUDED ? "exclusiveMinimum" : "minimum", json_real(p->min));
    json_object_set_new(s, p->flags & PARAM_MAX_EXCLUDED ? "exclusiveMaximum" : "maximum", json_real(p->max));
    return s;
}

static json_t *array_of(json_t *items, size_t count) {
    return json_pack("{ss, so, sI, sI}", "type", "array", "items", items, "minItems", (json_int_t)count,
        "maxItems", (json_int_t)count);
}

static json_t *words_schema(const Param *p) {
    json_t *words = json_array();
    for (size_t i = 0; p->choices[i]; i++) json_array_append_new(words, json_string(p->choices[i]));
    return json_pack("{so}", "enum", words);
}

static json_t *entry_schema(const Param *p) {
    if (p->tuple == 1) return number_schema(p);
    json_t *tuple = array_of(number_schema(p), p->tuple);
    if (!p->choices) return tuple;
    json_t *keys = json_object(), *required = json_array();
    size_t needed = p->def[0] > 0 ? (size_t)p->def[0] : p->tuple;
    for (size_t i = 0; p->choices[i]; i++) {
        json_object_set_new(keys, p->choices[i], number_schema(p));
        if (i < needed) json_array_append_new(required, json_string(p->choices[i]));
    }
    json_t *named = json_pack("{ss, so, so, sb}", "type", "object", "properties", keys, "required", required,
        "additionalProperties", 0);
    return json_pack("{s[oo]}", "anyOf", tuple, named);
}

static json_t *value_schema(const Param *p) {
    char reference[64];
    switch (p->type) {
    case PARAM_BOOL:
        return json_pack("{ss}", "type", "boolean");
    case PARAM_CHOICE:
        return words_schema(p);
    case PARAM_FLAGS:
        return json_pack("{ss, so}", "type", "array", "items", words_schema(p));
    case PARAM_MATRIX:
        return json_pack("{ss}", "$ref", "#/$defs/matrix");
    case PARAM_TEXT:
        return json_pack("{ss, si, si}", "type", "string", "minLength", 1, "maxLength", 255);
    case PARAM_PART:
        snprintf(reference, sizeof reference, "#/$defs/%s", p->name);
        return json_pack("{ss}", "$ref", reference);
    case PARAM_LIST: {
        json_t *list = json_pack("{ss, so}", "type", "array", "items", entry_schema(p));
        return p->flags & PARAM_OR_FILE ? json_pack("{s[o{ss}]}", "anyOf", list, "type", "string") : list;
    }
    case PARAM_NUMBER:
        return number_schema(p);
    default: {
        json_t *list = array_of(number_schema(p), param_components(p));
        return p->flags & PARAM_BROADCAST ? json_pack("{s[oo]}", "anyOf", list, number_schema(p)) : list;
    }
    }
}

static void add_default(json_t *schema, const Param *p) {
    if (!param_is_stored(p) || !reference_has_default(p)) return;
    if (p->type == PARAM_BOOL) json_object_set_new(schema, "default", json_boolean(p->def[0] != 0));
    if (p->type == PARAM_NUMBER) json_object_set_new(schema, "default", json_real(p->def[0]));
    if (p->type == PARAM_CHOICE)
        json_object_set_new(schema, "default", json_string(p->choices[(int)p->def[0]]));
}

static void add_table(json_t *object, const ParamTable *table) {
    json_t *properties = json_object_get(object, "properties"),
           *required = json_object_get(object, "required");
    for (size_t i = 0; i < table->count; i++) {
        const Param *p = &table->params[i];
        if (p->flags & PARAM_UNSUPPORTED) continue;
        char text[256];
        snprintf(
            text, sizeof text, "%s%s%s%s", p->help, p->unit[0] ? " (" : "", p->unit, p->unit[0] ? ")" : "");
        json_t *schema = value_schema(p);
        json_object_set_new(schema, "description", json_string(text));
        add_default(schema, p);
        json_object_set_new(properties, p->name, schema);
        if (p->flags & PARAM_REQUIRED) json_array_append_new(required, json_string(p->name));
    }
}

static json_t *new_object(const char *help, const char *const *required) {
    json_t *list = json_array();
    for (size_t i = 0; required && required[i]; i++) json_array_append_new(list, json_string(required[i]));
    json_t *object = json_pack(
        "{ss, s{}, so, sb}", "type", "object", "properties", "required", list, "additionalProperties", 0);
    if (help) json_object_set_new(object, "description", json_string(help));
    return object;
}

static json_t *part(const ParamTable *table, const char *const *required) {
    json_t *object = new_object(NULL, required);
    add_table(object, table);
    return object;
}

static json_t *kind(const char *name, const char *help, const ParamTable *table, const ParamTable *common) {
    static const char *const typed[] = {"type", NULL}, *const named[] = {"name", "type", NULL};
    json_t *object = new_object(help, common ? named : typed);
    json_object_set_new(json_object_get(object, "properties"), "type", json_pack("{ss}", "const", name));
    if (common) add_table(object, common);
    add_table(object, table);
    return object;
}

static json_t *all_kinds(int family) {
    size_t count;
    json_t *list = json_array();
    if (family == CAU_TYPES_OF_MATERIALS) {
        const MaterialKind *const *m = material_kinds(&count);
        for (size_t i = 0; i < count; i++)
            json_array_append_new(list, kind(m[i]->name, m[i]->help, &m[i]->table, NULL));
    } else if (family == CAU_TYPES_OF_SHAPES) {
        const ShapeKind *const *s = shape_kinds(&count);
        for (size_t i = 0; i < count; i++)
            json_array_append_new(list, kind(s[i]->name, s[i]->help, &s[i]->table, NULL));
        json_array_append_new(
            list, json_pack("{ss, s{s{ss}, s{so}, s{so}, s{so}, s{ss}}, s[sss], sb}", "type", "object",
                      "properties", "type", "const", "mesh", "vertices", "$ref", json_string("#/$defs/rows"),
                      "triangles", "$ref", json_string("#/$defs/rows"), "normals", "$ref",
                      json_string("#/$defs/rows"), "uvs", "type", "array", "required", "type", "vertices",
                      "triangles", "additionalProperties", 0));
    } else {
        const LightKind *const *l = light_kinds(&count);
        for (size_t i = 0; i < count; i++)
            if (strcmp(l[i]->name, "world") != 0)
                json_array_append_new(list, kind(l[i]->name, l[i]->help, &l[i]->table, &light_table));
    }
    return json_pack("{so}", "oneOf", list);
}

static json_t *definitions(void) {
    static const char *const look_keys[] = {"from", "to", NULL}, *const object_keys[] = {
                                                                     "name", "material", NULL};
    json_t *row = json_pack(
        "{s{ss}, ss, si, si}", "items", "type", "number", "type", "array", "minItems", 3, "maxItems", 3);
    json_t *four = json_pack(
        "{s{ss}, ss, si, si}", "items", "type", "number", "type", "array", "minItems", 4, "maxItems", 4);
    json_t *look = new_object(NULL, look_keys), *defs = json_object();
    json_object_set(json_object_get(look, "properties"), "from", row);
    json_object_set(json_object_get(look, "properties"), "to", row);
    json_object_set_new(defs, "look", look);
    json_object_set_new(defs, "matrix", array_of(four, 4));
    json_object_set_new(defs, "rows", json_pack("{ss, so}", "type", "array", "items", row));
    json_object_set_new(defs, "camera", part(&camera_table, NULL));
    json_object_set_new(defs, "filter", part(&filter_table, NULL));
    json_object_set_new(defs, "bounces", part(&bounces_table, NULL));
    json_object_set_new(defs, "world", part(&world_table, NULL));
    json_object_set_new(defs, "material", all_kinds(CAU_TYPES_OF_MATERIALS));
    json_object_set_new(defs, "object", part(&object_table, object_keys));
    json_object_set_new(defs, "shape", all_kinds(CAU_TYPES_OF_SHAPES));
    json_object_set_new(defs, "light", all_kinds(CAU_TYPES_OF_LIGHTS));
    return defs;
}

int reference_schema(void) {
    json_t *spaces = json_array();
    for (size_t i = 0; scene_color_spaces[i]; i++)
        json_array_append_new(spaces, json_string(scene_color_spaces[i]));
    json_t *properties =
        json_pack("{s{si}, s{so}, s{ss}, s{ss}, s{ss}, s{ss, s{ss}}, s{ss, s{ss}}, s{ss, s{ss}}}",
            "caustics_scene", "const", 1, "color_space", "enum", spaces, "camera", "$ref", "#/$defs/camera",
            "bounces", "$ref", "#/$defs/bounces", "world", "$ref", "#/$defs/world", "materials", "type",
            "object", "additionalProperties", "$ref", "#/$defs/material", "objects", "type", "array", "items",
            "$ref", "#/$defs/object", "lights", "type", "array", "items", "$ref", "#/$defs/light");
    json_t *root = json_pack("{ss, ss, ss, ss, so, s[ss], sb, so}", "$schema",
        "https://json-schema.org/draft/2020-12/schema", "title", "Caustics scene, version 1", "$comment",
        "Generated by scene_reference from the parameter tables; do not edit.", "type", "object",
        "properties", properties, "required", "caustics_scene", "camera", "additionalProperties", 0, "$defs",
        definitions());
    int failed = !root || json_dumpf(root, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(12)) != 0;
    putchar('\n');
    json_decref(root);
    return failed;
}
