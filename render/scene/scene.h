/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The scene stage: what the caller described, and its normalised form that every later stage reads.
 *
 *  scene_normalise() checks the whole, transforms everything in double precision into *scene space* (the
 * casters are centred at the origin and about one unit in size), and after it everything is finite. In scene
 * space lengths are `units_per_m` times metres; radiance and irradiance keep their values, flux is multiplied
 * by units_per_m squared (so that flux / area stays irradiance) and divided again where it is reported. */
#ifndef RENDER_SCENE_SCENE_H
#define RENDER_SCENE_SCENE_H

#include "caustics/scene.h"
#include "core/error.h"
#include "core/param.h"
#include "core/vec.h"
#include "render/light/light.h"
#include "render/material/material.h"
#include "render/scene/names.h"
#include "render/scene/shape.h"

#include <stdint.h>

struct cau_context {
    CauError error;
};

typedef enum CameraType { CAMERA_PERSPECTIVE, CAMERA_ORTHOGRAPHIC } CameraType;
typedef enum FilterType { FILTER_BOX, FILTER_GAUSSIAN, FILTER_BLACKMAN_HARRIS } FilterType;

typedef struct CameraParams {
    double type, hfov_deg, ortho_width, shift[2], clip[2], resolution[2], pixel_aspect, exposure;
    double matrix[16];
} CameraParams;

typedef struct FilterParams {
    double type, width;
} FilterParams;

typedef struct WorldParams {
    double color[3], strength;
} WorldParams;

/** Cycles' bounce limits; -1 is none. */
typedef struct BounceParams {
    double total, diffuse, glossy, transmission;
} BounceParams;

enum {
    VISIBLE_DIFFUSE = 1,
    VISIBLE_GLOSSY = 2,
    VISIBLE_TRANSMISSION = 4,
    VISIBLE_SHADOW = 8,
    VISIBLE_CAMERA = 16
};

typedef struct ObjectParams {
    double matrix[16], position[3], scale[3], rotation_deg[3];
    double smooth, visible_to_camera, visible_to, casts_caustics, receives_caustics;
} ObjectParams;

/** light_table: what every kind of light has; offsets in LightSource. */
extern const ParamTable camera_table, filter_table, world_table, bounces_table, object_table, light_table;

/** The colour spaces a scene may have, NULL-terminated; the first is the default. */
extern const char *const scene_color_spaces[];

enum { PLACED_NOT, PLACED_BY_MATRIX, PLACED_BY_LOOK, PLACED_BY_PARTS };

typedef struct Object {
    char *name, *material_name;
    ObjectParams params;
    int placed;
    const ShapeKind *shape; /**< NULL: mesh given by the caller */
    void *shape_data;
    Mesh mesh; /**< in a cau_scene: local space, as given. In a Scene: a copy or the tessellated shape, scene
                  space */
    bool mesh_from_floats; /**< the caller's vertices were single precision */
    int material;
    bool exact;    /**< intersected through shape->intersect, `mesh` is empty */
    bool mirrored; /**< local_to_scene has a negative determinant; the mesh's winding is already turned */
    Affine local_to_scene, scene_to_local; /**< filled by scene_normalise() */
    V3 bounds_min, bounds_max;             /**< scene space */
    unsigned visibility;                   /**< VISIBLE_* */
    bool casts;    /**< casts_caustics is set and the material has LOBE_CASTING lobes */
    bool receives; /**< receives_caustics is set and the material has a LOBE_DIFFUSE lobe */
} Object;

/** The scene-space unit normal of an exact surface, towards its front side also where the object is mirrored.
 */
static inline V3 object_normal(const Object *o, V3 local_normal) {
    V3 n = v3_normalize(affine_normal(&o->local_to_scene, local_normal));
    return o->mirrored ? v3_neg(n) : n;
}

typedef struct Camera {
    CameraType type;
    V3 position, right, up, forward; /**< scene space, orthonormal */
    double tan_half_width;           /**< perspective: tan(hfov / 2) */
    double ortho_width;              /**< scene units */
    double shift_x, shift_y;         /**< image widths */
    double clip_near, clip_far;      /**< scene units */
    int width, height;
    double pixel_aspect, exposure;
    FilterType filter;
    double filter_width; /**< pixels */
} Camera;

struct cau_scene {
    cau_context *context;
    CameraParams camera;
    int camera_placed;
    FilterParams filter;
    WorldParams world;
    BounceParams bounces;
    char *world_group, *color_space;
    Material *materials;
    size_t material_count, material_capacity;
    Object *objects;
    size_t object_count, object_capacity;
    LightSource *lights;
    size_t light_count, light_capacity;
    NameTable material_names, object_names, light_names;
    char *source_path; /**< the scene file, for errors; NULL when built in memory */
};

/** The normalised scene. It borrows names, materials and shape parameters from the cau_scene, which must
 * outlive it; the meshes are its own. */
typedef struct Scene {
    const struct cau_scene *source;
    Camera camera;
    V3 origin_m;        /**< world position of the scene-space origin */
    double units_per_m; /**< scene units per metre */
    BounceParams bounces;
    Object *objects;
    size_t object_count;
    const Material *materials;
    size_t material_count;
    Light *lights; /**< the world, if not black, is the last one */
    size_t light_count;
    LightSource world_source;
    V3 bounds_min, bounds_max; /**< of all objects, scene space */
    char **warnings;           /**< scene_warn() adds to them */
    size_t warning_count;
} Scene;

/** Checks and normalises. The camera's resolution may be overridden (0: as in the scene). */
cau_result scene_normalise(
    struct cau_scene *source, int width_override, int height_override, Scene *out, CauError *err);
void scene_free(Scene *scene);
/** Adds a warning that only a later stage can know of. */
cau_result scene_warn(Scene *scene, CauError *err, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** A 64-bit hash of everything the scene says (names, parameters, meshes, in this order), for metadata and
 *  checkpoints. It does not depend on the scene having been normalised. */
uint64_t scene_hash(const struct cau_scene *scene);

/** p_scene = (p_world - origin) * units_per_m. */
static inline V3 scene_from_world(const Scene *s, V3 p) {
    return v3_scale(v3_sub(p, s->origin_m), s->units_per_m);
}

#endif
