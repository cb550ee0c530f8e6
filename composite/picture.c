/* SPDX-License-Identifier: Apache-2.0 */
#include "composite/job.h"
#include "core/nearest.h"

#include "core/checked.h"

#include <stdio.h>

enum { LIST_TEXT = 400 };

cau_result picture_open(Picture *out, const char *path, CauError *err) {
    *out = (Picture){0};
    CAU_TRY(exr_reader_open(&out->reader, path, err));
    out->header = exr_reader_header(out->reader);
    return exr_layers_find(&out->layers, out->header, err);
}

void picture_close(Picture *picture) {
    exr_layers_free(&picture->layers);
    exr_reader_close(&picture->reader);
}

cau_result picture_check_readable(const Picture *picture, CauError *err) {
    for (size_t i = 0; i < picture->header->part_count; i++)
        CAU_TRY(exr_reader_can_read(picture->reader, i, err));
    return CAU_OK;
}

typedef bool Wanted(const Picture *picture, const ExrLayer *layer, const char *name);

static bool is_rgb(const Picture *p, const ExrLayer *l, const char *name) {
    (void)p;
    (void)name;
    return exr_layer_is_rgb(l);
}
static bool has_full_name(const Picture *p, const ExrLayer *l, const char *name) {
    return is_rgb(p, l, name) && strcmp(exr_layer_shown(l), name) == 0;
}
static bool has_name(const Picture *p, const ExrLayer *l, const char *name) {
    return is_rgb(p, l, name) && strcmp(l->name, name) == 0;
}
static bool has_pass(const Picture *p, const ExrLayer *l, const char *name) {
    return is_rgb(p, l, name) && strcmp(l->pass, name) == 0;
}
/* "Combined.left", as it would be the end of a channel's name. */
static bool has_pass_of_view(const Picture *p, const ExrLayer *l, const char *name) {
    size_t pass = strlen(l->pass);
    return is_rgb(p, l, name) && l->view && pass && strncmp(l->pass, name, pass) == 0 && name[pass] == '.' &&
           strcmp(name + pass + 1, l->view) == 0;
}
static bool is_in_part(const Picture *p, const ExrLayer *l, const char *name) {
    const char *part = p->header->parts[l->part].name;
    return is_rgb(p, l, name) && part && strcmp(part, name) == 0;
}
static bool is_bare(const Picture *p, const ExrLayer *l, const char *name) {
    return is_rgb(p, l, name) && l->bare;
}

static size_t count_layers(const Picture *p, Wanted *wanted, const char *name, const ExrLayer **first) {
    size_t count = 0;
    for (size_t i = 0; i < p->layers.count; i++)
        if (wanted(p, &p->layers.layers[i], name) && count++ == 0) *first = &p->layers.layers[i];
    return count;
}

/* "A, B, C", cut to a length that leaves room for the rest of the sentence. */
static void list_layers(char *text, const Picture *p, Wanted *wanted, const char *name) {
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < p->layers.count; i++) {
        const ExrLayer *l = &p->layers.layers[i];
        if (!wanted(p, l, name)) continue;
        const char *shown = exr_layer_shown(l);
        if (used + strlen(shown) + 8 > LIST_TEXT) {
            snprintf(text + used, LIST_TEXT - used, ", ...");
            return;
        }
        used += (size_t)snprintf(text + used, LIST_TEXT - used, "%s%s", used ? ", " : "", shown);
    }
}

static cau_result ambiguous(
    const Picture *p, Wanted *wanted, const char *name, const char *option, CauError *err) {
    char text[LIST_TEXT];
    list_layers(text, p, wanted, name);
    return error_set(err, CAU_ERROR_INPUT,
        "\"%s\" has several layers that could be meant: %s; choose one with %s", exr_reader_path(p->reader),
        text, option);
}

static cau_result not_found(const Picture *p, const char *name, const char *option, CauError *err) {
    const char **names = array_new(p->layers.count, sizeof *names);
    size_t count = 0;
    for (size_t i = 0; names && i < p->layers.count; i++)
        if (exr_layer_is_rgb(&p->layers.layers[i])) names[count++] = exr_layer_shown(&p->layers.layers[i]);
    int nearest = names ? nearest_name(name, names, count) : -1;
    char text[LIST_TEXT];
    list_layers(text, p, is_rgb, NULL);
    error_set(err, CAU_ERROR_INPUT, "%s: \"%s\" has no layer \"%s\" with R, G and B%s%s%s; it has: %s",
        option, exr_reader_path(p->reader), name, nearest >= 0 ? "; did you mean \"" : "",
        nearest >= 0 ? names[nearest] : "", nearest >= 0 ? "\"" : "", count ? text : "none");
    free(names);
    return CAU_ERROR_INPUT;
}

cau_result picture_find_layer(
    const ExrLayer **out, const Picture *p, const char *wanted, const char *option, CauError *err) {
    static Wanted *const ways[] = {has_full_name, has_name, has_pass, has_pass_of_view, is_in_part};
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        size_t count = count_layers(p, ways[i], wanted, out);
        if (count == 1) return CAU_OK;
        if (count > 1) return ambiguous(p, ways[i], wanted, option, err);
    }
    return not_found(p, wanted, option, err);
}

cau_result picture_default_layer(const ExrLayer **out, const Picture *p, const char *option, CauError *err) {
    size_t count = count_layers(p, has_pass, "Combined", out);
    if (count == 1) return CAU_OK;
    if (count > 1) return ambiguous(p, has_pass, "Combined", option, err);
    count = count_layers(p, is_bare, NULL, out);
    if (count == 1) return CAU_OK;
    if (count > 1) return ambiguous(p, is_bare, NULL, option, err);
    char text[LIST_TEXT];
    list_layers(text, p, is_rgb, NULL);
    return error_set(err, CAU_ERROR_INPUT,
        "\"%s\" has neither a Combined pass nor plain R,G,B channels; choose a layer with %s: %s",
        exr_reader_path(p->reader), option,
        text[0] ? text : "none has R, G and B, so save the picture as R,G,B");
}
