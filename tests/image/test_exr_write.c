/* SPDX-License-Identifier: Apache-2.0 */
/* With a folder as argument it writes sample files there, for read_back.py; without, it runs the tests. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "image/exr_write.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { WIDTH = 37, HEIGHT = 300, PIXELS = WIDTH * HEIGHT };

/* A value that says where it belongs. */
static float value(int layer, int channel, int x, int y) {
    return (float)(layer * 100 + channel) + (float)x / 64.0f + (float)y / 8.0f;
}

typedef struct Sample {
    ExrPicture picture;
    ExrLayerData layers[3];
    ExrAttribute attributes[3];
    float *pixels[3];
} Sample;

static void sample_init(Sample *s, int crop) {
    static const char *const names[] = {"", "caustics_key", "caustics_key_err"};
    static const char *const channels[] = {"RGB", "RGB", "Y"};
    memset(s, 0, sizeof *s);
    for (int i = 0; i < 3; i++) {
        int n = (int)strlen(channels[i]);
        s->pixels[i] = calloc((size_t)(PIXELS * n), sizeof(float));
        for (int p = 0; p < PIXELS; p++)
            for (int c = 0; c < n; c++)
                s->pixels[i][p * n + c] = value(i, c, crop + p % WIDTH, crop + p / WIDTH);
        s->layers[i] = (ExrLayerData){names[i], channels[i], s->pixels[i]};
    }
    s->attributes[0] = (ExrAttribute){.name = "caustics/layers", .kind = EXR_STRING, .text = "[]"};
    s->attributes[1] = (ExrAttribute){.name = "caustics/complete", .kind = EXR_INT, .integer = 1};
    s->attributes[2] = (ExrAttribute){.name = "caustics/error", .kind = EXR_FLOAT, .number = 0.25f};
    s->picture = (ExrPicture){.width = WIDTH + 2 * crop,
        .height = HEIGHT + 2 * crop,
        .data_x0 = crop,
        .data_y0 = crop,
        .data_x1 = crop + WIDTH - 1,
        .data_y1 = crop + HEIGHT - 1,
        .pixel_aspect = 1.5f,
        .color_interop_id = "lin_rec709_scene",
        .layers = s->layers,
        .layer_count = 3,
        .attributes = s->attributes,
        .attribute_count = 3};
}

static void sample_free(Sample *s) {
    for (int i = 0; i < 3; i++) free(s->pixels[i]);
}

static int write_samples(const char *folder) {
    static const char *const names[] = {"float", "half", "interleaved", "cropped"};
    for (int i = 0; i < 4; i++) {
        Sample s;
        sample_init(&s, i == 3 ? 5 : 0);
        s.picture.half = i == 1;
        s.picture.interleave = i == 2;
        s.pixels[1][0] = NAN;
        s.pixels[1][4] = -INFINITY;
        s.pixels[1][8] = 1e6f;
        char path[4096];
        snprintf(path, sizeof path, "%s/%s.exr", folder, names[i]);
        CauError err = {0};
        ExrWriteReport report;
        if (exr_write(path, &s.picture, &report, &err) != CAU_OK) {
            fprintf(stderr, "%s\n", err.text);
            return 1;
        }
        sample_free(&s);
    }
    return 0;
}

static void repairs_are_counted(void **state) {
    (void)state;
    char path[] = "/tmp/caustics_exr_XXXXXX";
    int fd = mkstemp(path);
    close(fd);
    Sample s;
    sample_init(&s, 0);
    s.pixels[0][5] = NAN;
    s.pixels[0][6] = INFINITY;
    s.pixels[2][7] = -65505.0f;
    ExrWriteReport report;
    assert_int_equal(exr_write(path, &s.picture, &report, NULL), CAU_OK);
    assert_int_equal(report.repaired, 2);
    assert_int_equal(report.clamped, 0);
    s.picture.half = true;
    assert_int_equal(exr_write(path, &s.picture, &report, NULL), CAU_OK);
    assert_int_equal(report.clamped, 1);
    sample_free(&s);
    unlink(path);
}

static void failure_leaves_the_old_file(void **state) {
    (void)state;
    char path[] = "/tmp/caustics_exr_XXXXXX";
    int fd = mkstemp(path);
    assert_int_equal(write(fd, "old", 3), 3);
    close(fd);
    Sample s;
    CauError err = {0};
    sample_init(&s, 0);
    s.layers[2].name = "caustics_key"; /* twice */
    assert_int_equal(exr_write(path, &s.picture, NULL, &err), CAU_ERROR_USAGE);
    assert_non_null(strstr(err.text, "caustics_key"));
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_size, 3);
    error_clear(&err);
    s.layers[2].name = "caustics_key_err";
    assert_int_equal(exr_write("/nowhere/x.exr", &s.picture, NULL, &err), CAU_ERROR_RESOURCE);
    sample_free(&s);
    unlink(path);
}

int main(int argc, char **argv) {
    if (argc == 2) return write_samples(argv[1]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(repairs_are_counted),
        cmocka_unit_test(failure_leaves_the_old_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
