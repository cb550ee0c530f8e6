/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Float layers to an EXR file in one call: what the renderer writes.
 *
 *  Every layer becomes a part of its own whose channels still carry the layer's name, which both Blender and
 * Nuke read; `interleave` puts the same channels in one part. Whatever happens, the old file or the whole new
 * one is there. No NaN, no infinity is ever written: they become 0 and are counted, and what is too large for
 * the type becomes its largest value and is counted. Both counts are in the header
 * (CAU_ATTRIBUTE_REPAIRED_NAN, CAU_ATTRIBUTE_CLAMPED; counts the caller knows of already go into
 * `repaired_before`, `clamped_before`). */
#ifndef IMAGE_EXR_WRITE_H
#define IMAGE_EXR_WRITE_H

#include "core/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ExrLayerData {
    const char *name;     /**< "caustics_key"; "" for bare channels, at most once */
    const char *channels; /**< one letter each: "RGB", "Y" */
    const float *pixels;  /**< interleaved in the order of `channels`, row by row, the whole data window */
} ExrLayerData;

typedef enum ExrAttributeKind { EXR_STRING, EXR_INT, EXR_FLOAT } ExrAttributeKind;

typedef struct ExrAttribute {
    const char *name;
    ExrAttributeKind kind;
    const char *text; /**< EXR_STRING, UTF-8 */
    int32_t integer;  /**< EXR_INT */
    float number;     /**< EXR_FLOAT */
} ExrAttribute;

typedef struct ExrPicture {
    int width, height;                      /**< display window (0,0)-(width-1,height-1) */
    int data_x0, data_y0, data_x1, data_y1; /**< data window, inclusive; pixels cover it */
    float pixel_aspect;                     /**< 0 means 1 */
    bool half;                              /**< else float */
    bool interleave;                        /**< one part instead of one per layer */
    const char *color_interop_id;           /**< "lin_rec709_scene"; NULL: no tag */
    const ExrLayerData *layers;
    size_t layer_count;
    const ExrAttribute *attributes; /**< written to the first part */
    size_t attribute_count;
    uint64_t repaired_before, clamped_before; /**< added to the counts in the header */
} ExrPicture;

typedef struct ExrWriteReport {
    uint64_t clamped;  /**< values cut to the largest of their type by this call */
    uint64_t repaired; /**< NaN and infinities that became 0 in this call */
} ExrWriteReport;

/** Writes `picture` to `path`, atomically. `report` may be NULL. Errors: CAU_ERROR_USAGE for a picture that
 * makes no sense, CAU_ERROR_RESOURCE when the disk or memory is full. */
cau_result exr_write(const char *path, const ExrPicture *picture, ExrWriteReport *report, CauError *err);

#endif
