/* SPDX-License-Identifier: Apache-2.0 */
/* Where no caustics go: a mask, the beauty's alpha, objects by their Cryptomatte names. */
#include "composite/stream.h"

#include "core/checked.h"
#include "core/nearest.h"

#include <jansson.h>
#include <stdio.h>
#include <unistd.h>

/* MurmurHash3_x86_32 (Austin Appleby, public domain), seed 0, as the Cryptomatte specification 1.2.0 asks. */
static uint32_t murmur3(const unsigned char *bytes, size_t count) {
    uint32_t h = 0, k = 0;
    size_t i = 0;
    for (; i + 4 <= count; i += 4) {
        memcpy(&k, bytes + i, 4);
        k *= 0xcc9e2d51u;
        k = (k << 15 | k >> 17) * 0x1b873593u;
        h ^= k;
        h = (h << 13 | h >> 19) * 5 + 0xe6546b64u;
    }
    k = 0;
    for (size_t j = count; j-- > i;) k = k << 8 | bytes[j];
    k *= 0xcc9e2d51u;
    h ^= (k << 15 | k >> 17) * 0x1b873593u;
    h ^= (uint32_t)count;
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

static float id_float(uint32_t hash) {
    uint32_t exponent = hash >> 23 & 255;
    if (exponent == 0 || exponent == 255) hash ^= 1u << 23; /* neither denormal nor infinite nor NaN */
    float id;
    memcpy(&id, &hash, sizeof id);
    return id;
}

float holdout_name_id(const char *name) {
    return id_float(murmur3((const unsigned char *)name, strlen(name)));
}

/* One Cryptomatte of the beauty: "ViewLayer.CryptoObject". */
typedef struct Matte {
    char *layer;
    json_t *manifest; /* name: hash as text; NULL */
} Matte;

typedef struct Mattes {
    Matte *mattes;
    size_t count, capacity;
} Mattes;

static void free_mattes(Mattes *m) {
    for (size_t i = 0; i < m->count; i++) {
        free(m->mattes[i].layer);
        json_decref(m->mattes[i].manifest);
    }
    free(m->mattes);
}

static cau_result no_memory(const Job *job) {
    return error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for the holdout");
}

/* cryptomatte/ID/name and cryptomatte/ID/manifest. */
static cau_result add_matte(const Job *job, Mattes *out, const ExrPart *part, const ExrAttr *attr) {
    size_t length = strlen(attr->name);
    char key[300];
    snprintf(key, sizeof key, "%.*smanifest", (int)(length - strlen("name")), attr->name);
    char *manifest = exr_attr_text(exr_attr_find(part, key)), *layer = exr_attr_text(attr);
    void *array = out->mattes;
    if (!layer || !array_reserve(&array, &out->capacity, out->count + 1, sizeof *out->mattes)) {
        free(manifest);
        free(layer);
        return layer ? no_memory(job) : CAU_OK;
    }
    out->mattes = array;
    out->mattes[out->count++] =
        (Matte){.layer = layer, .manifest = manifest ? json_loads(manifest, 0, NULL) : NULL};
    free(manifest);
    return CAU_OK;
}

static cau_result find_mattes(const Job *job, Mattes *out) {
    const ExrHeader *header = job->beauty.header;
    for (size_t i = 0; i < header->part_count; i++)
        for (size_t a = 0; a < header->parts[i].attr_count; a++) {
            const char *name = header->parts[i].attrs[a].name, *last = strrchr(name, '/');
            if (strncmp(name, "cryptomatte/", 12) == 0 && last > name + 11 && strcmp(last, "/name") == 0)
                CAU_TRY(add_matte(job, out, &header->parts[i], &header->parts[i].attrs[a]));
        }
    return CAU_OK;
}

/* "ViewLayer.CryptoObject00.r"; in one part of several views "ViewLayer.CryptoObject00.left.r". */
static int find_channel(
    const Job *job, const ExrPart *part, const char *layer, int rank, const char *letters) {
    const char *view = job->target->view ? job->target->view : "";
    char names[2][512];
    for (; *letters; letters++) {
        snprintf(names[0], sizeof names[0], "%s%02d.%c", layer, rank, *letters);
        snprintf(names[1], sizeof names[1], "%s%02d.%s.%c", layer, rank, view, *letters);
        for (size_t c = 0; c < part->channel_count; c++)
            if (strcmp(part->channels[c].name, names[0]) == 0 ||
                strcmp(part->channels[c].name, names[1]) == 0)
                return (int)c;
    }
    return -1;
}

/* The parts of a stereo picture that belong to another view than the target. */
static bool is_of_other_view(const Job *job, const ExrPart *part) {
    char *view = exr_attr_text(exr_attr_find(part, "view"));
    bool other = view && job->target->view && strcmp(view, job->target->view) != 0;
    free(view);
    return other;
}

static cau_result add_rank(Job *job, size_t part, int id, int coverage) {
    Holdout *h = &job->holdout;
    void *array = h->ranks;
    for (size_t i = 0; i < h->rank_count; i++)
        if (h->ranks[i].part == part && h->ranks[i].id == id) return CAU_OK;
    if (!array_reserve(&array, &h->rank_capacity, h->rank_count + 1, sizeof *h->ranks)) return no_memory(job);
    h->ranks = array;
    h->ranks[h->rank_count++] = (struct HoldoutRank){part, id, coverage};
    return CAU_OK;
}

static cau_result add_ranks(Job *job, const char *layer) {
    const ExrHeader *header = job->beauty.header;
    size_t before = job->holdout.rank_count, matches = 0;
    for (int rank = 0; rank < 100; rank++)
        for (size_t i = 0; i < header->part_count; i++) {
            const ExrPart *part = &header->parts[i];
            if (is_of_other_view(job, part)) continue;
            int r = find_channel(job, part, layer, rank, "rR"),
                g = find_channel(job, part, layer, rank, "gG");
            int b = find_channel(job, part, layer, rank, "bB"),
                a = find_channel(job, part, layer, rank, "aA");
            if (r >= 0 && g >= 0) CAU_TRY(add_rank(job, i, r, g));
            if (b >= 0 && a >= 0) CAU_TRY(add_rank(job, i, b, a));
            matches += r >= 0 && g >= 0;
        }
    if (matches || job->holdout.rank_count > before) return CAU_OK;
    return error_set(job->err, CAU_ERROR_INPUT,
        "\"%s\" lists the Cryptomatte \"%s\", but has no channels %s00.r", job->options->beauty, layer,
        layer);
}

static cau_result unknown_name(const Job *job, const Mattes *m, const char *name) {
    const char **names = NULL, *key;
    size_t count = 0, capacity = 0;
    json_t *value;
    for (size_t i = 0; i < m->count; i++) json_object_foreach(m->mattes[i].manifest, key, value) {
            void *array = names;
            if (!array_reserve(&array, &capacity, count + 1, sizeof *names)) break;
            names = array;
            names[count++] = key;
        }
    int nearest = nearest_name(name, names, count);
    error_set(job->err, CAU_ERROR_INPUT, "\"%s\" has no Cryptomatte name \"%s\"%s%s%s", job->options->beauty,
        name, nearest >= 0 ? "; did you mean \"" : ": render it with Cryptomatte passes",
        nearest >= 0 ? names[nearest] : "", nearest >= 0 ? "\"?" : "");
    free(names);
    return CAU_ERROR_INPUT;
}

/* The first Cryptomatte that lists the name; without manifests the name's hash in the first of all. */
static cau_result add_name(Job *job, const Mattes *m, const char *name) {
    Holdout *h = &job->holdout;
    bool listed = false;
    for (size_t i = 0; i < m->count; i++) {
        listed = listed || m->mattes[i].manifest;
        const char *hex = json_string_value(json_object_get(m->mattes[i].manifest, name));
        if (!hex) continue;
        h->ids[h->id_count++] = id_float((uint32_t)strtoul(hex, NULL, 16));
        return add_ranks(job, m->mattes[i].layer);
    }
    if (!m->count || listed) return unknown_name(job, m, name);
    h->ids[h->id_count++] = holdout_name_id(name);
    return add_ranks(job, m->mattes[0].layer);
}

static cau_result open_names(Job *job) {
    const cau_merge_options *o = job->options;
    Mattes mattes = {0};
    if (!o->holdout_name_count) return CAU_OK;
    job->holdout.ids = array_new(o->holdout_name_count, sizeof *job->holdout.ids);
    if (!job->holdout.ids) return no_memory(job);
    cau_result result = find_mattes(job, &mattes);
    for (size_t i = 0; result == CAU_OK && i < o->holdout_name_count; i++)
        result = add_name(job, &mattes, o->holdout_names[i]);
    free_mattes(&mattes);
    return result;
}

static int channel_named(const ExrPart *part, const char *name) {
    for (size_t c = 0; c < part->channel_count; c++)
        if (strcmp(part->channels[c].name, name) == 0) return (int)c;
    return -1;
}

static cau_result choose_mask_channel(Job *job, const char *wanted) {
    static const char *const usual[] = {"A", "Y", "R"};
    Holdout *h = &job->holdout;
    for (size_t i = 0; i < (wanted ? 1 : sizeof usual / sizeof *usual); i++)
        for (size_t p = 0; p < h->mask.header->part_count; p++) {
            h->mask_part = p;
            h->mask_channel = channel_named(&h->mask.header->parts[p], wanted ? wanted : usual[i]);
            if (h->mask_channel >= 0) return CAU_OK;
        }
    return error_set(job->err, CAU_ERROR_INPUT, "--holdout: \"%s\" has no channel %s%s",
        exr_reader_path(h->mask.reader), wanted ? wanted : "A, Y or R",
        wanted ? "" : ": name one, FILE:CHANNEL");
}

static cau_result open_mask(Job *job) {
    const char *given = job->options->holdout;
    if (!given) return CAU_OK;
    char *path = string_copy(given);
    if (!path) return no_memory(job);
    char *colon = access(given, F_OK) != 0 ? strrchr(path, ':') : NULL;
    if (colon) *colon = '\0';
    cau_result result = picture_open(&job->holdout.mask, path, job->err);
    if (result == CAU_OK) result = choose_mask_channel(job, colon ? colon + 1 : NULL);
    free(path);
    CAU_TRY(result);
    const Picture *mask = &job->holdout.mask;
    CAU_TRY(exr_reader_can_read(mask->reader, job->holdout.mask_part, job->err));
    ExrBox a = mask->header->parts[job->holdout.mask_part].display_window,
           b = job->beauty.header->parts[job->target->part].display_window;
    if (exr_box_width(a) == exr_box_width(b) && exr_box_height(a) == exr_box_height(b)) return CAU_OK;
    return error_set(job->err, CAU_ERROR_INPUT,
        "the holdout \"%s\" is %lld x %lld pixels, the beauty %lld x %lld; render both alike",
        exr_reader_path(mask->reader), (long long)exr_box_width(a), (long long)exr_box_height(a),
        (long long)exr_box_width(b), (long long)exr_box_height(b));
}

static cau_result open_alpha(Job *job) {
    const ExrPart *part = &job->beauty.header->parts[job->target->part];
    if (!job->options->holdout_alpha) return CAU_OK;
    char name[512];
    snprintf(
        name, sizeof name, "%s%sA", job->target->bare ? "" : job->target->name, job->target->bare ? "" : ".");
    job->holdout.by_alpha = true;
    job->holdout.alpha = channel_named(part, name);
    if (job->holdout.alpha >= 0) return CAU_OK;
    return error_set(job->err, CAU_ERROR_INPUT,
        "--holdout-alpha: \"%s\" has no channel %s; render it with a transparent film as RGBA",
        job->options->beauty, name);
}

cau_result holdout_open(Job *job) {
    CAU_TRY(open_mask(job));
    CAU_TRY(open_alpha(job));
    return open_names(job);
}

void holdout_close(Holdout *h) {
    picture_close(&h->mask);
    free(h->ranks);
    free(h->ids);
    *h = (Holdout){0};
}

cau_result holdout_load(const Job *job, Lane *lane, CauError *err) {
    const Holdout *h = &job->holdout;
    if (h->mask.header) CAU_TRY(source_load(&lane->mask, h->mask_part, err));
    if (h->by_alpha) CAU_TRY(source_load(&lane->beauty, job->target->part, err));
    for (size_t i = 0; i < h->rank_count; i++) CAU_TRY(source_load(&lane->beauty, h->ranks[i].part, err));
    return CAU_OK;
}

static double unit(double v) { return v > 0 ? (v < 1 ? v : 1) : 0; } /* NaN: 0 */

static bool is_held(const Holdout *h, double id) {
    for (size_t i = 0; i < h->id_count; i++)
        if ((float)id == h->ids[i]) return true;
    return false;
}

void holdout_row(const Job *job, const Lane *lane, int64_t y, int64_t x0, size_t count, double *left,
    double *id, double *coverage) {
    const Holdout *h = &job->holdout;
    for (size_t i = 0; i < count; i++) left[i] = 0;
    for (size_t k = 0; k < h->rank_count; k++) {
        source_row(&lane->beauty, h->ranks[k].part, h->ranks[k].id, y, x0, count, id);
        source_row(&lane->beauty, h->ranks[k].part, h->ranks[k].coverage, y, x0, count, coverage);
        for (size_t i = 0; i < count; i++)
            if (is_held(h, id[i])) left[i] += unit(coverage[i]);
    }
    for (size_t i = 0; i < count; i++) left[i] = 1 - unit(left[i]);
    if (h->mask.header) {
        source_row(&lane->mask, h->mask_part, h->mask_channel, y, x0, count, coverage);
        for (size_t i = 0; i < count; i++) left[i] *= 1 - unit(coverage[i]);
    }
    if (h->by_alpha) {
        source_row(&lane->beauty, job->target->part, h->alpha, y, x0, count, coverage);
        for (size_t i = 0; i < count; i++) left[i] *= unit(coverage[i]);
    }
}
