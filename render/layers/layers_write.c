/* SPDX-License-Identifier: Apache-2.0 */
/* The last stage: names, metadata, channels -> EXR (DESIGN section 8). */
#include "caustics/render_file.h"
#include "core/checked.h"
#include "image/exr_reader.h"
#include "image/exr_write.h"
#include "image/layer_names.h"
#include "render/scene/scene.h"

#include <inttypes.h>
#include <jansson.h>
#include <stdio.h>
#include <unistd.h>

/* The last digits of a figure depend on the order in which shards were joined. */
enum { FIGURE_DIGITS = 9 };

enum { LAYER_NAME_BYTES = 40, ATTRIBUTES_MAX = 16, STAMP_BYTES = 24 };

typedef struct Out {
    cau_render *render;
    cau_scene *scene;
    CauError *err;
    const cau_write_options *options;
    int width, height, x0, y0, x1, y1; /* data window, inclusive */
    size_t layer_count, light_count;
    LayerBase *bases;     /* [light] */
    ExrLayerData *layers; /* [0] the sum */
    char (*names)[LAYER_NAME_BYTES];
    float **pixels;
    LayerList list;
} Out;

static const char *suffix_of(const cau_layer *l) {
    switch (l->kind) {
    case CAU_LAYER_INDIRECT:
        return CAU_SUFFIX_INDIRECT;
    case CAU_LAYER_IRRADIANCE:
        return CAU_SUFFIX_IRRADIANCE;
    case CAU_LAYER_SEEN:
        return CAU_SUFFIX_SEEN;
    case CAU_LAYER_ERROR:
        return l->indirect ? CAU_SUFFIX_INDIRECT CAU_SUFFIX_ERROR : CAU_SUFFIX_ERROR;
    case CAU_LAYER_BIAS:
        return l->indirect ? CAU_SUFFIX_INDIRECT CAU_SUFFIX_BIAS : CAU_SUFFIX_BIAS;
    default:
        return "";
    }
}

static size_t light_index(const Out *o, const char *light) {
    size_t i = 0;
    while (i < o->light_count && strcmp(cau_render_light(o->render, i).light, light) != 0) i++;
    return i;
}

static cau_result map_names(Out *o) {
    const char **lights = array_new(o->light_count, sizeof *lights);
    o->bases = array_new(o->light_count, sizeof *o->bases);
    cau_result result =
        lights && o->bases ? CAU_OK : error_set(o->err, CAU_ERROR_RESOURCE, "out of memory for layer names");
    for (size_t i = 0; result == CAU_OK && i < o->light_count; i++)
        lights[i] = cau_render_light(o->render, i).light;
    if (result == CAU_OK) result = layer_names_map(lights, o->light_count, o->bases, o->err);
    free(lights);
    return result;
}

/* The part of a full picture inside the data window, moved to the front. */
static void crop(const Out *o, float *pixels) {
    size_t w = (size_t)(o->x1 - o->x0 + 1);
    if (w == (size_t)o->width && o->y0 == 0) return;
    for (int y = o->y0; y <= o->y1; y++)
        memmove(pixels + 3 * w * (size_t)(y - o->y0),
            pixels + 3 * ((size_t)y * (size_t)o->width + (size_t)o->x0), 3 * w * sizeof *pixels);
}

static float *picture_new(const Out *o) {
    return array_new(3 * (size_t)o->width * (size_t)o->height, sizeof(float));
}

static cau_result add_layer(Out *o, size_t index) {
    cau_layer l = cau_render_layer(o->render, index);
    bool beauty = l.kind >= CAU_LAYER_BEAUTY;
    float *pixels = o->pixels[index + 1] = picture_new(o);
    if (!pixels) return error_set(o->err, CAU_ERROR_RESOURCE, "out of memory for layer \"%s\"", l.light);
    CAU_TRY(cau_render_pixels(o->render, index, pixels));
    crop(o, pixels);
    char *name = o->names[index + 1];
    if (beauty)
        snprintf(name, LAYER_NAME_BYTES, l.kind == CAU_LAYER_BEAUTY ? "beauty" : "beauty" CAU_SUFFIX_ERROR);
    else
        snprintf(name, LAYER_NAME_BYTES, "%s%s", o->bases[light_index(o, l.light)].name, suffix_of(&l));
    o->layers[index + 1] = (ExrLayerData){name, "RGB", pixels};
    size_t values = 3 * (size_t)(o->x1 - o->x0 + 1) * (size_t)(o->y1 - o->y0 + 1);
    bool light_layer = l.kind == CAU_LAYER_RADIANCE || l.kind == CAU_LAYER_INDIRECT;
    for (size_t v = 0; (light_layer || l.kind == CAU_LAYER_BEAUTY) && v < values; v++)
        o->pixels[0][v] += pixels[v];
    return beauty ? CAU_OK : layer_list_add(&o->list, name, l.light, (cau_layer_kind)l.kind, o->err);
}

static cau_result gather_layers(Out *o) {
    o->layer_count = cau_render_layer_count(o->render);
    o->layers = array_new(o->layer_count + 1, sizeof *o->layers);
    o->names = array_new(o->layer_count + 1, sizeof *o->names);
    o->pixels = array_new(o->layer_count + 1, sizeof *o->pixels);
    if (o->pixels) o->pixels[0] = picture_new(o);
    if (!o->layers || !o->names || !o->pixels || !o->pixels[0])
        return error_set(o->err, CAU_ERROR_RESOURCE, "out of memory for %zu layers", o->layer_count + 1);
    o->layers[0] = (ExrLayerData){"", "RGB", o->pixels[0]};
    for (size_t i = 0; i < o->layer_count; i++) CAU_TRY(add_layer(o, i));
    return CAU_OK;
}

static json_t *errors_json(const Out *o) {
    json_t *all = json_object();
    for (size_t i = 0; i < o->light_count; i++) {
        cau_light_report r = cau_render_light(o->render, i);
        json_t *one = json_object();
        if (r.relative_error_direct >= 0)
            json_object_set_new(one, "direct", json_real(r.relative_error_direct));
        if (r.relative_error_indirect >= 0)
            json_object_set_new(one, "indirect", json_real(r.relative_error_indirect));
        json_object_set_new(all, r.light, one);
    }
    return all;
}

static json_t *repairs_json(const Out *o) {
    uint64_t non_finite = 0;
    double dropped = 0, emitted = 0;
    for (size_t i = 0; i < o->light_count; i++) {
        cau_light_report r = cau_render_light(o->render, i);
        non_finite += r.direct.non_finite + r.indirect.non_finite;
        dropped += r.direct.dropped + r.indirect.dropped;
        emitted += r.direct.emitted + r.indirect.emitted;
    }
    return json_pack("{s:I, s:f}", "non_finite_deposits", (json_int_t)non_finite, "dropped_flux_share",
        emitted > 0 ? dropped / emitted : 0.0);
}

static char *json_text(json_t *json) {
    char *text = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(FIGURE_DIGITS)) : NULL;
    json_decref(json);
    return text;
}

/* What is rendered, and how it is stored. */
static void make_stamp(const cau_render *render, const cau_write_options *o, char out[STAMP_BYTES]) {
    snprintf(out, STAMP_BYTES, "%016" PRIx64 "%d%d%d", cau_render_stamp(render), o->half != 0,
        o->interleave != 0, o->crop != 0);
}

int cau_render_is_written(const cau_render *render, const char *path, const cau_write_options *options) {
    ExrReader *reader = NULL;
    CauError unused = {0};
    if (access(path, R_OK) != 0 || exr_reader_open(&reader, path, &unused) != CAU_OK) return 0;
    const ExrPart *part = &exr_reader_header(reader)->parts[0];
    char wanted[STAMP_BYTES], *found = exr_attr_text(exr_attr_find(part, CAU_ATTRIBUTE_STAMP));
    int32_t complete = 0;
    make_stamp(render, options, wanted);
    exr_attr_int32(exr_attr_find(part, CAU_ATTRIBUTE_COMPLETE), &complete);
    bool written = complete && found && strcmp(found, wanted) == 0;
    free(found);
    exr_reader_close(&reader);
    return written;
}

static cau_result write_file(Out *o, const char *path) {
    char hash[20], seed[24], photons[24], shard[24];
    size_t known = offsetof(cau_write_options, shard_index);
    char stamp[STAMP_BYTES];
    bool stamped = o->options->size > offsetof(cau_write_options, stamp) && o->options->stamp;
    bool is_shard = o->options->size > known && o->options->shard_count;
    snprintf(hash, sizeof hash, "%016" PRIx64, cau_scene_hash(o->scene));
    snprintf(seed, sizeof seed, "%" PRIu64, o->options->seed);
    snprintf(photons, sizeof photons, "%" PRIu64, o->options->photons);
    if (is_shard) snprintf(shard, sizeof shard, "%u/%u", o->options->shard_index, o->options->shard_count);
    char *list = layer_list_encode(&o->list), *errors = json_text(errors_json(o)),
         *repairs = json_text(repairs_json(o));
    ExrAttribute attributes[ATTRIBUTES_MAX] = {
        {.name = CAU_ATTRIBUTE_LAYERS, .kind = EXR_STRING, .text = list ? list : "[]"},
        {.name = CAU_ATTRIBUTE_COMPLETE, .kind = EXR_INT, .integer = o->options->complete},
        {.name = "caustics/version", .kind = EXR_STRING, .text = cau_version()},
        {.name = "caustics/scene_hash", .kind = EXR_STRING, .text = hash},
        {.name = "caustics/seed", .kind = EXR_STRING, .text = seed},
        {.name = "caustics/photons", .kind = EXR_STRING, .text = photons},
        {.name = "caustics/plan", .kind = EXR_STRING, .text = cau_render_explain(o->render)},
        {.name = "caustics/error", .kind = EXR_STRING, .text = errors ? errors : "{}"},
        {.name = "caustics/repairs", .kind = EXR_STRING, .text = repairs ? repairs : "{}"},
    };
    size_t count = 9;
    if (is_shard)
        attributes[count++] = (ExrAttribute){.name = CAU_ATTRIBUTE_SHARD, .kind = EXR_STRING, .text = shard};
    make_stamp(o->render, o->options, stamp);
    if (stamped)
        attributes[count++] = (ExrAttribute){.name = CAU_ATTRIBUTE_STAMP, .kind = EXR_STRING, .text = stamp};
    bool alone = o->layer_count == 1 && cau_render_layer(o->render, 0).kind == CAU_LAYER_BEAUTY;
    ExrPicture picture = {.width = o->width,
        .height = o->height,
        .data_x0 = o->x0,
        .data_y0 = o->y0,
        .data_x1 = o->x1,
        .data_y1 = o->y1,
        .pixel_aspect = (float)o->scene->camera.pixel_aspect,
        .half = o->options->half,
        .interleave = o->options->interleave,
        .color_interop_id = o->scene->color_space,
        .layers = o->layers,
        .layer_count = alone ? 1 : o->layer_count + 1,
        .attributes = attributes,
        .attribute_count = count};
    cau_result result = exr_write(path, &picture, NULL, o->err);
    free(list);
    free(errors);
    free(repairs);
    return result;
}

static void set_window(Out *o) {
    cau_render_size(o->render, &o->width, &o->height);
    o->x1 = o->width - 1;
    o->y1 = o->height - 1;
    int region[4];
    cau_render_region(o->render, region);
    if (!o->options->crop) return;
    o->x0 = region[0];
    o->y0 = region[1];
    o->x1 = region[2] - 1;
    o->y1 = region[3] - 1;
}

cau_result cau_render_write(
    cau_render *render, cau_scene *scene, const char *path, const cau_write_options *options) {
    Out o = {.render = render, .scene = scene, .err = &scene->context->error, .options = options};
    o.light_count = cau_render_light_count(render);
    set_window(&o);
    cau_result result = map_names(&o);
    if (result == CAU_OK) result = gather_layers(&o);
    if (result == CAU_OK) result = write_file(&o, path);
    for (size_t i = 0; o.pixels && i <= o.layer_count; i++) free(o.pixels[i]);
    free(o.pixels);
    free(o.names);
    free(o.layers);
    free(o.bases);
    layer_list_free(&o.list);
    return result;
}

cau_result cau_render_layer_name(
    cau_render *render, cau_scene *scene, size_t index, char *out, size_t size, int *mapped) {
    Out o = {.render = render, .scene = scene, .err = &scene->context->error};
    o.light_count = cau_render_light_count(render);
    if (index >= o.light_count) return error_set(o.err, CAU_ERROR_USAGE, "light %zu does not exist", index);
    cau_result result = map_names(&o);
    if (result == CAU_OK) {
        snprintf(out, size, "%s", o.bases[index].name);
        *mapped = o.bases[index].mapped;
    }
    free(o.bases);
    return result;
}
