/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What an EXR header says, in plain memory: the same structure is read from a file and given to a writer.
 *
 *  Attributes keep the bytes of the file, whatever their type, so that even unknown ones survive a rewrite.
 */
#ifndef IMAGE_EXR_HEADER_H
#define IMAGE_EXR_HEADER_H

#include "core/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The values are those of the file format. */
typedef enum ExrPixelType { EXR_TYPE_UINT = 0, EXR_TYPE_HALF = 1, EXR_TYPE_FLOAT = 2 } ExrPixelType;
typedef enum ExrCodec {
    EXR_CODEC_NONE,
    EXR_CODEC_RLE,
    EXR_CODEC_ZIPS,
    EXR_CODEC_ZIP,
    EXR_CODEC_PIZ,
    EXR_CODEC_PXR24,
    EXR_CODEC_B44,
    EXR_CODEC_B44A,
    EXR_CODEC_DWAA,
    EXR_CODEC_DWAB,
    EXR_CODEC_COUNT
} ExrCodec;
typedef enum ExrOrder { EXR_ORDER_INCREASING = 0, EXR_ORDER_DECREASING = 1, EXR_ORDER_RANDOM = 2 } ExrOrder;
typedef enum ExrLevels { EXR_LEVELS_ONE = 0, EXR_LEVELS_MIPMAP = 1, EXR_LEVELS_RIPMAP = 2 } ExrLevels;

/** Inclusive on both ends, y downwards. */
typedef struct ExrBox {
    int32_t x0, y0, x1, y1;
} ExrBox;

typedef struct ExrChannel {
    char *name; /**< "R", "ViewLayer.Combined.R" */
    ExrPixelType type;
    uint8_t p_linear;
    int32_t x_sampling, y_sampling;
} ExrChannel;

typedef struct ExrAttr {
    char *name, *type;
    void *data; /**< as in the file: little endian, strings without a length */
    size_t size;
} ExrAttr;

typedef struct ExrPart {
    char *name; /**< NULL in a single-part file without one */
    bool tiled, deep;
    uint32_t tile_width, tile_height; /**< tiled only */
    ExrLevels levels;                 /**< tiled only */
    ExrCodec codec;
    ExrOrder order;
    ExrBox data_window, display_window;
    float pixel_aspect, screen_center[2], screen_width;
    ExrChannel *channels; /**< sorted by name, as in the file */
    size_t channel_count, channel_capacity;
    ExrAttr *attrs; /**< everything that has no field above */
    size_t attr_count, attr_capacity;
} ExrPart;

typedef struct ExrHeader {
    ExrPart *parts;
    size_t part_count;
} ExrHeader;

static inline size_t exr_type_bytes(ExrPixelType type) { return type == EXR_TYPE_HALF ? 2 : 4; }
static inline int64_t exr_box_width(ExrBox b) { return (int64_t)b.x1 - b.x0 + 1; }
static inline int64_t exr_box_height(ExrBox b) { return (int64_t)b.y1 - b.y0 + 1; }
static inline bool exr_box_equal(ExrBox a, ExrBox b) {
    return a.x0 == b.x0 && a.y0 == b.y0 && a.x1 == b.x1 && a.y1 == b.y1;
}

/** The smallest box that covers both. */
static inline ExrBox exr_box_union(ExrBox a, ExrBox b) {
    return (ExrBox){a.x0 < b.x0 ? a.x0 : b.x0, a.y0 < b.y0 ? a.y0 : b.y0, a.x1 > b.x1 ? a.x1 : b.x1,
        a.y1 > b.y1 ? a.y1 : b.y1};
}

/** "zip", "dwaa" ...; NULL for a value out of range. */
const char *exr_codec_name(ExrCodec codec);
/** False when there is no codec of that name. */
bool exr_codec_from_name(const char *name, ExrCodec *out);
/** PXR24, B44, B44A, DWAA, DWAB: what is decoded is not what was once encoded. */
bool exr_codec_is_lossy(ExrCodec codec);

/** `count` zeroed parts with the defaults of a scan-line ZIP part. Free with exr_header_free(). */
cau_result exr_header_create(ExrHeader *out, size_t count, CauError *err);
cau_result exr_header_copy(ExrHeader *out, const ExrHeader *from, CauError *err);
/** Safe on a zeroed header; zeroes it. */
void exr_header_free(ExrHeader *header);

cau_result exr_part_set_name(ExrPart *part, const char *name, CauError *err);
/** Keeps the channels sorted by name. A name that is there already is an error. */
cau_result exr_part_add_channel(ExrPart *part, const char *name, ExrPixelType type, CauError *err);
/** Rows of a chunk (a scan-line block, or a tile), and chunks side by side. */
int exr_chunk_rows(const ExrPart *part);
int exr_chunk_columns(const ExrPart *part);
/** Rows of a band, the unit of work: whole chunks, at least 16 rows. */
int exr_band_rows(const ExrPart *part);

/** A part cut into bands of `rows` rows, in the order in which they are written: upwards with decreasing line
 * order. */
typedef struct ExrBands {
    int rows;
    size_t count;
    const ExrPart *part;
} ExrBands;
ExrBands exr_bands(const ExrPart *part, int rows);
void exr_band_at(const ExrBands *bands, size_t index, int32_t *y0, int32_t *y1);
/** Bytes of one pixel over all channels. */
size_t exr_part_pixel_bytes(const ExrPart *part);

/** The attribute, or NULL. The first form tells upper from lower case. */
const ExrAttr *exr_attr_find(const ExrPart *part, const char *name);
const ExrAttr *exr_attr_find_any_case(const ExrPart *part, const char *name);
/** Sets or replaces an attribute; `data` is copied. */
cau_result exr_attr_set(
    ExrPart *part, const char *name, const char *type, const void *data, size_t size, CauError *err);
cau_result exr_attr_set_text(ExrPart *part, const char *name, const char *text, CauError *err);
cau_result exr_attr_set_int32(ExrPart *part, const char *name, int32_t value, CauError *err);
cau_result exr_attr_set_float32(ExrPart *part, const char *name, float value, CauError *err);
void exr_attr_remove(ExrPart *part, const char *name);
/** A string attribute as NUL-terminated text, to be freed; NULL when it is absent, of another type, or memory
 * is out. */
char *exr_attr_text(const ExrAttr *attr);
/** False when the attribute is absent or not an int. */
bool exr_attr_int32(const ExrAttr *attr, int32_t *out);

#ifdef __cplusplus
}
#endif
#endif
