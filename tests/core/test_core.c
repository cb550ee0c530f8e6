/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "core/error.h"
#include "core/file_atomic.h"
#include "core/nearest.h"
#include "core/sampling.h"
#include "core/tasks.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static void first_error_is_kept(void **state) {
    (void)state;
    CauError err = {0};
    assert_int_equal(error_set(&err, CAU_ERROR_INPUT, "first %d\n", 1), CAU_ERROR_INPUT);
    assert_int_equal(error_set(&err, CAU_ERROR_USAGE, "second"), CAU_ERROR_USAGE);
    assert_string_equal(err.text, "first 1?");
    error_prefix(&err, "a.json: ");
    assert_string_equal(err.text, "a.json: first 1?");
}

static void nearest_finds_typing_errors(void **state) {
    (void)state;
    const char *names[] = {"glass", "metal", "diffuse"};
    assert_int_equal(nearest_name("Glas", names, 3), 0);
    assert_int_equal(nearest_name("difuse", names, 3), 2);
    assert_int_equal(nearest_name("x", names, 0), -1);
    const char *const keys[] = {"look", "hfov_deg"};
    assert_int_equal(nearest_name("hfov", keys, 2), 1);
}

static void count_piece(void *data, size_t index, unsigned thread) {
    (void)thread;
    ((unsigned char *)data)[index]++;
}

static void every_piece_runs_once(void **state) {
    (void)state;
    for (unsigned threads = 1; threads <= 7; threads += 3) {
        TaskPool *pool = NULL;
        assert_int_equal(tasks_create(&pool, threads, NULL), CAU_OK);
        for (int round = 0; round < 50; round++) {
            unsigned char seen[777] = {0};
            tasks_run(pool, sizeof seen, count_piece, seen);
            for (size_t i = 0; i < sizeof seen; i++) assert_int_equal(seen[i], 1);
        }
        tasks_destroy(&pool);
        assert_null(pool);
    }
}

static void atomic_file_replaces_or_leaves(void **state) {
    (void)state;
    char folder[] = "/tmp/caustics_core_XXXXXX";
    assert_non_null(mkdtemp(folder));
    char path[64], target[64];
    snprintf(path, sizeof path, "%s/out", folder);
    snprintf(target, sizeof target, "%s/target", folder);
    CauError err = {0};
    assert_int_equal(file_write_atomic(target, "old", 3, &err), CAU_OK);
    assert_int_equal(symlink(target, path), 0);
    assert_int_equal(file_write_atomic(path, "newer", 5, &err), CAU_OK);
    struct stat info;
    assert_int_equal(lstat(path, &info), 0);
    assert_true(S_ISREG(info.st_mode) && info.st_size == 5);
    assert_int_equal(stat(target, &info), 0);
    assert_int_equal(info.st_size, 3);
    FileAtomic file;
    assert_int_equal(file_atomic_begin(&file, path, &err), CAU_OK);
    file_atomic_abort(&file);
    assert_int_equal(file_write_atomic(folder, "x", 1, &err), CAU_ERROR_INPUT);
    error_clear(&err);
    assert_int_equal(file_write_atomic("/nowhere/at/all", "x", 1, &err), CAU_ERROR_RESOURCE);
    unlink(path);
    unlink(target);
    assert_int_equal(rmdir(folder), 0); /* nothing temporary is left behind */
}

/* Within two units in the last place of 1 of the C library's. */
static void turns_have_the_library_s_sine(void **state) {
    (void)state;
    double worst = 0, sine, cosine;
    for (int i = 0; i <= 1250000; i++) {
        double u = 1e-6 * i, angle = 2 * CAU_PI * u;
        sincos_turn(u, &sine, &cosine);
        worst = fmax(worst, fmax(fabs(sine - sin(angle)), fabs(cosine - cos(angle))));
    }
    /* The angle itself has rounded: up to 4.4e-16 of its 7.85. */
    if (!(worst < 9e-16)) fail_msg("%g off", worst);
}

/* The disk's map against its definition by angles. */
static void disk_is_shirley_and_chiu_s(void **state) {
    (void)state;
    for (int i = 0; i < 101 * 101; i++) {
        double u = i % 101 / 100.0, v = i / 101 / 100.0, a = 2 * u - 1, b = 2 * v - 1, x, y;
        bool wide = fabs(a) > fabs(b);
        double r = wide ? a : b, phi = r == 0 ? 0 : CAU_PI / 4 * (wide ? b / a : 2 - a / b);
        sample_disk(u, v, &x, &y);
        assert_true(fabs(x - r * cos(phi)) < 1e-15 && fabs(y - r * sin(phi)) < 1e-15);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(first_error_is_kept),
        cmocka_unit_test(nearest_finds_typing_errors),
        cmocka_unit_test(every_piece_runs_once),
        cmocka_unit_test(atomic_file_replaces_or_leaves),
        cmocka_unit_test(turns_have_the_library_s_sine),
        cmocka_unit_test(disk_is_shirley_and_chiu_s),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
