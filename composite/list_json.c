/* SPDX-License-Identifier: Apache-2.0 */
/* What a file holds, for programs. */
#include "composite/job.h"
#include "composite/report.h"

#include <jansson.h>
#include <stdlib.h>

/* Names in files need not be UTF-8; JSON must. */
static json_t *text_json(const char *text) {
    json_t *value = text ? json_string(text) : json_null();
    return value ? value : json_string("(not UTF-8)");
}

static json_t *box_json(ExrBox b) { return json_pack("[i,i,i,i]", b.x0, b.y0, b.x1, b.y1); }

static const char *type_name(ExrPixelType type) {
    return type == EXR_TYPE_HALF ? "half" : type == EXR_TYPE_FLOAT ? "float" : "uint";
}

static json_t *part_json(const ExrPart *part) {
    static const char *const levels[] = {"one", "mipmap", "ripmap"};
    static const char *const orders[] = {"increasing", "decreasing", "random"};
    json_t *out = json_object(), *channels = json_array();
    for (size_t c = 0; c < part->channel_count; c++)
        json_array_append_new(channels, json_pack("{s:o, s:s}", "name", text_json(part->channels[c].name),
                                            "type", type_name(part->channels[c].type)));
    json_object_set_new(out, "name", text_json(part->name));
    json_object_set_new(out, "data_window", box_json(part->data_window));
    json_object_set_new(out, "display_window", box_json(part->display_window));
    json_object_set_new(out, "pixel_aspect", json_real((double)part->pixel_aspect));
    json_object_set_new(out, "compression", text_json(exr_codec_name(part->codec)));
    json_object_set_new(
        out, "line_order", text_json((unsigned)part->order < 3 ? orders[part->order] : "unknown"));
    json_object_set_new(out, "deep", json_boolean(part->deep));
    json_object_set_new(out, "tiles",
        part->tiled ? json_pack("[i,i]", (int)part->tile_width, (int)part->tile_height) : json_null());
    json_object_set_new(
        out, "levels", text_json(part->tiled && (unsigned)part->levels < 3 ? levels[part->levels] : "one"));
    json_object_set_new(out, "channels", channels);
    return out;
}

static json_t *layers_json(const Picture *p) {
    json_t *out = json_array();
    for (size_t i = 0; i < p->layers.count; i++) {
        const ExrLayer *l = &p->layers.layers[i];
        const ExrPart *part = &p->header->parts[l->part];
        int any = l->rgb[0] >= 0 ? l->rgb[0] : l->luma;
        json_array_append_new(
            out, json_pack("{s:o, s:I, s:I, s:o, s:b}", "name", text_json(exr_layer_shown(l)), "part",
                     (json_int_t)l->part, "channels", (json_int_t)l->channel_count, "type",
                     any >= 0 ? text_json(type_name(part->channels[any].type)) : json_null(), "rgb",
                     exr_layer_is_rgb(l)));
    }
    return out;
}

static json_t *lights_json(const Picture *p, const Lights *lights, const json_t *errors) {
    json_t *out = json_array();
    for (size_t i = 0; i < lights->count; i++) {
        const Light *l = &lights->lights[i];
        const struct {
            int layer;
            cau_layer_kind kind;
        } kinds[] = {{l->radiance, CAU_LAYER_RADIANCE}, {l->indirect, CAU_LAYER_INDIRECT},
            {l->irradiance, CAU_LAYER_IRRADIANCE}, {l->seen, CAU_LAYER_SEEN}};
        json_t *light = json_object(), *layers = json_object(), *error = json_object_get(errors, l->name);
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
            if (kinds[k].layer >= 0)
                json_object_set_new(layers, cau_layer_kind_name(kinds[k].kind),
                    text_json(exr_layer_shown(&p->layers.layers[kinds[k].layer])));
        json_object_set_new(light, "name", text_json(l->name));
        json_object_set_new(light, "layers", layers);
        json_object_set(light, "error", error ? error : json_null());
        json_array_append_new(out, light);
    }
    return out;
}

/* An attribute of the first part: its number, its JSON, or its text. */
static json_t *attribute_json(const Picture *p, const char *name, bool is_json) {
    const ExrAttr *attr = exr_attr_find(&p->header->parts[0], name);
    int32_t number;
    if (exr_attr_int32(attr, &number)) return json_integer(number);
    char *text = exr_attr_text(attr);
    json_t *parsed = text && is_json ? json_loads(text, 0, NULL) : NULL;
    json_t *out = parsed ? parsed : text_json(text);
    free(text);
    return out;
}

static json_t *colour_json(const Picture *p, const Lights *lights) {
    ColourTag tag;
    colour_tag_read(&tag, p->header, picture_colour_part(p, lights));
    if (tag.source == COLOUR_TAG_NONE) return json_null();
    return json_pack("{s:o, s:s}", "space", text_json(tag.id), "source", report_tag_source((int)tag.source));
}

static json_t *file_json(const Picture *p, const char *file, const Lights *lights) {
    static const struct {
        const char *key, *name;
        bool is_json;
    } attributes[] = {{"complete", CAU_ATTRIBUTE_COMPLETE, false},
        {"repaired_nan", CAU_ATTRIBUTE_REPAIRED_NAN, false}, {"clamped", CAU_ATTRIBUTE_CLAMPED, false},
        {"scene_hash", CAU_ATTRIBUTE_SCENE_HASH, false}, {"seed", CAU_ATTRIBUTE_SEED, false},
        {"shard", CAU_ATTRIBUTE_SHARD, false}, {"photons", CAU_ATTRIBUTE_PHOTONS, false},
        {"plan", CAU_ATTRIBUTE_PLAN, true}, {"merge", CAU_ATTRIBUTE_MERGE, true},
        {"stamp", CAU_ATTRIBUTE_STAMP, false}};
    json_t *out = json_object(), *parts = json_array(),
           *errors = attribute_json(p, CAU_ATTRIBUTE_ERROR, true);
    for (size_t i = 0; i < p->header->part_count; i++)
        json_array_append_new(parts, part_json(&p->header->parts[i]));
    json_object_set_new(out, "file", text_json(file));
    json_object_set_new(out, "parts", parts);
    json_object_set_new(out, "layers", layers_json(p));
    json_object_set_new(out, "lights", lights_json(p, lights, errors));
    json_object_set_new(out, "colour", colour_json(p, lights));
    for (size_t i = 0; i < sizeof attributes / sizeof *attributes; i++)
        json_object_set_new(
            out, attributes[i].key, attribute_json(p, attributes[i].name, attributes[i].is_json));
    json_decref(errors);
    return out;
}

cau_result report_list_json(const Report *report, const char *file) {
    Picture p;
    Lights lights = {0};
    cau_result result = picture_open(&p, file, report->err);
    if (result == CAU_OK) result = lights_find(&lights, &p, report->err);
    json_t *json = result == CAU_OK ? file_json(&p, file, &lights) : NULL;
    char *text = json ? json_dumps(json, JSON_INDENT(1)) : NULL;
    if (result == CAU_OK && !text)
        result = error_set(report->err, CAU_ERROR_RESOURCE, "out of memory for what \"%s\" holds", file);
    if (text && report->line) report->line(report->user, text);
    free(text);
    json_decref(json);
    lights_free(&lights);
    picture_close(&p);
    return result;
}
