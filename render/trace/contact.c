/* SPDX-License-Identifier: Apache-2.0 */
#include "render/trace/contact.h"

enum { CONTACT_TRIANGLES_MAX = 20000, CONTACT_NEAR = 32 };

static bool faces_touch(const NearTriangle *n, V3 p, V3 normal) {
    V3 m = v3_cross(v3_sub(n->b, n->a), v3_sub(n->c, n->a));
    double length = v3_length(m);
    return length > 0 && fabs(v3_dot(m, normal)) > 0.9999 * length &&
           fabs(v3_dot(m, v3_sub(p, n->a))) < CONTACT_DISTANCE * length;
}

static V3 corner(const Mesh *m, uint32_t i) {
    const double *p = &m->positions[3 * (size_t)i];
    return v3((float)p[0], (float)p[1], (float)p[2]); /* as Embree has it */
}

/* Marks the receivers that a caster's triangles lie on, looked for at the triangles' centres. */
static void find_contacts(const TraceScene *trace, const Scene *scene, const Object *caster, bool *touched) {
    const Mesh *m = &caster->mesh;
    size_t step = m->triangle_count / CONTACT_TRIANGLES_MAX + 1;
    for (size_t t = 0; t < m->triangle_count; t += step) {
        const uint32_t *index = &m->triangles[3 * t];
        V3 a = corner(m, index[0]), b = corner(m, index[1]), c = corner(m, index[2]);
        V3 p = v3_scale(v3_add(a, v3_add(b, c)), 1.0 / 3), n = v3_cross(v3_sub(b, a), v3_sub(c, a));
        double length = v3_length(n);
        if (!(length > 0)) continue;
        NearTriangle found[CONTACT_NEAR];
        size_t count = trace_collect(trace, p, 2 * CONTACT_DISTANCE, found, CONTACT_NEAR);
        for (size_t i = 0; i < count && i < CONTACT_NEAR; i++) {
            unsigned lobes = scene->materials[scene->objects[found[i].object].material].lobes;
            if (found[i].exact || (lobes & LOBE_CASTING)) continue;
            if (faces_touch(&found[i], p, v3_scale(n, 1 / length))) touched[found[i].object] = true;
        }
    }
}

void contacts_find(const TraceScene *trace, const Scene *scene, bool *touched) {
    for (size_t i = 0; i < scene->object_count; i++)
        if (scene->materials[scene->objects[i].material].lobes & LOBE_CASTING)
            find_contacts(trace, scene, &scene->objects[i], touched);
}
