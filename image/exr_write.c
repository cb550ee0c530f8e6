/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_write.h"

#include "caustics/layers.h"
#include "core/checked.h"
#include "core/file_atomic.h"
#include "image/exr_writer.h"
#include "image/half.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>

enum { CHANNEL_NAME_MAX = 255 };

/* Where a channel of the file comes from. */
typedef struct Source {
    const float *pixels; /* of the first pixel */
    size_t stride;       /* floats from pixel to pixel */
} Source;

static cau_result check_picture(const ExrPicture *p, CauError *err) {
    if (p->width < 1 || p->height < 1)
        return error_set(
            err, CAU_ERROR_USAGE, "a picture of %d x %d pixels cannot be written", p->width, p->height);
    if (p->data_x1 < p->data_x0 || p->data_y1 < p->data_y0)
        return error_set(err, CAU_ERROR_USAGE, "the data window (%d,%d)-(%d,%d) is empty", p->data_x0,
            p->data_y0, p->data_x1, p->data_y1);
    if (p->layer_count == 0)
        return error_set(err, CAU_ERROR_USAGE, "a picture without layers cannot be written");
    for (size_t i = 0; i < p->layer_count; i++)
        if (!p->layers[i].channels[0] || !p->layers[i].pixels)
            return error_set(err, CAU_ERROR_USAGE, "layer \"%s\" has no pixels", p->layers[i].name);
    return CAU_OK;
}

static cau_result add_channels(ExrPart *part, const ExrLayerData *layer, bool half, CauError *err) {
    for (const char *letter = layer->channels; *letter; letter++) {
        char name[CHANNEL_NAME_MAX + 1];
        int length = snprintf(name, sizeof name, "%s%s%c", layer->name, layer->name[0] ? "." : "", *letter);
        if (length < 0 || (size_t)length >= sizeof name)
            return error_set(err, CAU_ERROR_USAGE, "layer \"%s\": the name is longer than %d bytes",
                layer->name, CHANNEL_NAME_MAX);
        CAU_TRY(exr_part_add_channel(part, name, half ? EXR_TYPE_HALF : EXR_TYPE_FLOAT, err));
    }
    return CAU_OK;
}

static cau_result add_attributes(ExrPart *part, const ExrPicture *p, CauError *err) {
    if (p->color_interop_id)
        CAU_TRY(exr_attr_set_text(part, CAU_ATTRIBUTE_COLOR_ID, p->color_interop_id, err));
    for (size_t i = 0; i < p->attribute_count; i++) {
        const ExrAttribute *a = &p->attributes[i];
        if (a->kind == EXR_STRING) CAU_TRY(exr_attr_set_text(part, a->name, a->text, err));
        if (a->kind == EXR_INT) CAU_TRY(exr_attr_set_int32(part, a->name, a->integer, err));
        if (a->kind == EXR_FLOAT) CAU_TRY(exr_attr_set_float32(part, a->name, a->number, err));
    }
    return CAU_OK;
}

static void set_windows(ExrPart *part, const ExrPicture *p) {
    part->display_window = (ExrBox){0, 0, p->width - 1, p->height - 1};
    part->data_window = (ExrBox){p->data_x0, p->data_y0, p->data_x1, p->data_y1};
    part->pixel_aspect = p->pixel_aspect > 0 ? p->pixel_aspect : 1;
}

static cau_result build_header(ExrHeader *header, const ExrPicture *p, CauError *err) {
    bool one = p->interleave || p->layer_count == 1;
    CAU_TRY(exr_header_create(header, one ? 1 : p->layer_count, err));
    for (size_t i = 0; i < header->part_count; i++) set_windows(&header->parts[i], p);
    for (size_t i = 0; i < p->layer_count; i++) {
        ExrPart *part = &header->parts[one ? 0 : i];
        if (!one) {
            const char *name = p->layers[i].name[0] ? p->layers[i].name : "rgb";
            for (size_t k = 0; k < i; k++)
                if (strcmp(header->parts[k].name, name) == 0)
                    return error_set(err, CAU_ERROR_USAGE, "layer \"%s\" is there twice", name);
            CAU_TRY(exr_part_set_name(part, name, err));
        }
        CAU_TRY(add_channels(part, &p->layers[i], p->half, err));
    }
    return add_attributes(&header->parts[0], p, err);
}

/* What is written for v; counts what had to be changed. */
static float storable(float v, float largest, ExrWriteReport *report) {
    if (!isfinite(v)) {
        report->repaired++;
        return 0;
    }
    if (fabsf(v) > largest) {
        report->clamped++;
        return copysignf(largest, v);
    }
    return v;
}

/* The counts stand in the header, which is written before any pixel: so count first. */
static cau_result count_repairs(
    ExrHeader *header, const ExrPicture *p, ExrWriteReport *report, CauError *err) {
    size_t pixels = (size_t)exr_box_width(header->parts[0].data_window) *
                    (size_t)exr_box_height(header->parts[0].data_window);
    for (size_t i = 0; i < p->layer_count; i++) {
        size_t values = pixels * strlen(p->layers[i].channels);
        for (size_t k = 0; k < values; k++)
            storable(p->layers[i].pixels[k], p->half ? HALF_LARGEST : INFINITY, report);
    }
    uint64_t repaired = report->repaired + p->repaired_before, clamped = report->clamped + p->clamped_before;
    CAU_TRY(exr_attr_set_int32(&header->parts[0], CAU_ATTRIBUTE_REPAIRED_NAN,
        repaired > INT32_MAX ? INT32_MAX : (int32_t)repaired, err));
    return exr_attr_set_int32(
        &header->parts[0], CAU_ATTRIBUTE_CLAMPED, clamped > INT32_MAX ? INT32_MAX : (int32_t)clamped, err);
}

static bool find_source(const ExrPicture *p, const char *channel, Source *out) {
    const char *dot = strrchr(channel, '.');
    size_t length = dot ? (size_t)(dot - channel) : 0;
    char letter = dot ? dot[1] : channel[0];
    for (size_t i = 0; i < p->layer_count; i++) {
        const ExrLayerData *layer = &p->layers[i];
        const char *at = strchr(layer->channels, letter);
        if (!at || strlen(layer->name) != length || strncmp(layer->name, channel, length) != 0) continue;
        *out = (Source){layer->pixels + (at - layer->channels), strlen(layer->channels)};
        return true;
    }
    return false;
}

static void fill_row(uint8_t *row, const Source *source, size_t first, size_t count, bool half) {
    ExrWriteReport counted = {0};
    const float *from = source->pixels + first * source->stride;
    for (size_t i = 0; i < count; i++) {
        float v = storable(from[i * source->stride], half ? HALF_LARGEST : INFINITY, &counted);
        uint16_t h = half ? half_from_float(v) : 0;
        if (half)
            memcpy(row + i * sizeof h, &h, sizeof h);
        else
            memcpy(row + i * sizeof v, &v, sizeof v);
    }
}

static cau_result fill_rows(const ExrRows *rows, const ExrPart *part, const ExrPicture *p, CauError *err) {
    size_t width = (size_t)exr_box_width(part->data_window);
    for (size_t c = 0; c < part->channel_count; c++) {
        Source source;
        if (!find_source(p, part->channels[c].name, &source))
            return error_set(err, CAU_ERROR_INTERNAL, "channel \"%s\" has no source", part->channels[c].name);
        size_t offset = exr_channel_offset(part, c);
        for (int32_t y = rows->y0; y <= rows->y1; y++)
            fill_row(exr_rows_at(rows, y, offset), &source, (size_t)(y - part->data_window.y0) * width, width,
                p->half);
    }
    return CAU_OK;
}

static cau_result write_part(
    ExrWriter *writer, const ExrHeader *header, size_t index, const ExrPicture *p, CauError *err) {
    const ExrPart *part = &header->parts[index];
    ExrBands bands = exr_bands(part, exr_band_rows(part));
    ExrRows rows = {0};
    cau_result result = CAU_OK;
    for (size_t band = 0; result == CAU_OK && band < bands.count; band++) {
        int32_t y0, y1;
        exr_band_at(&bands, band, &y0, &y1);
        result = exr_rows_reserve(&rows, part, y0, y1, err);
        if (result == CAU_OK) result = fill_rows(&rows, part, p, err);
        if (result == CAU_OK) result = exr_writer_put_rows(writer, index, &rows, err);
    }
    exr_rows_free(&rows);
    return result;
}

static cau_result write_parts(
    ExrWriter *writer, const ExrHeader *header, const ExrPicture *p, CauError *err) {
    for (size_t i = 0; i < header->part_count; i++) CAU_TRY(write_part(writer, header, i, p, err));
    return CAU_OK;
}

static cau_result write_file(const char *path, const ExrHeader *header, const ExrPicture *p, CauError *err) {
    FileAtomic file;
    ExrWriter *writer = NULL;
    CAU_TRY(file_atomic_begin(&file, path, err));
    cau_result result = exr_writer_open(&writer, file.temp_path, path, header, err);
    if (result == CAU_OK) result = write_parts(writer, header, p, err);
    if (result == CAU_OK)
        result = exr_writer_close(&writer, err);
    else
        exr_writer_abort(&writer);
    if (result == CAU_OK) return file_atomic_commit(&file, err);
    file_atomic_abort(&file);
    return result;
}

cau_result exr_write(const char *path, const ExrPicture *picture, ExrWriteReport *report, CauError *err) {
    ExrWriteReport counted = {0};
    ExrHeader header = {0};
    CAU_TRY(check_picture(picture, err));
    cau_result result = build_header(&header, picture, err);
    if (result == CAU_OK) result = count_repairs(&header, picture, &counted, err);
    if (result == CAU_OK) result = write_file(path, &header, picture, err);
    exr_header_free(&header);
    if (report) *report = counted;
    return result;
}
