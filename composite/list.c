/* SPDX-License-Identifier: Apache-2.0 */
/* What a file holds, from its headers alone. */
#include "composite/job.h"
#include "composite/report.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void report_line(const Report *report, const char *format, ...) {
    char text[CAU_ERROR_TEXT_MAX];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    /* Names come from files: a control character must not reach a terminal. */
    for (unsigned char *c = (unsigned char *)text; *c; c++)
        if (*c < 32 || *c == 127) *c = '?';
    if (report->line) report->line(report->user, text);
}

static const char *type_name(ExrPixelType type) {
    return type == EXR_TYPE_HALF ? "half" : type == EXR_TYPE_FLOAT ? "float" : "uint";
}

static void list_parts(const Report *report, const Picture *p) {
    for (size_t i = 0; i < p->header->part_count; i++) {
        const ExrPart *part = &p->header->parts[i];
        ExrBox d = part->data_window;
        report_line(report, "part %zu%s%s%s: %" PRId64 " x %" PRId64 ", data (%d,%d)-(%d,%d), %s, %s%s", i,
            part->name ? " \"" : "", part->name ? part->name : "", part->name ? "\"" : "",
            exr_box_width(part->display_window), exr_box_height(part->display_window), d.x0, d.y0, d.x1, d.y1,
            exr_codec_name(part->codec), part->tiled ? "tiles" : "scan lines", part->deep ? ", deep" : "");
    }
}

static void list_layers(const Report *report, const Picture *p) {
    for (size_t i = 0; i < p->layers.count; i++) {
        const ExrLayer *l = &p->layers.layers[i];
        const ExrPart *part = &p->header->parts[l->part];
        int any = l->rgb[0] >= 0 ? l->rgb[0] : l->luma;
        report_line(report, "layer %s: %zu channels%s%s", exr_layer_shown(l), l->channel_count,
            any >= 0 ? ", " : "", any >= 0 ? type_name(part->channels[any].type) : "");
    }
}

static void list_light(const Report *report, const Picture *p, const Light *l) {
    const struct {
        int layer;
        const char *kind;
    } kinds[] = {{l->radiance, "radiance"}, {l->indirect, "indirect"}, {l->irradiance, "irradiance"},
        {l->seen, "seen"}};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (kinds[i].layer >= 0)
            report_line(report, "light %s: %s, layer %s", l->name, kinds[i].kind,
                exr_layer_shown(&p->layers.layers[kinds[i].layer]));
}

static void list_attribute(const Report *report, const ExrPart *part, const char *name) {
    const ExrAttr *attr = exr_attr_find_any_case(part, name);
    int32_t number;
    char *text = exr_attr_text(attr), *rest = NULL;
    for (char *line = text ? strtok_r(text, "\n", &rest) : NULL; line; line = strtok_r(NULL, "\n", &rest))
        report_line(report, "%s: %s", name, line); /* a plan has several */
    if (!text && exr_attr_int32(attr, &number)) report_line(report, "%s: %d", name, number);
    free(text);
}

const char *report_tag_source(int source) {
    static const char *const sources[] = {"", "acesImageContainerFlag", CAU_ATTRIBUTE_COLOR_ID,
        "chromaticities", "written by Blender, which does not say"};
    return sources[source];
}

static void list_colour(const Report *report, const Picture *p, const Lights *lights) {
    ColourTag tag;
    colour_tag_read(&tag, p->header, picture_colour_part(p, lights));
    if (tag.source == COLOUR_TAG_NONE)
        report_line(report, "colour: not said");
    else
        report_line(report, "colour: %s (%s)", tag.id, report_tag_source((int)tag.source));
}

static cau_result list_open(const Report *report, const Picture *p) {
    static const char *const attributes[] = {CAU_ATTRIBUTE_COMPLETE, CAU_ATTRIBUTE_REPAIRED_NAN,
        CAU_ATTRIBUTE_CLAMPED, CAU_ATTRIBUTE_SCENE_HASH, CAU_ATTRIBUTE_SEED, CAU_ATTRIBUTE_SHARD,
        CAU_ATTRIBUTE_PHOTONS, CAU_ATTRIBUTE_ERROR, CAU_ATTRIBUTE_PLAN, CAU_ATTRIBUTE_MERGE};
    list_parts(report, p);
    list_layers(report, p);
    Lights lights;
    cau_result result = lights_find(&lights, p, report->err);
    for (size_t i = 0; result == CAU_OK && i < lights.count; i++) list_light(report, p, &lights.lights[i]);
    list_colour(report, p, &lights);
    lights_free(&lights);
    for (size_t i = 0; i < sizeof attributes / sizeof *attributes; i++)
        list_attribute(report, &p->header->parts[0], attributes[i]);
    return result;
}

cau_result report_list(const Report *report, const char *file) {
    Picture p;
    cau_result result = picture_open(&p, file, report->err);
    if (result == CAU_OK) result = list_open(report, &p);
    picture_close(&p);
    return result;
}
