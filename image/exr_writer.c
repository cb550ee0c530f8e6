/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_writer_private.h"

#include "core/checked.h"
#include "image/exr_attr_io.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <unistd.h>

static cau_result failed(ExrWriter *w, exr_result_t code, CauError *err) {
    return exr_core_error(&w->file, code, "write", w->shown, err);
}

static bool needs_long_names(const ExrHeader *header) {
    for (size_t i = 0; i < header->part_count; i++) {
        const ExrPart *part = &header->parts[i];
        for (size_t c = 0; c < part->channel_count; c++)
            if (strlen(part->channels[c].name) > 31) return true;
        for (size_t a = 0; a < part->attr_count; a++)
            if (strlen(part->attrs[a].name) > 31 || strlen(part->attrs[a].type) > 31) return true;
    }
    return false;
}

static exr_result_t define_channels(ExrWriter *w, int index, const ExrPart *part) {
    for (size_t c = 0; c < part->channel_count; c++) {
        const ExrChannel *channel = &part->channels[c];
        exr_result_t code = exr_add_channel(w->context, index, channel->name, (exr_pixel_type_t)channel->type,
            channel->p_linear ? EXR_PERCEPTUALLY_LINEAR : EXR_PERCEPTUALLY_LOGARITHMIC, channel->x_sampling,
            channel->y_sampling);
        if (code != EXR_ERR_SUCCESS) return code;
    }
    return EXR_ERR_SUCCESS;
}

static exr_attr_box2i_t core_box(ExrBox b) {
    exr_attr_box2i_t box;
    box.min.x = b.x0;
    box.min.y = b.y0;
    box.max.x = b.x1;
    box.max.y = b.y1;
    return box;
}

static cau_result define_part(ExrWriter *w, const ExrPart *part, CauError *err) {
    int index = 0;
    exr_attr_box2i_t data = core_box(part->data_window), display = core_box(part->display_window);
    exr_attr_v2f_t center;
    center.x = part->screen_center[0];
    center.y = part->screen_center[1];
    exr_result_t code =
        exr_add_part(w->context, part->name, part->tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &index);
    if (code == EXR_ERR_SUCCESS)
        code = exr_initialize_required_attr(w->context, index, &display, &data, part->pixel_aspect, &center,
            part->screen_width, (exr_lineorder_t)part->order, (exr_compression_t)part->codec);
    if (code == EXR_ERR_SUCCESS && part->tiled)
        code = exr_set_tile_descriptor(
            w->context, index, part->tile_width, part->tile_height, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN);
    if (code == EXR_ERR_SUCCESS) code = define_channels(w, index, part);
    if (code != EXR_ERR_SUCCESS) return failed(w, code, err);
    for (size_t a = 0; a < part->attr_count; a++) {
        code = exr_attr_to_core(w->context, index, &part->attrs[a]);
        if (code == EXR_ERR_SUCCESS) continue;
        failed(w, code, err);
        error_prefix(err, "attribute \"%s\" of type \"%s\": ", part->attrs[a].name, part->attrs[a].type);
        return code == EXR_ERR_OUT_OF_MEMORY ? CAU_ERROR_RESOURCE : CAU_ERROR_INPUT;
    }
    return CAU_OK;
}

static cau_result define(ExrWriter *w, CauError *err) {
    if (needs_long_names(w->header)) exr_set_longname_support(w->context, 1);
    for (size_t i = 0; i < w->header->part_count; i++) CAU_TRY(define_part(w, &w->header->parts[i], err));
    exr_result_t code = exr_write_header(w->context);
    return code == EXR_ERR_SUCCESS ? CAU_OK : failed(w, code, err);
}

/* OpenEXRCore 3.1 has neither B44 nor DWA encoders and writes rows from the top only. */
static bool core_can_write(const ExrHeader *header) {
    for (size_t i = 0; i < header->part_count; i++)
        if (header->parts[i].codec >= EXR_CODEC_B44 || header->parts[i].order == EXR_ORDER_DECREASING)
            return false;
    return true;
}

static cau_result open_file(ExrWriter *w, const char *path, const char *shown, CauError *err) {
    w->shown = string_copy(shown);
    if (!w->shown) return error_set(err, CAU_ERROR_RESOURCE, "cannot write \"%s\": out of memory", shown);
    if (!core_can_write(w->header)) return imf_writer_open(&w->imf, path, shown, w->header, err);
    CAU_TRY(exr_core_open_write(&w->context, &w->file, path, err));
    return define(w, err);
}

cau_result exr_writer_open(
    ExrWriter **out, const char *path, const char *shown, const ExrHeader *header, CauError *err) {
    *out = NULL;
    ExrWriter *w = array_new(1, sizeof *w);
    if (!w) return error_set(err, CAU_ERROR_RESOURCE, "cannot write \"%s\": out of memory", shown);
    w->header = header;
    w->file.fd = -1;
    cau_result result = open_file(w, path, shown, err);
    if (result != CAU_OK)
        exr_writer_abort(&w);
    else
        *out = w;
    return result;
}

bool exr_writer_takes_packed(const ExrWriter *writer) { return !writer->imf; }

cau_result exr_writer_put_packed(
    ExrWriter *w, size_t part, int32_t y0, const ExrPacked *packed, CauError *err) {
    const ExrPart *p = &w->header->parts[part];
    size_t columns = (size_t)exr_chunk_columns(p), begin = 0;
    if (w->imf) return error_set(err, CAU_ERROR_INTERNAL, "\"%s\" takes rows only", w->shown);
    for (size_t i = 0; i < packed->count; i++) {
        const uint8_t *bytes = packed->bytes + begin;
        size_t size = packed->ends[i] - begin;
        int row = (int)((y0 - (int64_t)p->data_window.y0) / exr_chunk_rows(p) + (int64_t)(i / columns));
        exr_result_t code =
            p->tiled ? exr_write_tile_chunk(w->context, (int)part, (int)(i % columns), row, 0, 0, bytes, size)
                     : exr_write_scanline_chunk(
                           w->context, (int)part, p->data_window.y0 + row * exr_chunk_rows(p), bytes, size);
        if (code != EXR_ERR_SUCCESS) return failed(w, code, err);
        begin = packed->ends[i];
    }
    return CAU_OK;
}

cau_result exr_writer_put_rows(ExrWriter *w, size_t part, const ExrRows *rows, CauError *err) {
    if (w->imf) return imf_writer_rows(w->imf, part, rows, err);
    if (!w->encoder) CAU_TRY(exr_encoder_create(&w->encoder, w, err));
    CAU_TRY(exr_encoder_pack(w->encoder, part, rows, &w->packed, err));
    return exr_writer_put_packed(w, part, rows->y0, &w->packed, err);
}

static void destroy(ExrWriter **writer) {
    free((*writer)->shown);
    free(*writer);
    *writer = NULL;
}

cau_result exr_writer_close(ExrWriter **writer, CauError *err) {
    ExrWriter *w = *writer;
    exr_encoder_free(&w->encoder);
    exr_packed_free(&w->packed);
    cau_result result =
        w->imf ? imf_writer_close(&w->imf, err) : exr_core_close(&w->context, &w->file, w->shown, err);
    destroy(writer);
    return result;
}

void exr_writer_abort(ExrWriter **writer) {
    if (!*writer) return;
    exr_writer_close(writer, NULL);
}

/* Reads from `at` on until a zero byte; false when there is none within the room. */
static bool read_text(int fd, off_t at, char *text, size_t room) {
    ssize_t n = pread(fd, text, room, at);
    return n > 0 && memchr(text, 0, (size_t)n);
}

/* Where the value of an attribute of the first part begins; 0 when it is not there. */
static off_t find_value(int fd, const char *wanted, const char *wanted_type) {
    char name[257], type[257];
    off_t at = 8; /* behind the magic number and the version */
    while (read_text(fd, at, name, sizeof name) && name[0]) {
        at += (off_t)strlen(name) + 1;
        int32_t size;
        if (!read_text(fd, at, type, sizeof type)) return 0;
        at += (off_t)strlen(type) + 1;
        if (pread(fd, &size, sizeof size, at) != sizeof size || size < 0) return 0;
        at += (off_t)sizeof size;
        if (strcmp(name, wanted) == 0) return strcmp(type, wanted_type) == 0 ? at : 0;
        at += size;
    }
    return 0;
}

cau_result exr_writer_patch_int(
    const char *path, const char *shown, const char *name, int32_t value, CauError *err) {
    int fd = open(path, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (fd < 0) return error_set(err, CAU_ERROR_RESOURCE, "cannot write \"%s\": %s", shown, strerror(errno));
    off_t at = find_value(fd, name, "int");
    bool done = at && pwrite(fd, &value, sizeof value, at) == sizeof value;
    int cause = errno;
    if (close(fd) != 0) done = false;
    if (done) return CAU_OK;
    return at ? error_set(err, CAU_ERROR_RESOURCE, "cannot write \"%s\": %s", shown, strerror(cause))
              : error_set(err, CAU_ERROR_INTERNAL, "\"%s\" has no attribute \"%s\"", shown, name);
}
