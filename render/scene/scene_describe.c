/* SPDX-License-Identifier: Apache-2.0 */
/* What a host can ask about parameters: the scene reader and the panels of hosts are built on it. */
#include "render/scene/scene_internal.h"

#include <string.h>

static cau_result describe(cau_scene *scene, const Param *p, cau_param *out) {
    if (out->size != sizeof *out)
        return error_set(&scene->context->error, CAU_ERROR_USAGE,
            "cau_param.size is %zu; it must be %zu, the size of this library's struct", out->size,
            sizeof *out);
    *out = (cau_param){.size = sizeof *out,
        .name = p->name,
        .unit = p->unit,
        .help = p->help,
        .type = (int32_t)p->type,
        .flags = p->flags,
        .count = param_components(p),
        .min = p->min,
        .max = p->max,
        .words = p->choices};
    memcpy(out->def, p->def, sizeof out->def);
    return CAU_OK;
}

size_t cau_param_count(cau_scene *scene, cau_item item) {
    ItemView v;
    if (!scene || !item_find(scene, item, &v)) return 0;
    size_t count = 0;
    for (size_t t = 0; t < v.table_count; t++) count += v.tables[t]->count;
    return count;
}

cau_result cau_param_at(cau_scene *scene, cau_item item, size_t index, cau_param *out) {
    if (!scene || !out) return CAU_ERROR_USAGE;
    ItemView v;
    CAU_TRY(item_view(scene, item, &v));
    for (size_t t = 0; t < v.table_count; t++) {
        if (index < v.tables[t]->count) return describe(scene, &v.tables[t]->params[index], out);
        index -= v.tables[t]->count;
    }
    return error_set(&scene->context->error, CAU_ERROR_USAGE, "%s has only %zu parameters", v.place,
        cau_param_count(scene, item));
}

cau_result cau_param_named(cau_scene *scene, cau_item item, const char *key, cau_param *out) {
    if (!scene || !key || !out) return CAU_ERROR_USAGE;
    ItemView v;
    size_t table = 0;
    const Param *p = NULL;
    CAU_TRY(item_view(scene, item, &v));
    CAU_TRY(item_key(scene, &v, key, &table, &p));
    return describe(scene, p, out);
}
