/* SPDX-License-Identifier: Apache-2.0 */
/* Several renders of one scene become one: the mean of each layer, weighted by photons. */
#include "composite/source.h"
#include "core/checked.h"
#include "core/file_atomic.h"
#include "core/ordered.h"
#include "image/exr_samples.h"

#include <ctype.h>
#include <float.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>

typedef struct Shard {
    Picture picture;
    char *seed, *shard; /* what makes its photons its own; NULL */
    double photons, weight;
} Shard;

/* What one thread works with. */
typedef struct Desk {
    Source *sources; /* one per shard */
    ExrEncoder *encoder;
    ExrRows rows;
    ExrPacked packed;
    double *sum, *in;
    uint64_t repaired, clamped;
} Desk;

typedef struct Join {
    const cau_merge_options *options;
    CauError *err;
    Shard *shards;
    size_t count;
    LayerList layers;
    ExrHeader header;
    ExrWriter *writer;
    Desk *desks;
    unsigned desk_count;
    size_t part;
    ExrBands bands;
    uint64_t repaired, clamped;
    bool incomplete;
} Join;

static cau_result no_memory(const Join *j) {
    return error_set(j->err, CAU_ERROR_RESOURCE, "out of memory for %zu shards", j->count);
}

static const char *name_of(const Join *j, size_t i) { return exr_reader_path(j->shards[i].picture.reader); }

static const ExrPart *first_part(const Shard *s) { return &s->picture.header->parts[0]; }

static cau_result read_shard(Join *j, size_t i, const char *file) {
    Shard *s = &j->shards[i];
    CAU_TRY(picture_open(&s->picture, file, j->err));
    CAU_TRY(picture_check_readable(&s->picture, j->err));
    char *photons = exr_attr_text(exr_attr_find(first_part(s), CAU_ATTRIBUTE_PHOTONS)), *end = photons;
    s->photons = photons ? strtod(photons, &end) : 0;
    bool good = photons && end != photons && !*end && s->photons > 0 && isfinite(s->photons);
    free(photons);
    if (!good)
        return error_set(j->err, CAU_ERROR_INPUT,
            "\"%s\" does not say how many photons it was made with (%s), so it cannot be weighed: is it a "
            "render "
            "of caustic-render?",
            file, CAU_ATTRIBUTE_PHOTONS);
    s->seed = exr_attr_text(exr_attr_find(first_part(s), CAU_ATTRIBUTE_SEED));
    s->shard = exr_attr_text(exr_attr_find(first_part(s), CAU_ATTRIBUTE_SHARD));
    int32_t complete = 1;
    exr_attr_int32(exr_attr_find(first_part(s), CAU_ATTRIBUTE_COMPLETE), &complete);
    if (complete) return CAU_OK;
    j->incomplete = true;
    if (j->options->allow_incomplete) return CAU_OK;
    return error_set(j->err, CAU_ERROR_INPUT,
        "\"%s\" is the state of a render that was stopped (%s is 0): finish it, or accept it with "
        "--allow-incomplete",
        file, CAU_ATTRIBUTE_COMPLETE);
}

/* Attributes that differ between shards of one render. */
static bool may_differ(const char *name) {
    static const char *const names[] = {CAU_ATTRIBUTE_SEED, CAU_ATTRIBUTE_SHARD, CAU_ATTRIBUTE_PHOTONS,
        CAU_ATTRIBUTE_ERROR, CAU_ATTRIBUTE_REPAIRED_NAN, CAU_ATTRIBUTE_CLAMPED, CAU_ATTRIBUTE_COMPLETE,
        CAU_ATTRIBUTE_STAMP, "caustics/repairs"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(name, names[i]) == 0) return true;
    return false;
}

static cau_result differ(const Join *j, size_t i, const char *what, const ExrAttr *a, const ExrAttr *b) {
    char *x = exr_attr_text(a), *y = exr_attr_text(b);
    bool show = x && y && strlen(x) < 100 && strlen(y) < 100;
    error_set(j->err, CAU_ERROR_INPUT, "\"%s\" and \"%s\" are not of one render: %s differs%s%s%s%s%s",
        name_of(j, 0), name_of(j, i), what, show ? ", \"" : "", show ? x : "", show ? "\" against \"" : "",
        show ? y : "", show ? "\"" : "");
    free(x);
    free(y);
    return CAU_ERROR_INPUT;
}

/* A plan holds shares that its probes estimated, which differ from seed to seed: all else must be the same.
 */
static bool same_plan(const ExrAttr *a, const ExrAttr *b) {
    const char *x = a->data, *y = b->data, *x_end = x + a->size, *y_end = y + b->size;
    for (;;) {
        while (x < x_end && (isdigit((unsigned char)*x) || strchr(".+-", *x))) x++;
        while (y < y_end && (isdigit((unsigned char)*y) || strchr(".+-", *y))) y++;
        if (x == x_end || y == y_end) return x == x_end && y == y_end;
        if (*x++ != *y++) return false;
    }
}

static cau_result compare_attrs(const Join *j, size_t i) {
    const ExrPart *a = first_part(&j->shards[0]), *b = first_part(&j->shards[i]);
    const ExrPart *both[2][2] = {{a, b}, {b, a}};
    for (int k = 0; k < 2; k++)
        for (size_t n = 0; n < both[k][0]->attr_count; n++) {
            const ExrAttr *attr = &both[k][0]->attrs[n], *other = exr_attr_find(both[k][1], attr->name);
            bool ours =
                strncmp(attr->name, "caustics/", 9) == 0 || strcmp(attr->name, CAU_ATTRIBUTE_COLOR_ID) == 0;
            if (!ours || may_differ(attr->name)) continue;
            if (other && strcmp(attr->name, CAU_ATTRIBUTE_PLAN) == 0 && same_plan(attr, other)) continue;
            if (!other || other->size != attr->size || memcmp(other->data, attr->data, attr->size) != 0)
                return differ(j, i, attr->name, k ? other : attr, k ? attr : other);
        }
    return CAU_OK;
}

static cau_result compare_parts(const Join *j, size_t i) {
    const ExrHeader *a = j->shards[0].picture.header, *b = j->shards[i].picture.header;
    if (a->part_count != b->part_count) return differ(j, i, "the number of layers", NULL, NULL);
    for (size_t p = 0; p < a->part_count; p++) {
        const ExrPart *x = &a->parts[p], *y = &b->parts[p];
        if (!exr_box_equal(x->data_window, y->data_window) ||
            !exr_box_equal(x->display_window, y->display_window))
            return differ(j, i, "the resolution or region", NULL, NULL);
        if (x->channel_count != y->channel_count) return differ(j, i, "the list of channels", NULL, NULL);
        for (size_t c = 0; c < x->channel_count; c++)
            if (strcmp(x->channels[c].name, y->channels[c].name) != 0 ||
                x->channels[c].type != y->channels[c].type)
                return differ(j, i, "the list of channels", NULL, NULL);
    }
    return CAU_OK;
}

static bool same_text(const char *a, const char *b) { return strcmp(a ? a : "", b ? b : "") == 0; }

static cau_result compare(const Join *j) {
    for (size_t i = 1; i < j->count; i++) {
        CAU_TRY(compare_attrs(j, i));
        CAU_TRY(compare_parts(j, i));
        for (size_t k = 0; k < i; k++)
            if (same_text(j->shards[i].seed, j->shards[k].seed) &&
                same_text(j->shards[i].shard, j->shards[k].shard))
                return error_set(j->err, CAU_ERROR_INPUT,
                    "\"%s\" and \"%s\" hold the same photons: both have seed %s%s%s; render them with "
                    "different "
                    "seeds",
                    name_of(j, k), name_of(j, i), j->shards[i].seed ? j->shards[i].seed : "(none)",
                    j->shards[i].shard ? " and shard " : "", j->shards[i].shard ? j->shards[i].shard : "");
    }
    return CAU_OK;
}

static cau_result open_all(Join *j, const char *const *files) {
    double photons = 0;
    j->shards = array_new(j->count, sizeof *j->shards);
    if (!j->shards) return no_memory(j);
    for (size_t i = 0; i < j->count; i++) {
        CAU_TRY(read_shard(j, i, files[i]));
        photons += j->shards[i].photons;
    }
    for (size_t i = 0; i < j->count; i++) j->shards[i].weight = j->shards[i].photons / photons;
    CAU_TRY(compare(j));
    char *json = exr_attr_text(exr_attr_find(first_part(&j->shards[0]), CAU_ATTRIBUTE_LAYERS));
    cau_result result = json ? layer_list_decode(&j->layers, json, j->err) : CAU_OK;
    free(json);
    return result;
}

/* Errors add in squares: they are independent. */
static bool is_error(const Join *j, const char *channel) {
    char layer[300], light[300];
    const char *dot = strrchr(channel, '.');
    cau_layer_kind kind;
    if (!dot || dot - channel >= (long)sizeof layer) return false;
    snprintf(layer, sizeof layer, "%.*s", (int)(dot - channel), channel);
    for (size_t i = 0; i < j->layers.count; i++)
        if (strcmp(j->layers.entries[i].layer, layer) == 0)
            return j->layers.entries[i].kind == CAU_LAYER_ERROR;
    return layer_name_parse(layer, light, &kind) && kind == CAU_LAYER_ERROR;
}

/* {"key": {"direct": 0.01}}: relative errors of independent means, each of its own. */
static char *combined_errors(const Join *j) {
    json_t *all = json_object(), *value, *inner;
    const char *light, *key;
    for (size_t i = 0; i < j->count; i++) {
        char *text = exr_attr_text(exr_attr_find(first_part(&j->shards[i]), CAU_ATTRIBUTE_ERROR));
        json_t *one = text ? json_loads(text, 0, NULL) : NULL;
        free(text);
        json_object_foreach(one, light, inner) {
            if (!json_object_get(all, light)) json_object_set_new(all, light, json_object());
            json_t *out = json_object_get(all, light);
            json_object_foreach(inner, key, value) {
                double before = json_number_value(json_object_get(out, key)),
                       e = json_number_value(value) * j->shards[i].weight;
                json_object_set_new(out, key, json_real(sqrt(before * before + e * e)));
            }
        }
        json_decref(one);
    }
    char *text = json_dumps(all, JSON_COMPACT);
    json_decref(all);
    return text;
}

/* The seeds or shards of all, with commas; NULL when none says. */
static char *joined(const Join *j, size_t offset) {
    size_t room = 1;
    for (size_t i = 0; i < j->count; i++) {
        char *text;
        memcpy(&text, (const char *)&j->shards[i] + offset, sizeof text);
        if (!text) return NULL;
        room += strlen(text) + 1;
    }
    char *out = array_new(room, 1), *at = out;
    for (size_t i = 0; out && i < j->count; i++) {
        char *text;
        memcpy(&text, (const char *)&j->shards[i] + offset, sizeof text);
        at += snprintf(at, room - (size_t)(at - out), "%s%s", i ? "," : "", text);
    }
    return out;
}

static cau_result set_text(Join *j, const char *name, char *text) {
    cau_result result = text ? exr_attr_set_text(&j->header.parts[0], name, text, j->err) : CAU_OK;
    free(text);
    return result;
}

static cau_result build_header(Join *j) {
    char photons[32];
    double sum = 0;
    CAU_TRY(exr_header_copy(&j->header, j->shards[0].picture.header, j->err));
    for (size_t i = 0; i < j->count; i++) sum += j->shards[i].photons;
    snprintf(photons, sizeof photons, "%.0f", sum);
    for (size_t i = 0; i < j->header.part_count; i++) {
        ExrPart *part = &j->header.parts[i];
        ExrCodec codec = exr_codec_is_lossy(part->codec) ? EXR_CODEC_ZIP : part->codec;
        if (j->options->compression && !exr_codec_from_name(j->options->compression, &codec))
            return error_set(j->err, CAU_ERROR_USAGE,
                "unknown compression \"%s\", not one of none, rle, zips, zip, piz, pxr24, b44, b44a, dwaa, "
                "dwab",
                j->options->compression);
        part->codec = codec;
        part->levels = EXR_LEVELS_ONE;
    }
    ExrPart *first = &j->header.parts[0];
    exr_attr_remove(first, CAU_ATTRIBUTE_SHARD);
    exr_attr_remove(first, "caustics/repairs"); /* of one of them */
    CAU_TRY(exr_attr_set_text(first, CAU_ATTRIBUTE_PHOTONS, photons, j->err));
    CAU_TRY(set_text(j, CAU_ATTRIBUTE_SEED, joined(j, offsetof(Shard, seed))));
    CAU_TRY(set_text(j, CAU_ATTRIBUTE_SHARD, joined(j, offsetof(Shard, shard))));
    CAU_TRY(set_text(j, CAU_ATTRIBUTE_ERROR, combined_errors(j)));
    CAU_TRY(exr_attr_set_int32(first, CAU_ATTRIBUTE_COMPLETE, !j->incomplete, j->err));
    CAU_TRY(exr_attr_set_int32(first, CAU_ATTRIBUTE_REPAIRED_NAN, 0, j->err));
    return exr_attr_set_int32(first, CAU_ATTRIBUTE_CLAMPED, 0, j->err);
}

static uint64_t store(uint8_t *row, size_t at, double v, ExrPixelType type) {
    double largest = type == EXR_TYPE_HALF ? (double)HALF_LARGEST : (double)FLT_MAX;
    bool over = fabs(v) > largest;
    if (over) v = copysign(largest, v);
    uint16_t h = type == EXR_TYPE_HALF ? half_from_double(v) : 0;
    float f = (float)v;
    if (type == EXR_TYPE_HALF)
        memcpy(row + at * sizeof h, &h, sizeof h);
    else
        memcpy(row + at * sizeof f, &f, sizeof f);
    return over;
}

static void join_row(const Join *j, Desk *desk, size_t channel, int64_t y, bool error) {
    const ExrPart *part = &j->header.parts[j->part];
    size_t width = (size_t)exr_box_width(part->data_window);
    uint8_t *row = exr_rows_at(&desk->rows, y, exr_channel_offset(part, channel));
    for (size_t x = 0; x < width; x++) desk->sum[x] = 0;
    for (size_t i = 0; i < j->count; i++) {
        double w = j->shards[i].weight;
        source_row(&desk->sources[i], j->part, (int)channel, y, part->data_window.x0, width, desk->in);
        for (size_t x = 0; x < width; x++) {
            double v = desk->in[x];
            if (!isfinite(v)) {
                v = 0;
                desk->repaired++;
            }
            desk->sum[x] += error ? w * w * v * v : w * v;
        }
    }
    for (size_t x = 0; x < width; x++)
        desk->clamped +=
            store(row, x, error ? sqrt(desk->sum[x]) : desk->sum[x], part->channels[channel].type);
}

static cau_result work(void *data, size_t index, unsigned slot, CauError *err) {
    const Join *j = data;
    Desk *desk = &j->desks[slot];
    const ExrPart *part = &j->header.parts[j->part];
    int32_t y0, y1;
    exr_band_at(&j->bands, index, &y0, &y1);
    for (size_t i = 0; i < j->count; i++) {
        source_begin(&desk->sources[i], y0, y1);
        CAU_TRY(source_load(&desk->sources[i], j->part, err));
    }
    CAU_TRY(exr_rows_reserve(&desk->rows, part, y0, y1, err));
    for (size_t c = 0; c < part->channel_count; c++) {
        bool error = is_error(j, part->channels[c].name);
        for (int64_t y = y0; y <= y1; y++) join_row(j, desk, c, y, error);
    }
    return desk->encoder ? exr_encoder_pack(desk->encoder, j->part, &desk->rows, &desk->packed, err) : CAU_OK;
}

static cau_result take(void *data, size_t index, unsigned slot, CauError *err) {
    Join *j = data;
    Desk *desk = &j->desks[slot];
    const cau_merge_options *o = j->options;
    (void)index;
    j->repaired += desk->repaired;
    j->clamped += desk->clamped;
    desk->repaired = desk->clamped = 0;
    if (o->cancelled && o->cancelled(o->user))
        return error_set(err, CAU_ERROR_CANCELLED, "stopped on request; no output was written or changed");
    if (!desk->encoder) return exr_writer_put_rows(j->writer, j->part, &desk->rows, err);
    return exr_writer_put_packed(j->writer, j->part, desk->rows.y0, &desk->packed, err);
}

static cau_result create_desks(Join *j) {
    size_t width = 0;
    j->desks = array_new(j->desk_count, sizeof *j->desks);
    if (!j->desks) return no_memory(j);
    for (size_t i = 0; i < j->header.part_count; i++)
        if ((size_t)exr_box_width(j->header.parts[i].data_window) > width)
            width = (size_t)exr_box_width(j->header.parts[i].data_window);
    for (unsigned d = 0; d < j->desk_count; d++) {
        Desk *desk = &j->desks[d];
        desk->sources = array_new(j->count, sizeof *desk->sources);
        desk->sum = array_new(width, sizeof *desk->sum);
        desk->in = array_new(width, sizeof *desk->in);
        if (!desk->sources || !desk->sum || !desk->in) return no_memory(j);
        for (size_t i = 0; i < j->count; i++)
            CAU_TRY(source_create(&desk->sources[i], &j->shards[i].picture, 0, 0, j->err));
        if (exr_writer_takes_packed(j->writer))
            CAU_TRY(exr_encoder_create(&desk->encoder, j->writer, j->err));
    }
    return CAU_OK;
}

static void free_desks(Join *j) {
    for (unsigned d = 0; j->desks && d < j->desk_count; d++) {
        Desk *desk = &j->desks[d];
        for (size_t i = 0; desk->sources && i < j->count; i++)
            if (desk->sources[i].picture) source_free(&desk->sources[i]);
        free(desk->sources);
        free(desk->sum);
        free(desk->in);
        exr_encoder_free(&desk->encoder);
        exr_rows_free(&desk->rows);
        exr_packed_free(&desk->packed);
    }
    free(j->desks);
}

static cau_result write_pixels(Join *j) {
    unsigned threads = j->options->threads ? j->options->threads : ordered_processors();
    j->desk_count = threads > 1 ? threads + 1 : 1;
    cau_result result = create_desks(j);
    for (j->part = 0; result == CAU_OK && j->part < j->header.part_count; j->part++) {
        int in = exr_band_rows(&j->shards[0].picture.header->parts[j->part]),
            out = exr_band_rows(&j->header.parts[j->part]);
        j->bands = exr_bands(&j->header.parts[j->part], in > out ? in : out);
        result = ordered_run(threads, j->desk_count, j->bands.count, work, take, NULL, j, j->err);
    }
    free_desks(j);
    return result;
}

static cau_result write_temporary(Join *j, const char *path) {
    const char *shown = j->options->output;
    CAU_TRY(exr_writer_open(&j->writer, path, shown, &j->header, j->err));
    cau_result result = write_pixels(j);
    if (result != CAU_OK) {
        exr_writer_abort(&j->writer);
        return result;
    }
    CAU_TRY(exr_writer_close(&j->writer, j->err));
    if (j->repaired)
        CAU_TRY(exr_writer_patch_int(path, shown, CAU_ATTRIBUTE_REPAIRED_NAN,
            j->repaired > INT32_MAX ? INT32_MAX : (int32_t)j->repaired, j->err));
    if (!j->clamped) return CAU_OK;
    return exr_writer_patch_int(
        path, shown, CAU_ATTRIBUTE_CLAMPED, j->clamped > INT32_MAX ? INT32_MAX : (int32_t)j->clamped, j->err);
}

static cau_result run(Join *j, const char *const *files) {
    FileAtomic file;
    for (size_t i = 0; i < j->count; i++) CAU_TRY(output_check(j->options->output, files[i], j->err));
    CAU_TRY(open_all(j, files));
    CAU_TRY(build_header(j));
    CAU_TRY(file_atomic_begin(&file, j->options->output, j->err));
    cau_result result = write_temporary(j, file.temp_path);
    if (result == CAU_OK) return file_atomic_commit(&file, j->err);
    file_atomic_abort(&file);
    return result;
}

cau_result shards_join(const char *const *files, size_t count, const cau_merge_options *o, CauError *err) {
    Join j = {.options = o, .err = err, .count = count};
    cau_result result = run(&j, files);
    for (size_t i = 0; j.shards && i < count; i++) {
        free(j.shards[i].seed);
        free(j.shards[i].shard);
        picture_close(&j.shards[i].picture);
    }
    free(j.shards);
    layer_list_free(&j.layers);
    exr_header_free(&j.header);
    return result;
}
