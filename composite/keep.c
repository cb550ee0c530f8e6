/* SPDX-License-Identifier: Apache-2.0 */
/* The caustic layers as parts of the output: as they were rendered, in the beauty's space and pixels. */
#include "composite/stream.h"

#include "core/checked.h"
#include "image/exr_samples.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

static cau_result no_memory(const Job *job) {
    return error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for the layers that are kept");
}

static bool is_named(const Picture *p, const char *pass) {
    for (size_t i = 0; i < p->layers.count; i++)
        if (strcmp(p->layers.layers[i].pass, pass) == 0) return true;
    return false;
}

/* Radiance and irradiance can be converted; a standard error cannot. */
static bool convertible(const char *layer) {
    char light[512];
    cau_layer_kind kind;
    return strlen(layer) < sizeof light && layer_name_parse(layer, light, &kind) && kind != CAU_LAYER_ERROR &&
           kind != CAU_LAYER_BIAS;
}

static bool is_light_layer(const Job *job, int layer) {
    for (size_t i = 0; i < job->lights.count; i++) {
        const Light *l = &job->lights.lights[i];
        if (l->radiance == layer || l->indirect == layer || l->irradiance == layer || l->seen == layer)
            return true;
    }
    return false;
}

cau_result keep_choose(Job *job) {
    const ExrLayers *all = &job->caustics.layers;
    bool same;
    CAU_TRY(colour_matrix(
        job->colour, job->caustics_space, job->beauty_space, job->keep_matrix, &same, job->err));
    job->kept = array_new(all->count, sizeof *job->kept);
    if (!job->kept) return no_memory(job);
    for (size_t i = 0; i < all->count; i++) {
        const char *pass = all->layers[i].pass;
        bool light = is_light_layer(job, (int)i),
             named = strncmp(pass, CAU_LAYER_PREFIX, strlen(CAU_LAYER_PREFIX)) == 0;
        if (!exr_layer_is_rgb(&all->layers[i]) || !(light || named)) continue;
        if (is_named(&job->beauty, pass))
            return error_set(job->err, CAU_ERROR_INPUT,
                "--keep-layers: \"%s\" has a layer \"%s\" already; add to the picture that was rendered",
                job->options->beauty, pass);
        if (!same && !light && !convertible(pass)) {
            job_notice(
                job, "layer %s is not kept: an error cannot be converted to \"%s\"", pass, job->beauty_space);
            continue;
        }
        job->kept[job->kept_count++] = (Kept){.layer = (int)i, .convert = !same};
    }
    return CAU_OK;
}

/* Attributes that all parts of a file share. */
static cau_result copy_shared(ExrPart *to, const ExrPart *from, CauError *err) {
    static const char *const names[] = {"chromaticities", "timeCode"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const ExrAttr *attr = exr_attr_find(from, names[i]);
        if (attr) CAU_TRY(exr_attr_set(to, attr->name, attr->type, attr->data, attr->size, err));
    }
    return CAU_OK;
}

static cau_result add_part(const Job *job, ExrPart *part, const ExrPart *first, const Kept *kept) {
    const ExrLayer *layer = &job->caustics.layers.layers[kept->layer];
    const ExrPart *from = &job->caustics.header->parts[layer->part];
    const char *pass = layer->pass;
    ExrBox w = from->data_window;
    *part = (ExrPart){.codec = exr_codec_is_lossy(from->codec) ? EXR_CODEC_ZIP : from->codec,
        .data_window = {w.x0 - job->shift_x, w.y0 - job->shift_y, w.x1 - job->shift_x, w.y1 - job->shift_y},
        .display_window = first->display_window,
        .pixel_aspect = first->pixel_aspect,
        .screen_width = 1};
    CAU_TRY(exr_part_set_name(part, pass, job->err));
    for (int c = 0; c < 3; c++) {
        char name[300];
        snprintf(name, sizeof name, "%.255s.%c", pass, "RGB"[c]);
        CAU_TRY(exr_part_add_channel(part, name, from->channels[layer->rgb[c]].type, job->err));
    }
    return copy_shared(part, first, job->err);
}

/* What the renderer said of its layers goes with them. */
static cau_result copy_words(const Job *job, ExrPart *first) {
    const ExrPart *from = &job->caustics.header->parts[0];
    for (size_t a = 0; a < from->attr_count; a++) {
        const ExrAttr *attr = &from->attrs[a];
        if (strncmp(attr->name, "caustics/", 9) != 0 || exr_attr_find(first, attr->name)) continue;
        CAU_TRY(exr_attr_set(first, attr->name, attr->type, attr->data, attr->size, job->err));
    }
    return CAU_OK;
}

/* The list names kept layers only. */
static cau_result write_list(const Job *job, ExrPart *first) {
    char *json = exr_attr_text(exr_attr_find(first, CAU_ATTRIBUTE_LAYERS));
    LayerList all = {0}, kept = {0};
    if (!json) return CAU_OK;
    cau_result result = layer_list_decode(&all, json, job->err);
    free(json);
    for (size_t i = 0; result == CAU_OK && i < all.count; i++)
        for (size_t k = 0; k < job->kept_count; k++) {
            const char *pass = job->caustics.layers.layers[job->kept[k].layer].pass;
            if (strcmp(pass, all.entries[i].layer) == 0)
                result = layer_list_add(&kept, pass, all.entries[i].light, all.entries[i].kind, job->err);
        }
    json = result == CAU_OK ? layer_list_encode(&kept) : NULL;
    if (result == CAU_OK)
        result = json ? exr_attr_set_text(first, CAU_ATTRIBUTE_LAYERS, json, job->err) : no_memory(job);
    free(json);
    layer_list_free(&all);
    layer_list_free(&kept);
    return result;
}

cau_result keep_header(const Job *job, ExrHeader *header) {
    size_t before = header->part_count;
    ExrPart *parts = realloc(header->parts, (before + job->kept_count) * sizeof *parts);
    if (!parts) return no_memory(job);
    header->parts = parts;
    memset(parts + before, 0, job->kept_count * sizeof *parts);
    header->part_count += job->kept_count;
    /* A file of several parts names them all. */
    if (!parts[0].name || !parts[0].name[0]) CAU_TRY(exr_part_set_name(&parts[0], "beauty", job->err));
    for (size_t k = 0; k < job->kept_count; k++)
        CAU_TRY(add_part(job, &parts[before + k], &parts[0], &job->kept[k]));
    CAU_TRY(copy_words(job, &parts[0]));
    return write_list(job, &parts[0]);
}

/* The chunks can be taken as they are. */
static bool as_it_is(const Job *job, const Kept *kept, const ExrPart *out) {
    const ExrLayer *layer = &job->caustics.layers.layers[kept->layer];
    const ExrPart *in = &job->caustics.header->parts[layer->part];
    return !kept->convert && !in->tiled && in->codec == out->codec && in->channel_count == 3 &&
           in->order == EXR_ORDER_INCREASING;
}

static void store(uint8_t *row, size_t at, double v, ExrPixelType type) {
    double largest = type == EXR_TYPE_HALF ? (double)HALF_LARGEST : (double)FLT_MAX;
    if (fabs(v) > largest) v = copysign(largest, v);
    uint16_t h = type == EXR_TYPE_HALF ? half_from_double(v) : 0;
    float f = (float)v;
    if (type == EXR_TYPE_HALF)
        memcpy(row + at * sizeof h, &h, sizeof h);
    else
        memcpy(row + at * sizeof f, &f, sizeof f);
}

static void convert_row(const double m[9], uint8_t *const to[3], const uint8_t *const from[3],
    const ExrPixelType types[3], size_t width) {
    for (size_t i = 0; i < width; i++) {
        double in[3];
        for (int c = 0; c < 3; c++) in[c] = exr_sample(from[c], i, types[c]);
        for (int c = 0; c < 3; c++)
            store(to[c], i, m[3 * c] * in[0] + m[3 * c + 1] * in[1] + m[3 * c + 2] * in[2], types[c]);
    }
}

static cau_result make_rows(
    const Job *job, const Kept *kept, const ExrPart *out, Lane *lane, int32_t y0, int32_t y1, CauError *err) {
    const ExrLayer *layer = &job->caustics.layers.layers[kept->layer];
    const ExrPart *in = &job->caustics.header->parts[layer->part];
    size_t width = (size_t)exr_box_width(out->data_window);
    CAU_TRY(source_load(&lane->caustics, layer->part, err));
    CAU_TRY(exr_rows_reserve(&lane->kept, out, y0, y1, err));
    const ExrRows *rows = &lane->caustics.rows[layer->part];
    for (int64_t y = y0; y <= y1; y++) {
        const uint8_t *from[3];
        uint8_t *to[3];
        ExrPixelType types[3];
        for (int c = 0; c < 3; c++) {
            size_t channel = (size_t)layer->rgb[c], own = (size_t)(2 - c); /* sorted by name: B, G, R */
            from[c] = exr_rows_at(rows, y + job->shift_y, exr_channel_offset(in, channel));
            to[c] = exr_rows_at(&lane->kept, y, exr_channel_offset(out, own));
            types[c] = in->channels[channel].type;
            if (!kept->convert) memcpy(to[c], from[c], width * exr_type_bytes(types[c]));
        }
        if (kept->convert) convert_row(job->keep_matrix, to, (const uint8_t *const *)from, types, width);
    }
    return CAU_OK;
}

cau_result keep_band(const Job *job, const ExrHeader *header, size_t index, Lane *lane, int32_t y0,
    int32_t y1, CauError *err) {
    const Kept *kept = &job->kept[index];
    size_t part = job->beauty.header->part_count + index;
    const ExrPart *out = &header->parts[part];
    if (lane->encoder && as_it_is(job, kept, out))
        return exr_decoder_packed(lane->caustics.decoder, job->caustics.layers.layers[kept->layer].part,
            y0 + job->shift_y, y1 + job->shift_y, &lane->packed, err);
    CAU_TRY(make_rows(job, kept, out, lane, y0, y1, err));
    if (lane->encoder) return exr_encoder_pack(lane->encoder, part, &lane->kept, &lane->packed, err);
    lane->ready = &lane->kept;
    return CAU_OK;
}
