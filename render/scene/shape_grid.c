/* SPDX-License-Identifier: Apache-2.0 */
/* A sheet through a lattice of heights. The first row lies at -y, the first number of a row at -x. */
#include "render/scene/shape_common.h"

#include <string.h>

typedef struct GridParams {
    double size[2], columns;
    ParamList heights;
} GridParams;

static const Param params[] = {
    SHAPE_SIZE(GridParams, PARAM_VEC2, "full sides, centred"),
    {.name = "columns",
        .type = PARAM_NUMBER,
        .unit = "",
        .offset = offsetof(GridParams, columns),
        .min = 2,
        .max = 65536,
        .flags = PARAM_POSITIVE_INT,
        .help = "heights per row; a file of heights says it itself"},
    {.name = "heights",
        .type = PARAM_LIST,
        .unit = "m",
        .offset = offsetof(GridParams, heights),
        .min = -SHAPE_SIZE_MAX,
        .max = SHAPE_SIZE_MAX,
        .flags = PARAM_REQUIRED | PARAM_OR_FILE,
        .tuple = 1,
        .help = "row by row from -y to +y, each from -x to +x; or a text file with a row per line"},
};

static cau_result check(const void *data, const char *owner, CauError *err) {
    const GridParams *p = data;
    size_t columns = (size_t)p->columns, count = p->heights.count;
    if (columns < 2)
        return error_set(err, CAU_ERROR_INPUT, "%s: \"columns\" is missing (heights per row)", owner);
    if (count % columns != 0 || count / columns < 2)
        return error_set(err, CAU_ERROR_INPUT,
            "%s.heights has %zu numbers; it must have at least 2 whole rows of %zu", owner, count, columns);
    return CAU_OK;
}

static cau_result tessellate(const void *data, bool smooth, Mesh *out, CauError *err) {
    const GridParams *p = data;
    size_t columns = (size_t)p->columns, rows = p->heights.count / columns;
    CAU_TRY(mesh_sheet(out, p->size, columns - 1, rows - 1, false, err));
    for (size_t i = 0; i < p->heights.count; i++) out->positions[3 * i + 2] = p->heights.values[i];
    return smooth ? mesh_smooth_normals(out, err) : CAU_OK;
}

const ShapeKind shape_grid = {
    .name = "grid",
    .help = "a sheet through a lattice of heights, facing +Z",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(GridParams),
    .sheet = true,
    .check = check,
    .tessellate = tessellate,
};
