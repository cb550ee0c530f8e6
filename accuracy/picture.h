/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Pictures from and to files. */
#ifndef ACCURACY_PICTURE_H
#define ACCURACY_PICTURE_H

#include "core/error.h"

/** Reads channels R, G and B of the first part of an EXR file as `caustic-render` and Blender write it: scan
 *  lines, whole picture. *rgb becomes *width * *height * 3 values from the top left, which the caller frees.
 */
cau_result picture_read(const char *path, int *width, int *height, float **rgb, CauError *err);

/** Writes `rgb` times `gain` as an 8-bit sRGB PNG, atomically. */
cau_result picture_write_png(
    const char *path, const float *rgb, int width, int height, double gain, CauError *err);

/** A gain that brings the brightest 1 % of values of `rgb` to white. */
double picture_gain(const float *rgb, int width, int height);

#endif
