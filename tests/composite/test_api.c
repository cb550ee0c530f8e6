/* SPDX-License-Identifier: Apache-2.0 */
/* The library through its public header alone. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "caustics/composite.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char beauty[] = SOURCE_DIR "/tests/data/beauty/a_off_single_half.exr";

static void misuse_is_an_error(void **state) {
    (void)state;
    cau_merge *merge = NULL;
    cau_merge_options o = {.size = sizeof o};
    assert_int_equal(cau_merge_create(NULL), CAU_ERROR_USAGE);
    assert_int_equal(cau_merge_create(&merge), CAU_OK);
    assert_string_equal(cau_merge_error(merge), "");
    assert_int_equal(cau_merge_add(NULL, &o), CAU_ERROR_USAGE);
    assert_int_equal(cau_merge_add(merge, NULL), CAU_ERROR_USAGE);
    assert_int_equal(cau_merge_add(merge, &o), CAU_ERROR_USAGE);
    o.size = 3;
    assert_int_equal(cau_merge_add(merge, &o), CAU_ERROR_USAGE);
    assert_non_null(strstr(cau_merge_error(merge), "size"));
    cau_merge_light light = {.light = "key", .set = CAU_MERGE_GAIN, .gain = NAN};
    o = (cau_merge_options){
        .size = sizeof o, .beauty = "a", .caustics = "b", .output = "c", .lights = &light, .light_count = 1};
    assert_int_equal(cau_merge_add(merge, &o), CAU_ERROR_USAGE);
    assert_non_null(strstr(cau_merge_error(merge), "finite"));
    assert_int_equal(cau_merge_list(merge, NULL, NULL, NULL), CAU_ERROR_USAGE);
    cau_merge_destroy(&merge);
    assert_null(merge);
    cau_merge_destroy(&merge);
}

static void an_older_caller_is_understood(void **state) {
    (void)state;
    cau_merge *merge = NULL;
    assert_int_equal(cau_merge_create(&merge), CAU_OK);
    /* Only the fields up to `output` existed for this caller; the rest is not read. */
    cau_merge_options o = {.size = offsetof(cau_merge_options, lights),
        .beauty = beauty,
        .caustics = beauty,
        .output = "/nowhere/x.exr"};
    o.light_count = 77;
    o.ocio = "/nowhere.ocio";
    assert_int_equal(cau_merge_add(merge, &o), CAU_ERROR_INPUT);
    assert_non_null(strstr(cau_merge_error(merge), "no light layers"));
    cau_merge_destroy(&merge);
}

static void frames_shards_and_diff_refuse_nonsense(void **state) {
    (void)state;
    cau_merge *merge = NULL;
    cau_merge_frames frames = {.size = sizeof frames, .first = 3, .last = 1, .step = 1};
    cau_merge_options o = {
        .size = sizeof o, .beauty = "b.####.exr", .caustics = "c.####.exr", .output = "o.####.exr"};
    const char *const files[] = {beauty, beauty};
    assert_int_equal(cau_merge_create(&merge), CAU_OK);
    assert_int_equal(cau_merge_add_frames(merge, &o, NULL), CAU_ERROR_USAGE);
    assert_int_equal(cau_merge_add_frames(merge, &o, &frames), CAU_ERROR_USAGE);
    frames.step = 0;
    frames.last = 5;
    assert_int_equal(cau_merge_add_frames(merge, &o, &frames), CAU_ERROR_USAGE);
    o.output = "o.exr";
    assert_int_equal(cau_merge_add_frames(merge, &o, &frames), CAU_ERROR_USAGE);
    assert_non_null(strstr(cau_merge_error(merge), "o.exr"));
    assert_int_equal(cau_merge_shards(merge, files, 1, &o), CAU_ERROR_USAGE);
    assert_int_equal(cau_merge_shards(merge, NULL, 2, &o), CAU_ERROR_USAGE);
    o.output = "/nowhere/o.exr";
    assert_int_equal(cau_merge_shards(merge, files, 2, &o), CAU_ERROR_INPUT);
    assert_non_null(strstr(cau_merge_error(merge), "photons"));
    assert_int_equal(cau_merge_diff(merge, beauty, NULL, NULL, NULL), CAU_ERROR_USAGE);
    assert_int_equal(cau_merge_diff(merge, beauty, beauty, NULL, NULL), CAU_OK);
    cau_merge_destroy(&merge);
}

static void keep_frame(void *user, int frame, const char *output, cau_result result, const char *sentence) {
    int *told = user;
    assert_non_null(output);
    assert_non_null(sentence);
    assert_int_equal(frame, *told + 1);
    assert_int_equal(result, CAU_ERROR_INPUT);
    *told = frame;
}

static void frames_are_told_in_order(void **state) {
    (void)state;
    cau_merge *merge = NULL;
    int told = 0;
    cau_merge_frames frames = {.size = sizeof frames, .first = 1, .last = 40, .step = 1, .frame = keep_frame};
    cau_merge_options o = {.size = sizeof o,
        .beauty = "/nowhere/b.%04d.exr",
        .caustics = "/nowhere/c.####.exr",
        .output = "/nowhere/o.#.exr",
        .threads = 7,
        .user = &told};
    assert_int_equal(cau_merge_create(&merge), CAU_OK);
    assert_int_equal(cau_merge_add_frames(merge, &o, &frames), CAU_ERROR_INPUT);
    assert_int_equal(told, 40);
    assert_non_null(strstr(cau_merge_error(merge), "40 of 40"));
    cau_merge_destroy(&merge);
}

static void count_line(void *user, const char *text) {
    assert_non_null(text);
    ++*(int *)user;
}

static int stop(void *user) {
    ++*(int *)user;
    return 1;
}

static void reports_and_cancel(void **state) {
    (void)state;
    cau_merge *merge = NULL;
    int lines = 0, asked = 0;
    assert_int_equal(cau_merge_create(&merge), CAU_OK);
    assert_int_equal(cau_merge_list(merge, beauty, count_line, &lines), CAU_OK);
    assert_true(lines >= 3);
    lines = 0;
    assert_int_equal(cau_merge_check(merge, beauty, count_line, &lines), CAU_OK);
    assert_true(lines >= 1);
    assert_int_equal(cau_merge_check(merge, "/nowhere.exr", count_line, &lines), CAU_ERROR_INPUT);
    assert_non_null(strstr(cau_merge_error(merge), "/nowhere.exr"));
    cau_merge_options o = {.size = sizeof o,
        .beauty = beauty,
        .preview = "/tmp/caustics_never.png",
        .user = &asked,
        .cancelled = stop};
    assert_int_equal(cau_merge_preview(merge, &o), CAU_ERROR_CANCELLED);
    assert_true(asked > 0);
    assert_int_not_equal(access(o.preview, F_OK), 0);
    cau_merge_destroy(&merge);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(misuse_is_an_error),
        cmocka_unit_test(an_older_caller_is_understood),
        cmocka_unit_test(frames_shards_and_diff_refuse_nonsense),
        cmocka_unit_test(frames_are_told_in_order),
        cmocka_unit_test(reports_and_cancel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
