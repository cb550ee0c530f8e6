/* SPDX-License-Identifier: Apache-2.0 */
/* A box centred at the origin; its faces stay flat whatever `smooth` says. */
#include "render/scene/shape_common.h"

typedef struct BoxParams {
    double size[3];
} BoxParams;

static const Param params[] = {
    SHAPE_SIZE(BoxParams, PARAM_VEC3, "full sides, centred"),
};

/* Corner i has bit 0 set where x is positive, bit 1 y, bit 2 z. */
static const unsigned char faces[6][4] = {
    {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

static cau_result tessellate(const void *data, bool smooth, Mesh *out, CauError *err) {
    const double *size = ((const BoxParams *)data)->size;
    (void)smooth;
    CAU_TRY(mesh_alloc(out, 8, 12, false, err));
    for (unsigned i = 0; i < 8; i++)
        mesh_put_vertex(out, i,
            v3((i & 1 ? 0.5 : -0.5) * size[0], (i & 2 ? 0.5 : -0.5) * size[1],
                (i & 4 ? 0.5 : -0.5) * size[2]));
    for (size_t f = 0; f < 6; f++) {
        mesh_put_triangle(out, 2 * f, faces[f][0], faces[f][1], faces[f][2]);
        mesh_put_triangle(out, 2 * f + 1, faces[f][0], faces[f][2], faces[f][3]);
    }
    return CAU_OK;
}

const ShapeKind shape_box = {
    .name = "box",
    .help = "a box centred at the origin",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(BoxParams),
    .tessellate = tessellate,
};
