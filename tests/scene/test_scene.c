/* SPDX-License-Identifier: Apache-2.0 */
/* The scene API and normalisation: errors, transforms, scene space. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "render/scene/scene.h"

#include <stdlib.h>
#include <string.h>

typedef struct World {
    cau_context *context;
    cau_scene *scene;
} World;

static World open_world(void) {
    World w = {0};
    assert_int_equal(cau_context_create(&w.context), CAU_OK);
    assert_int_equal(cau_scene_create(w.context, &w.scene), CAU_OK);
    return w;
}

static void close_world(World *w) {
    cau_scene_destroy(&w->scene);
    cau_context_destroy(&w->context);
    assert_null(w->scene);
    assert_null(w->context);
}

static void must(World *w, cau_result result) {
    if (result != CAU_OK) fail_msg("%s", cau_error_text(w->context));
}

/* The call failed with the code, and its sentence holds the words. */
static void expect_error(World *w, cau_result result, cau_result code, const char *words) {
    const char *text = cau_error_text(w->context);
    if (result != code || !strstr(text, words))
        fail_msg("code %d, \"%s\" does not say \"%s\"", result, text, words);
    assert_int_equal(cau_error_code(w->context), code);
    cau_error_clear(w->context);
}

static void set(World *w, cau_item item, const char *key, size_t count, const double *values) {
    must(w, cau_set(w->scene, item, key, values, count));
}

static void set1(World *w, cau_item item, const char *key, double value) { set(w, item, key, 1, &value); }

static void add_camera(World *w) {
    set1(w, CAU_CAMERA, "hfov_deg", 40);
    set(w, CAU_CAMERA, "resolution", 2, (double[]){48, 27});
    must(w, cau_set_look(w->scene, CAU_CAMERA, (double[]){0, -4, 2.5}, (double[]){-0.2, 0, 0.4}));
}

static cau_item add_glass(World *w) {
    cau_item m;
    must(w, cau_add_material(w->scene, "glass", "glass", &m));
    set(w, m, "color", 3, (double[]){1, 1, 1});
    return m;
}

static cau_item add_object(World *w, const char *name, const char *shape, cau_item *shape_item) {
    cau_item o;
    must(w, cau_add_object(w->scene, name, &o));
    must(w, cau_set_text(w->scene, o, "material", "glass"));
    if (shape) must(w, cau_add_shape(w->scene, o, shape, shape_item));
    return o;
}

static Scene normalised(World *w) {
    Scene s;
    CauError err = {0};
    if (scene_normalise(w->scene, 0, 0, &s, &err) != CAU_OK) fail_msg("%s", err.text);
    return s;
}

static void expect_normalise(World *w, const char *words) {
    Scene s;
    CauError err = {0};
    assert_int_not_equal(scene_normalise(w->scene, 0, 0, &s, &err), CAU_OK);
    if (!strstr(err.text, words)) fail_msg("\"%s\" does not say \"%s\"", err.text, words);
}

static void mistakes_are_named(void **state) {
    (void)state;
    World w = open_world();
    cau_scene *s = w.scene;
    cau_item glass = add_glass(&w), shape, ball = add_object(&w, "ball", "sphere", &shape), other;
    double one = 1, bad = NAN, minus = -1, two[] = {1, 2, 3},
           flat[16] = {1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0, 1};
    expect_error(&w, cau_set(s, glass, "iorr", &one, 1), CAU_ERROR_INPUT, "did you mean \"ior\"");
    expect_error(
        &w, cau_set(s, glass, "ior", &bad, 1), CAU_ERROR_INPUT, "materials.glass.ior is not a finite");
    expect_error(&w, cau_set(s, shape, "radius", &minus, 1), CAU_ERROR_INPUT,
        "objects[0].shape.radius is -1 m; it must be greater than 0 (object \"ball\")");
    expect_error(&w, cau_set(s, glass, "ior", two, 2), CAU_ERROR_INPUT, "must have 1");
    expect_error(&w, cau_set(s, glass, "abbe", &one, 1), CAU_ERROR_UNSUPPORTED, "not yet supported");
    expect_error(
        &w, cau_set(s, CAU_CAMERA, "hfov_deg", (double[]){180}, 1), CAU_ERROR_INPUT, "less than 180");
    expect_error(&w, cau_set(s, CAU_CAMERA, "resolution", (double[]){1.5, 2}, 2), CAU_ERROR_INPUT, "whole");
    expect_error(&w, cau_set(s, CAU_CAMERA, "resolution", (double[]){65537, 2}, 2), CAU_ERROR_INPUT, "65536");
    expect_error(&w, cau_set(s, ball, "matrix", flat, 16), CAU_ERROR_INPUT, "singular");
    expect_error(&w, cau_set_choice(s, CAU_FILTER, "type", "boxx"), CAU_ERROR_INPUT, "\"box\"");
    expect_error(&w, cau_set_flags(s, ball, "visible_to", (const char *[]){"difuse"}, 1), CAU_ERROR_INPUT,
        "\"diffuse\"");
    expect_error(&w, cau_add_object(s, "ball", &other), CAU_ERROR_INPUT, "taken");
    expect_error(&w, cau_add_object(s, "", &other), CAU_ERROR_INPUT, "empty");
    expect_error(&w, cau_add_object(s, "a\nb", &other), CAU_ERROR_INPUT, "control");
    expect_error(&w, cau_add_material(s, "m", "glas", &other), CAU_ERROR_INPUT, "did you mean \"glass\"");
    expect_error(&w, cau_add_material(s, "m", "emission", &other), CAU_ERROR_UNSUPPORTED, "mesh lights");
    expect_error(&w, cau_add_light(s, "l", "world", &other), CAU_ERROR_INPUT, "unknown light type");
    expect_error(&w, cau_add_shape(s, ball, "sphere", &other), CAU_ERROR_INPUT, "has a shape");
    expect_error(&w, cau_set(s, 12345, "ior", &one, 1), CAU_ERROR_USAGE, "12345");
    expect_error(&w, cau_set_color_space(s, "lin_rec709"), CAU_ERROR_INPUT, "lin_rec709_scene");
    expect_error(&w, cau_set_look(s, ball, two, two), CAU_ERROR_INPUT, "same point");
    set1(&w, ball, "scale", 2);
    expect_error(
        &w, cau_set_look(s, ball, (double[]){0, 0, 0}, (double[]){1, 0, 0}), CAU_ERROR_INPUT, "both");
    assert_int_equal(cau_set(NULL, glass, "ior", &one, 1), CAU_ERROR_USAGE);
    expect_normalise(&w, "\"radius\" is missing");
    set1(&w, shape, "radius", 1);
    expect_normalise(&w, "no camera");
    add_camera(&w);
    must(&w, cau_set_text(s, ball, "material", "gläss"));
    expect_normalise(&w, "objects[0]: unknown material \"gläss\"; did you mean \"glass\"");
    close_world(&w);
}

static void bad_meshes_are_refused(void **state) {
    (void)state;
    World w = open_world();
    add_glass(&w);
    cau_item o = add_object(&w, "mesh", NULL, NULL);
    float p[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, n[3] = {0, 0, 1};
    uint32_t t[3] = {0, 1, 4};
    cau_mesh m = {.size = sizeof m, .positions = p, .vertex_count = 4, .triangles = t, .triangle_count = 1};
    expect_error(&w, cau_set_mesh(w.scene, o, &m), CAU_ERROR_INPUT, "uses vertex 4; there are only 4");
    t[2] = 2;
    p[4] = INFINITY;
    expect_error(&w, cau_set_mesh(w.scene, o, &m), CAU_ERROR_INPUT, "vertex 1");
    p[4] = 0;
    m.size = 8;
    expect_error(&w, cau_set_mesh(w.scene, o, &m), CAU_ERROR_USAGE, "cau_mesh.size");
    m.size = sizeof m;
    m.position_stride = 4;
    expect_error(&w, cau_set_mesh(w.scene, o, &m), CAU_ERROR_INPUT, "stride");
    m.position_stride = 0;
    m.vertex_count = (size_t)1 << 40;
    expect_error(&w, cau_set_mesh(w.scene, o, &m), CAU_ERROR_INPUT, "too large");
    m.vertex_count = 4;
    n[0] = NAN;
    m.normals = n;
    m.normals_are_per_corner = 1;
    m.normal_stride = 12;
    m.triangle_count = 0; /* no triangle, no normal that is read */
    must(&w, cau_set_mesh(w.scene, o, &m));
    close_world(&w);
}

static void every_parameter_is_described(void **state) {
    (void)state;
    World w = open_world();
    cau_item items[64] = {CAU_CAMERA, CAU_FILTER, CAU_WORLD, CAU_BOUNCES};
    size_t count = 4, described = 0;
    char name[16] = "a";
    const char *type;
    for (size_t i = 0; (type = cau_type_name(CAU_TYPES_OF_MATERIALS, i)); i++, name[0]++)
        must(&w, cau_add_material(w.scene, name, type, &items[count++]));
    for (size_t i = 0; (type = cau_type_name(CAU_TYPES_OF_LIGHTS, i)); i++, name[0]++)
        must(&w, cau_add_light(w.scene, name, type, &items[count++]));
    for (size_t i = 0; (type = cau_type_name(CAU_TYPES_OF_SHAPES, i)); i++, name[0]++) {
        must(&w, cau_add_object(w.scene, name, &items[count++]));
        must(&w, cau_add_shape(w.scene, items[count - 1], type, &items[count]));
        count++;
    }
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < cau_param_count(w.scene, items[i]); k++) {
            cau_param p = {.size = sizeof p}, again = p;
            must(&w, cau_param_at(w.scene, items[i], k, &p));
            must(&w, cau_param_named(w.scene, items[i], p.name, &again));
            assert_true(p.name == again.name && p.type == again.type && p.help == again.help);
            assert_true(p.help && *p.help && p.unit);
            assert_true(p.type >= CAU_PARAM_NUMBER && p.type <= CAU_PARAM_PART);
            described++;
            bool settable = !(p.flags & CAU_PARAM_UNSUPPORTED) && p.count > 0 && p.type != CAU_PARAM_LIST;
            if (!settable || p.type == CAU_PARAM_CHOICE || p.type == CAU_PARAM_FLAGS ||
                p.type == CAU_PARAM_MATRIX)
                continue;
            double low[3], nan[3] = {NAN, NAN, NAN}, over[3];
            for (int c = 0; c < 3; c++) {
                low[c] = p.flags & CAU_PARAM_MIN_EXCLUDED ? fmin(p.min + 1, 0.5 * (p.min + p.max)) : p.min;
                over[c] = p.max * 2 + 1;
            }
            must(&w, cau_set(w.scene, items[i], p.name, low, p.count));
            expect_error(&w, cau_set(w.scene, items[i], p.name, nan, p.count), CAU_ERROR_INPUT, "finite");
            expect_error(
                &w, cau_set(w.scene, items[i], p.name, over, p.count), CAU_ERROR_INPUT, "it must be");
        }
    assert_true(described > 80);
    close_world(&w);
}

/* ---- transforms ---- */

static void look_is_blenders(void **state) {
    (void)state;
    World w = open_world();
    add_camera(&w);
    must(&w, cau_set_look(w.scene, CAU_CAMERA, (double[]){0, 0, 5}, (double[]){0, 0, 0}));
    Scene s = normalised(&w);
    assert_true(s.camera.forward.z == -1 && s.camera.up.y == 1 && s.camera.right.x == 1);
    assert_true(s.units_per_m == 1 && s.object_count == 0 && s.light_count == 0 && s.warning_count == 3);
    scene_free(&s);
    must(&w, cau_set_look(w.scene, CAU_CAMERA, (double[]){0, -4, 0}, (double[]){0, 0, 0}));
    s = normalised(&w);
    assert_true(s.camera.forward.y == 1 && s.camera.up.z == 1 && s.camera.right.x == 1);
    scene_free(&s);
    close_world(&w);
}

/* M = T Rz Ry Rx S, as Blender composes XYZ Euler angles. */
static void parts_compose_as_in_blender(void **state) {
    (void)state;
    World w = open_world();
    add_glass(&w);
    add_camera(&w);
    cau_item shape, o = add_object(&w, "box", "box", &shape);
    set(&w, shape, "size", 3, (double[]){2, 2, 2});
    set(&w, o, "position", 3, (double[]){10, 20, 30});
    set(&w, o, "scale", 3, (double[]){1, 2, 3});
    set(&w, o, "rotation_deg", 3, (double[]){90, 0, 90});
    Scene s = normalised(&w);
    /* Local (1, 1, 1), scaled (1, 2, 3), about X to (1, -3, 2), about Z to (3, 1, 2), moved. */
    V3 p = affine_point(&s.objects[0].local_to_scene, v3(1, 1, 1)),
       expected = scene_from_world(&s, v3(13, 21, 32));
    assert_true(p.x == expected.x && p.y == expected.y && p.z == expected.z);
    V3 back = affine_point(&s.objects[0].scene_to_local, p);
    assert_true(v3_length(v3_sub(back, v3(1, 1, 1))) < 1e-14);
    scene_free(&s);
    close_world(&w);
}

static V3 corner(const Mesh *m, size_t t, int c) {
    const double *p = &m->positions[3 * (size_t)m->triangles[3 * t + (size_t)c]];
    return v3(p[0], p[1], p[2]);
}

/* A tessellated ellipsoid under any affine map: outward faces, and corner normals equal to its gradient. */
static void mirrored_and_sheared_normals(void **state) {
    (void)state;
    static const double maps[3][16] = {
        {1, 0, 0, 2, 0, 3, 0, 1, 0, 0, 0.25, 5, 0, 0, 0, 1},        /* non-uniform */
        {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},          /* mirrored */
        {0.5, 1, 0, 3, 0.25, -2, 0.5, -1, 0, 0.5, 1, 0, 0, 0, 0, 1} /* sheared and mirrored */
    };
    for (size_t k = 0; k < 3; k++) {
        World w = open_world();
        add_glass(&w);
        add_camera(&w);
        cau_item shape, o = add_object(&w, "ball", "sphere", &shape), exact_shape,
                        e = add_object(&w, "exact", "sphere", &exact_shape);
        set1(&w, shape, "radius", 1);
        set1(&w, shape, "segments", 64);
        set1(&w, exact_shape, "radius", 1);
        set(&w, o, "matrix", 16, maps[k]);
        set(&w, e, "matrix", 16, maps[k]);
        Scene s = normalised(&w);
        const Object *ball = &s.objects[0], *exact = &s.objects[1];
        assert_int_equal(ball->mirrored, k > 0);
        assert_true(exact->exact && !ball->exact);
        V3 centre = affine_column(&ball->local_to_scene, 3);
        double volume = 0;
        for (size_t t = 0; t < ball->mesh.triangle_count; t++) {
            V3 p[3] = {corner(&ball->mesh, t, 0), corner(&ball->mesh, t, 1), corner(&ball->mesh, t, 2)};
            volume += v3_dot(v3_sub(p[0], centre), v3_cross(v3_sub(p[1], centre), v3_sub(p[2], centre))) / 6;
            for (int c = 0; c < 3; c++) {
                V3 local =
                    affine_point(&ball->scene_to_local, p[c]); /* on the unit sphere: also its normal there */
                const float *n = &ball->mesh.normals[9 * t + 3 * (size_t)c];
                V3 normal = v3((double)n[0], (double)n[1], (double)n[2]), outward = v3_sub(p[c], centre);
                assert_true(v3_dot(normal, outward) > 0);
                assert_true(v3_length(v3_sub(object_normal(exact, v3_normalize(local)), normal)) < 1e-6);
            }
        }
        double det = fabs(affine_determinant(&ball->local_to_scene));
        assert_true(fabs(volume / (det * 4 / 3 * CAU_PI) - 1) < 0.01);
        assert_int_equal(s.warning_count, 2); /* no light, no receiver; nothing about the glass */
        scene_free(&s);
        close_world(&w);
    }
}

/* ---- scene space ---- */

/* A small scene, every length times `scale`, everything moved by `offset`. */
static World moved_world(double scale, double offset) {
    World w = open_world();
    cau_item m, shape, o, l;
    add_glass(&w);
    must(&w, cau_add_material(w.scene, "floor", "diffuse", &m));
    set(&w, m, "color", 3, (double[]){0.8, 0.8, 0.8});
    o = add_object(&w, "ball", "sphere", &shape);
    set1(&w, shape, "radius", 0.5 * scale);
    set1(&w, shape, "segments", 32);
    set(&w, o, "position", 3, (double[]){0.3125 * scale + offset, offset, 0.71875 * scale + offset});
    o = add_object(&w, "ball2", "sphere", &shape);
    set1(&w, shape, "radius", 0.25 * scale);
    set(&w, o, "position", 3, (double[]){-0.5 * scale + offset, offset, 0.25 * scale + offset});
    o = add_object(&w, "floor", "plane", &shape);
    must(&w, cau_set_text(w.scene, o, "material", "floor"));
    set(&w, shape, "size", 2, (double[]){8 * scale, 8 * scale});
    set(&w, o, "position", 3, (double[]){offset, offset, offset});
    must(&w, cau_add_light(w.scene, "Key", "area", &l));
    must(&w, cau_set_choice(w.scene, l, "shape", "disk"));
    set(&w, l, "size", 2, (double[]){scale, 0.5 * scale});
    set1(&w, l, "power_w", 100 * scale * scale);
    set(&w, l, "matrix", 16,
        (double[]){1, 0, 0, scale + offset, 0, 1, 0, offset, 0, 0, 1, 4 * scale + offset, 0, 0, 0, 1});
    set1(&w, CAU_CAMERA, "hfov_deg", 40);
    set(&w, CAU_CAMERA, "resolution", 2, (double[]){48, 27});
    set(&w, CAU_CAMERA, "clip", 2, (double[]){0.0078125 * scale, 1048576 * scale});
    must(&w, cau_set_look(w.scene, CAU_CAMERA, (double[]){offset, -4 * scale + offset, 2.5 * scale + offset},
                 (double[]){-0.25 * scale + offset, offset, 0.5 * scale + offset}));
    return w;
}

static void assert_same_scene(const Scene *a, const Scene *b) {
    assert_int_equal(a->object_count, b->object_count);
    for (size_t i = 0; i < a->object_count; i++) {
        const Object *x = &a->objects[i], *y = &b->objects[i];
        assert_int_equal(x->mesh.vertex_count, y->mesh.vertex_count);
        assert_int_equal(x->mesh.triangle_count, y->mesh.triangle_count);
        if (x->mesh.vertex_count) {
            assert_memory_equal(x->mesh.positions, y->mesh.positions, 24 * x->mesh.vertex_count);
            assert_memory_equal(x->mesh.triangles, y->mesh.triangles, 12 * x->mesh.triangle_count);
        }
        if (x->mesh.normals)
            assert_memory_equal(x->mesh.normals, y->mesh.normals, 36 * x->mesh.triangle_count);
        assert_int_equal(x->visibility, y->visibility);
        assert_int_equal(x->material, y->material);
    }
    assert_memory_equal(&a->camera, &b->camera, sizeof a->camera);
    assert_int_equal(a->light_count, b->light_count);
    for (size_t i = 0; i < a->light_count; i++) {
        const Light *x = &a->lights[i], *y = &b->lights[i];
        assert_string_equal(x->layer, y->layer);
        assert_memory_equal(&x->position, &y->position, sizeof x->position);
        assert_memory_equal(&x->u, &y->u, sizeof x->u);
        assert_memory_equal(&x->n, &y->n, sizeof x->n);
        assert_memory_equal(x->derived, y->derived, sizeof x->derived);
    }
}

static void scale_and_offset_change_no_bit(void **state) {
    (void)state;
    World plain = moved_world(1, 0);
    Scene a = normalised(&plain);
    static const double scales[] = {0x1p-20, 0x1p20, 1, 0x1p-4}, offsets[] = {0, 0, 0x1p20, -0x1p10};
    for (int i = 0; i < 4; i++) {
        World moved = moved_world(scales[i], offsets[i]);
        Scene b = normalised(&moved);
        assert_same_scene(&a, &b);
        assert_true(b.units_per_m == a.units_per_m / scales[i]);
        for (size_t o = 0; o < a.object_count; o++)
            assert_memory_equal(&a.objects[o].bounds_min, &b.objects[o].bounds_min, sizeof(V3));
        scene_free(&b);
        close_world(&moved);
    }
    double half = 0.5 * v3_length(v3_sub(a.objects[0].bounds_max, a.objects[0].bounds_min));
    assert_true(half > 0.1 && half < 1);
    /* Scales that are not powers of two: the same within rounding. */
    World small = moved_world(1e-6, 0), far = moved_world(1, 1e6);
    Scene s = normalised(&small), f = normalised(&far);
    double ratio = s.units_per_m * 1e-6 / a.units_per_m;
    assert_true(ratio > 0.5 && ratio < 2);
    assert_true(v3_length(v3_sub(f.objects[0].bounds_min, a.objects[0].bounds_min)) < 1e-9);
    scene_free(&s);
    scene_free(&f);
    close_world(&small);
    close_world(&far);
    scene_free(&a);
    close_world(&plain);
}

static void lights_do_not_move_the_scene(void **state) {
    (void)state;
    World one = moved_world(1, 0), two = moved_world(1, 0);
    cau_item l;
    must(&two, cau_add_light(two.scene, "Far", "point", &l));
    set1(&two, l, "power_w", 1e6);
    set(&two, l, "matrix", 16, (double[]){1, 0, 0, 1e5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
    must(&two, cau_set(two.scene, CAU_WORLD, "color", (double[]){1, 1, 1}, 3));
    must(&two, cau_set_text(two.scene, CAU_WORLD, "group", "sky"));
    Scene a = normalised(&one), b = normalised(&two);
    assert_true(a.units_per_m == b.units_per_m && memcmp(&a.origin_m, &b.origin_m, sizeof a.origin_m) == 0);
    assert_int_equal(b.light_count, 3);
    assert_string_equal(b.lights[2].layer, "sky");
    assert_true(b.lights[2].infinite);
    assert_true(a.lights[0].stream == b.lights[0].stream && b.lights[1].stream != b.lights[0].stream);
    assert_true(scene_hash(one.scene) != scene_hash(two.scene));
    scene_free(&a);
    scene_free(&b);
    close_world(&one);
    close_world(&two);
}

/* ---- warnings ---- */

static bool warned(const Scene *s, const char *words) {
    for (size_t i = 0; i < s->warning_count; i++)
        if (strstr(s->warnings[i], words)) return true;
    return false;
}

static void doubtful_meshes_are_warned_of(void **state) {
    (void)state;
    World w = open_world();
    add_glass(&w);
    add_camera(&w);
    static const float p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 5, 5, 5};
    static const float far[] = {1e5f, 0, 0, 1e5f + 1, 0, 0, 1e5f, 1, 0, 1e5f, 0, 1};
    static const uint32_t out[] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3, 0, 0, 1};
    static const uint32_t in[] = {0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2};
    cau_mesh m = {.size = sizeof m, .positions = p, .vertex_count = 5, .triangles = out, .triangle_count = 4};
    must(&w, cau_set_mesh(w.scene, add_object(&w, "good", NULL, NULL), &m));
    m.triangle_count = 5;
    must(&w, cau_set_mesh(w.scene, add_object(&w, "flat", NULL, NULL), &m));
    m.triangle_count = 3;
    must(&w, cau_set_mesh(w.scene, add_object(&w, "open", NULL, NULL), &m));
    m.triangle_count = 4;
    m.triangles = in;
    must(&w, cau_set_mesh(w.scene, add_object(&w, "inverted", NULL, NULL), &m));
    cau_item mirrored = add_object(&w, "mirrored", NULL, NULL);
    m.triangles = out;
    must(&w, cau_set_mesh(w.scene, mirrored, &m));
    set(&w, mirrored, "scale", 3, (double[]){1, 1, -1});
    m.positions = far;
    m.vertex_count = 4;
    must(&w, cau_set_mesh(w.scene, add_object(&w, "far", NULL, NULL), &m));
    Scene s = normalised(&w);
    assert_true(warned(&s, "\"flat\": 1 of 5 triangles have no area"));
    assert_true(warned(&s, "\"open\" is of glass but not closed: 3 edges"));
    assert_true(warned(&s, "\"inverted\" is of glass and inside out"));
    assert_true(warned(&s, "\"far\" is 1 m large"));
    assert_false(warned(&s, "\"good\"") || warned(&s, "\"mirrored\""));
    assert_int_equal(s.objects[1].mesh.triangle_count, 4);
    scene_free(&s);
    close_world(&w);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mistakes_are_named),
        cmocka_unit_test(bad_meshes_are_refused),
        cmocka_unit_test(every_parameter_is_described),
        cmocka_unit_test(look_is_blenders),
        cmocka_unit_test(parts_compose_as_in_blender),
        cmocka_unit_test(mirrored_and_sheared_normals),
        cmocka_unit_test(scale_and_offset_change_no_bit),
        cmocka_unit_test(lights_do_not_move_the_scene),
        cmocka_unit_test(doubtful_meshes_are_warned_of),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
