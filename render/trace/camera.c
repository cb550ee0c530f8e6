/* SPDX-License-Identifier: Apache-2.0 */
#include "render/trace/camera.h"

/* Cycles' filter functions: src/scene/film.cpp of Cycles 3.4. The support is the width for a box, three times
 * the width for a Gaussian, twice the width for Blackman-Harris. */
static double filter_raw(FilterType type, double support, double x) {
    if (type == FILTER_GAUSSIAN) {
        double v = 6.0 * x / support;
        return exp(-2.0 * v * v);
    }
    if (type == FILTER_BLACKMAN_HARRIS) {
        double v = 2.0 * CAU_PI * (x / support + 0.5);
        return 0.35875 - 0.48829 * cos(v) + 0.14128 * cos(2 * v) - 0.01168 * cos(3 * v);
    }
    return 1.0;
}

static double filter_support(FilterType type, double width) {
    return type == FILTER_GAUSSIAN ? 3.0 * width : (type == FILTER_BLACKMAN_HARRIS ? 2.0 * width : width);
}

void filter_prepare(PixelFilter *filter, FilterType type, double width) {
    enum { STEPS = 1 << 16 };
    double support = filter_support(type, width), step = support / STEPS, total = 0;
    filter->type = type;
    filter->width = width;
    filter->half_width = support / 2;
    for (int i = 0; i < STEPS; i++) total += filter_raw(type, support, (i + 0.5) * step - support / 2);
    filter->norm = total * step;
    double sum = 0;
    int at = 0;
    for (int k = 0; k <= FILTER_TABLE_SIZE; k++) {
        double wanted = total * k / FILTER_TABLE_SIZE, value = 0;
        while (at < STEPS) {
            value = filter_raw(type, support, (at + 0.5) * step - support / 2);
            if (sum + value >= wanted) break;
            sum += value;
            at++;
        }
        double fraction = value > 0 ? clamp((wanted - sum) / value, 0, 1) : 0;
        filter->inverse[k] = (at + fraction) * step - support / 2;
    }
    filter->inverse[0] = -support / 2;
    filter->inverse[FILTER_TABLE_SIZE] = support / 2;
}

double filter_sample(const PixelFilter *filter, double u) {
    double x = u * FILTER_TABLE_SIZE;
    int i = (int)x;
    if (i >= FILTER_TABLE_SIZE) i = FILTER_TABLE_SIZE - 1;
    double f = x - i;
    return filter->inverse[i] * (1 - f) + filter->inverse[i + 1] * f;
}

double filter_value(const PixelFilter *filter, double offset) {
    if (fabs(offset) > filter->half_width) return 0;
    return filter_raw(filter->type, 2 * filter->half_width, offset) / filter->norm;
}

/* Screen coordinates in image widths, from the middle, y up. */
static double screen_height(const Camera *c) { return c->height / (c->width * c->pixel_aspect); }

Ray camera_ray(const Camera *c, double x, double y) {
    double sx = x / c->width - 0.5 + c->shift_x, sy = (0.5 - y / c->height) * screen_height(c) + c->shift_y;
    if (c->type == CAMERA_ORTHOGRAPHIC) {
        V3 origin = v3_add(c->position,
            v3_add(v3_scale(c->right, sx * c->ortho_width), v3_scale(c->up, sy * c->ortho_width)));
        return ray_from_point(origin, c->forward, c->clip_near, c->clip_far, VISIBLE_CAMERA);
    }
    double s = 2 * c->tan_half_width;
    V3 dir = v3_add(c->forward, v3_add(v3_scale(c->right, sx * s), v3_scale(c->up, sy * s)));
    double length = v3_length(dir); /* 1 / cosine to the axis: clip distances are depths */
    return ray_from_point(
        c->position, v3_scale(dir, 1 / length), c->clip_near * length, c->clip_far * length, VISIBLE_CAMERA);
}

bool camera_project(const Camera *c, V3 p, CameraView *out) {
    V3 d = v3_sub(p, c->position);
    double depth = v3_dot(d, c->forward);
    if (depth <= c->clip_near || depth >= c->clip_far) return false;
    double rx = c->width, ry = c->height / screen_height(c); /* raster per image width */
    double sx, sy;
    if (c->type == CAMERA_ORTHOGRAPHIC) {
        sx = v3_dot(d, c->right) / c->ortho_width;
        sy = v3_dot(d, c->up) / c->ortho_width;
        out->to_camera = v3_neg(c->forward);
        out->distance = depth;
        out->raster_per_area = rx * ry / square(c->ortho_width);
    } else {
        double s = 2 * c->tan_half_width * depth;
        sx = v3_dot(d, c->right) / s;
        sy = v3_dot(d, c->up) / s;
        out->distance = v3_length(d);
        out->to_camera = v3_scale(d, -1 / out->distance);
        double cosine = depth / out->distance;
        /* Solid angle of a facing area is A / distance^2; the screen at unit depth gets 1 / cos^3 of it. */
        out->raster_per_area =
            rx * ry / (square(2 * c->tan_half_width) * square(out->distance) * cosine * cosine * cosine);
    }
    out->x = (sx - c->shift_x + 0.5) * rx;
    out->y = (0.5 * screen_height(c) - (sy - c->shift_y)) * ry;
    return true;
}

double camera_pixel_size(const Camera *c, double distance) {
    if (c->type == CAMERA_ORTHOGRAPHIC) return c->ortho_width / c->width;
    return 2 * c->tan_half_width / c->width * distance;
}
