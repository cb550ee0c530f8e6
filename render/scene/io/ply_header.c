/* SPDX-License-Identifier: Apache-2.0 */
#include "render/scene/io/ply.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINE_MAX_BYTES = 512 };

static cau_result bad_line(const Ply *p, const char *line) {
    return error_set(p->reader->err, CAU_ERROR_INPUT,
        "%s: its PLY header holds the line \"%.80s\"; it cannot be read", p->place, line);
}

size_t ply_type_size(PlyType type) {
    static const size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[type];
}

static bool find_type(const char *name, PlyType *out) {
    static const char *const names[8][2] = {{"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},
        {"ushort", "uint16"}, {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"},
        {"double", "float64"}};
    for (int i = 0; i < 8; i++)
        if (strcmp(names[i][0], name) == 0 || strcmp(names[i][1], name) == 0) {
            *out = (PlyType)i;
            return true;
        }
    return false;
}

/* The next line without its end; false at the end of the file or when it is too long. */
static bool next_line(Ply *p, char line[LINE_MAX_BYTES]) {
    size_t left = (size_t)(p->end - p->at);
    const char *stop = memchr(p->at, '\n', left);
    if (!stop || stop - p->at >= LINE_MAX_BYTES) return false;
    size_t n = (size_t)(stop - p->at);
    memcpy(line, p->at, n);
    if (n > 0 && line[n - 1] == '\r') n--;
    line[n] = '\0';
    p->at = stop + 1;
    return true;
}

static cau_result read_format(Ply *p, const char *line) {
    static const char *const names[] = {
        "format ascii 1.0", "format binary_little_endian 1.0", "format binary_big_endian 1.0"};
    for (int i = 0; i < 3; i++)
        if (strcmp(line, names[i]) == 0) {
            p->format = (PlyFormat)i;
            return CAU_OK;
        }
    return bad_line(p, line);
}

static cau_result read_element(Ply *p, const char *line) {
    char rest;
    uint64_t count;
    if (p->element_count == PLY_ELEMENTS_MAX) return bad_line(p, line);
    PlyElement *e = &p->elements[p->element_count];
    if (strchr(line, '-') || sscanf(line, "element %39s %" SCNu64 " %c", e->name, &count, &rest) != 2)
        return bad_line(p, line);
    if (count > (uint64_t)(p->end - p->begin) || count > UINT32_MAX)
        return error_set(p->reader->err, CAU_ERROR_INPUT,
            "%s: says it holds %" PRIu64 " of \"%s\", more than its %zu bytes can", p->place, count, e->name,
            (size_t)(p->end - p->begin));
    e->count = (size_t)count;
    p->element_count++;
    return CAU_OK;
}

static cau_result read_property(Ply *p, const char *line) {
    char count_type[PLY_NAME_MAX], type[PLY_NAME_MAX], rest;
    PlyElement *e = p->element_count ? &p->elements[p->element_count - 1] : NULL;
    if (!e || e->property_count == PLY_PROPERTIES_MAX) return bad_line(p, line);
    PlyProperty *property = &e->properties[e->property_count++];
    property->list =
        sscanf(line, "property list %39s %39s %39s %c", count_type, type, property->name, &rest) == 3;
    if (property->list) {
        bool known = find_type(count_type, &property->count_type) && find_type(type, &property->type);
        return known && property->count_type < PLY_FLOAT ? CAU_OK : bad_line(p, line);
    }
    if (sscanf(line, "property %39s %39s %c", type, property->name, &rest) != 2 ||
        !find_type(type, &property->type))
        return bad_line(p, line);
    return CAU_OK;
}

static bool begins(const char *line, const char *word) { return strncmp(line, word, strlen(word)) == 0; }

static cau_result read_line(Ply *p, const char *line, bool *format_seen) {
    if (begins(line, "comment") || begins(line, "obj_info") || !*line) return CAU_OK;
    if (begins(line, "element ")) return read_element(p, line);
    if (begins(line, "property ")) return read_property(p, line);
    if (!begins(line, "format ")) return bad_line(p, line);
    *format_seen = true;
    return read_format(p, line);
}

cau_result ply_header(Ply *p) {
    char line[LINE_MAX_BYTES];
    bool format_seen = false;
    if (!next_line(p, line) || strcmp(line, "ply") != 0)
        return error_set(
            p->reader->err, CAU_ERROR_INPUT, "%s: not a PLY file: its first line is not \"ply\"", p->place);
    while (next_line(p, line)) {
        if (strcmp(line, "end_header") != 0) {
            CAU_TRY(read_line(p, line, &format_seen));
            continue;
        }
        if (format_seen) return CAU_OK;
        return error_set(p->reader->err, CAU_ERROR_INPUT, "%s: its PLY header names no format", p->place);
    }
    return error_set(
        p->reader->err, CAU_ERROR_INPUT, "%s: its PLY header does not end; the file is cut off", p->place);
}
