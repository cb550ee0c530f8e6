/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What the two halves of the PLY reader share: the header as parsed. */
#ifndef RENDER_SCENE_IO_PLY_H
#define RENDER_SCENE_IO_PLY_H

#include "render/scene/io/mesh_source.h"

typedef enum PlyType {
    PLY_INT8,
    PLY_UINT8,
    PLY_INT16,
    PLY_UINT16,
    PLY_INT32,
    PLY_UINT32,
    PLY_FLOAT,
    PLY_DOUBLE
} PlyType;

typedef enum PlyFormat { PLY_TEXT, PLY_LITTLE, PLY_BIG } PlyFormat;

enum { PLY_NAME_MAX = 40, PLY_ELEMENTS_MAX = 8, PLY_PROPERTIES_MAX = 48 };

typedef struct PlyProperty {
    char name[PLY_NAME_MAX];
    PlyType type, count_type;
    bool list;
} PlyProperty;

typedef struct PlyElement {
    char name[PLY_NAME_MAX];
    size_t count, property_count;
    PlyProperty properties[PLY_PROPERTIES_MAX];
} PlyElement;

typedef struct Ply {
    Reader *reader;
    const char *place;
    const char *begin, *at, *end;
    PlyFormat format;
    PlyElement elements[PLY_ELEMENTS_MAX];
    size_t element_count;
    uint32_t *corners;
    size_t corner_capacity, index_capacity;
} Ply;

size_t ply_type_size(PlyType type);
/** Parses the header; p->at is left at the first byte after it. */
cau_result ply_header(Ply *p);

#endif
