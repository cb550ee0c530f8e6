/* SPDX-License-Identifier: Apache-2.0 */
#include "composite/hosts/json_text.h"

#include <stdbool.h>
#include <string.h>

const char *json_text_skip(const char *at) { return at + strspn(at, " \t\r\n"); }

static const char *string_end(const char *at) {
    for (at++; *at && *at != '"'; at++)
        if (*at == '\\' && at[1]) at++;
    return *at ? at + 1 : at;
}

const char *json_text_end(const char *at) {
    if (*at == '"') return string_end(at);
    if (*at != '{' && *at != '[') return at + strcspn(at, ",]} \t\r\n");
    for (int depth = 0; *at;) {
        if (*at == '"') {
            at = string_end(at);
            continue;
        }
        depth += (*at == '{' || *at == '[') - (*at == '}' || *at == ']');
        at++;
        if (depth == 0) break;
    }
    return at;
}

/* Past the comma after a value; NULL after the last. */
static const char *next(const char *value) {
    const char *at = json_text_skip(json_text_end(value));
    return *at == ',' ? json_text_skip(at + 1) : NULL;
}

const char *json_text_member(const char *object, const char *key) {
    size_t length = strlen(key);
    const char *at = json_text_skip(object + 1);
    while (at && *at == '"') {
        const char *end = string_end(at), *value = json_text_skip(json_text_skip(end) + 1);
        bool same = (size_t)(end - at) == length + 2 && strncmp(at + 1, key, length) == 0;
        if (same) return value;
        at = next(value);
    }
    return NULL;
}

const char *json_text_element(const char *array, size_t index) {
    const char *at = json_text_skip(array + 1);
    if (*at == ']') return NULL;
    while (at && index-- > 0) at = next(at);
    return at;
}
