/* SPDX-License-Identifier: Apache-2.0 */
/* In which colour space a picture is, and whether light may be added there. */
#include "composite/job.h"
#include "composite/report.h"
#include "core/checked.h"
#include "core/nearest.h"

#include <math.h>
#include <stdio.h>
#include <strings.h>

static bool ends_with(const char *text, const char *end) {
    size_t n = strlen(text), m = strlen(end);
    return n >= m && strcasecmp(text + n - m, end) == 0;
}

/* `file`: what says so; NULL: the user did, by the option. */
static cau_result not_linear(
    const Job *job, const char *file, const char *space, ColourKind kind, const char *option) {
    static const char *const reasons[] = {
        [COLOUR_DISPLAY] = "display-referred: light can only be added before the view; save the picture "
                           "scene-linear, as OpenEXR without a view, or name its true space",
        [COLOUR_DATA] = "data and not a colour: name the linear colour space of the picture",
        [COLOUR_ENCODED] = "not scene-linear: light cannot be added to encoded values; save the picture "
                           "scene-linear, or name its true space",
        [COLOUR_LINEAR] = ""};
    if (!file)
        return error_set(
            job->err, CAU_ERROR_INPUT, "%s: the space \"%s\" is %s", option, space, reasons[kind]);
    return error_set(job->err, CAU_ERROR_INPUT, "\"%s\" is in the space \"%s\", which is %s with %s", file,
        space, reasons[kind], option);
}

static cau_result unknown_space(const Job *job, const char *file, const char *name, const char *option) {
    if (ends_with(name, "_display")) return not_linear(job, file, name, COLOUR_DISPLAY, option);
    size_t count = colour_name_count(job->colour), used = 0;
    const char **names = array_new(count, sizeof *names);
    char text[400] = "";
    for (size_t i = 0; names && i < count; i++) {
        names[i] = colour_name_at(job->colour, i);
        if (used + strlen(names[i]) + 8 < sizeof text)
            used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", i ? ", " : "", names[i]);
    }
    int nearest = names ? nearest_name(name, names, count) : -1;
    error_set(job->err, CAU_ERROR_INPUT,
        "%s%s%s: %s has no colour space \"%s\"; did you mean \"%s\"? It has: %s", file ? "\"" : "",
        file ? file : option, file ? "\"" : "", colour_origin(job->colour), name,
        nearest >= 0 ? names[nearest] : "", text);
    free(names);
    return CAU_ERROR_INPUT;
}

static cau_result check_linear(
    const char **out, const Job *job, const char *file, const char *space, const char *option) {
    ColourKind kind = colour_kind(job->colour, space);
    if (kind != COLOUR_LINEAR) return not_linear(job, file, space, kind, option);
    *out = space;
    return CAU_OK;
}

/* By the names under which configurations list a space; NULL. */
static const char *by_name(const Colour *colour, const char *id) {
    const char *space = colour_resolve(colour, id), *other;
    for (size_t i = 0; !space && i < colour_id_count(); i++)
        if (strcmp(colour_id_at(i), id) == 0)
            for (size_t k = 0; !space && (other = colour_id_other_name(i, k)); k++)
                space = colour_resolve(colour, other);
    return space;
}

static bool is_linear_id(const char *id) { return strncmp(id, "lin_", 4) == 0; }

/* Another linear space that both configurations have by name. */
static bool find_anchor(
    const Colour *colour, const Colour *ours, const char *id, const char **theirs, const char **our_own) {
    for (size_t i = 0; i < colour_id_count(); i++) {
        const char *other = colour_id_at(i);
        if (strcmp(other, id) == 0 || !is_linear_id(other)) continue;
        *theirs = by_name(colour, other);
        *our_own = by_name(ours, other);
        if (*theirs && *our_own && colour_kind(colour, *theirs) == COLOUR_LINEAR) return true;
    }
    return false;
}

/* Blender 3 calls linear Rec.709 "Linear". So: the linear space that is to a space known by name as it must
 * be. Configurations state their matrices to four digits. */
static const char *by_matrix(const Colour *colour, const Colour *ours, const char *id) {
    const char *theirs, *our_own, *wanted_name = by_name(ours, id);
    double wanted[9], found[9];
    bool same;
    CauError unused = {0};
    if (!wanted_name || !is_linear_id(id) || !find_anchor(colour, ours, id, &theirs, &our_own) ||
        colour_matrix(ours, wanted_name, our_own, wanted, &same, &unused) != CAU_OK)
        return NULL;
    for (size_t i = 0; i < colour_name_count(colour); i++) {
        const char *space = colour_resolve(colour, colour_name_at(colour, i));
        bool match = space && colour_kind(colour, space) == COLOUR_LINEAR &&
                     colour_matrix(colour, space, theirs, found, &same, &unused) == CAU_OK;
        for (int k = 0; match && k < 9; k++) match = fabs(found[k] - wanted[k]) <= 1e-3;
        if (match) return space;
    }
    return NULL;
}

/* Configurations differ in what they call a space. */
const char *space_of_id(const Colour *colour, const char *id) {
    const char *space = by_name(colour, id);
    Colour *ours = NULL;
    CauError unused = {0};
    if (space || colour_open(&ours, "builtin", &unused) != CAU_OK) return space;
    space = by_matrix(colour, ours, id);
    colour_close(&ours);
    return space;
}

static bool is_name_of(size_t id, const char *name) {
    if (strcasecmp(colour_id_at(id), name) == 0) return true;
    const char *other;
    for (size_t k = 0; (other = colour_id_other_name(id, k)); k++)
        if (strcasecmp(other, name) == 0) return true;
    return false;
}

cau_result space_named(const char **out, const Job *job, const char *name, const char *option) {
    const char *space = colour_resolve(job->colour, name);
    for (size_t i = 0; !space && i < colour_id_count(); i++)
        if (is_name_of(i, name)) space = space_of_id(job->colour, colour_id_at(i));
    if (!space) return unknown_space(job, NULL, name, option);
    return check_linear(out, job, NULL, space, option);
}

/* What is believed is used; what contradicts it is told. */
static void tell_other(
    const Job *job, const Picture *picture, size_t part, const ColourTag *tag, const char *option) {
    ColourTag other;
    if (!colour_tag_other(&other, picture->header, part, tag)) return;
    job_notice(job,
        "\"%s\" says its colour space twice: %s by %s, which is believed, and %s by %s (%s overrides)",
        exr_reader_path(picture->reader), tag->id, report_tag_source((int)tag->source), other.id,
        report_tag_source((int)other.source), option);
}

cau_result space_find(const char **out, ColourTagSource *source, const Job *job, const Picture *picture,
    size_t part, const char *said, const char *option) {
    const char *file = exr_reader_path(picture->reader);
    *source = COLOUR_TAG_NONE;
    if (said) return space_named(out, job, said, option);
    ColourTag tag;
    colour_tag_read(&tag, picture->header, part);
    if (tag.source == COLOUR_TAG_NONE)
        return error_set(job->err, CAU_ERROR_INPUT,
            "\"%s\" %s: name its colour space with %s, for example %s \"Linear Rec.709\"", file,
            tag.unknown_chromaticities ? "has the chromaticities of no known colour space"
                                       : "does not say in which colour space it is",
            option, option);
    const char *space = space_of_id(job->colour, tag.id);
    if (!space) return unknown_space(job, file, tag.id, option);
    if (tag.source == COLOUR_TAG_BLENDER)
        job_notice(job,
            "\"%s\" does not say its colour space; it was written by Blender, so it is taken as \"%s\" "
            "(%s overrides)",
            file, space, option);
    tell_other(job, picture, part, &tag, option);
    *source = tag.source;
    return check_linear(out, job, file, space, option);
}

const char *space_id(const Colour *colour, const char *space) {
    const char *alias;
    for (size_t i = 0; i < colour_id_count(); i++) {
        if (is_name_of(i, space)) return colour_id_at(i);
        for (size_t k = 0; (alias = colour_alias_at(colour, space, k)); k++)
            if (is_name_of(i, alias)) return colour_id_at(i);
    }
    for (size_t i = 0; i < colour_id_count(); i++) {
        const char *found = space_of_id(colour, colour_id_at(i));
        if (found && strcmp(found, space) == 0) return colour_id_at(i);
    }
    return NULL;
}
