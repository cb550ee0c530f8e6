/* SPDX-License-Identifier: Apache-2.0 */
/* One number for everything a scene says. It loops over the parameter tables, so a new parameter is in it the
 * moment it exists. */
#include "render/scene/scene.h"

#include "core/rng.h"

#include <string.h>

static uint64_t hash_number(uint64_t h, double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return rng_combine(h, isnan(x) ? 0x7ff8u : bits); /* not set is not set, whatever the sign of NaN */
}

static uint64_t hash_text(uint64_t h, const char *text) {
    return rng_combine(h, text ? rng_hash_text(text) : 1);
}

static uint64_t hash_table(uint64_t h, const ParamTable *table, const void *data) {
    for (size_t i = 0; i < table->count; i++) {
        const Param *p = &table->params[i];
        if (!param_is_stored(p)) continue;
        h = hash_text(h, p->name);
        const void *at = (const char *)data + p->offset;
        const ParamList *list = p->type == PARAM_LIST ? at : NULL;
        size_t count = list ? list->count * p->tuple : param_components(p);
        const double *values = list ? list->values : at;
        h = rng_combine(h, count);
        for (size_t c = 0; c < count; c++) h = hash_number(h, values[c]);
    }
    return h;
}

static uint64_t hash_mesh(uint64_t h, const Mesh *m) {
    h = rng_combine(rng_combine(h, m->vertex_count), m->triangle_count);
    for (size_t i = 0; i < 3 * m->vertex_count; i++) h = hash_number(h, m->positions[i]);
    for (size_t i = 0; i < 3 * m->triangle_count; i++) h = rng_combine(h, m->triangles[i]);
    for (size_t i = 0; m->normals && i < 9 * m->triangle_count; i++)
        h = hash_number(h, (double)m->normals[i]);
    return h;
}

static uint64_t hash_object(uint64_t h, const Object *o) {
    h = hash_text(hash_text(h, o->name), o->material_name);
    h = hash_table(rng_combine(h, (uint64_t)o->placed), &object_table, &o->params);
    if (!o->shape) return hash_mesh(h, &o->mesh);
    return hash_table(hash_text(h, o->shape->name), &o->shape->table, o->shape_data);
}

uint64_t scene_hash(const struct cau_scene *s) {
    uint64_t h = hash_text(0, s->color_space);
    h = hash_table(rng_combine(h, (uint64_t)s->camera_placed), &camera_table, &s->camera);
    h = hash_table(h, &filter_table, &s->filter);
    h = hash_text(hash_table(h, &world_table, &s->world), s->world_group);
    h = hash_table(h, &bounces_table, &s->bounces);
    for (size_t i = 0; i < s->material_count; i++) {
        const Material *m = &s->materials[i];
        h = hash_table(hash_text(hash_text(h, m->name), m->kind->name), &m->kind->table, m->data);
    }
    for (size_t i = 0; i < s->object_count; i++) h = hash_object(h, &s->objects[i]);
    for (size_t i = 0; i < s->light_count; i++) {
        const LightSource *l = &s->lights[i];
        h = hash_text(hash_text(hash_text(h, l->name), l->kind->name), l->group);
        h = hash_table(rng_combine(h, (uint64_t)l->placed), &light_table, l);
        h = hash_table(h, &l->kind->table, l->data);
    }
    return h;
}
