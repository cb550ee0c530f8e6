/* SPDX-License-Identifier: Apache-2.0 */
/* libpng rather than OpenImageIO, whose 260 libraries cost every run of the program 0.2 s and 130 MB. */
#include "composite/picture_file.h"

#include <png.h>

#include <errno.h>
#include <stdio.h>
#include <string.h>

cau_result png_write(
    const char *path, const char *shown, const uint8_t *rgb, size_t width, size_t height, CauError *err) {
    png_image image = {.version = PNG_IMAGE_VERSION,
        .width = (png_uint_32)width,
        .height = (png_uint_32)height,
        .format = PNG_FORMAT_RGB,
        .flags = PNG_IMAGE_FLAG_COLORSPACE_NOT_sRGB};
    FILE *file = fopen(path, "wb");
    if (!file) return error_set(err, CAU_ERROR_RESOURCE, "cannot write \"%s\": %s", shown, strerror(errno));
    errno = 0;
    int written = png_image_write_to_stdio(&image, file, 0, rgb, 0, NULL);
    int cause = errno;
    if (fclose(file) != 0 && written) {
        cause = errno;
        written = 0;
    }
    if (written) return CAU_OK;
    return error_set(
        err, CAU_ERROR_RESOURCE, "cannot write \"%s\": %s", shown, cause ? strerror(cause) : image.message);
}
