/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What the files of render/scene/ share among themselves. */
#ifndef RENDER_SCENE_INTERNAL_H
#define RENDER_SCENE_INTERNAL_H

#include "render/scene/scene.h"

typedef enum ItemKind { ITEM_NONE, ITEM_PART, ITEM_MATERIAL, ITEM_LIGHT, ITEM_OBJECT, ITEM_SHAPE } ItemKind;

enum { PLACE_TEXT_MAX = 320, NAME_BYTES_MAX = 255 };

/** An item found: its tables, the data behind each, and the place to name in an error ("objects[2].shape").
 */
typedef struct ItemView {
    ItemKind kind;
    size_t index;
    const ParamTable *tables[2];
    void *data[2];
    size_t table_count;
    char place[PLACE_TEXT_MAX];
} ItemView;

cau_item item_make(ItemKind kind, size_t index);
/** Fills `out`. False when the item is not in the scene. */
bool item_find(struct cau_scene *scene, cau_item item, ItemView *out);
/** The same as an error: an item that is not in the scene is wrong usage. */
cau_result item_view(struct cau_scene *scene, cau_item item, ItemView *out);
/** The table that holds the key, and the key; else an error that names the nearest of all tables. */
cau_result item_key(
    struct cau_scene *scene, const ItemView *view, const char *key, size_t *table, const Param **param);

/** The places of things in the sentences of errors, as in the scene file. */
void place_of_material(const Material *m, char out[PLACE_TEXT_MAX]);
void place_of_object(size_t index, char out[PLACE_TEXT_MAX]);
void place_of_light(size_t index, char out[PLACE_TEXT_MAX]);

/** A row-major 4x4 as an affine map. */
Affine affine_from_matrix(const double m[16]);
/** The map of something at `from` that looks along its local -Z at `to`. False when they are the same point.
 */
bool matrix_look(const double from[3], const double to[3], double out[16]);
/** T Rz Ry Rx S. */
Affine affine_from_parts(const double position[3], const double rotation_deg[3], const double scale[3]);

/** A list of sentences; `lost` when memory ran out. */
typedef struct Warnings {
    char **texts;
    size_t count, capacity;
    bool lost;
} Warnings;

void warnings_add(Warnings *w, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** Local mesh or exact shape of every object of `scene`, and the local-to-world map in local_to_scene. */
cau_result normalise_shape(const Object *source, size_t index, Object *out, CauError *err);
/** World bounds of an object whose local_to_scene is still local-to-world. False when it is empty. */
bool object_world_bounds(const Object *o, V3 *lo, V3 *hi);
/** Mesh to scene space: vertices, normals, winding; drops triangles without area, with a warning. */
cau_result normalise_mesh(Object *o, Warnings *warnings, CauError *err);
/** Warns of glass that is open or inside out, and of vertices with too few digits. */
cau_result mesh_warn(
    const Object *o, const Mesh *local, const Material *material, Warnings *warnings, CauError *err);

cau_result normalise_camera(const struct cau_scene *source, int width, int height, Scene *out, CauError *err);
cau_result normalise_lights(struct cau_scene *source, Scene *out, CauError *err);

#endif
