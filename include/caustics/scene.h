/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  A scene in memory.
 *
 *  A scene is built from items: the camera, the world, materials, lights, objects and their shapes. Each kind
 * of item has parameters with the names, units, ranges and defaults of the scene file
 * (docs/scene-reference.md); cau_set() and its sisters store one. Metres, Z up, right-handed; colours are
 * scene-linear RGB.
 *
 *  Ownership: everything passed in is copied during the call, no host pointer outlives it. Threads: one scene
 * is used by one thread at a time; two scenes are independent. Errors: each call returns a cau_result; the
 * first error of a context is kept as a sentence, see cau_error_text(). */
#ifndef CAUSTICS_SCENE_H
#define CAUSTICS_SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "caustics/error.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cau_context cau_context;
typedef struct cau_scene cau_scene;

/** Version of the library as "major.minor.patch". */
CAU_API const char *cau_version(void);

/** Creates a context: it keeps the first error and nothing else. */
CAU_API cau_result cau_context_create(cau_context **out);
/** Destroys it and sets *context to NULL. Scenes must be destroyed before. */
CAU_API void cau_context_destroy(cau_context **context);
/** The first error as one sentence, "" when there is none. Valid until the next call with this context. */
CAU_API const char *cau_error_text(const cau_context *context);
/** The code of the first error, CAU_OK when there is none. */
CAU_API cau_result cau_error_code(const cau_context *context);
CAU_API void cau_error_clear(cau_context *context);

CAU_API cau_result cau_scene_create(cau_context *context, cau_scene **out);
CAU_API void cau_scene_destroy(cau_scene **scene);

/** A part of a scene, valid as long as the scene. */
typedef uint32_t cau_item;

/** The parts that every scene has. */
enum { CAU_CAMERA = 1, CAU_FILTER = 2, CAU_WORLD = 3, CAU_BOUNCES = 4 };

/** Adds a material of a type ("diffuse", "plastic", "metal", "glass", "transparent"). Names are unique. */
CAU_API cau_result cau_add_material(cau_scene *scene, const char *name, const char *type, cau_item *out);

/** Adds a light of a type ("sun", "point", "spot", "area"). Names are unique. */
CAU_API cau_result cau_add_light(cau_scene *scene, const char *name, const char *type, cau_item *out);

/** Adds an object, still without shape. Names are unique. */
CAU_API cau_result cau_add_object(cau_scene *scene, const char *name, cau_item *out);

/** Gives an object a parametric shape ("plane", "sphere", "lathe", ...) whose parameters are then set on
 * *out. */
CAU_API cau_result cau_add_shape(cau_scene *scene, cau_item object, const char *type, cau_item *out);

/** A triangle mesh by pointer and stride. */
typedef struct cau_mesh {
    size_t size;              /**< sizeof(cau_mesh) */
    const void *positions;    /**< vertex_count times 3 floats or doubles, local space, metres */
    size_t position_stride;   /**< bytes from one vertex to the next, 0: tightly packed */
    int positions_are_double; /**< 0: float, 1: double */
    size_t vertex_count;
    const uint32_t
        *triangles; /**< triangle_count times 3 vertex indices, counter-clockwise seen from the front */
    size_t triangle_stride; /**< bytes, 0: tightly packed */
    size_t triangle_count;
    const float *normals;       /**< 3 floats per vertex or per corner, or NULL: computed where smooth */
    size_t normal_stride;       /**< bytes, 0: tightly packed */
    int normals_are_per_corner; /**< 1: 3 * triangle_count normals */
} cau_mesh;

/** Gives an object a mesh. It is copied; a bad index, a non-finite number or an unknown size is an error. */
CAU_API cau_result cau_set_mesh(cau_scene *scene, cau_item object, const cau_mesh *mesh);

/** Stores numbers: `count` must be what the parameter has (1, 2, 3 or 16; lists any multiple of their entry).
 */
CAU_API cau_result cau_set(
    cau_scene *scene, cau_item item, const char *key, const double *values, size_t count);

/** Stores a word ("type": "perspective"; "shape": "disk"). */
CAU_API cau_result cau_set_choice(cau_scene *scene, cau_item item, const char *key, const char *word);

/** Stores a set of words ("visible_to": diffuse, shadow). */
CAU_API cau_result cau_set_flags(
    cau_scene *scene, cau_item item, const char *key, const char *const *words, size_t count);

/** Stores a text: an object's "material", a light's or the world's "group". */
CAU_API cau_result cau_set_text(cau_scene *scene, cau_item item, const char *key, const char *text);

/** Places a camera, light or object at `from`, looking along its local -Z at `to`, world Z up (Y up where the
 *  view is vertical). */
CAU_API cau_result cau_set_look(cau_scene *scene, cau_item item, const double from[3], const double to[3]);

/** What a parameter holds. */
enum {
    CAU_PARAM_NUMBER = 0,
    CAU_PARAM_VEC2 = 1,
    CAU_PARAM_VEC3 = 2,
    CAU_PARAM_COLOR = 3,  /**< three numbers */
    CAU_PARAM_BOOL = 4,   /**< 0 or 1 by cau_set(), "true" or "false" by cau_set_choice() */
    CAU_PARAM_CHOICE = 5, /**< one of `words`, by cau_set_choice() */
    CAU_PARAM_FLAGS = 6,  /**< any of `words`, by cau_set_flags() */
    CAU_PARAM_MATRIX = 7, /**< 16 numbers, row-major */
    CAU_PARAM_LIST = 8,   /**< any multiple of `count` numbers; `words` name the numbers of an entry, or is
                             NULL; then   the first def[0] of them (0: all) must be given in a scene file */
    CAU_PARAM_TEXT = 9,   /**< by cau_set_text(), or fixed when the item is added ("name", "type") */
    CAU_PARAM_PART = 10   /**< a nested part of the scene file with a call or item of its own */
};

enum {
    CAU_PARAM_REQUIRED = 1,
    CAU_PARAM_UNSUPPORTED = 2, /**< known to the format, not built yet: setting it is an error that says so */
    CAU_PARAM_MIN_EXCLUDED = 4,
    CAU_PARAM_WHOLE = 8, /**< whole numbers only */
    CAU_PARAM_MAX_EXCLUDED = 16,
    CAU_PARAM_BROADCAST = 32, /**< one number stands for all components */
    CAU_PARAM_OR_FILE = 64    /**< a scene file may name a text file of rows of numbers */
};

/** A parameter of an item: what a host needs to build a panel for it. The strings are static. */
typedef struct cau_param {
    size_t size; /**< sizeof(cau_param), set by the caller */
    const char *name, *unit, *help;
    int32_t type;   /**< CAU_PARAM_NUMBER ... CAU_PARAM_PART */
    uint32_t flags; /**< CAU_PARAM_REQUIRED ... */
    uint32_t count; /**< how many numbers; a list: per entry; texts and parts: 0 */
    double def[3], min, max;
    const char *const *words; /**< NULL-terminated, or NULL */
} cau_param;

/** How many parameters an item has, 0 for an item that is not in the scene. */
CAU_API size_t cau_param_count(cau_scene *scene, cau_item item);
CAU_API cau_result cau_param_at(cau_scene *scene, cau_item item, size_t index, cau_param *out);
/** The parameter of that name; an unknown one is an error that names the nearest. */
CAU_API cau_result cau_param_named(cau_scene *scene, cau_item item, const char *key, cau_param *out);

enum { CAU_TYPES_OF_MATERIALS = 1, CAU_TYPES_OF_LIGHTS = 2, CAU_TYPES_OF_SHAPES = 3 };
/** The index-th type of material, light or shape; NULL past the last. */
CAU_API const char *cau_type_name(int family, size_t index);

/** The colour space of every colour in the scene, an interop ID of a linear RGB space: "lin_rec709_scene"
 * (the default), "lin_ap1_scene", "lin_ap0_scene", "lin_p3d65_scene", "lin_rec2020_scene",
 * "lin_adobergb_scene". */
CAU_API cau_result cau_set_color_space(cau_scene *scene, const char *name);

#ifdef __cplusplus
}
#endif
#endif
