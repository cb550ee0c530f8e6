/* SPDX-License-Identifier: Apache-2.0 */
/* A rectangle at z = 0, facing +Z. */
#include "render/scene/shape_common.h"

typedef struct PlaneParams {
    double size[2];
} PlaneParams;

static const Param params[] = {
    SHAPE_SIZE(PlaneParams, PARAM_VEC2, "full sides, centred"),
};

static cau_result tessellate(const void *data, bool smooth, Mesh *out, CauError *err) {
    (void)smooth; /* flat either way */
    return mesh_sheet(out, ((const PlaneParams *)data)->size, 1, 1, false, err);
}

const ShapeKind shape_plane = {
    .name = "plane",
    .help = "a rectangle at z = 0, facing +Z",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(PlaneParams),
    .sheet = true,
    .tessellate = tessellate,
};
