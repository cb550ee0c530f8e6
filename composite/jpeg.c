/* SPDX-License-Identifier: Apache-2.0 */
#include "composite/picture_file.h"

#include <setjmp.h>
#include <stdio.h>

#include <jpeglib.h>

#include <errno.h>
#include <stdbool.h>
#include <string.h>

enum { QUALITY = 92 };

typedef struct Failure {
    struct jpeg_error_mgr manager; /* first: the library knows only this */
    jmp_buf back;
    char text[JMSG_LENGTH_MAX];
} Failure;

static void fail(j_common_ptr info) {
    Failure *failure = (Failure *)info->err;
    failure->manager.format_message(info, failure->text);
    longjmp(failure->back, 1);
}

/* No variable changes between setjmp and longjmp. */
static bool compress(Failure *failure, FILE *file, const uint8_t *rgb, size_t width, size_t height) {
    struct jpeg_compress_struct jpeg;
    jpeg.err = jpeg_std_error(&failure->manager);
    failure->manager.error_exit = fail;
    jpeg_create_compress(&jpeg);
    if (setjmp(failure->back)) {
        jpeg_destroy_compress(&jpeg);
        return false;
    }
    jpeg_stdio_dest(&jpeg, file);
    jpeg.image_width = (JDIMENSION)width;
    jpeg.image_height = (JDIMENSION)height;
    jpeg.input_components = 3;
    jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, QUALITY, TRUE);
    jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor =
        1; /* caustics are fine in colour too */
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < jpeg.image_height) {
        JSAMPROW row = (JSAMPROW)(rgb + 3 * width * jpeg.next_scanline);
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    return true;
}

cau_result jpeg_write(
    const char *path, const char *shown, const uint8_t *rgb, size_t width, size_t height, CauError *err) {
    Failure failure = {.text = ""};
    FILE *file = fopen(path, "wb");
    if (!file) return error_set(err, CAU_ERROR_RESOURCE, "cannot write \"%s\": %s", shown, strerror(errno));
    errno = 0;
    bool written = compress(&failure, file, rgb, width, height);
    int cause = errno;
    if (fclose(file) != 0 && written) {
        cause = errno;
        written = false;
    }
    if (written) return CAU_OK;
    return error_set(
        err, CAU_ERROR_RESOURCE, "cannot write \"%s\": %s", shown, cause ? strerror(cause) : failure.text);
}
