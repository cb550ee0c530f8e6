/* SPDX-License-Identifier: Apache-2.0 */
#include "composite/source.h"

#include "core/checked.h"
#include "image/exr_samples.h"

cau_result source_create(
    Source *out, const Picture *picture, int64_t shift_x, int64_t shift_y, CauError *err) {
    size_t parts = picture->header->part_count;
    *out = (Source){.picture = picture,
        .rows = array_new(parts, sizeof *out->rows),
        .loaded = array_new(parts, sizeof *out->loaded),
        .shift_x = shift_x,
        .shift_y = shift_y};
    if (!out->rows || !out->loaded)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu parts", parts);
    return exr_decoder_create(&out->decoder, picture->reader, err);
}

void source_free(Source *source) {
    for (size_t i = 0; source->rows && i < source->picture->header->part_count; i++)
        exr_rows_free(&source->rows[i]);
    free(source->rows);
    free(source->loaded);
    exr_decoder_free(&source->decoder);
    *source = (Source){0};
}

void source_begin(Source *source, int64_t y0, int64_t y1) {
    source->y0 = y0;
    source->y1 = y1;
    for (size_t i = 0; i < source->picture->header->part_count; i++) source->loaded[i] = false;
}

cau_result source_load(Source *source, size_t part, CauError *err) {
    if (source->loaded[part]) return CAU_OK;
    ExrBox window = source->picture->header->parts[part].data_window;
    int64_t y0 = source->y0 + source->shift_y, y1 = source->y1 + source->shift_y;
    if (y0 < window.y0) y0 = window.y0;
    if (y1 > window.y1) y1 = window.y1;
    if (y0 > y1) return CAU_OK;
    CAU_TRY(exr_decoder_rows(source->decoder, part, (int32_t)y0, (int32_t)y1, &source->rows[part], err));
    source->loaded[part] = true;
    return CAU_OK;
}

/* Columns of the window that x0.. covers: the first, counted from the window's left, and how many; *skip of
 * those asked for lie to the left of it. */
static size_t overlap(ExrBox window, int64_t x0, size_t count, size_t *first, size_t *skip) {
    int64_t a = x0 > window.x0 ? x0 : window.x0, b = x0 + (int64_t)count - 1;
    if (b > window.x1) b = window.x1;
    if (a > b) return 0;
    *first = (size_t)(a - window.x0);
    *skip = (size_t)(a - x0);
    return (size_t)(b - a + 1);
}

void source_row(const Source *s, size_t part, int channel, int64_t y, int64_t x0, size_t count, double *out) {
    const ExrPart *p = &s->picture->header->parts[part];
    const ExrRows *rows = &s->rows[part];
    size_t first = 0, skip = 0, n = 0;
    int64_t row = y + s->shift_y;
    if (s->loaded[part] && row >= rows->y0 && row <= rows->y1)
        n = overlap(p->data_window, x0 + s->shift_x, count, &first, &skip);
    for (size_t i = 0; i < (n ? skip : count); i++) out[i] = 0;
    if (!n) return;
    ExrPixelType type = p->channels[channel].type;
    const uint8_t *from = exr_rows_at(rows, row, exr_channel_offset(p, (size_t)channel));
    exr_samples(out + skip, from + first * exr_type_bytes(type), n, type);
    for (size_t i = skip + n; i < count; i++) out[i] = 0;
}

static bool all_zero(const uint8_t *bytes, size_t count) {
    return bytes[0] == 0 && memcmp(bytes, bytes + 1, count - 1) == 0;
}

bool source_any(const Source *s, const ExrLayer *layer, int64_t x0, size_t count) {
    const ExrPart *p = &s->picture->header->parts[layer->part];
    const ExrRows *rows = &s->rows[layer->part];
    size_t first = 0, skip = 0, n = overlap(p->data_window, x0 + s->shift_x, count, &first, &skip);
    if (!s->loaded[layer->part] || !n) return false;
    for (int c = 0; c < 3; c++) {
        size_t bytes = exr_type_bytes(p->channels[layer->rgb[c]].type);
        size_t offset = exr_channel_offset(p, (size_t)layer->rgb[c]) + first * bytes;
        for (int64_t y = rows->y0; y <= rows->y1; y++)
            if (!all_zero(exr_rows_at(rows, y, offset), n * bytes)) return true;
    }
    return false;
}
