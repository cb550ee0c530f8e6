/* SPDX-License-Identifier: Apache-2.0 */
/* Receivers that are seen through glass or in mirrors: no projection leads from a landed triangle to their
 * pixels, so each eye point looks up the triangles that it lies in. */
#include "render/gather/wave/wave_internal.h"

#include "core/checked.h"

#include <string.h>

/* A triangle of less area than this part of a pixel's footprint, and of what triangles of an even spread
 * have, is gathered by a kernel, as a photon: few eye points would lie in it, and those would be too bright.
 * Where triangles are small but cover the receiver evenly, every eye point lies in one, and no kernel blurs
 * the picture. */
#define LOOKUP_AREA 0.1

/* Eye points of a band of pixel rows under a tree. */
typedef struct Band {
    PhotonTree tree;
    const EyePoint **points;
    size_t count;
    V3 lo, hi; /* of the points */
} Band;

struct WaveSeen {
    Band *bands;
    size_t count;
    const Scene *scene;
};

/* ---- the trees ---- */

static size_t band_points(const EyePoints *points, int y0, int y1, const EyePoint **out) {
    size_t count = 0;
    for (int y = y0; y < y1; y++)
        for (size_t i = 0; i < points->rows[y].count; i++) {
            const EyePoint *p = &points->rows[y].items[i];
            if (p->straight) continue;
            if (out) out[count] = p;
            count++;
        }
    return count;
}

/* The tree's items say by their flux which point they are. */
static cau_result band_build(Band *b, const EyePoints *points, int y0, int y1, CauError *err) {
    size_t count = band_points(points, y0, y1, NULL);
    if (count == 0) return CAU_OK;
    b->points = array_new(count, sizeof *b->points);
    Deposit *items = array_new(count, sizeof *items);
    cau_result result = b->points && items && count < UINT32_MAX
                            ? CAU_OK
                            : error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu eye points", count);
    b->lo = v3(INFINITY, INFINITY, INFINITY);
    b->hi = v3_neg(b->lo);
    if (result == CAU_OK) {
        b->count = band_points(points, y0, y1, b->points);
        for (size_t i = 0; i < count; i++) {
            V3 p = b->points[i]->position;
            uint32_t number = (uint32_t)i;
            b->lo = v3_min(b->lo, p);
            b->hi = v3_max(b->hi, p);
            items[i] = (Deposit){.position = {(float)p.x, (float)p.y, (float)p.z}};
            memcpy(&items[i].flux[0], &number, sizeof number);
        }
        result = photon_tree_build(&b->tree, items, count, err);
    }
    free(items);
    return result;
}

cau_result wave_seen_create(WaveSeen **out, const Scene *scene, const EyePoints *points, int y0, int y1,
    size_t bands, CauError *err) {
    WaveSeen *s = *out = array_new(1, sizeof *s);
    if (s) s->bands = array_new(bands, sizeof *s->bands);
    if (!s || !s->bands) return error_set(err, CAU_ERROR_RESOURCE, "out of memory for eye points");
    s->scene = scene;
    s->count = bands;
    size_t rows = (size_t)(y1 - y0);
    for (size_t i = 0; i < bands; i++)
        CAU_TRY(band_build(
            &s->bands[i], points, y0 + (int)(rows * i / bands), y0 + (int)(rows * (i + 1) / bands), err));
    return CAU_OK;
}

void wave_seen_free(WaveSeen **seen) {
    WaveSeen *s = *seen;
    if (!s) return;
    for (size_t i = 0; s->bands && i < s->count; i++) {
        photon_tree_free(&s->bands[i].tree);
        free(s->bands[i].points);
    }
    free(s->bands);
    free(s);
    *seen = NULL;
}

/* ---- a triangle ---- */

bool wave_seen_triangle(
    const WaveLanding *const l[3], const WavePlane *plane, Rgb flux, double even, WaveSeenTriangle *out) {
    V3 n = plane->normal, center = plane->center;
    V3 e1 = v3_sub(l[1]->position, l[0]->position), e2 = v3_sub(l[2]->position, l[0]->position);
    double area = 0.5 * fabs(v3_dot(v3_cross(e1, e2), n));
    if (!(area > LOOKUP_AREA * square(fmin(even, plane->footprint)))) return false;
    *out = (WaveSeenTriangle){.normal = n,
        .plane = v3_dot(n, center),
        .irradiance = rgb_scale(flux, 1 / area),
        .reach = plane->reach,
        .center = center,
        .radius = fmax(v3_length(v3_sub(l[0]->position, center)),
            fmax(v3_length(v3_sub(l[1]->position, center)), v3_length(v3_sub(l[2]->position, center)))),
        .receiver = l[0]->receiver,
        .glossy = l[0]->glossy,
        .transmission = l[0]->transmission};
    /* Along the normal, whichever way the triangle is turned. */
    double turn = v3_dot(v3_cross(e1, e2), n) > 0 ? 1 : -1;
    for (int k = 0; k < 3; k++) {
        V3 a = l[k]->position, along = v3_sub(l[k < 2 ? k + 1 : 0]->position, a);
        out->side[k] = v3_scale(v3_cross(n, along), turn);
        out->edge[k] = v3_dot(out->side[k], a);
    }
    return true;
}

typedef struct Lookup {
    const WaveSeen *seen;
    const Band *band;
    const WaveSeenTriangle *triangle;
    const PassImages *images;
} Lookup;

static bool within(const WaveSeenTriangle *t, V3 p) {
    return v3_dot(t->side[0], p) > t->edge[0] && v3_dot(t->side[1], p) > t->edge[1] &&
           v3_dot(t->side[2], p) > t->edge[2];
}

static void add(double *image, size_t at, Rgb value) {
    image[at] += value.r;
    image[at + 1] += value.g;
    image[at + 2] += value.b;
}

static void visit(void *data, const Deposit *item, double distance2) {
    (void)distance2;
    const Lookup *l = data;
    const WaveSeenTriangle *t = l->triangle;
    V3 at = v3((double)item->position[0], (double)item->position[1], (double)item->position[2]);
    if (!within(t, at) || fabs(v3_dot(at, t->normal) - t->plane) > t->reach) return;
    uint32_t number;
    memcpy(&number, &item->flux[0], sizeof number);
    const EyePoint *p = l->band->points[number];
    if (!wave_same_receiver(wave_receiver(l->seen->scene, p->object), t->receiver)) return;
    V3 ng = v3((double)p->ng[0], (double)p->ng[1], (double)p->ng[2]);
    double facing = v3_dot(ng, t->normal);
    if (facing < WAVE_FACING_COSINE) return;
    if (!bounces_allow(&l->seen->scene->bounces, 1, (unsigned)t->glossy + p->glossy,
            (unsigned)t->transmission + p->transmission))
        return;
    /* What is slanted to the plane has more area for the same light. */
    Rgb radiance = rgb_mul(rgb_scale(t->irradiance, facing),
        rgb((double)p->weight[0], (double)p->weight[1], (double)p->weight[2]));
    add(l->images->radiance, 3 * (size_t)p->pixel, radiance);
    if (l->images->seen) add(l->images->seen, 3 * (size_t)p->pixel, radiance);
    spread_add(l->images->spread, p->pixel, radiance);
}

static bool meets(const Band *b, V3 c, double r) {
    return c.x + r > b->lo.x && c.x - r < b->hi.x && c.y + r > b->lo.y && c.y - r < b->hi.y &&
           c.z + r > b->lo.z && c.z - r < b->hi.z;
}

void wave_seen_light(const WaveSeen *seen, size_t band, const WaveBatch *batches, size_t batch_count,
    const PassImages *images) {
    Lookup l = {seen, &seen->bands[band], NULL, images};
    if (l.band->count == 0) return;
    for (size_t b = 0; b < batch_count; b++)
        for (size_t i = 0; i < batches[b].seen_count; i++) {
            const WaveSeenTriangle *t = l.triangle = &batches[b].seen[i];
            double radius = t->radius + t->reach;
            if (meets(l.band, t->center, radius))
                photon_tree_query(&l.band->tree, t->center, radius, visit, &l);
        }
}
