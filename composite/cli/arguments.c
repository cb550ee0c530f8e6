/* SPDX-License-Identifier: Apache-2.0 */
#include "composite/cli/arguments.h"

#include "core/checked.h"
#include "core/nearest.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>

typedef enum Kind { TEXT, FLAG, SWITCH, OFFSET, LIGHT, EVERY, NAME, STOPS, THREADS, MEMORY } Kind;

typedef struct Option {
    const char *name;
    Kind kind;
    size_t at;    /* TEXT, FLAG (bool), SWITCH (int): offset in Arguments */
    uint32_t set; /* LIGHT: CAU_MERGE_... */
} Option;

#define IN_OPTIONS(field) offsetof(Arguments, options) + offsetof(cau_merge_options, field)

static const Option options[] = {
    {"--output", TEXT, offsetof(Arguments, output), 0},
    {"-o", TEXT, offsetof(Arguments, output), 0},
    {"--gain", LIGHT, 0, CAU_MERGE_GAIN},
    {"--ev", LIGHT, 0, CAU_MERGE_EV},
    {"--tint", LIGHT, 0, CAU_MERGE_TINT},
    {"--mute", LIGHT, 0, CAU_MERGE_MUTE},
    {"--solo", LIGHT, 0, CAU_MERGE_SOLO},
    {"--temperature", LIGHT, 0, CAU_MERGE_TEMPERATURE},
    {"--saturation", LIGHT, 0, CAU_MERGE_SATURATION},
    {"--all-to", EVERY, 0, 0},
    {"--write-recipe", TEXT, IN_OPTIONS(write_recipe), 0},
    {"--into-groups", SWITCH, IN_OPTIONS(into_groups), 0},
    {"--into-diffuse", SWITCH, IN_OPTIONS(into_diffuse), 0},
    {"--keep-layers", SWITCH, IN_OPTIONS(keep_layers), 0},
    {"--holdout", TEXT, IN_OPTIONS(holdout), 0},
    {"--holdout-alpha", SWITCH, IN_OPTIONS(holdout_alpha), 0},
    {"--holdout-name", NAME, 0, 0},
    {"--threads", THREADS, 0, 0},
    {"--memory", MEMORY, 0, 0},
    {"--recipe", TEXT, IN_OPTIONS(recipe), 0},
    {"--pass", TEXT, IN_OPTIONS(pass), 0},
    {"--layer", TEXT, IN_OPTIONS(pass), 0},
    {"--albedo", TEXT, IN_OPTIONS(albedo), 0},
    {"--ocio", TEXT, IN_OPTIONS(ocio), 0},
    {"--beauty-space", TEXT, IN_OPTIONS(beauty_space), 0},
    {"--caustics-space", TEXT, IN_OPTIONS(caustics_space), 0},
    {"--tint-space", TEXT, IN_OPTIONS(tint_space), 0},
    {"--compression", TEXT, IN_OPTIONS(compression), 0},
    {"--preview", TEXT, IN_OPTIONS(preview), 0},
    {"--display", TEXT, IN_OPTIONS(display), 0},
    {"--view", TEXT, IN_OPTIONS(view), 0},
    {"--look", TEXT, IN_OPTIONS(look), 0},
    {"--exposure", STOPS, IN_OPTIONS(preview_ev), 0},
    {"--contact-sheet", TEXT, IN_OPTIONS(contact_sheet), 0},
    {"--offset", OFFSET, 0, 0},
    {"--allow-incomplete", SWITCH, IN_OPTIONS(allow_incomplete), 0},
    {"--frames", TEXT, offsetof(Arguments, frames), 0},
    {"--json", FLAG, offsetof(Arguments, json), 0},
    {"--report", TEXT, offsetof(Arguments, report), 0},
    {"--resume", FLAG, offsetof(Arguments, resume), 0},
    {"--from-nuke", TEXT, offsetof(Arguments, from_nuke), 0},
    {"--from-blender", TEXT, offsetof(Arguments, from_blender), 0},
    {"--to-scene", TEXT, offsetof(Arguments, to_scene), 0},
    {"--quiet", FLAG, offsetof(Arguments, quiet), 0},
    {"--help", FLAG, offsetof(Arguments, help), 0},
    {"-h", FLAG, offsetof(Arguments, help), 0},
    {"--version", FLAG, offsetof(Arguments, version), 0},
};
enum { OPTIONS = sizeof options / sizeof *options };

static bool read_number(const char *text, const char **end, double *out) {
    char *stop;
    *out = strtod(text, &stop);
    *end = stop;
    return stop != text && isfinite(*out);
}

static bool whole_number(const char *text, double *out) {
    const char *end;
    return read_number(text, &end, out) && !*end;
}

static bool read_tint(const char *text, double tint[3]) {
    const char *at = text;
    for (int i = 0; i < 3; i++) {
        if (!read_number(at, &at, &tint[i])) return false;
        if (*at++ != (i < 2 ? ',' : '\0')) return false;
    }
    return true;
}

/* The values that belong to a light, and what they must look like. */
static const struct Value {
    uint32_t set;
    size_t at;
    int count;
    const char *key, *wanted;
} values[] = {
    {CAU_MERGE_GAIN, offsetof(cau_merge_light, gain), 1, "gain", "a finite number"},
    {CAU_MERGE_EV, offsetof(cau_merge_light, ev), 1, "ev", "a finite number"},
    {CAU_MERGE_TINT, offsetof(cau_merge_light, tint), 3, "tint", "three finite numbers R,G,B"},
    {CAU_MERGE_TEMPERATURE, offsetof(cau_merge_light, temperature_k), 1, "temperature", "a number of kelvin"},
    {CAU_MERGE_SATURATION, offsetof(cau_merge_light, saturation), 1, "saturation", "a finite number"},
};
enum { VALUES = sizeof values / sizeof *values };

static cau_result read_value(cau_merge_light *light, const char *text, const char *option, CauError *err) {
    for (int i = 0; i < VALUES; i++) {
        double *to = (double *)(void *)((char *)light + values[i].at);
        if (values[i].set != light->set) continue;
        if (values[i].count == 3 ? read_tint(text, to) : whole_number(text, to)) return CAU_OK;
        return error_set(err, CAU_ERROR_USAGE, "%s %s: \"%s\" is not %s", option,
            light->light ? light->light : values[i].key, text, values[i].wanted);
    }
    return CAU_OK;
}

/* --all-to ev=1: one value for every light. */
static cau_result read_every(Arguments *a, const char *text, CauError *err) {
    cau_merge_light *light = &a->lights[a->light_count];
    const char *equals = strchr(text, '=');
    size_t length = equals ? (size_t)(equals - text) : 0;
    *light = (cau_merge_light){0};
    a->light_names[a->light_count++] = NULL;
    for (int i = 0; equals && i < VALUES; i++)
        if (strlen(values[i].key) == length && strncmp(values[i].key, text, length) == 0)
            light->set = values[i].set;
    if (light->set) return read_value(light, equals + 1, "--all-to", err);
    return error_set(err, CAU_ERROR_USAGE,
        "--all-to: \"%s\" is not KEY=VALUE with a key out of gain, ev, tint, temperature, saturation", text);
}

static cau_result read_threads(Arguments *a, const char *text, CauError *err) {
    double count;
    if (!whole_number(text, &count) || count < 1 || count > 1024 || count != floor(count))
        return error_set(
            err, CAU_ERROR_USAGE, "--threads: \"%s\" is not a whole number from 1 to 1024", text);
    a->options.threads = (unsigned)count;
    return CAU_OK;
}

static cau_result read_memory(Arguments *a, const char *text, CauError *err) {
    const char *end;
    double size, unit = 1;
    bool good = read_number(text, &end, &size);
    if (good && *end && strchr("kKmMgG", *end)) {
        unit = strchr("kK", *end) ? 1e3 : strchr("mM", *end) ? 1e6 : 1e9;
        end++;
    }
    if (good && (*end == 'B' || *end == 'b')) end++;
    if (!good || *end || size * unit < 1e6 || size * unit > 1e15)
        return error_set(
            err, CAU_ERROR_USAGE, "--memory: \"%s\" is not a size of at least 1M, as in 500M or 2G", text);
    a->options.memory_bytes = (size_t)(size * unit);
    return CAU_OK;
}

static cau_result read_light(Arguments *a, const Option *option, const char *value, CauError *err) {
    cau_merge_light *light = &a->lights[a->light_count];
    char *name = string_copy(value);
    if (!name) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the command line");
    a->light_names[a->light_count++] = name;
    *light = (cau_merge_light){.light = name, .set = option->set};
    if (option->set & (CAU_MERGE_MUTE | CAU_MERGE_SOLO))
        return name[0] ? CAU_OK
                       : error_set(err, CAU_ERROR_USAGE, "%s needs the name of a light", option->name);
    char *equals = strrchr(name, '='); /* the last: a light's name may hold one */
    if (!equals || equals == name)
        return error_set(err, CAU_ERROR_USAGE, "%s: \"%s\" is not NAME=VALUE", option->name, value);
    *equals = '\0';
    return read_value(light, equals + 1, option->name, err);
}

static cau_result read_offset(Arguments *a, const char *value, CauError *err) {
    char *end;
    errno = 0;
    long x = strtol(value, &end, 10), y = 0;
    bool good = end != value && *end == ',';
    const char *second = end + 1;
    if (good) y = strtol(second, &end, 10);
    good = good && end != second && !*end && !errno && labs(x) < (1 << 29) && labs(y) < (1 << 29);
    if (!good) return error_set(err, CAU_ERROR_USAGE, "--offset: \"%s\" is not two whole numbers X,Y", value);
    a->options.has_offset = 1;
    a->options.offset_x = (int)x;
    a->options.offset_y = (int)y;
    return CAU_OK;
}

static cau_result unknown_option(const char *name, CauError *err) {
    const char *names[OPTIONS];
    for (int i = 0; i < OPTIONS; i++) names[i] = options[i].name;
    return error_set(err, CAU_ERROR_USAGE, "unknown option \"%s\"; did you mean %s? See caustic-merge --help",
        name, names[nearest_name(name, names, OPTIONS)]);
}

static cau_result take_value(Arguments *a, const Option *option, const char *value, CauError *err) {
    if (option->kind == LIGHT) return read_light(a, option, value, err);
    if (option->kind == EVERY) return read_every(a, value, err);
    if (option->kind == OFFSET) return read_offset(a, value, err);
    if (option->kind == THREADS) return read_threads(a, value, err);
    if (option->kind == STOPS && !whole_number(value, (double *)(void *)((char *)a + option->at)))
        return error_set(err, CAU_ERROR_USAGE, "%s: \"%s\" is not a finite number", option->name, value);
    if (option->kind == STOPS) return CAU_OK;
    if (option->kind == MEMORY) return read_memory(a, value, err);
    if (!value[0]) return error_set(err, CAU_ERROR_USAGE, "%s needs a value, not an empty one", option->name);
    if (strcmp(value, "-") == 0)
        return error_set(err, CAU_ERROR_USAGE,
            "%s: \"-\" is not a file name here; for a file of that name write ./-", option->name);
    if (option->kind == NAME) {
        a->holdout_names[a->holdout_name_count++] = value;
        return CAU_OK;
    }
    memcpy((char *)a + option->at, &value, sizeof value);
    return CAU_OK;
}

/* "--name=value" and "--name value" both work; *used says how many words were taken. */
static cau_result read_option(Arguments *a, int left, char **words, int *used, CauError *err) {
    const char *word = words[0], *equals = strncmp(word, "--", 2) == 0 ? strchr(word, '=') : NULL;
    size_t length = equals ? (size_t)(equals - word) : strlen(word);
    const Option *option = NULL;
    for (int i = 0; i < OPTIONS; i++)
        if (strlen(options[i].name) == length && strncmp(options[i].name, word, length) == 0)
            option = &options[i];
    *used = 1;
    if (!option) return unknown_option(word, err);
    if (option->at != offsetof(Arguments, quiet) && option->at != offsetof(Arguments, output) &&
        option->at != offsetof(Arguments, json))
        a->any_option = true;
    if (option->kind == FLAG || option->kind == SWITCH) {
        if (equals) return error_set(err, CAU_ERROR_USAGE, "%s takes no value", option->name);
        if (option->kind == SWITCH)
            *(int *)(void *)((char *)a + option->at) = 1;
        else
            *(bool *)((char *)a + option->at) = true;
        return CAU_OK;
    }
    if (!equals && left < 2) return error_set(err, CAU_ERROR_USAGE, "%s needs a value", option->name);
    const char *value = equals ? equals + 1 : words[(*used)++];
    return take_value(a, option, value, err);
}

static cau_result read_word(Arguments *a, const char *word, CauError *err) {
    if (strcmp(word, "-") == 0)
        return error_set(err, CAU_ERROR_USAGE,
            "\"-\" is not a file name here: pictures come from files; for a file of that name "
            "write ./-");
    if (!word[0]) return error_set(err, CAU_ERROR_USAGE, "a file name is empty");
    if (!a->command)
        a->command = word;
    else
        a->files[a->file_count++] = word;
    return CAU_OK;
}

cau_result arguments_parse(Arguments *out, int argc, char **argv, CauError *err) {
    *out = (Arguments){.options = {.size = sizeof(cau_merge_options)}};
    size_t most = (size_t)(argc > 0 ? argc : 1);
    out->files = array_new(most, sizeof *out->files);
    out->lights = array_new(most, sizeof *out->lights);
    out->light_names = array_new(most, sizeof *out->light_names);
    out->holdout_names = array_new(most, sizeof *out->holdout_names);
    if (!out->files || !out->lights || !out->light_names || !out->holdout_names)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the command line");
    bool only_files = false;
    for (int i = 1; i < argc;) {
        int used = 1;
        if (!only_files && strcmp(argv[i], "--") == 0)
            only_files = true;
        else if (!only_files && argv[i][0] == '-' && argv[i][1])
            CAU_TRY(read_option(out, argc - i, argv + i, &used, err));
        else
            CAU_TRY(read_word(out, argv[i], err));
        i += used;
    }
    out->options.lights = out->lights;
    out->options.light_count = out->light_count;
    out->options.holdout_names = out->holdout_names;
    out->options.holdout_name_count = out->holdout_name_count;
    return CAU_OK;
}

void arguments_free(Arguments *a) {
    for (size_t i = 0; i < a->light_count; i++) free(a->light_names[i]);
    free(a->light_names);
    free(a->holdout_names);
    free(a->lights);
    free(a->files);
    *a = (Arguments){0};
}
