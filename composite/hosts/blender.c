/* SPDX-License-Identifier: Apache-2.0 */
/* A Blender script: the shot as JSON, and blender_script.py, which builds it. */
#include "composite/hosts/hosts.h"
#include "core/frames.h"

#include "composite/hosts/scripts.h"
#include "core/checked.h"

#include <inttypes.h>
#include <jansson.h>

static const char head[] =
    "# SPDX-License-Identifier: Apache-2.0\n"
    "# Adds the caustics to the compositor, with sliders for every light. Written by caustic-merge "
    "blender.\n"
    "#   blender shot.blend --python THIS_FILE                    to the scene's own render\n"
    "#   blender shot.blend --python THIS_FILE -- beauty.exr      to a picture\n"
    "# or open it in Blender's text editor and run it. Running it again replaces what it made.\n"
    "import json\n"
    "\n"
    "SHOT = json.loads(r'''";

static json_t *matrix_json(bool has, const double m[9]) {
    if (!has) return json_null();
    json_t *list = json_array();
    for (int i = 0; i < 9; i++) json_array_append_new(list, json_real(m[i]));
    return list;
}

static const char *label_of(const char *key) {
    size_t prefix = strlen(CAU_LAYER_PREFIX);
    return strncmp(key, CAU_LAYER_PREFIX, prefix) == 0 && key[prefix] ? key + prefix : key;
}

static json_t *lights_json(const HostPlan *plan) {
    json_t *list = json_array();
    for (size_t i = 0; i < plan->control_count; i++) {
        const HostControl *c = &plan->controls[i];
        const Setting *s = &c->setting;
        json_array_append_new(
            list, json_pack("{s:s, s:s, s:s?, s:o, s:f, s:f, s:[f,f,f], s:b, s:b}", "key", c->key, "label",
                      label_of(c->key), "of", c->of < 0 ? NULL : plan->controls[c->of].key, "saturation",
                      c->saturates ? json_real(s->saturation) : json_null(), "ev", s->ev, "gain", s->gain,
                      "tint", s->tint[0], s->tint[1], s->tint[2], "mute", s->mute, "solo", s->solo));
    }
    return list;
}

static json_t *layers_json(const HostPlan *plan) {
    json_t *list = json_array();
    for (size_t i = 0; i < plan->layer_count; i++) {
        const HostLayer *l = &plan->layers[i];
        json_array_append_new(list, json_pack("{s:s, s:s, s:b}", "layer", l->layer->name, "light",
                                        plan->controls[l->control].key, "albedo", l->times_albedo));
    }
    return list;
}

/* Of a sequence, the first file. */
static json_t *path_json(const HostPath *path, const HostPlan *plan) {
    if (!path->path) return json_null();
    char *frame = plan->has_frames ? frame_name(path->path, plan->first) : NULL;
    json_t *value = json_string(frame ? frame : path->path);
    free(frame);
    return value;
}

static cau_result refuse(const HostPlan *plan, ExrBox c, ExrBox b, CauError *err) {
    return error_set(err, CAU_ERROR_INPUT,
        "Blender puts pictures over each other by their middles, so the caustics must cover just the "
        "picture: "
        "\"%s\" covers (%d,%d)-(%d,%d), the picture (%d,%d)-(%d,%d); render without --crop, or --region for "
        "a "
        "cropped picture",
        exr_reader_path(plan->caustics.reader), c.x0, c.y0, c.x1, c.y1, b.x0, b.y0, b.x1, b.y1);
}

static cau_result check_windows(const HostPlan *plan, ExrBox *window, CauError *err) {
    for (size_t i = 0; i < plan->layer_count; i++) {
        const ExrPart *c = &plan->caustics.header->parts[plan->layers[i].layer->part];
        ExrBox b =
            plan->has_beauty ? plan->beauty.header->parts[plan->target->part].data_window : c->display_window;
        *window = b;
        b.x0 += plan->shift_x;
        b.x1 += plan->shift_x;
        b.y0 += plan->shift_y;
        b.y1 += plan->shift_y;
        if (!exr_box_equal(c->data_window, b)) return refuse(plan, c->data_window, b, err);
    }
    return CAU_OK;
}

/* No ''' may end the text early: inside JSON a ' can only be in a string. */
static void put_json(FILE *out, const char *json) {
    for (const char *c = json; *c; c++) {
        if (*c == '\'')
            fputs("\\u0027", out);
        else
            fputc(*c, out);
    }
}

static cau_result check_tints(const HostPlan *plan, CauError *err) {
    for (size_t i = 0; i < plan->control_count; i++)
        for (int k = 0; k < 3; k++)
            if (plan->controls[i].setting.tint[k] < 0)
                return error_set(err, CAU_ERROR_INPUT,
                    "light \"%s\": its tint has %g, and no colour of Blender is negative: use a negative "
                    "gain",
                    label_of(plan->controls[i].key), plan->controls[i].setting.tint[k]);
    return CAU_OK;
}

cau_result host_write_blender(FILE *out, const HostPlan *plan, CauError *err) {
    ExrBox window = {0};
    CAU_TRY(check_windows(plan, &window, err));
    CAU_TRY(check_tints(plan, err));
    json_t *frames = plan->has_frames ? json_pack("[i,i]", plan->first, plan->last) : json_null();
    json_t *shot = json_pack("{s:o, s:o, s:s, s:s?, s:[I,I], s:o, s:o, s:o, s:[f,f,f], s:s?, s:o, s:o}",
        "caustics", path_json(&plan->caustics_path, plan), "beauty", path_json(&plan->beauty_path, plan),
        "pass", plan->target ? plan->target->name : "", "albedo", plan->albedo ? plan->albedo->name : NULL,
        "size", (json_int_t)exr_box_width(window), (json_int_t)exr_box_height(window), "frames", frames,
        "to_tint", matrix_json(plan->has_to_tint, plan->conversion.to_tint), "to_beauty",
        matrix_json(plan->has_to_beauty, plan->conversion.to_beauty), "luminance",
        plan->conversion.luminance[0], plan->conversion.luminance[1], plan->conversion.luminance[2],
        "tint_space", plan->tint_space, "lights", lights_json(plan), "layers", layers_json(plan));
    char *text = shot ? json_dumps(shot, JSON_INDENT(1) | JSON_ENSURE_ASCII | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(shot);
    if (!text)
        return error_set(err, CAU_ERROR_INPUT, "a file name is not UTF-8, so that no script can hold it");
    fputs(head, out);
    put_json(out, text);
    fputs("''')\n\n", out);
    fputs(host_blender_script, out);
    free(text);
    return CAU_OK;
}
