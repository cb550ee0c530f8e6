/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Places in JSON text, so that a value can be exchanged and all else stays as somebody wrote it. The text
 * must be valid JSON: these do not check it. */
#ifndef COMPOSITE_HOSTS_JSON_TEXT_H
#define COMPOSITE_HOSTS_JSON_TEXT_H

#include <stddef.h>

/** Past white space. */
const char *json_text_skip(const char *at);
/** The end of the value that begins at `at`. */
const char *json_text_end(const char *at);
/** The value of `key` in the object that begins at `object`; NULL when there is none. */
const char *json_text_member(const char *object, const char *key);
/** Element `index` of the array that begins at `array`; NULL beyond the last. */
const char *json_text_element(const char *array, size_t index);

#endif
