/* SPDX-License-Identifier: Apache-2.0 */
/* A folder for files under test, and pieces of scene files. */
#ifndef TESTS_SCENE_FILES_H
#define TESTS_SCENE_FILES_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "caustics/scene_file.h"
#include "render/scene/scene.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char folder[] = "/tmp/caustics_scene_XXXXXX";

static inline const char *in_folder(const char *name) {
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static inline void write_file(const char *name, const void *data, size_t size) {
    FILE *file = fopen(in_folder(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static inline void write_text(const char *name, const char *text) { write_file(name, text, strlen(text)); }

/* Loads and normalises; the sentence of the error, if any, goes to `text`. */
static inline cau_result load(const char *path, char text[CAU_ERROR_TEXT_MAX]) {
    cau_context *context;
    cau_scene *scene;
    Scene normal;
    assert_int_equal(cau_context_create(&context), CAU_OK);
    cau_result result = cau_scene_load_file(context, path, &scene);
    assert_int_equal(result == CAU_OK, scene != NULL);
    if (result == CAU_OK) {
        result = scene_normalise(scene, 0, 0, &normal, &context->error);
        if (result == CAU_OK) scene_free(&normal);
    }
    snprintf(text, CAU_ERROR_TEXT_MAX, "%s", cau_error_text(context));
    cau_scene_destroy(&scene);
    cau_context_destroy(&context);
    return result;
}

#define CAMERA                                                                                               \
    "\"camera\":{\"look\":{\"from\":[0,-4,2],\"to\":[0,0,0]},\"hfov_deg\":40,\"resolution\":[48,27]}"
#define HEAD "{\"caustics_scene\":1," CAMERA
#define MATERIALS ",\"materials\":{\"glass\":{\"type\":\"glass\",\"color\":[1,1,1]}}"
#define BALL "{\"name\":\"ball\",\"shape\":{\"type\":\"sphere\",\"radius\":1},\"material\":\"glass\"}"
#define OBJECT(rest)                                                                                         \
    HEAD MATERIALS ",\"objects\":[" BALL ",{\"name\":\"b\",\"material\":\"glass\"," rest "}]}"
#define SHAPE(rest) OBJECT("\"shape\":{" rest "}")
#define LIGHT(rest) HEAD ",\"lights\":[{\"name\":\"Key\"," rest "}]}"

static inline void check_sentence(const char *text, const char *words, cau_result result, cau_result code) {
    char prefix[520];
    snprintf(prefix, sizeof prefix, "%s: ", in_folder("bad.json"));
    if (result != code || !strstr(text, words) || strncmp(text, prefix, strlen(prefix)) != 0)
        fail_msg("code %d: \"%s\" does not say \"%s\"", result, text, words);
    assert_null(strchr(text, '\n'));
    assert_null(strstr(text + strlen(prefix), prefix)); /* the file is named once */
}

static inline int open_test_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : 1;
}

static inline int close_test_folder(void **state) {
    (void)state;
    DIR *d = opendir(folder);
    for (struct dirent *e; d && (e = readdir(d));)
        if (e->d_name[0] != '.' && unlink(in_folder(e->d_name)) != 0) rmdir(in_folder(e->d_name));
    if (d) closedir(d);
    return rmdir(folder);
}

#endif
