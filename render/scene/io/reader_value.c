/* SPDX-License-Identifier: Apache-2.0 */
/* One value of the file onto one parameter of an item. */
#include "render/scene/io/reader.h"

#include "core/checked.h"
#include "core/param.h"

enum { WORDS_MAX = 64 };

const char *json_kind(const json_t *value) {
    switch (json_typeof(value)) {
    case JSON_OBJECT:
        return "an object {...}";
    case JSON_ARRAY:
        return "a list";
    case JSON_STRING:
        return "a text";
    case JSON_INTEGER:
    case JSON_REAL:
        return "a number";
    case JSON_TRUE:
        return "true";
    case JSON_FALSE:
        return "false";
    default:
        return "null";
    }
}

cau_result reader_wrong_type(
    Reader *r, const char *place, const char *key, const char *expected, const json_t *value) {
    if (json_is_string(value))
        return error_set(r->err, CAU_ERROR_INPUT, "%s%s%s must be %s, not the text \"%.60s\"", place,
            *key ? "." : "", key, expected, json_string_value(value));
    return error_set(r->err, CAU_ERROR_INPUT, "%s%s%s must be %s, not %s", place, *key ? "." : "", key,
        expected, json_kind(value));
}

cau_result reader_numbers(
    Reader *r, const char *place, const char *key, const json_t *value, size_t count, double *out) {
    char expected[48];
    snprintf(expected, sizeof expected, "a list of %zu numbers", count);
    if (!json_is_array(value)) return reader_wrong_type(r, place, key, expected, value);
    if (json_array_size(value) != count)
        return error_set(r->err, CAU_ERROR_INPUT, "%s.%s has %zu entries; it must be %s", place, key,
            json_array_size(value), expected);
    for (size_t i = 0; i < count; i++) {
        const json_t *x = json_array_get(value, i);
        if (!json_is_number(x)) {
            char entry[READER_PLACE_MAX];
            snprintf(entry, sizeof entry, "%.200s[%zu]", key, i);
            return reader_wrong_type(r, place, entry, "a number", x);
        }
        out[i] = json_number_value(x);
    }
    return CAU_OK;
}

cau_result reader_text(
    Reader *r, const char *place, const json_t *object, const char *key, const char **out) {
    const json_t *value = json_object_get(object, key);
    if (!value) return error_set(r->err, CAU_ERROR_INPUT, "%s: \"%s\" is missing", place, key);
    if (!json_is_string(value)) return reader_wrong_type(r, place, key, "a text", value);
    *out = json_string_value(value);
    return CAU_OK;
}

cau_result reader_look(Reader *r, cau_item item, const char *place, const json_t *value) {
    static const char *const known[] = {"from", "to"};
    double ends[2][3];
    char here[READER_PLACE_MAX], key_place[READER_PLACE_MAX];
    snprintf(here, sizeof here, "%s.look", place);
    if (!json_is_object(value))
        return reader_wrong_type(r, here, "", "{\"from\": [x,y,z], \"to\": [x,y,z]}", value);
    const char *key;
    json_t *entry;
    json_object_foreach((json_t *)(uintptr_t)value, key,
        entry) if (strcmp(key, known[0]) != 0 && strcmp(key, known[1]) != 0) return param_unknown(here, "key",
        key, known, 2, r->err);
    for (int i = 0; i < 2; i++) {
        const json_t *end = json_object_get(value, known[i]);
        snprintf(key_place, sizeof key_place, "look.%s", known[i]);
        if (!end) return error_set(r->err, CAU_ERROR_INPUT, "%s: \"%s\" is missing", here, known[i]);
        CAU_TRY(reader_numbers(r, place, key_place, end, 3, ends[i]));
    }
    return cau_set_look(r->scene, item, ends[0], ends[1]);
}

static cau_result numbers_value(
    Reader *r, cau_item item, const char *place, const cau_param *p, const json_t *value) {
    double numbers[3];
    char expected[64];
    if (json_is_object(value) && json_object_get(value, "image"))
        return error_set(r->err, CAU_ERROR_UNSUPPORTED,
            "%s.%s: not yet supported: a texture in place of a number or colour; give a value", place,
            p->name);
    if (json_is_number(value) && (p->count == 1 || (p->flags & CAU_PARAM_BROADCAST))) {
        numbers[0] = json_number_value(value);
        return cau_set(r->scene, item, p->name, numbers, 1);
    }
    snprintf(expected, sizeof expected, p->count == 1 ? "a number" : "a list of %u numbers", p->count);
    if (p->count == 1 || !json_is_array(value)) return reader_wrong_type(r, place, p->name, expected, value);
    CAU_TRY(reader_numbers(r, place, p->name, value, p->count, numbers));
    return cau_set(r->scene, item, p->name, numbers, p->count);
}

static cau_result matrix_value(
    Reader *r, cau_item item, const char *place, const char *key, const json_t *value) {
    double numbers[16];
    char row[READER_PLACE_MAX];
    if (!json_is_array(value) || json_array_size(value) != 4)
        return reader_wrong_type(r, place, key, "a list of 4 rows of 4 numbers", value);
    for (size_t i = 0; i < 4; i++) {
        snprintf(row, sizeof row, "%.200s[%zu]", key, i);
        CAU_TRY(reader_numbers(r, place, row, json_array_get(value, i), 4, numbers + 4 * i));
    }
    return cau_set(r->scene, item, key, numbers, 16);
}

static cau_result flags_value(
    Reader *r, cau_item item, const char *place, const char *key, const json_t *value) {
    const char *words[WORDS_MAX];
    size_t count = json_array_size(value);
    if (!json_is_array(value) || count > WORDS_MAX)
        return reader_wrong_type(r, place, key, "a list of words", value);
    for (size_t i = 0; i < count; i++) {
        const json_t *word = json_array_get(value, i);
        if (!json_is_string(word)) return reader_wrong_type(r, place, key, "a list of words", word);
        words[i] = json_string_value(word);
    }
    return cau_set_flags(r->scene, item, key, words, count);
}

/* An entry with named numbers: {"amplitude": ..., "k": ...}. */
static cau_result named_entry(
    Reader *r, const char *place, const cau_param *p, const json_t *entry, double *out) {
    size_t known = 0, required = p->def[0] > 0 ? (size_t)p->def[0] : p->count;
    while (p->words[known]) known++;
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)entry, key, value) {
        size_t i = 0;
        while (i < known && strcmp(p->words[i], key) != 0) i++;
        if (i == known) return param_unknown(place, "key", key, p->words, known, r->err);
        if (!json_is_number(value)) return reader_wrong_type(r, place, key, "a number", value);
        out[i] = json_number_value(value);
    }
    for (size_t i = 0; i < required; i++)
        if (!json_object_get(entry, p->words[i]))
            return error_set(r->err, CAU_ERROR_INPUT, "%s: \"%s\" is missing", place, p->words[i]);
    return CAU_OK;
}

static cau_result list_entry(
    Reader *r, const char *place, const cau_param *p, size_t index, const json_t *entry, double *out) {
    char here[READER_PLACE_MAX], key[READER_PLACE_MAX];
    snprintf(here, sizeof here, "%s.%s[%zu]", place, p->name, index);
    if (p->words && json_is_object(entry)) return named_entry(r, here, p, entry, out);
    if (p->count > 1) {
        snprintf(key, sizeof key, "%.200s[%zu]", p->name, index);
        return reader_numbers(r, place, key, entry, p->count, out);
    }
    if (!json_is_number(entry)) return reader_wrong_type(r, here, "", "a number", entry);
    *out = json_number_value(entry);
    return CAU_OK;
}

static cau_result list_value(
    Reader *r, cau_item item, const char *place, const cau_param *p, const json_t *value) {
    if (json_is_string(value) && (p->flags & CAU_PARAM_OR_FILE))
        return reader_heights(r, item, place, p->name, json_string_value(value));
    if (!json_is_array(value)) return reader_wrong_type(r, place, p->name, "a list", value);
    size_t entries = json_array_size(value);
    double *numbers = array_new(entries, p->count * sizeof *numbers);
    if (!numbers)
        return error_set(r->err, CAU_ERROR_RESOURCE, "%s: out of memory for \"%s\"", place, p->name);
    cau_result result = CAU_OK;
    for (size_t i = 0; i < entries && result == CAU_OK; i++)
        result = list_entry(r, place, p, i, json_array_get(value, i), numbers + i * p->count);
    if (result == CAU_OK) result = cau_set(r->scene, item, p->name, numbers, entries * p->count);
    free(numbers);
    return result;
}

cau_result reader_value(Reader *r, cau_item item, const char *place, const char *key, const json_t *value) {
    cau_param p = {.size = sizeof p};
    const double nothing = 0;
    CAU_TRY(cau_param_named(r->scene, item, key, &p));
    if (p.flags & CAU_PARAM_UNSUPPORTED)
        return cau_set(r->scene, item, key, &nothing, 1); /* its error says why */
    switch (p.type) {
    case CAU_PARAM_BOOL:
        if (!json_is_boolean(value)) return reader_wrong_type(r, place, key, "true or false", value);
        return cau_set_choice(r->scene, item, key, json_is_true(value) ? "true" : "false");
    case CAU_PARAM_CHOICE:
    case CAU_PARAM_TEXT:
        if (!json_is_string(value)) return reader_wrong_type(r, place, key, "a text", value);
        if (p.type == CAU_PARAM_TEXT) return cau_set_text(r->scene, item, key, json_string_value(value));
        return cau_set_choice(r->scene, item, key, json_string_value(value));
    case CAU_PARAM_FLAGS:
        return flags_value(r, item, place, key, value);
    case CAU_PARAM_MATRIX:
        return matrix_value(r, item, place, key, value);
    case CAU_PARAM_LIST:
        return list_value(r, item, place, &p, value);
    case CAU_PARAM_PART:
        return reader_look(r, item, place, value); /* the other parts have callers of their own */
    default:
        return numbers_value(r, item, place, &p, value);
    }
}
