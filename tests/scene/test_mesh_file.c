/* SPDX-License-Identifier: Apache-2.0 */
/* Mesh and height files: what they hold arrives, what is damaged is said in one sentence. */
#include "tests/scene/files.h"

/* ---- meshes ---- */

#define PLY_HEAD(vertices, faces)                                                                            \
    "ply\nformat ascii 1.0\nelement vertex " vertices                                                        \
    "\nproperty float x\nproperty float y\nproperty float z\nelement face " faces                            \
    "\nproperty list uchar int vertex_indices\nend_header\n"
#define CUBE_V "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n"
#define CUBE_F "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n"

static Scene load_object(const char *mesh, cau_context **context, cau_scene **scene) {
    char json[1024];
    Scene s = {0};
    snprintf(json, sizeof json,
        HEAD MATERIALS ",\"objects\":[{\"name\":\"b\",\"material\":\"glass\",\"file\":\"%s\"}]}", mesh);
    write_text("mesh.json", json);
    assert_int_equal(cau_context_create(context), CAU_OK);
    if (cau_scene_load_file(*context, in_folder("mesh.json"), scene) != CAU_OK ||
        scene_normalise(*scene, 0, 0, &s, &(*context)->error) != CAU_OK)
        fail_msg("%s", cau_error_text(*context));
    return s;
}

static double volume(const Mesh *m, double units) {
    double six = 0;
    for (size_t t = 0; t < m->triangle_count; t++) {
        V3 p[3];
        for (size_t c = 0; c < 3; c++) {
            const double *q = &m->positions[3 * (size_t)m->triangles[3 * t + c]];
            p[c] = v3(q[0], q[1], q[2]);
        }
        six += v3_dot(p[0], v3_cross(p[1], p[2]));
    }
    return six / 6 / (units * units * units);
}

static void check_cube(const char *name, size_t vertices) {
    cau_context *context;
    cau_scene *scene;
    Scene s = load_object(name, &context, &scene);
    assert_int_equal(s.objects[0].mesh.triangle_count, 12);
    if (vertices) assert_int_equal(s.objects[0].mesh.vertex_count, vertices);
    assert_true(fabs(volume(&s.objects[0].mesh, s.units_per_m) - 1) < 1e-6);
    for (size_t w = 0; w < s.warning_count; w++) assert_null(strstr(s.warnings[w], "\"b\""));
    scene_free(&s);
    cau_scene_destroy(&scene);
    cau_context_destroy(&context);
}

static void mesh_files_are_read(void **state) {
    (void)state;
    static const char obj[] =
        "mtllib ../../etc/passwd\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
        "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    write_text("cube.ply", PLY_HEAD("8", "6") CUBE_V CUBE_F);
    write_text("cube.obj", obj);
    check_cube("cube.ply", 8);
    check_cube("cube.obj", 8);
}

/* Doubles keep their digits, big-endian is read, properties come in any order, faces in any size. */
static void ply_in_all_its_forms(void **state) {
    (void)state;
    static const char text[] =
        "ply\r\nformat ascii 1.0\r\ncomment an L, in doubles\r\nelement vertex 6\r\nproperty uchar red\r\n"
        "property double z\r\nproperty double y\r\nproperty double x\r\nelement face 1\r\nproperty list "
        "uint8 int32 "
        "vertex_index\r\nproperty float q\r\nelement edge 1\r\nproperty int a\r\nend_header\r\n"
        "9 0 0 0\r\n9 0 0 2\r\n9 0 1 2\r\n9 0 1 1\r\n9 0 2 1\r\n9 0 2 0.1000000000000001\r\n6 0 1 2 3 4 5 "
        "1.5\r\n7\r\n";
    static const char head[] =
        "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
        "short z\nproperty list uchar char skip\nelement face 1\nproperty list ushort uchar "
        "vertex_indices\nend_header\n";
    static const unsigned char body[] = {0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xfe, 2, 5, 5, 0x3f, 0x80, 0, 0, 0, 0,
        0, 0, 0, 0, 0, 0, 0, 0, 0, 0x3f, 0x80, 0, 0, 0, 0, 0, 0, 3, 0, 1, 2};
    char big[512];
    memcpy(big, head, sizeof head - 1);
    memcpy(big + sizeof head - 1, body, sizeof body);
    write_text("l.ply", text);
    write_file("big.ply", big, sizeof head - 1 + sizeof body);
    cau_context *context;
    cau_scene *scene;
    Scene s = load_object("l.ply", &context, &scene);
    const Mesh *m = &scene->objects[0].mesh;
    assert_int_equal(m->triangle_count, 4);
    assert_true(m->positions[15] == 0.1000000000000001 && !scene->objects[0].mesh_from_floats);
    double area = 0;
    for (size_t t = 0; t < 4; t++) {
        const double *a = &m->positions[3 * m->triangles[3 * t]],
                     *b = &m->positions[3 * m->triangles[3 * t + 1]],
                     *c = &m->positions[3 * m->triangles[3 * t + 2]];
        double twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert_true(twice > 0); /* no triangle lies across the notch */
        area += 0.5 * twice;
    }
    assert_true(fabs(area - 2.9) < 1e-12);
    scene_free(&s);
    cau_scene_destroy(&scene);
    cau_context_destroy(&context);
    s = load_object("big.ply", &context, &scene);
    m = &scene->objects[0].mesh;
    assert_true(
        m->vertex_count == 3 && m->positions[2] == -2 && m->positions[3] == 1 && m->positions[7] == 1);
    scene_free(&s);
    cau_scene_destroy(&scene);
    cau_context_destroy(&context);
}

/* A triangle standing in glTF's XY plane, +Y up, facing +Z: it must stand in our XZ plane and face -Y. */
static void gltf_stands_upright(void **state) {
    (void)state;
    static const char gltf[] = "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
                               "\"nodes\":[{\"mesh\":0,\"translation\":[0,5,0]}],"
                               "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
                               "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":"
                               "\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}],"
                               "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"uri\":"
                               "\"tri.bin\",\"byteLength\":36}]}";
    static const float points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    write_text("tri.gltf", gltf);
    write_file("tri.bin", points, sizeof points);
    cau_context *context;
    cau_scene *scene;
    Scene s = load_object("tri.gltf", &context, &scene);
    const Mesh *m = &scene->objects[0].mesh;
    assert_int_equal(m->triangle_count, 1);
    static const double expected[9] = {0, 0, 5, 1, 0, 5, 0, 0, 6};
    for (size_t c = 0; c < 9; c++) assert_true(m->positions[3 * m->triangles[c / 3] + c % 3] == expected[c]);
    scene_free(&s);
    cau_scene_destroy(&scene);
    cau_context_destroy(&context);
}

static void check_bad_mesh(const char *name, const void *data, size_t size, const char *words) {
    char json[1024], text[CAU_ERROR_TEXT_MAX];
    write_file(name, data, size);
    snprintf(json, sizeof json, OBJECT("\"file\":\"%s\""), name);
    write_text("bad.json", json);
    cau_result result = load(in_folder("bad.json"), text);
    check_sentence(text, words, result, CAU_ERROR_INPUT);
}

static void damaged_meshes_get_one_sentence(void **state) {
    (void)state;
    static const struct {
        const char *name, *text, *words;
    } bad[] = {
        {"a.ply", "", "not a PLY file"},
        {"a.ply", "plyx\n", "not a PLY file"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 8\n", "header does not end"},
        {"a.ply", PLY_HEAD("8", "6") CUBE_V, "objects[1].file \"a.ply\""},
        {"a.ply", PLY_HEAD("8", "6") "0 0 0\n1 0 0\n", "objects[1].file \"a.ply\""},
        {"a.ply", PLY_HEAD("8", "6") CUBE_V "4 0 3 2 1\n4 4 5 6 7\n", "objects[1].file \"a.ply\""},
        {"a.ply", PLY_HEAD("8", "-6") CUBE_V CUBE_F, "cannot be read"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 0\nelement vertex 0\nend_header\n", "no x, y and z"},
        {"a.ply", "ply\nelement vertex 0\nend_header\n", "names no format"},
        {"a.ply", "ply\nformat ascii 2.0\nend_header\n", "cannot be read"},
        {"a.ply", "ply\nformat ascii 1.0\nproperty float x\nend_header\n", "cannot be read"},
        {"a.ply", "ply\nformat ascii 1.0\nend_header\n", "holds no faces"},
        {"a.ply", PLY_HEAD("4000000000", "6") CUBE_V CUBE_F, "more than its"},
        {"a.ply", PLY_HEAD("99999999999999999999999", "6") CUBE_V CUBE_F, "more than its"},
        {"a.ply",
            PLY_HEAD("8", "6") CUBE_V "4 0 3 2 99\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n",
            "objects[1].file \"a.ply\""},
        {"a.ply", PLY_HEAD("3", "1") "0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", "vertex 1"},
        {"a.ply", PLY_HEAD("3", "1") "0 0 0\n1 0 inf\n0 1 0\n3 0 1 2\n", "vertex 1"},
        {"a.ply", PLY_HEAD("3", "1") "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "objects[1].file \"a.ply\""},
        {"a.obj", "", "objects[1].file \"a.obj\""},
        {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", "objects[1].file \"a.obj\""},
        {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2", "objects[1].file \"a.obj\""},
        {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "objects[1].file \"a.obj\""},
        {"a.obj", "v 0 0 0\nv 1 nan 0\nv 0 1 0\nf 1 2 3\n", "vertex"},
        {"a.glb", "glTF", "objects[1].file \"a.glb\""},
        {"a.gltf", "{\"asset\":{\"version\":\"2.0\"}}", "objects[1].file \"a.gltf\""},
        {"a.gltf", "{", "objects[1].file \"a.gltf\""},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        check_bad_mesh(bad[i].name, bad[i].text, strlen(bad[i].text), bad[i].words);
    check_bad_mesh("a.obj", "v 0 0\0 0\n", 9, "objects[1].file \"a.obj\"");
}

/* Every cut of a binary PLY is an error. */
static void a_cut_binary_ply_is_noticed(void **state) {
    (void)state;
    unsigned char data[512];
    static const char head[] =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float "
        "y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    static const float points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const int face[3] = {0, 1, 2};
    size_t n = sizeof head - 1;
    memcpy(data, head, n);
    memcpy(data + n, points, sizeof points);
    data[n + sizeof points] = 3;
    memcpy(data + n + sizeof points + 1, face, sizeof face);
    size_t size = n + sizeof points + 1 + sizeof face;
    for (size_t cut = 0; cut < size; cut++) check_bad_mesh("a.ply", data, cut, "objects[1].file \"a.ply\"");
    write_file("a.ply", data, size);
    cau_context *context;
    cau_scene *scene;
    Scene s = load_object("a.ply", &context, &scene);
    assert_int_equal(s.objects[0].mesh.triangle_count, 1);
    scene_free(&s);
    cau_scene_destroy(&scene);
    cau_context_destroy(&context);
}

static void height_files(void **state) {
    (void)state;
    char text[CAU_ERROR_TEXT_MAX];
    write_text("bad.json", SHAPE("\"type\":\"grid\",\"size\":[2,2],\"heights\":\"h.txt\""));
    write_text("h.txt", "# a bump\n0 0 0\n0 0.5, 0\r\n0 0 0 # last\n");
    assert_int_equal(load(in_folder("bad.json"), text), CAU_OK);
    write_text("h.txt", "0 0 0\n0 0.5\n");
    check_sentence(
        text, "", load(in_folder("bad.json"), text) == CAU_ERROR_INPUT ? CAU_OK : CAU_ERROR_INTERNAL, CAU_OK);
    assert_non_null(strstr(text, "line 2 has 2 numbers; the first row has 3"));
    write_text("h.txt", "0 nan\n");
    assert_int_equal(load(in_folder("bad.json"), text), CAU_ERROR_INPUT);
    assert_non_null(strstr(text, "line 1: \"nan"));
    write_text("h.txt", "1 2 3\n");
    assert_int_equal(load(in_folder("bad.json"), text), CAU_ERROR_INPUT);
    assert_non_null(strstr(text, "at least 2 whole rows"));
    write_text("h.txt", "");
    assert_int_equal(load(in_folder("bad.json"), text), CAU_ERROR_INPUT);
    write_text("bad.json", SHAPE("\"type\":\"grid\",\"size\":[2,2],\"columns\":2,\"heights\":[0,1,2,3]"));
    assert_int_equal(load(in_folder("bad.json"), text), CAU_OK);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mesh_files_are_read),
        cmocka_unit_test(ply_in_all_its_forms),
        cmocka_unit_test(gltf_stands_upright),
        cmocka_unit_test(damaged_meshes_get_one_sentence),
        cmocka_unit_test(a_cut_binary_ply_is_noticed),
        cmocka_unit_test(height_files),
    };
    return cmocka_run_group_tests(tests, open_test_folder, close_test_folder);
}
