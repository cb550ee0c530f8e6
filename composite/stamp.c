/* SPDX-License-Identifier: Apache-2.0 */
/* Is this output that of these inputs and settings? By content: times of files lie on a farm. */
#include "composite/job.h"

#include "core/checked.h"
#include "core/rng.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

typedef struct Stamp {
    uint64_t a, b;
} Stamp;

/* Two multiplicative hashes of 64 bits each: against accidents, not against forgers. */
static void add_bytes(Stamp *s, const void *data, size_t count) {
    const uint8_t *bytes = data;
    size_t i = 0;
    for (; i + 8 <= count; i += 8) {
        uint64_t v;
        memcpy(&v, bytes + i, 8);
        s->a = (s->a ^ v) * 0x9e3779b97f4a7c15u;
        s->a ^= s->a >> 29;
        s->b = (s->b + v) * 0xd1342543de82ef95u;
        s->b ^= s->b >> 31;
    }
    for (; i < count; i++) {
        s->a = (s->a ^ bytes[i]) * 0x9e3779b97f4a7c15u;
        s->b = (s->b + bytes[i]) * 0xd1342543de82ef95u;
    }
    s->a = rng_mix(s->a ^ count);
    s->b = rng_mix(s->b + count);
}

static void add_text(Stamp *s, const char *text) {
    add_bytes(s, text ? text : "", text ? strlen(text) + 1 : 0);
}

static cau_result add_file(Stamp *s, const char *path, CauError *err) {
    enum { BLOCK = 1 << 20 };
    if (!path) return CAU_OK;
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return error_set(
            err, CAU_ERROR_INPUT, "cannot open \"%s\": %s; check the name", path, strerror(errno));
    uint8_t *block = malloc(BLOCK);
    ssize_t n = -1;
    while (block && (n = read(fd, block, BLOCK)) > 0) add_bytes(s, block, (size_t)n);
    int cause = errno;
    close(fd);
    if (!block) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for reading \"%s\"", path);
    free(block);
    return n == 0 ? CAU_OK : error_set(err, CAU_ERROR_INPUT, "cannot read \"%s\": %s", path, strerror(cause));
}

static void add_options(Stamp *s, const cau_merge_options *o) {
    const char *texts[] = {"caustic-merge " CAUSTICS_VERSION, o->pass, o->albedo, o->beauty_space,
        o->caustics_space, o->tint_space, o->compression};
    int numbers[] = {o->allow_incomplete, o->has_offset, o->offset_x, o->offset_y, o->into_groups,
        o->into_diffuse, o->keep_layers, o->holdout_alpha};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) add_text(s, texts[i]);
    add_bytes(s, numbers, sizeof numbers);
    for (size_t i = 0; i < o->light_count; i++) {
        const cau_merge_light *l = &o->lights[i];
        double values[] = {l->gain, l->ev, l->tint[0], l->tint[1], l->tint[2], l->temperature_k,
            l->saturation, (double)l->set};
        add_text(s, l->light);
        add_bytes(s, values, sizeof values);
    }
    for (size_t i = 0; i < o->holdout_name_count; i++) add_text(s, o->holdout_names[i]);
}

/* "FILE" or "FILE:CHANNEL". */
static cau_result add_holdout(Stamp *s, const char *given, CauError *err) {
    char *path = string_copy(given), *colon = path ? strrchr(path, ':') : NULL;
    if (!path) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for a name");
    if (access(given, F_OK) != 0 && colon) *colon = '\0';
    cau_result result = add_file(s, path, err);
    add_text(s, given + strlen(path));
    free(path);
    return result;
}

cau_result stamp_make(char out[STAMP_MAX], const cau_merge_options *o, CauError *err) {
    Stamp s = {1, 2};
    const char *config = o->ocio ? o->ocio : getenv("OCIO");
    add_options(&s, o);
    add_text(&s, config);
    CAU_TRY(add_file(&s, o->beauty, err));
    CAU_TRY(add_file(&s, o->caustics, err));
    CAU_TRY(add_file(&s, o->recipe, err));
    if (config && access(config, R_OK) == 0) CAU_TRY(add_file(&s, config, err));
    if (o->holdout) CAU_TRY(add_holdout(&s, o->holdout, err));
    snprintf(out, STAMP_MAX, "%016llx%016llx", (unsigned long long)s.a, (unsigned long long)s.b);
    return CAU_OK;
}

/* Nothing was cut off: the last chunks can be read. */
static bool is_whole(const Picture *p) {
    ExrDecoder *decoder = NULL;
    ExrPacked packed = {0};
    CauError unused = {0};
    bool whole = exr_decoder_create(&decoder, p->reader, &unused) == CAU_OK;
    for (size_t i = 0; whole && i < p->header->part_count; i++) {
        const ExrPart *part = &p->header->parts[i];
        ExrBands bands = exr_bands(part, exr_band_rows(part));
        int32_t y0, y1;
        exr_band_at(&bands, bands.count - 1, &y0, &y1);
        whole = exr_decoder_packed(decoder, i, y0, y1, &packed, &unused) == CAU_OK;
    }
    exr_packed_free(&packed);
    exr_decoder_free(&decoder);
    return whole;
}

bool stamp_matches(const char *file, const char *stamp) {
    Picture picture;
    CauError unused = {0};
    char *found = NULL;
    bool whole = access(file, R_OK) == 0 && picture_open(&picture, file, &unused) == CAU_OK;
    if (whole) found = exr_attr_text(exr_attr_find(&picture.header->parts[0], CAU_ATTRIBUTE_STAMP));
    whole = whole && found && strcmp(found, stamp) == 0 && is_whole(&picture);
    free(found);
    if (access(file, R_OK) == 0) picture_close(&picture);
    return whole;
}
