/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The scene reader: a thin front of the public API. It knows the nesting of the file; what keys there are,
 * of which type, and within which limits, it asks the library (cau_param_named). */
#ifndef RENDER_SCENE_IO_READER_H
#define RENDER_SCENE_IO_READER_H

#include "caustics/scene_file.h"
#include "core/error.h"

#include <jansson.h>
#include <locale.h>

enum { READER_PLACE_MAX = 512 };

typedef struct Reader {
    cau_context *context;
    cau_scene *scene;
    CauError *err;
    const char *path;  /**< as the caller gave it */
    locale_t c_locale; /**< a host may have set one with decimal commas */
    char *folder;      /**< real path of the folder that files must stay in */
} Reader;

/** "a number", "a list", ... */
const char *json_kind(const json_t *value);
/** Error: `place`.`key` must be `expected`, not what it is. An empty key names the place itself. */
cau_result reader_wrong_type(
    Reader *r, const char *place, const char *key, const char *expected, const json_t *value);

/** Stores the value of a key on an item, whatever its type. */
cau_result reader_value(Reader *r, cau_item item, const char *place, const char *key, const json_t *value);
/** Exactly `count` numbers. */
cau_result reader_numbers(
    Reader *r, const char *place, const char *key, const json_t *value, size_t count, double *out);
/** The text under a key that must be there. */
cau_result reader_text(Reader *r, const char *place, const json_t *object, const char *key, const char **out);
/** "look": {"from", "to"}. */
cau_result reader_look(Reader *r, cau_item item, const char *place, const json_t *value);

/** An object's "shape", also an inline mesh. */
cau_result reader_shape(Reader *r, cau_item object, const char *place, const json_t *shape);
/** An object's "file". */
cau_result reader_mesh_file(Reader *r, cau_item object, const char *place, const char *name);
/** A file of heights, one row a line, for a "grid". */
cau_result reader_heights(Reader *r, cau_item shape, const char *place, const char *key, const char *name);

/** The real path of a file named in the scene, to be freed: relative, a regular file, in the folder or below.
 */
cau_result reader_resolve(Reader *r, const char *place, const char *key, const char *name, char **out);

/** A whole regular file, with a zero byte after its end, to be freed. `place` begins the sentence of an
 * error. */
cau_result file_read(
    const char *path, size_t limit, const char *place, char **data, size_t *size, CauError *err);
/** True when the real path `path` lies in the real path `folder`. */
int path_inside(const char *folder, const char *path);

#endif
