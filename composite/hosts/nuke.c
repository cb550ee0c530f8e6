/* SPDX-License-Identifier: Apache-2.0 */
/* A Nuke script: two Reads and a group with the panel of the lights. Nodes take their inputs from a stack,
 * the top of which is input 0; of a Merge that is B. */
#include "composite/hosts/hosts.h"

#include "core/checked.h"

#include <ctype.h>
#include <inttypes.h>

static const char about[] =
    "# Caustics as nodes, written by caustic-merge nuke. File > Open it, or paste it into a script.\n"
    "# The files are read raw: their numbers are added as they are, in the beauty's colour space.\n"
    "version 11.0 v1\n";

/* How Nuke calls an EXR layer: dots and what is no letter, digit or _ become _, a piece loses its leading
 * digits. "rgba" for bare channels. */
static void nuke_layer(char *out, size_t room, const ExrLayer *layer) {
    size_t n = 0;
    bool begin = true;
    for (const char *c = layer->name; *c && n + 1 < room; c++) {
        if (begin && isdigit((unsigned char)*c)) continue;
        begin = *c == '.';
        out[n++] = isalnum((unsigned char)*c) ? *c : '_';
    }
    out[n] = '\0';
    if (layer->bare || n == 0) snprintf(out, room, "rgba");
}

enum { LAYER_TEXT = 256 };

static void put_layer(FILE *out, const Picture *picture, const ExrLayer *layer) {
    char name[LAYER_TEXT];
    nuke_layer(name, sizeof name, layer);
    if (strcmp(name, "rgba") == 0) return;
    bool alpha = false;
    const ExrPart *part = &picture->header->parts[layer->part];
    size_t length = strlen(layer->name);
    for (size_t i = 0; i < part->channel_count; i++) {
        const char *c = part->channels[i].name;
        alpha = alpha || (strncmp(c, layer->name, length) == 0 && strcmp(c + length, ".A") == 0);
    }
    fprintf(out, "add_layer {%s %s.red %s.green %s.blue", name, name, name, name);
    if (alpha) fprintf(out, " %s.alpha", name);
    fputs("}\n", out);
}

/* Within quotes, where Tcl would take these characters for its own. */
static void put_quoted(FILE *out, const char *text) {
    for (const char *c = text; *c; c++) {
        if (strchr("[]$\"\\{}", *c)) fputs(strchr("\"{}", *c) ? "\\" : "\\\\\\", out);
        fputc(*c, out);
    }
}

static void put_read(FILE *out, const char *name, const HostPath *path, const HostPlan *plan) {
    fprintf(out, "Read {\n inputs 0\n file_type exr\n file \"");
    if (path->relative) fputs("\\[file dirname \\[value root.name]]/", out);
    put_quoted(out, path->path ? path->path : "");
    fprintf(out, "\"\n");
    if (plan->has_frames)
        fprintf(out, " first %d\n last %d\n origfirst %d\n origlast %d\n", plan->first, plan->last,
            plan->first, plan->last);
    if (!path->path) fprintf(out, " label \"choose the beauty\"\n");
    fprintf(out, " raw true\n name %s\n}\n", name);
}

/* Pictures that do not lie over each other: a cropped beauty. Nuke counts rows from the bottom. */
static void put_place(FILE *out, const HostPlan *plan) {
    if (!plan->shift_x && !plan->shift_y) return;
    const ExrPart *b = &plan->beauty.header->parts[plan->target->part];
    const ExrPart *c = &plan->caustics.header->parts[plan->layers[0].layer->part];
    int64_t up = (int64_t)b->display_window.y1 - c->display_window.y1 + plan->shift_y;
    int64_t right = (int64_t)c->display_window.x0 - b->display_window.x0 - plan->shift_x;
    fprintf(out, "Transform {\n translate {%" PRId64 " %" PRId64 "}\n filter Impulse\n name Place\n}\n",
        right, up);
}

static void put_value(FILE *out, const char *key, const char *knob, double value) {
    char text[HOST_NUMBER_MAX];
    host_number(text, value);
    fprintf(out, " %s_%s %s\n", key, knob, text);
}

static void put_factor(FILE *out, const HostPlan *plan, const HostControl *c) {
    fprintf(out, " addUserKnob {18 %s_factor +INVISIBLE}\n %s_factor {", c->key, c->key);
    for (int i = 0; i < 3; i++) {
        const HostControl *of = c->of < 0 ? NULL : &plan->controls[c->of];
        char channel = "rgb"[i];
        fprintf(out, "%s{%s_gain*pow(2,%s_ev)*%s_tint.%c*(1-%s_mute)*", i ? " " : "", c->key, c->key, c->key,
            channel, c->key);
        if (of)
            fprintf(out, "%s_gain*pow(2,%s_ev)*%s_tint.%c*(1-%s_mute)*(any_solo?max(%s_solo,%s_solo):1)}",
                of->key, of->key, of->key, channel, of->key, c->key, of->key);
        else
            fprintf(out, "(any_solo?%s_solo:1)}", c->key);
    }
    fputs("}\n", out);
}

/* Knob types: 20 tab, 26 text, 7 number, 18 colour, 6 check box. */
static void put_panel(FILE *out, const HostPlan *plan) {
    fputs(" addUserKnob {20 caustics_relight l Caustics}\n", out);
    if (plan->tint_space) {
        fputs(
            " addUserKnob {1 caustics_tint_space l \"tint space\" +INVISIBLE}\n caustics_tint_space \"", out);
        put_quoted(out, plan->tint_space);
        fputs("\"\n", out);
    }
    for (size_t i = 0; i < plan->control_count; i++) {
        const HostControl *c = &plan->controls[i];
        const Setting *s = &c->setting;
        char tint[3][HOST_NUMBER_MAX];
        for (int k = 0; k < 3; k++) host_number(tint[k], s->tint[k]);
        fprintf(out, " addUserKnob {26 %s_title l \"\" T \"<b>%s</b>\"}\n", c->key, c->key);
        fprintf(out, " addUserKnob {7 %s_ev l EV R -6 6}\n", c->key);
        put_value(out, c->key, "ev", s->ev);
        fprintf(out, " addUserKnob {7 %s_gain l gain R 0 4}\n", c->key);
        put_value(out, c->key, "gain", s->gain);
        fprintf(out, " addUserKnob {18 %s_tint l tint}\n %s_tint {%s %s %s}\n", c->key, c->key, tint[0],
            tint[1], tint[2]);
        if (c->saturates) {
            fprintf(out, " addUserKnob {7 %s_saturation l saturation R 0 2}\n", c->key);
            put_value(out, c->key, "saturation", s->saturation);
        }
        fprintf(out, " addUserKnob {6 %s_mute l mute +STARTLINE}\n %s_mute %s\n", c->key, c->key,
            s->mute ? "true" : "false");
        fprintf(out, " addUserKnob {6 %s_solo l solo -STARTLINE}\n %s_solo %s\n", c->key, c->key,
            s->solo ? "true" : "false");
    }
    fputs(" addUserKnob {6 any_solo +INVISIBLE}\n any_solo {{max(0", out);
    for (size_t i = 0; i < plan->control_count; i++) fprintf(out, ",%s_solo", plan->controls[i].key);
    fputs(")}}\n", out);
    for (size_t i = 0; i < plan->control_count; i++) put_factor(out, plan, &plan->controls[i]);
}

static void put_matrix(FILE *out, bool has, const double m[9], const char *name, size_t number) {
    if (!has) return;
    fputs(" ColorMatrix {\n  matrix {\n", out);
    for (int i = 0; i < 9; i += 3) {
        char text[3][HOST_NUMBER_MAX];
        for (int k = 0; k < 3; k++) host_number(text[k], m[i + k]);
        fprintf(out, "   {%s %s %s}\n", text[0], text[1], text[2]);
    }
    fprintf(out, "  }\n  name %s%zu\n }\n", name, number);
}

static void put_plus(FILE *out, const char *operation, const char *name, size_t number) {
    fprintf(out,
        " Merge2 {\n  inputs 2\n  operation %s\n  bbox B\n  Achannels rgb\n  Bchannels rgb\n  output rgb\n"
        "  name %s%zu\n }\n",
        operation, name, number);
}

/* s x colour + (1 - s) x luminance, s the product of the saturations that count. */
static void put_saturation(FILE *out, const HostPlan *plan, const HostControl *c, size_t number) {
    const HostControl *of = c->of < 0 ? NULL : &plan->controls[c->of];
    bool both = of && of->saturates && c->saturates;
    if (!c->saturates && !(of && of->saturates)) return;
    char s[4 * HOST_NAME_MAX];
    snprintf(s, sizeof s, "parent.%s_saturation%s%s%s", c->saturates ? c->key : of->key,
        both ? "*parent." : "", both ? of->key : "", both ? "_saturation" : "");
    fputs(" ColorMatrix {\n  matrix {\n", out);
    for (int row = 0; row < 3; row++) {
        fputs("   {", out);
        for (int k = 0; k < 3; k++) {
            char weight[HOST_NUMBER_MAX];
            host_number(weight, plan->conversion.luminance[k]);
            fprintf(
                out, "%s{%s*(1-%s)%s%s}", k ? " " : "", weight, s, k == row ? "+" : "", k == row ? s : "");
        }
        fputs("}\n", out);
    }
    fprintf(out, "  }\n  name Saturation%zu\n }\n", number);
}

/* The sum of the layers that are weighted by the albedo, or of those that are not, in rgb as variable N<sum>.
 */
static bool put_sum(FILE *out, const HostPlan *plan, bool weighted, const char *sum) {
    bool any = false;
    for (size_t i = 0; i < plan->layer_count; i++) {
        const HostLayer *l = &plan->layers[i];
        if (l->times_albedo != weighted) continue;
        const char *key = plan->controls[l->control].key;
        char name[LAYER_TEXT];
        nuke_layer(name, sizeof name, l->layer);
        fprintf(
            out, "push $Ncaustics\n Shuffle {\n  in %s\n  alpha black\n  name Layer%zu\n }\n", name, i + 1);
        put_matrix(out, plan->has_to_tint, plan->conversion.to_tint, "ToTint", i + 1);
        put_saturation(out, plan, &plan->controls[l->control], i + 1);
        fprintf(out,
            " Multiply {\n  channels rgb\n  value {{parent.%s_factor.r} {parent.%s_factor.g} "
            "{parent.%s_factor.b} 1}\n  name Factor%zu\n }\n",
            key, key, key, i + 1);
        if (any) {
            fprintf(out, "push $N%s\n", sum);
            put_plus(out, "plus", "Add", i + 1);
        }
        fprintf(out, "set N%s [stack 0]\n", sum);
        any = true;
    }
    if (any && plan->has_to_beauty) {
        put_matrix(out, true, plan->conversion.to_beauty, "ToBeauty", weighted ? 2 : 1);
        fprintf(out, "set N%s [stack 0]\n", sum);
    }
    return any;
}

static void put_albedo(FILE *out, const HostPlan *plan) {
    char name[LAYER_TEXT];
    nuke_layer(name, sizeof name, plan->albedo);
    fprintf(
        out, "push $Nweighted\npush $Nbeauty\n Shuffle {\n  in %s\n  alpha black\n  name Albedo\n }\n", name);
    put_plus(out, "multiply", "TimesAlbedo", 1);
    fputs(" Multiply {\n  channels rgb\n  value {{1/pi} {1/pi} {1/pi} 1}\n  name ByPi\n }\n"
          "set Nweighted [stack 0]\n",
        out);
}

static void put_group(FILE *out, const HostPlan *plan) {
    char target[LAYER_TEXT] = "rgba";
    if (plan->target) nuke_layer(target, sizeof target, plan->target);
    bool moved = strcmp(target, "rgba") != 0;
    fputs("Group {\n inputs 2\n name CausticsRelight\n", out);
    put_panel(out, plan);
    fputs("}\n Input {\n  inputs 0\n  name Caustics\n  number 1\n }\nset Ncaustics [stack 0]\n"
          " Input {\n  inputs 0\n  name Beauty\n }\nset Nbeauty [stack 0]\n",
        out);
    if (moved) fprintf(out, " Shuffle {\n  in %s\n  name Target\n }\n", target);
    fputs("set Nresult [stack 0]\n", out);
    bool weighted = put_sum(out, plan, true, "weighted"), plain = put_sum(out, plan, false, "plain");
    if (weighted) put_albedo(out, plan);
    const char *sums[] = {weighted ? "weighted" : NULL, plain ? "plain" : NULL};
    for (size_t i = 0; i < 2; i++) {
        if (!sums[i]) continue;
        fprintf(out, "push $N%s\npush $Nresult\n", sums[i]);
        put_plus(out, "plus", "Caustics", i + 1);
        fputs("set Nresult [stack 0]\n", out);
    }
    if (moved) fprintf(out, " Shuffle {\n  in rgba\n  out %s\n  name Back\n }\n", target);
    fputs(" Output {\n  name Output1\n }\nend_group\n", out);
}

cau_result host_write_nuke(FILE *out, const HostPlan *plan, CauError *err) {
    (void)err;
    fputs(about, out);
    for (size_t i = 0; i < plan->layer_count; i++) put_layer(out, &plan->caustics, plan->layers[i].layer);
    if (plan->target) put_layer(out, &plan->beauty, plan->target);
    if (plan->albedo) put_layer(out, &plan->beauty, plan->albedo);
    put_read(out, "Caustics", &plan->caustics_path, plan);
    put_place(out, plan);
    put_read(out, "Beauty", &plan->beauty_path, plan);
    put_group(out, plan);
    return CAU_OK;
}
