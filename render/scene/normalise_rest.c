/* SPDX-License-Identifier: Apache-2.0 */
/* Camera and lights into scene space. */
#include "render/scene/scene_internal.h"

#include "core/checked.h"
#include "core/rng.h"

#include <stdio.h>

static cau_result camera_size(const CameraParams *p, int width, int height, Camera *out, CauError *err) {
    if (width > 0 && height > 0) {
        if (width > 65536 || height > 65536)
            return error_set(
                err, CAU_ERROR_INPUT, "the resolution is %d x %d; the limit is 65536 x 65536", width, height);
        out->width = width;
        out->height = height;
        return CAU_OK;
    }
    if (isnan(p->resolution[0]))
        return error_set(
            err, CAU_ERROR_INPUT, "camera: \"resolution\" is missing (width and height in pixels)");
    out->width = (int)p->resolution[0];
    out->height = (int)p->resolution[1];
    return CAU_OK;
}

static cau_result camera_projection(const CameraParams *p, double units, Camera *out, CauError *err) {
    out->type = p->type == 0 ? CAMERA_PERSPECTIVE : CAMERA_ORTHOGRAPHIC;
    if (out->type == CAMERA_PERSPECTIVE && isnan(p->hfov_deg))
        return error_set(
            err, CAU_ERROR_INPUT, "camera: \"hfov_deg\" is missing (horizontal field of view in degrees)");
    if (out->type == CAMERA_ORTHOGRAPHIC && isnan(p->ortho_width))
        return error_set(
            err, CAU_ERROR_INPUT, "camera: \"ortho_width\" is missing (width of the picture in metres)");
    if (!(p->clip[0] < p->clip[1]))
        return error_set(err, CAU_ERROR_INPUT,
            "camera.clip is %g %g m; the first must be less than the second", p->clip[0], p->clip[1]);
    if (out->type == CAMERA_PERSPECTIVE)
        out->tan_half_width = tan(0.5 * p->hfov_deg * (CAU_PI / 180));
    else
        out->ortho_width = p->ortho_width * units;
    out->clip_near = p->clip[0] * units;
    out->clip_far = p->clip[1] * units;
    return CAU_OK;
}

/* The view direction is kept, up is made square to it; scale and mirroring are ignored, as Blender does. */
static void camera_axes(const Affine *world, Camera *out) {
    out->forward = v3_neg(v3_normalize(affine_column(world, 2)));
    V3 up = v3_normalize(affine_column(world, 1));
    up = v3_mad(up, -v3_dot(up, out->forward), out->forward);
    out->up = v3_normalize(up);
    out->right = v3_cross(out->forward, out->up);
}

cau_result normalise_camera(
    const struct cau_scene *source, int width, int height, Scene *out, CauError *err) {
    const CameraParams *p = &source->camera;
    Camera *c = &out->camera;
    if (source->camera_placed == PLACED_NOT)
        return error_set(
            err, CAU_ERROR_INPUT, "scene: no camera is placed; give \"camera\" a \"look\" or a \"matrix\"");
    CAU_TRY(camera_size(p, width, height, c, err));
    CAU_TRY(camera_projection(p, out->units_per_m, c, err));
    Affine world = affine_from_matrix(p->matrix);
    camera_axes(&world, c);
    c->position = scene_from_world(out, affine_column(&world, 3));
    c->shift_x = p->shift[0];
    c->shift_y = p->shift[1];
    c->pixel_aspect = p->pixel_aspect;
    c->exposure = p->exposure;
    c->filter = (FilterType)source->filter.type;
    c->filter_width = source->filter.width;
    return CAU_OK;
}

static Affine light_to_scene(const Scene *s, const LightSource *l) {
    Affine a = affine_from_matrix(l->matrix);
    V3 p = scene_from_world(s, affine_column(&a, 3));
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) a.m[r][c] *= s->units_per_m;
    a.m[0][3] = p.x;
    a.m[1][3] = p.y;
    a.m[2][3] = p.z;
    return a;
}

static cau_result add_light(Scene *s, const LightSource *l, const char *place, CauError *err) {
    Light *out = &s->lights[s->light_count];
    CAU_TRY(param_check_required(&l->kind->table, l->data, place, err));
    Affine to_scene = light_to_scene(s, l);
    CAU_TRY(l->kind->prepare(l, &to_scene, square(s->units_per_m), out, place, err));
    out->kind = l->kind;
    out->name = l->name;
    out->layer = l->group ? l->group : l->name;
    out->stream = rng_hash_text(l->name);
    out->casts = l->casts_caustics != 0;
    s->light_count++;
    return CAU_OK;
}

/* The world is a light like others from here on; a black one is none. */
static cau_result add_world(const struct cau_scene *source, Scene *s, CauError *err) {
    const WorldParams *w = &source->world;
    const LightKind *kind = light_find("world");
    double brightest = fmax(w->color[0], fmax(w->color[1], w->color[2])) * w->strength;
    if (!(brightest > 0) || !kind) return CAU_OK;
    LightSource *l = &s->world_source;
    *l = (LightSource){.kind = kind, .name = (char *)(uintptr_t) "world", .group = source->world_group};
    param_defaults(&light_table, l);
    param_defaults(&kind->table, l->data);
    CAU_TRY(param_set(&kind->table, l->data, "world", "color", w->color, 3, err));
    CAU_TRY(param_set(&kind->table, l->data, "world", "strength", &w->strength, 1, err));
    return add_light(s, l, "world", err);
}

cau_result normalise_lights(struct cau_scene *source, Scene *out, CauError *err) {
    out->lights = array_new(source->light_count + 1, sizeof *out->lights);
    if (!out->lights)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu lights", source->light_count);
    for (size_t i = 0; i < source->light_count; i++) {
        const LightSource *l = &source->lights[i];
        char place[PLACE_TEXT_MAX + NAME_BYTES_MAX + 16];
        snprintf(place, sizeof place, "lights[%zu] \"%s\"", i, l->name);
        if (l->placed == PLACED_NOT)
            return error_set(err, CAU_ERROR_INPUT, "%s: not placed; give a \"look\" or a \"matrix\"", place);
        CAU_TRY(add_light(out, l, place, err));
    }
    return add_world(source, out, err);
}
