/* SPDX-License-Identifier: Apache-2.0 */
/* The panel's values out of a .nk file. A node is "Class {", a line for each knob, "}"; a value goes on to
 * the end of its line unless a brace or a quote is open. */
#include "composite/hosts/hosts.h"

#include "core/checked.h"

#include <ctype.h>
#include <math.h>

typedef struct Knob {
    const char *name, *value;
    size_t name_length, value_length;
} Knob;

static bool blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/* The end of a value: Tcl's rules for braces, quotes and backslashes. */
static const char *value_end(const char *at) {
    int depth = 0;
    bool quoted = false;
    for (; *at && (*at != '\n' || depth > 0 || quoted); at++) {
        if (*at == '\\' && at[1])
            at++;
        else if (*at == '"' && depth == 0)
            quoted = !quoted;
        else if (*at == '{' && !quoted)
            depth++;
        else if (*at == '}' && !quoted && --depth < 0)
            break;
    }
    return at;
}

/* The next line of a node; false at its end. */
static bool next_knob(const char **at, Knob *out) {
    while (blank(**at) || **at == '\n') ++*at;
    if (**at == '\0' || **at == '}') return false;
    out->name = *at;
    while (**at && !blank(**at) && **at != '\n') ++*at;
    out->name_length = (size_t)(*at - out->name);
    while (blank(**at)) ++*at;
    out->value = *at;
    *at = value_end(*at);
    out->value_length = (size_t)(*at - out->value);
    while (out->value_length && blank(out->value[out->value_length - 1])) out->value_length--;
    return true;
}

/* "Word {" and nothing else on the line. */
static bool node_begins(const char *line, const char **knobs) {
    while (blank(*line)) line++;
    const char *at = line;
    while (isalnum((unsigned char)*at) || *at == '_' || *at == '.') at++;
    if (at == line || !blank(*at)) return false;
    while (blank(*at)) at++;
    if (*at++ != '{') return false;
    while (blank(*at)) at++;
    *knobs = at;
    return *at == '\n';
}

static bool is(const Knob *knob, const char *name) {
    return strlen(name) == knob->name_length && strncmp(knob->name, name, knob->name_length) == 0;
}

/* The second word of addUserKnob's list: the name of the new knob. */
static bool new_name(const Knob *knob, char *out, size_t room) {
    const char *at = knob->value, *end = at + knob->value_length;
    if (at < end && *at == '{') at++;
    while (at < end && isdigit((unsigned char)*at)) at++;
    while (at < end && blank(*at)) at++;
    size_t n = 0;
    while (at < end && !blank(*at) && *at != '}' && n + 1 < room) out[n++] = *at++;
    out[n] = '\0';
    return n > 0;
}

static const char *const knobs[] = {"_ev", "_gain", "_tint", "_mute", "_solo", "_saturation"};
enum { KNOBS = sizeof knobs / sizeof *knobs };

/* "caustics_key_ev": which of the knobs, and the length of the light's part; -1 for another knob. */
static int which_knob(const char *name, size_t length, size_t *light) {
    size_t prefix = strlen(CAU_LAYER_PREFIX);
    for (int i = 0; i < KNOBS; i++) {
        size_t n = strlen(knobs[i]);
        if (length <= prefix + n || strncmp(name, CAU_LAYER_PREFIX, prefix) != 0) continue;
        *light = length - n;
        if (strncmp(name + *light, knobs[i], n) == 0) return i;
    }
    return -1;
}

/* Nuke saves no value that is zero, so a knob begins as zero. */
static cau_result declare(Lights *out, const Knob *knob, CauError *err) {
    char name[256];
    size_t length;
    int which = new_name(knob, name, sizeof name) ? which_knob(name, strlen(name), &length) : -1;
    if (which < 0) return CAU_OK;
    name[length] = '\0';
    Light *light;
    CAU_TRY(host_light(&light, out, name, err));
    if (which == 1) light->both.gain = 0;
    if (which == 2) memset(light->both.tint, 0, sizeof light->both.tint);
    if (which == 5) light->both.saturation = 0;
    return CAU_OK;
}

static bool read_numbers(const char *text, double *out, int *count) {
    char *end;
    bool list = *text == '{';
    for (*count = 0, text += list; *count < 4; text = end) {
        while (blank(*text)) text++;
        if (list && *text == '}') return text[1] == '\0' && *count > 0;
        out[*count] = strtod(text, &end);
        if (end == text || !isfinite(out[*count])) return false;
        ++*count;
        if (!list) return *end == '\0';
    }
    while (blank(*text)) text++;
    return strcmp(text, "}") == 0;
}

static bool set_value(Setting *s, int which, const char *text) {
    double n[4];
    int count = 0;
    if (which == 3 || which == 4) {
        bool on = strcmp(text, "true") == 0 || strcmp(text, "1") == 0;
        *(which == 3 ? &s->mute : &s->solo) = on;
        return on || strcmp(text, "false") == 0 || strcmp(text, "0") == 0;
    }
    if (!read_numbers(text, n, &count)) return false;
    if (which == 2)
        for (int i = 0; i < 3; i++) s->tint[i] = n[count >= 3 ? i : 0];
    else
        *(which == 0 ? &s->ev : which == 1 ? &s->gain : &s->saturation) = n[0];
    return which == 2 ? count != 2 : count == 1;
}

/* "Linear Rec.709", with quotes and backslashes where Tcl needs them. */
static cau_result set_tint_space(Lights *out, const Knob *knob, CauError *err) {
    free(out->tint_space);
    char *to = out->tint_space = array_new(knob->value_length + 1, 1);
    if (!to) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for a recipe");
    for (size_t i = 0; i < knob->value_length; i++)
        if (knob->value[i] != '"' && knob->value[i] != '\\') *to++ = knob->value[i];
    return CAU_OK;
}

static cau_result assign(Lights *out, const Knob *knob, CauError *err) {
    size_t length;
    if (is(knob, "caustics_tint_space")) return set_tint_space(out, knob, err);
    int which = which_knob(knob->name, knob->name_length, &length);
    if (which < 0 || length > 255) return CAU_OK;
    char name[256], text[256];
    snprintf(name, sizeof name, "%.*s", (int)length, knob->name);
    Light *light;
    CAU_TRY(host_light(&light, out, name, err));
    bool fits = knob->value_length < sizeof text;
    if (fits) snprintf(text, sizeof text, "%.*s", (int)knob->value_length, knob->value);
    if (fits && set_value(&light->both, which, text)) return CAU_OK;
    return error_set(err, CAU_ERROR_INPUT,
        "light \"%s\": its %s is animated or an expression, and a recipe holds one value: set a number",
        light->name, knobs[which] + 1);
}

static cau_result read_node(Lights *out, const char **at, bool *marked, CauError *err) {
    Knob knob;
    char name[256];
    *marked = false;
    while (next_knob(at, &knob)) {
        bool adds = is(&knob, "addUserKnob");
        if (adds && new_name(&knob, name, sizeof name) && strcmp(name, "caustics_relight") == 0)
            *marked = true;
        if (*marked) CAU_TRY(adds ? declare(out, &knob, err) : assign(out, &knob, err));
    }
    return CAU_OK;
}

static cau_result read_script(Lights *out, const char *text, CauError *err) {
    size_t panels = 0;
    for (const char *line = text, *at; line; line = strchr(line, '\n') ? strchr(line, '\n') + 1 : NULL) {
        if (!node_begins(line, &at)) continue;
        bool marked;
        CAU_TRY(read_node(out, &at, &marked, err));
        panels += marked;
        line = at;
    }
    if (panels == 1) return CAU_OK;
    return panels == 0
               ? error_set(err, CAU_ERROR_INPUT, "it has no relight panel: caustic-merge nuke writes one")
               : error_set(err, CAU_ERROR_INPUT,
                     "it has %zu relight panels, and a recipe holds one: export the node you mean by itself",
                     panels);
}

cau_result host_read_nuke(Lights *out, const char *path, CauError *err) {
    char *text = NULL;
    size_t size;
    CAU_TRY(host_read_file(&text, &size, path, err));
    cau_result result = read_script(out, text, err);
    free(text);
    if (result != CAU_OK) error_prefix(err, "\"%s\": ", path);
    return result;
}
