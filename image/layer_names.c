/* SPDX-License-Identifier: Apache-2.0 */
#include "image/layer_names.h"

#include "core/checked.h"

#include <stdint.h>
#include <stdio.h>

enum { HASH_TAIL = 5 }; /* "_1a2b" */

static const char *const suffixes[] = {
    CAU_SUFFIX_INDIRECT, CAU_SUFFIX_IRRADIANCE, CAU_SUFFIX_SEEN, CAU_SUFFIX_ERROR, CAU_SUFFIX_BIAS};

static bool ends_with(const char *text, const char *end) {
    size_t n = strlen(text), m = strlen(end);
    return n >= m && strcmp(text + n - m, end) == 0;
}

static bool reserved_end(const char *base) {
    for (size_t i = 0; i < sizeof suffixes / sizeof *suffixes; i++)
        if (ends_with(base, suffixes[i])) return true;
    return false;
}

static bool plain(unsigned char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

/* FNV-1a, folded to 16 bits. `again` makes another one when the first is taken. */
static unsigned hash_name(const char *name, unsigned again) {
    uint32_t h = 2166136261u + again * 16777619u;
    for (const unsigned char *c = (const unsigned char *)name; *c; c++) h = (h ^ *c) * 16777619u;
    return (h ^ h >> 16) & 0xffffu;
}

/* Prefix and light with one underscore for every character that is not plain; false when it was cut. */
static bool sanitise(const char *light, char *out) {
    size_t n = (size_t)snprintf(out, LAYER_BASE_MAX + 1, "%s", CAU_LAYER_PREFIX);
    for (const unsigned char *c = (const unsigned char *)light; *c; c++) {
        if ((*c & 0xc0) == 0x80) continue; /* the rest of a UTF-8 character */
        if (n == LAYER_BASE_MAX) return false;
        out[n++] = plain(*c) ? (char)*c : '_';
        out[n] = '\0';
    }
    return n > strlen(CAU_LAYER_PREFIX);
}

static void append_hash(char *base, const char *light, unsigned again) {
    size_t keep = strlen(base);
    if (keep > LAYER_BASE_MAX - HASH_TAIL) keep = LAYER_BASE_MAX - HASH_TAIL;
    snprintf(base + keep, HASH_TAIL + 1, "_%04x", hash_name(light, again));
}

static bool taken(const LayerBase *bases, size_t count, size_t except, const char *name) {
    for (size_t i = 0; i < count; i++)
        if (i != except && strcmp(bases[i].name, name) == 0) return true;
    return false;
}

cau_result layer_names_map(const char *const *lights, size_t count, LayerBase *out, CauError *err) {
    bool *hashed = array_new(count, sizeof *hashed);
    if (!hashed)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for the names of %zu lights", count);
    for (size_t i = 0; i < count; i++) {
        bool whole = sanitise(lights[i], out[i].name);
        hashed[i] = !whole || reserved_end(out[i].name);
    }
    /* Both sides of a clash are changed, so that neither depends on which light came first. */
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < i; k++)
            if (strcmp(out[i].name, out[k].name) == 0) hashed[i] = hashed[k] = true;
    for (size_t i = 0; i < count; i++) {
        if (!hashed[i]) continue;
        char base[LAYER_BASE_MAX + 1];
        memcpy(base, out[i].name, sizeof base);
        unsigned again = 0;
        do {
            memcpy(out[i].name, base, sizeof base);
            append_hash(out[i].name, lights[i], again++);
        } while (taken(out, count, i, out[i].name) && again < 0x10000u);
    }
    for (size_t i = 0; i < count; i++)
        out[i].mapped = strcmp(out[i].name + strlen(CAU_LAYER_PREFIX), lights[i]) != 0;
    free(hashed);
    return CAU_OK;
}

static bool cut_suffix(char *text, const char *suffix) {
    size_t n = strlen(text), m = strlen(suffix);
    if (n <= m || strcmp(text + n - m, suffix) != 0) return false;
    text[n - m] = '\0';
    return true;
}

bool layer_name_parse(const char *layer, char *light, cau_layer_kind *kind) {
    size_t prefix = strlen(CAU_LAYER_PREFIX);
    if (strncmp(layer, CAU_LAYER_PREFIX, prefix) != 0 || !layer[prefix]) return false;
    memcpy(light, layer + prefix, strlen(layer + prefix) + 1);
    *kind = CAU_LAYER_RADIANCE;
    if (cut_suffix(light, CAU_SUFFIX_ERROR))
        *kind = CAU_LAYER_ERROR;
    else if (cut_suffix(light, CAU_SUFFIX_BIAS))
        *kind = CAU_LAYER_BIAS;
    else if (cut_suffix(light, CAU_SUFFIX_IRRADIANCE))
        *kind = CAU_LAYER_IRRADIANCE;
    else if (cut_suffix(light, CAU_SUFFIX_SEEN))
        *kind = CAU_LAYER_SEEN;
    if (cut_suffix(light, CAU_SUFFIX_INDIRECT) && *kind == CAU_LAYER_RADIANCE) *kind = CAU_LAYER_INDIRECT;
    return true;
}
