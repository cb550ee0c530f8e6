/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Camera rays and pixel filters, as Cycles has them: a pixel's samples are drawn from its filter and
 * weigh 1. */
#ifndef RENDER_TRACE_CAMERA_H
#define RENDER_TRACE_CAMERA_H

#include "render/trace/embree.h"

enum { FILTER_TABLE_SIZE = 16384 };

/** The inverted cumulative filter, and what splatting needs of it. */
typedef struct PixelFilter {
    double inverse[FILTER_TABLE_SIZE + 1]; /**< offset in pixels at equal steps of probability */
    double half_width;                     /**< support, pixels */
    double norm;                           /**< integral of the unnormalised filter */
    FilterType type;
    double width;
} PixelFilter;

void filter_prepare(PixelFilter *filter, FilterType type, double width);
/** Offset in pixels drawn from the filter. */
double filter_sample(const PixelFilter *filter, double u);
/** The normalised filter (it integrates to 1), per pixel. */
double filter_value(const PixelFilter *filter, double offset);

/** The ray through raster position (x, y): x to the right, y down, pixel (0,0) covers [0,1)x[0,1). */
Ray camera_ray(const Camera *camera, double x, double y);

/** Where the camera sees a point. */
typedef struct CameraView {
    double x, y;            /**< raster position */
    V3 to_camera;           /**< unit */
    double distance;        /**< from the point to the camera (orthographic: to its plane) */
    double raster_per_area; /**< raster area covered per unit area of a surface that faces to_camera */
} CameraView;

/** False when the point is behind the camera or outside the clip range. */
bool camera_project(const Camera *camera, V3 p, CameraView *out);

/** Edge length of a pixel's footprint on a surface that faces the ray, after `distance` along it. */
double camera_pixel_size(const Camera *camera, double distance);

#endif
