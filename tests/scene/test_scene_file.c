/* SPDX-License-Identifier: Apache-2.0 */
/* Scene files: what is wrong with a file is said in one sentence, what is right gives the same scene as the
 * API. */
#include "tests/scene/files.h"

typedef struct Wrong {
    const char *text, *words;
    cau_result code;
} Wrong;

static const Wrong wrongs[] = {
    {"", "line", CAU_ERROR_INPUT},
    {"{", "line 1", CAU_ERROR_INPUT},
    {"[]", "must be an object", CAU_ERROR_INPUT},
    {"not json", "line 1, column", CAU_ERROR_INPUT},
    {"{\"caustics_scene\":1}", "no camera", CAU_ERROR_INPUT},
    {"{" CAMERA "}", "\"caustics_scene\" is missing", CAU_ERROR_INPUT},
    {"{\"caustics_scene\":2," CAMERA "}", "caustics_scene is 2", CAU_ERROR_INPUT},
    {"{\"caustics_scene\":\"1\"," CAMERA "}", "not the text \"1\"", CAU_ERROR_INPUT},
    {HEAD "} }", "end of file expected", CAU_ERROR_INPUT},
    {HEAD "," CAMERA "}", "duplicate", CAU_ERROR_INPUT},
    {HEAD ",\"object\":[]}", "did you mean \"objects\"", CAU_ERROR_INPUT},
    {HEAD ",\"objects\":{}}", "objects must be a list, not an object", CAU_ERROR_INPUT},
    {HEAD ",\"objects\":[5]}", "objects[0] must be an object {...}, not a number", CAU_ERROR_INPUT},
    {HEAD ",\"objects\":[{\"shape\":{}}]}", "objects[0]: \"name\" is missing", CAU_ERROR_INPUT},
    {HEAD ",\"color_space\":\"srgb\"}", "did you mean", CAU_ERROR_INPUT},
    {HEAD ",\"materials\":{\"m\":{\"type\":\"glas\"}}}",
        "materials.m: unknown material type \"glas\"; did you mean \"glass\"?", CAU_ERROR_INPUT},
    {HEAD ",\"materials\":{\"m\":{\"type\":\"glass\",\"colour\":[1,1,1]}}}", "did you mean \"color\"",
        CAU_ERROR_INPUT},
    {HEAD ",\"materials\":{\"m\":{\"type\":\"glass\"}}}", "materials.m: \"color\" is missing",
        CAU_ERROR_INPUT},
    {HEAD ",\"materials\":{\"a b\":{\"type\":\"diffuse\",\"color\":[1,1]}}}",
        "materials[\"a b\"].color has 2", CAU_ERROR_INPUT},
    {HEAD ",\"materials\":{\"m\":{\"type\":\"diffuse\",\"color\":[1,\"1\",1]}}}",
        "materials.m.color[1] must be a number", CAU_ERROR_INPUT},
    {HEAD ",\"materials\":{\"m\":{\"type\":\"diffuse\",\"color\":{\"image\":\"a.exr\"}}}}",
        "not yet supported: a texture", CAU_ERROR_UNSUPPORTED},
    {HEAD ",\"materials\":{\"m\":{\"type\":\"glass\",\"color\":[1,1,1],\"absorption\":{\"color\":[1,1,1],"
          "\"distance_m\":1}}}}",
        "not yet supported", CAU_ERROR_UNSUPPORTED},
    {HEAD ",\"materials\":{\"m\":{\"type\":\"emission\",\"color\":[1,1,1]}}}", "not yet supported",
        CAU_ERROR_UNSUPPORTED},
    {HEAD ",\"materials\":{\"m\":{\"type\":\"glass\",\"color\":[1,1,1],\"ior\":1e999}}}", "line 1",
        CAU_ERROR_INPUT},
    {HEAD ",\"materials\":{\"m\":{\"type\":\"glass\",\"color\":[1,1,1],\"ior\":NaN}}}", "line 1",
        CAU_ERROR_INPUT},
    {HEAD ",\"materials\":{\"m\":{\"type\":\"glass\",\"color\":[1,1,1],\"ior\":0}}}", "materials.m.ior is 0",
        CAU_ERROR_INPUT},
    {HEAD ",\"world\":{\"image\":\"sky.exr\"}}", "world.image: not yet supported", CAU_ERROR_UNSUPPORTED},
    {HEAD ",\"world\":{\"strength\":-1}}", "world.strength is -1", CAU_ERROR_INPUT},
    {HEAD ",\"bounces\":{\"total\":1.5}}", "whole number", CAU_ERROR_INPUT},
    {"{\"caustics_scene\":1,\"camera\":{\"hfov_deg\":40,\"resolution\":[48,27]}}", "no camera is placed",
        CAU_ERROR_INPUT},
    {"{\"caustics_scene\":1,\"camera\":{\"look\":{\"from\":[0,0,0],\"to\":[0,0,0]},\"hfov_deg\":40}}",
        "same point", CAU_ERROR_INPUT},
    {"{\"caustics_scene\":1,\"camera\":{\"look\":{\"from\":[0,0,0],\"too\":[0,0,1]},\"hfov_deg\":40}}",
        "camera.look: unknown key \"too\"; did you mean \"to\"?", CAU_ERROR_INPUT},
    {"{\"caustics_scene\":1,\"camera\":{\"look\":{\"from\":[0,0,0],\"to\":[0,0,1]},\"resolution\":[4,4]}}",
        "\"hfov_deg\" is missing", CAU_ERROR_INPUT},
    {"{\"caustics_scene\":1,\"camera\":{\"type\":\"fisheye\"}}", "camera.type: unknown word \"fisheye\"",
        CAU_ERROR_INPUT},
    {"{\"caustics_scene\":1,\"camera\":{\"hfov_deg\":180}}",
        "camera.hfov_deg is 180 deg; it must be less than 180", CAU_ERROR_INPUT},
    {"{\"caustics_scene\":1,\"camera\":{\"fstop\":2}}", "not yet supported: lens blur",
        CAU_ERROR_UNSUPPORTED},
    {"{\"caustics_scene\":1,\"camera\":{\"matrix\":[[1,0,0,0],[0,1,0,0],[0,0,1,0]]}}",
        "camera.matrix must be a list of 4 rows", CAU_ERROR_INPUT},
    {"{\"caustics_scene\":1,\"camera\":{\"matrix\":[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,2]]}}", "last row",
        CAU_ERROR_INPUT},
    {OBJECT("\"matrix\":[[1,0,0,0],[0,0,0,0],[0,0,1,0],[0,0,0,1]]"), "objects[1].matrix is singular",
        CAU_ERROR_INPUT},
    {OBJECT("\"scale\":0,\"shape\":{\"type\":\"box\",\"size\":[1,1,1]}"), "objects[1].scale",
        CAU_ERROR_INPUT},
    {OBJECT("\"position\":[0,0,0],\"look\":{\"from\":[0,0,0],\"to\":[0,0,1]}"), "by both", CAU_ERROR_INPUT},
    {OBJECT("\"smooth\":1"), "objects[1].smooth must be true or false, not a number", CAU_ERROR_INPUT},
    {OBJECT("\"visible_to\":[\"camera\"]"), "objects[1].visible_to: unknown word", CAU_ERROR_INPUT},
    {OBJECT("\"position\":[0,0,0]"), "neither \"shape\" nor \"file\"", CAU_ERROR_INPUT},
    {OBJECT("\"shape\":{\"type\":\"box\",\"size\":[1,1,1]},\"file\":\"a.ply\""),
        "both \"shape\" and \"file\"", CAU_ERROR_INPUT},
    {HEAD MATERIALS ",\"objects\":[" BALL "," BALL "]}", "objects[1]: the name \"ball\" is taken",
        CAU_ERROR_INPUT},
    {HEAD ",\"objects\":[" BALL "]}", "objects[0]: unknown material \"glass\"", CAU_ERROR_INPUT},
    {HEAD ",\"objects\":[{\"name\":\"b\",\"shape\":{\"type\":\"sphere\",\"radius\":1}}]}", "no material",
        CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"sfere\""), "did you mean \"sphere\"", CAU_ERROR_INPUT},
    {SHAPE("\"radius\":1"), "objects[1].shape: \"type\" is missing", CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"sphere\",\"radius\":-1"), "objects[1].shape.radius is -1 m; it must be greater than 0",
        CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"sphere\",\"radius\":[1]"), "must be a number, not a list", CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"sphere\""), "objects[1].shape: \"radius\" is missing", CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"sphere\",\"radius\":1,\"segments\":2"), "at least 3", CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"lathe\",\"profile\":[[1,0],[1,2,3]]"), "shape.profile[1] has 3 entries",
        CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"lathe\",\"profile\":[[1,0],[-1,2]]"),
        "objects[1].shape.profile[1] has the radius -1 m", CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"heightfield\",\"size\":[1,1],\"waves\":[{\"amplitude\":1}]"),
        "shape.waves[0]: \"k\" is missing", CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"heightfield\",\"size\":[1,1],\"waves\":[{\"amplitude\":1,\"k\":1,\"fase\":1}]"),
        "did you mean \"phase\"", CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"mesh\",\"vertices\":[[0,0,0],[1,0,0],[0,1,0]],\"triangles\":[[0,1,3]]"),
        "triangles[0] holds 3", CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"mesh\",\"vertices\":[[0,0,0],[1,0,0],[0,1,0]],\"triangles\":[[0,1,-1]]"),
        "triangles[0] holds -1", CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"mesh\",\"vertices\":[[0,0,0],[1,0],[0,1,0]],\"triangles\":[[0,1,2]]"),
        "shape.vertices[1] has 2", CAU_ERROR_INPUT},
    {SHAPE("\"type\":\"mesh\",\"vertices\":[[0,0,0],[1,0,0],[0,1,0]],\"triangles\":[[0,1,2]],\"normals\":[[0,"
           "0,1]]"),
        "normals has 1", CAU_ERROR_INPUT},
    {LIGHT("\"type\":\"sunn\""), "lights[0]: unknown light type \"sunn\"; did you mean \"sun\"?",
        CAU_ERROR_INPUT},
    {LIGHT("\"type\":\"sun\",\"strength\":1"), "lights[0] \"Key\": not placed", CAU_ERROR_INPUT},
    {LIGHT("\"type\":\"sun\",\"look\":{\"from\":[0,0,1],\"to\":[0,0,0]}"), "\"strength\" is missing",
        CAU_ERROR_INPUT},
    {LIGHT("\"type\":\"point\",\"power_w\":-5"),
        "lights[0].power_w is -5 W; it must be at least 0 (light \"Key\")", CAU_ERROR_INPUT},
    {LIGHT("\"type\":\"area\",\"shape\":\"disk\",\"size\":[0,1],\"power_w\":5"), "lights[0].size is 0 m",
        CAU_ERROR_INPUT},
    {LIGHT("\"type\":\"area\",\"shape\":\"hexagon\""), "lights[0].shape: unknown word", CAU_ERROR_INPUT},
    {LIGHT("\"type\":\"area\",\"radius_m\":1"), "unknown key \"radius_m\"", CAU_ERROR_INPUT},
    {"{\"asset\":{\"version\":\"2.0\"}}", "glTF file as the scene", CAU_ERROR_UNSUPPORTED},
    {OBJECT("\"file\":\"../a.ply\""), "stays in its folder", CAU_ERROR_INPUT},
    {OBJECT("\"file\":\"/etc/a.ply\""), "stays in its folder", CAU_ERROR_INPUT},
    {OBJECT("\"file\":\"sub/../../a.ply\""), "stays in its folder", CAU_ERROR_INPUT},
    {OBJECT("\"file\":\"a.fbx\""), "must end in .ply", CAU_ERROR_INPUT},
    {OBJECT("\"file\":\"missing.ply\""), "objects[1].file \"missing.ply\" cannot be opened", CAU_ERROR_INPUT},
    {OBJECT("\"file\":\"link.ply\""), "leaves the scene file's folder", CAU_ERROR_INPUT},
    {OBJECT("\"file\":\"folder.ply\""), "not a regular file", CAU_ERROR_INPUT},
    {OBJECT("\"file\":\"pipe.ply\""), "not a regular file", CAU_ERROR_INPUT},
};

static void malformed_files_get_one_sentence(void **state) {
    (void)state;
    char text[CAU_ERROR_TEXT_MAX], outside[] = "/tmp/caustics_outside_XXXXXX";
    int file = mkstemp(outside);
    assert_true(file >= 0);
    close(file);
    assert_int_equal(symlink(outside, in_folder("link.ply")), 0);
    assert_int_equal(mkdir(in_folder("folder.ply"), 0700), 0);
    assert_int_equal(mkdir(in_folder("sub"), 0700), 0);
    assert_int_equal(mkfifo(in_folder("pipe.ply"), 0600), 0);
    for (size_t i = 0; i < sizeof wrongs / sizeof *wrongs; i++) {
        write_text("bad.json", wrongs[i].text);
        cau_result result = load(in_folder("bad.json"), text);
        check_sentence(text, wrongs[i].words, result, wrongs[i].code);
    }
    print_message("%zu malformed files\n", sizeof wrongs / sizeof *wrongs);
    unlink(outside);
}

static void files_that_are_none(void **state) {
    (void)state;
    char text[CAU_ERROR_TEXT_MAX];
    assert_int_equal(load(in_folder("none.json"), text), CAU_ERROR_INPUT);
    assert_non_null(strstr(text, "none.json: scene file: cannot be opened: No such file"));
    assert_int_equal(load("/nowhere/at/all.json", text), CAU_ERROR_INPUT);
    assert_int_equal(load(folder, text), CAU_ERROR_INPUT);
    assert_non_null(strstr(text, "not a regular file"));
    assert_int_equal(load("", text), CAU_ERROR_INPUT);
    /* Deep nesting, an endless list of one key, and every cut of a good file. */
    char *deep = malloc(200001);
    assert_non_null(deep);
    memset(deep, '[', 200000);
    deep[200000] = '\0';
    write_text("bad.json", deep);
    assert_int_equal(load(in_folder("bad.json"), text), CAU_ERROR_INPUT);
    free(deep);
    static const char good[] =
        HEAD MATERIALS ",\"objects\":[" BALL "],\"lights\":[{\"name\":\"Key\",\"type\":\"sun\","
                       "\"strength\":3,\"angle_deg\":0,\"look\":{\"from\":[0,0,1],\"to\":[0,0,0]}}]}";
    for (size_t n = 0; n < sizeof good; n++) {
        write_file("bad.json", good, n);
        assert_int_equal(load(in_folder("bad.json"), text), n + 1 == sizeof good ? CAU_OK : CAU_ERROR_INPUT);
    }
}

/* Any single byte of a good file changed: an error or a scene, never a crash. */
static void changed_bytes_do_no_harm(void **state) {
    (void)state;
    static const char good[] =
        HEAD MATERIALS ",\"bounces\":{\"total\":4},\"objects\":[" BALL
                       ",{\"name\":\"w\",\"material\":\"glass\",\"position\":[1,2,3],\"shape\":{\"type\":"
                       "\"lathe\",\"profile\":[[0,0],[1,1],[0,2]],\"segments\":8}}]}";
    static const char bytes[] = {'0', '9', '-', '[', '}', '"', ',', 'e', '\0', '\n', (char)0xff};
    char text[CAU_ERROR_TEXT_MAX], copy[sizeof good];
    for (size_t i = 0; i + 1 < sizeof good; i++) {
        memcpy(copy, good, sizeof good);
        copy[i] = bytes[i % sizeof bytes];
        write_file("bad.json", copy, sizeof good - 1);
        cau_result result = load(in_folder("bad.json"), text);
        assert_true(result == CAU_OK || result == CAU_ERROR_INPUT || result == CAU_ERROR_UNSUPPORTED);
        assert_int_equal(result == CAU_OK, text[0] == '\0');
    }
}

/* ---- the same scene by file and by hand ---- */

static void api_and_file_agree(void **state) {
    (void)state;
    static const char json[] = HEAD MATERIALS
        ",\"bounces\":{\"diffuse\":4},\"world\":{\"color\":[0.5,0.5,0.5],\"strength\":2,\"group\":\"sky\"},"
        "\"objects\":[" BALL ",{\"name\":\"m\",\"material\":\"glass\",\"position\":[1,2,3],\"scale\":2,"
        "\"rotation_deg\":[0,0,30],\"smooth\":false,"
        "\"visible_to\":[\"diffuse\",\"shadow\"],\"visible_to_camera\":false,\"shape\":{\"type\":\"mesh\","
        "\"vertices\":[[0,0,0],"
        "[1,0,0],[0,1,0]],\"triangles\":[[0,1,2]],\"uvs\":[[0,0],[1,0],[0,1]]}}],\"lights\":[{\"name\":"
        "\"Key\",\"type\":\"spot\",\"power_w\":100,"
        "\"cone_deg\":60,\"group\":\"key\",\"casts_caustics\":false,\"look\":{\"from\":[0,0,3],\"to\":[0,0,0]"
        "}}]}";
    write_text("good.json", json);
    cau_context *c;
    cau_scene *file, *hand;
    cau_item i;
    assert_int_equal(cau_context_create(&c), CAU_OK);
    if (cau_scene_load_file(c, in_folder("good.json"), &file) != CAU_OK) fail_msg("%s", cau_error_text(c));
    assert_int_equal(cau_scene_create(c, &hand), CAU_OK);
    cau_set_look(hand, CAU_CAMERA, (double[]){0, -4, 2}, (double[]){0, 0, 0});
    cau_set(hand, CAU_CAMERA, "hfov_deg", (double[]){40}, 1);
    cau_set(hand, CAU_CAMERA, "resolution", (double[]){48, 27}, 2);
    cau_set(hand, CAU_BOUNCES, "diffuse", (double[]){4}, 1);
    cau_set(hand, CAU_WORLD, "color", (double[]){0.5, 0.5, 0.5}, 3);
    cau_set(hand, CAU_WORLD, "strength", (double[]){2}, 1);
    cau_set_text(hand, CAU_WORLD, "group", "sky");
    cau_add_material(hand, "glass", "glass", &i);
    cau_set(hand, i, "color", (double[]){1, 1, 1}, 3);
    cau_add_object(hand, "ball", &i);
    cau_set_text(hand, i, "material", "glass");
    cau_add_shape(hand, i, "sphere", &i);
    cau_set(hand, i, "radius", (double[]){1}, 1);
    cau_add_object(hand, "m", &i);
    cau_set_text(hand, i, "material", "glass");
    cau_set(hand, i, "position", (double[]){1, 2, 3}, 3);
    cau_set(hand, i, "scale", (double[]){2, 2, 2}, 3);
    cau_set(hand, i, "rotation_deg", (double[]){0, 0, 30}, 3);
    cau_set_choice(hand, i, "smooth", "false");
    cau_set(hand, i, "visible_to_camera", (double[]){0}, 1);
    cau_set_flags(hand, i, "visible_to", (const char *[]){"shadow", "diffuse"}, 2);
    static const double p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t t[] = {0, 1, 2};
    cau_set_mesh(hand, i,
        &(cau_mesh){.size = sizeof(cau_mesh),
            .positions = p,
            .positions_are_double = 1,
            .vertex_count = 3,
            .triangles = t,
            .triangle_count = 1});
    cau_add_light(hand, "Key", "spot", &i);
    cau_set(hand, i, "power_w", (double[]){100}, 1);
    cau_set(hand, i, "cone_deg", (double[]){60}, 1);
    cau_set_text(hand, i, "group", "key");
    cau_set_choice(hand, i, "casts_caustics", "false");
    cau_set_look(hand, i, (double[]){0, 0, 3}, (double[]){0, 0, 0});
    assert_string_equal(cau_error_text(c), "");
    assert_true(scene_hash(file) == scene_hash(hand));
    Scene a, b;
    assert_int_equal(scene_normalise(file, 0, 0, &a, &c->error), CAU_OK);
    assert_int_equal(scene_normalise(hand, 96, 54, &b, &c->error), CAU_OK);
    assert_int_equal(b.camera.width, 96);
    b.camera.width = 48;
    b.camera.height = 27;
    assert_memory_equal(&a.camera, &b.camera, sizeof a.camera);
    assert_memory_equal(a.objects[1].mesh.positions, b.objects[1].mesh.positions, 72);
    assert_int_equal(a.objects[1].visibility, VISIBLE_DIFFUSE | VISIBLE_SHADOW);
    assert_string_equal(a.lights[0].layer, "key");
    assert_string_equal(a.lights[1].layer, "sky");
    assert_true(!a.lights[0].casts && a.lights[1].casts);
    cau_set(hand, CAU_BOUNCES, "diffuse", (double[]){5}, 1);
    assert_true(scene_hash(file) != scene_hash(hand));
    scene_free(&a);
    scene_free(&b);
    cau_scene_destroy(&file);
    cau_scene_destroy(&hand);
    cau_context_destroy(&c);
}

static void our_scenes_load(void **state) {
    (void)state;
    char path[600], text[CAU_ERROR_TEXT_MAX];
    DIR *scenes = opendir(SOURCE_DIR "/scenes");
    int count = 0;
    for (struct dirent *e; scenes && (e = readdir(scenes));) {
        const char *dot = strrchr(e->d_name, '.');
        if (!dot || strcmp(dot, ".json") != 0) continue;
        snprintf(path, sizeof path, SOURCE_DIR "/scenes/%s", e->d_name);
        if (load(path, text) != CAU_OK) fail_msg("%s", text);
        count++;
    }
    if (scenes) closedir(scenes);
    print_message("%d scenes\n", count);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(malformed_files_get_one_sentence),
        cmocka_unit_test(files_that_are_none),
        cmocka_unit_test(changed_bytes_do_no_harm),
        cmocka_unit_test(api_and_file_agree),
        cmocka_unit_test(our_scenes_load),
    };
    return cmocka_run_group_tests(tests, open_test_folder, close_test_folder);
}
