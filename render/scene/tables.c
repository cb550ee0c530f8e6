/* SPDX-License-Identifier: Apache-2.0 */
/* The parameters of everything that is not a material, a kind of light or a shape. */
#include "render/scene/scene.h"

/* Beyond this, metres lose meaning in double precision: a picometre is left. */
#define FAR 1e12
#define HUGE_STRENGTH 1e30

#define TEXT(name_, help_)                                                                                   \
    { .name = (name_), .type = PARAM_TEXT, .unit = "", .help = (help_) }
#define PART(name_, help_)                                                                                   \
    { .name = (name_), .type = PARAM_PART, .unit = "", .help = (help_) }
#define REFUSED(name_, help_)                                                                                \
    { .name = (name_), .type = PARAM_NUMBER, .unit = "", .flags = PARAM_UNSUPPORTED, .help = (help_) }
#define AT(type_, field_) .name = #field_, .offset = offsetof(type_, field_)
#define SWITCH(type_, field_, help_)                                                                         \
    { AT(type_, field_), .type = PARAM_BOOL, .unit = "", .def = {1}, .max = 1, .help = (help_) }
#define MATRIX(type_, help_)                                                                                 \
    { AT(type_, matrix), .type = PARAM_MATRIX, .unit = "", .min = -FAR, .max = FAR, .help = (help_) }
#define LOOK PART("look", "from and to: in place of the matrix, world Z up")

static const char *const camera_types[] = {"perspective", "orthographic", NULL};

static const Param camera_params[] = {
    {AT(CameraParams, type), .type = PARAM_CHOICE, .unit = "", .choices = camera_types, .help = "projection"},
    MATRIX(CameraParams, "camera to world; it looks along its local -Z, +Y up; its scale is ignored"),
    LOOK,
    {AT(CameraParams, hfov_deg), .type = PARAM_NUMBER, .unit = "deg", .def = {NAN}, .max = 180,
        .flags = PARAM_MIN_EXCLUDED | PARAM_MAX_EXCLUDED,
        .help = "horizontal field of view; needed by a perspective camera"},
    {AT(CameraParams, ortho_width), .type = PARAM_NUMBER, .unit = "m", .def = {NAN}, .max = FAR,
        .flags = PARAM_MIN_EXCLUDED, .help = "width of the picture; needed by an orthographic camera"},
    {AT(CameraParams, shift), .type = PARAM_VEC2, .unit = "image widths", .min = -100, .max = 100,
        .help = "moves the picture plane"},
    {AT(CameraParams, clip), .type = PARAM_VEC2, .unit = "m", .def = {0.01, 1e6}, .max = 1e15,
        .flags = PARAM_MIN_EXCLUDED, .help = "nearest and farthest distance seen, along the view axis"},
    {AT(CameraParams, resolution), .type = PARAM_VEC2, .unit = "px", .def = {NAN, NAN}, .min = 1,
        .max = 65536, .flags = PARAM_POSITIVE_INT,
        .help = "width and height; needed unless the render call gives them"},
    {AT(CameraParams, pixel_aspect), .type = PARAM_NUMBER, .unit = "", .def = {1}, .min = 0.01, .max = 100,
        .help = "width of a pixel over its height"},
    PART("filter", "pixel filter"),
    {AT(CameraParams, exposure), .type = PARAM_NUMBER, .unit = "", .def = {1}, .max = HUGE_STRENGTH,
        .flags = PARAM_MIN_EXCLUDED, .help = "scales the output, as the film exposure of Cycles does"},
    REFUSED("fstop", "lens blur"),
    REFUSED("aperture_radius", "lens blur"),
    REFUSED("focus_distance", "lens blur"),
    REFUSED("lens_blur", "lens blur"),
    REFUSED("depth_of_field", "lens blur"),
    REFUSED("motion_blur", "motion blur"),
    REFUSED("shutter", "motion blur"),
};
const ParamTable camera_table = PARAM_TABLE(camera_params);

static const char *const filter_types[] = {"box", "gaussian", "blackman_harris", NULL};

static const Param filter_params[] = {
    {AT(FilterParams, type), .type = PARAM_CHOICE, .unit = "", .def = {FILTER_BLACKMAN_HARRIS},
        .choices = filter_types, .help = "as in Cycles"},
    {AT(FilterParams, width), .type = PARAM_NUMBER, .unit = "px", .def = {1.5}, .max = 64,
        .flags = PARAM_MIN_EXCLUDED, .help = "full width"},
};
const ParamTable filter_table = PARAM_TABLE(filter_params);

static const Param world_params[] = {
    {AT(WorldParams, color), .type = PARAM_COLOR, .unit = "", .max = HUGE_STRENGTH,
        .help = "radiance before `strength`"},
    {AT(WorldParams, strength), .type = PARAM_NUMBER, .unit = "W/m2/sr", .def = {1}, .max = HUGE_STRENGTH,
        .help = "scales the colour"},
    TEXT("group", "name of its layer, \"world\" by default"),
    REFUSED("image", "environment images"),
    REFUSED("rotation_deg", "environment images and their rotation"),
};
const ParamTable world_table = PARAM_TABLE(world_params);

#define BOUNCE(field_, help_)                                                                                \
    {                                                                                                        \
        AT(BounceParams, field_), .type = PARAM_NUMBER, .unit = "", .def = {-1}, .max = 1e6,                 \
                                  .flags = PARAM_POSITIVE_INT, .help = (help_)                               \
    }

static const Param bounces_params[] = {
    BOUNCE(total, "all kinds together"),
    BOUNCE(diffuse, "diffuse reflections"),
    BOUNCE(glossy, "glossy and mirror reflections"),
    BOUNCE(transmission, "refractions"),
    REFUSED("volume", "volumes"),
};
const ParamTable bounces_table = PARAM_TABLE(bounces_params);

static const char *const ray_kinds[] = {"diffuse", "glossy", "transmission", "shadow", NULL};

static const Param object_params[] = {
    TEXT("name", "unique"),
    TEXT("material", "name of a material"),
    PART("shape", "a parametric shape, or a mesh given inline"),
    TEXT("file", "mesh file in place of a shape: .ply .obj .gltf .glb"),
    MATRIX(ObjectParams, "object to world"),
    LOOK,
    {AT(ObjectParams, position), .type = PARAM_VEC3, .unit = "m", .min = -FAR, .max = FAR,
        .help = "in place of the matrix, with scale and rotation"},
    {AT(ObjectParams, scale), .type = PARAM_VEC3, .unit = "", .def = {1, 1, 1}, .min = -FAR, .max = FAR,
        .flags = PARAM_BROADCAST, .help = "applied first; not 0"},
    {AT(ObjectParams, rotation_deg), .type = PARAM_VEC3, .unit = "deg", .min = -1e6, .max = 1e6,
        .help = "XYZ Euler angles: about X, then Y, then Z"},
    SWITCH(ObjectParams, smooth, "interpolated normals where the surface is curved; false: flat faces"),
    SWITCH(ObjectParams, visible_to_camera, "seen by camera rays"),
    {AT(ObjectParams, visible_to), .type = PARAM_FLAGS, .unit = "", .def = {15}, .max = 15,
        .choices = ray_kinds, .help = "kinds of ray that see it, as the ray visibility of Cycles"},
    SWITCH(ObjectParams, casts_caustics, "false: makes none, still blocks light"),
    SWITCH(ObjectParams, receives_caustics, "false: no caustic falls on it"),
    REFUSED("motion_blur", "motion blur"),
    REFUSED("volume", "volumes"),
};
const ParamTable object_table = PARAM_TABLE(object_params);

static const Param light_params[] = {
    TEXT("name", "unique; names the layer unless there is a group"),
    MATRIX(LightSource, "light to world; it shines along its local -Z"),
    LOOK,
    TEXT("group", "name of its layer; the light's own name by default"),
    SWITCH(LightSource, casts_caustics, "false: has no layer"),
};
const ParamTable light_table = PARAM_TABLE(light_params);

/* Interop IDs of linear RGB spaces: colours of any other kind would not add up. The first is the default. */
const char *const scene_color_spaces[] = {"lin_rec709_scene", "lin_ap1_scene", "lin_ap0_scene",
    "lin_p3d65_scene", "lin_rec2020_scene", "lin_adobergb_scene", NULL};
