/* SPDX-License-Identifier: Apache-2.0 */
/* Settings of lights without a picture: read from a recipe's text, and written as one. */
#include "composite/hosts/hosts.h"

#include "core/checked.h"

#include <jansson.h>

void host_number(char *out, double value) {
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(out, HOST_NUMBER_MAX, "%.*g", digits, value);
        if (strtod(out, NULL) == value) return;
    }
}

cau_result host_light(Light **out, Lights *lights, const char *name, CauError *err) {
    size_t prefix = strlen(CAU_LAYER_PREFIX);
    if (strncmp(name, CAU_LAYER_PREFIX, prefix) == 0 && name[prefix]) name += prefix;
    for (size_t i = 0; i < lights->count; i++) {
        *out = &lights->lights[i];
        if (strcmp((*out)->name, name) == 0) return CAU_OK;
    }
    void *array = lights->lights;
    bool ok = array_reserve(&array, &lights->capacity, lights->count + 1, sizeof **out);
    lights->lights = array;
    if (ok) {
        *out = &lights->lights[lights->count++];
        char *base = malloc(prefix + strlen(name) + 1);
        if (base) sprintf(base, "%s%s", CAU_LAYER_PREFIX, name);
        **out =
            (Light){string_copy(name), base, string_copy(""), -1, -1, -1, -1, setting_plain, setting_plain};
        ok = (*out)->name && base && (*out)->place;
    }
    return ok ? CAU_OK : error_set(err, CAU_ERROR_RESOURCE, "out of memory for the list of lights");
}

cau_result host_read_recipe(Lights *out, const char *json, const char *from, CauError *err) {
    json_t *root = json_loads(json, 0, NULL); /* what is wrong with it is said below */
    const char *name;
    json_t *unused;
    cau_result result = CAU_OK;
    json_object_foreach(json_object_get(root, "lights"), name, unused) {
        Light *light;
        if (result == CAU_OK) result = host_light(&light, out, name, err);
    }
    json_decref(root);
    return result == CAU_OK ? recipe_apply_text(out, json, from, err) : result;
}

static void put_light(FILE *out, const Light *l, bool first) {
    const Setting *s = &l->both;
    char number[5][HOST_NUMBER_MAX], more[2][HOST_NUMBER_MAX];
    host_number(number[0], s->gain);
    host_number(number[1], s->ev);
    for (int i = 0; i < 3; i++) host_number(number[2 + i], s->tint[i]);
    host_number(more[0], s->temperature_k);
    host_number(more[1], s->saturation);
    json_t *text = json_string(l->name);
    char *name = text ? json_dumps(text, JSON_ENCODE_ANY) : NULL;
    fprintf(out, "%s  %s: {\"gain\": %s, \"ev\": %s, \"tint\": [%s, %s, %s], ", first ? "" : ",\n",
        name ? name : "\"(not UTF-8)\"", number[0], number[1], number[2], number[3], number[4]);
    if (s->temperature_k != setting_plain.temperature_k) fprintf(out, "\"temperature\": %s, ", more[0]);
    if (s->saturation != 1) fprintf(out, "\"saturation\": %s, ", more[1]);
    fprintf(out, "\"mute\": %s, \"solo\": %s}", s->mute ? "true" : "false", s->solo ? "true" : "false");
    free(name);
    json_decref(text);
}

char *host_recipe_text(const Lights *lights) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    json_t *space = lights->tint_space ? json_string(lights->tint_space) : NULL;
    char *quoted = space ? json_dumps(space, JSON_ENCODE_ANY) : NULL;
    fputs("{\"caustics_recipe\": 1, ", out);
    if (quoted) fprintf(out, "\"tint_space\": %s, ", quoted);
    fputs("\"lights\": {\n", out);
    free(quoted);
    json_decref(space);
    for (size_t i = 0; i < lights->count; i++) put_light(out, &lights->lights[i], i == 0);
    fputs("\n}}\n", out);
    if (fclose(out) == 0) return text;
    free(text);
    return NULL;
}
