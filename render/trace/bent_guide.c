/* SPDX-License-Identifier: Apache-2.0 */
/* Where to look for a lamp in a mirror that is seen bent. What it shows comes from one height, MIRROR_HEIGHT,
 * so from a curve of directions, and a small lamp lies on few of them: of light looked for evenly one try in
 * thousands finds any, and a picture would lack it until a firefly brings it. Light that comes from the lamp
 * tells which faces it grazes, and from where. */
#include "render/trace/bent.h"
#include "render/trace/bent_between.h"

#include "core/checked.h"
#include "core/rng.h"

/* After the first few it is given up where all would not graze as many faces as there are triangles: of fine
 * meshes little is bent, and the light that a guide has not met is worth no less than the other. */
enum { GUIDE_FIRST = 1 << 13, GUIDE_PHOTONS = 1 << 17, GUIDE_DEPTH = 16 };

/* Light up to this height over a face (cosine) is taken to graze it, ... */
#define GRAZING 0.1
/* ... and its azimuth says that of light at MIRROR_HEIGHT to within this, in radians, ... */
#define AZIMUTH_WIDTH 0.1
/* ... or, with this chance, its face alone. */
#define ANY_AZIMUTH 0.25

static double azimuth_of(V3 ng, V3 w) {
    V3 x, y;
    v3_frame(ng, &x, &y);
    return atan2(v3_dot(w, y), v3_dot(w, x));
}

/* Light from azimuth a, at the height that a bent mirror shows; *turned: its derivative by a. */
static V3 grazing_light(V3 ng, double a, V3 *turned) {
    V3 x, y;
    v3_frame(ng, &x, &y);
    double s = sqrt(1 - square(MIRROR_HEIGHT));
    *turned = v3_mad(v3_scale(x, -s * sin(a)), s * cos(a), y);
    return v3_mad(v3_mad(v3_scale(ng, MIRROR_HEIGHT), s * cos(a), x), s * sin(a), y);
}

/* ---- making it ---- */

/* The triangle among the mirrors, which are in order; -1: not one of them. */
static int64_t mirror_of(const BentSet *set, int object, uint32_t primitive) {
    size_t low = 0, high = set->mirror_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        const BentTriangle *t = &set->mirrors[middle];
        if (t->object < object || (t->object == object && t->primitive < primitive))
            low = middle + 1;
        else
            high = middle;
    }
    bool found = low < set->mirror_count && set->mirrors[low].object == object &&
                 set->mirrors[low].primitive == primitive;
    return found ? (int64_t)low : -1;
}

static bool note(BentGuide *guide, size_t *capacity, const BentSet *set, const Hit *hit, V3 wi) {
    ShadingFrame f = frame_from_light(hit, wi);
    if (v3_dot(wi, f.ng) > GRAZING) return true;
    int64_t triangle = mirror_of(set, hit->object, hit->primitive);
    if (triangle < 0) return true;
    if (!array_reserve((void **)&guide->seeds, capacity, guide->count + 1, sizeof *guide->seeds))
        return false;
    guide->seeds[guide->count++] = (BentSeed){2 * (uint64_t)triangle + !f.front, (float)azimuth_of(f.ng, wi)};
    return true;
}

/* One photon along smooth surfaces. */
static bool follow(const BentRun *run, const Photon *p, uint32_t index, BentGuide *guide, size_t *capacity) {
    PathNumbers numbers = path_numbers(run->key, index);
    Ray ray = ray_from_point(p->origin, p->dir, 0, INFINITY, VISIBLE_SHADOW);
    for (int depth = 0; depth < GUIDE_DEPTH; depth++, path_numbers_next(&numbers)) {
        Hit hit;
        if (!trace_nearest(run->trace, &ray, &hit)) return true;
        V3 wi = v3_neg(ray.dir);
        const struct BentObject *o = &run->set->objects[hit.object];
        if (o->bends && o->alpha == 0 && !note(guide, capacity, run->set, &hit, wi)) return false;
        unsigned lobes = hit.material->lobes & (LOBE_SPECULAR | LOBE_TRANSPARENT);
        if (!run->scene->objects[hit.object].casts) lobes &= ~(unsigned)LOBE_CASTING;
        ShadingFrame f = frame_from_light(&hit, wi);
        ScatterSample s;
        double u[3];
        for (int k = 0; k < 3; k++) u[k] = path_number(&numbers);
        if (!lobes || !hit.material->kind->sample(hit.material, &f, wi, u, lobes, true, &s)) return true;
        ray = ray_from_hit(&hit, s.wo, INFINITY, ray.visibility);
    }
    return true;
}

static int by_face(const void *a, const void *b) {
    const BentSeed *s = a, *t = b;
    if (s->face != t->face) return s->face < t->face ? -1 : 1;
    return (s->azimuth > t->azimuth) - (s->azimuth < t->azimuth);
}

void bent_guide_create(BentGuide *out, const BentRun *run, const Aim *casters) {
    AimMix aim = {.first = casters};
    size_t capacity = 0;
    *out = (BentGuide){0};
    for (uint32_t i = 0; i < GUIDE_PHOTONS; i++) {
        Photon p;
        if (i == GUIDE_FIRST && out->count * (GUIDE_PHOTONS / GUIDE_FIRST) < run->set->mirror_count) {
            out->count = 0;
            break;
        }
        if (!emit_photon(run->light, &aim, i, run->key, &p)) continue;
        if (!follow(run, &p, i, out, &capacity)) {
            out->out_of_memory = true;
            return;
        }
    }
    if (out->count) qsort(out->seeds, out->count, sizeof *out->seeds, by_face);
}

void bent_guide_free(BentGuide *guide) {
    free(guide->seeds);
    *guide = (BentGuide){0};
}

/* ---- using it ---- */

bool bent_guide_direction(const BentSeed *seed, V3 ng, V3 ns, double u, double v, V3 *dir) {
    Between b;
    if (!between(ng, ns, &b)) return false;
    double azimuth = u < ANY_AZIMUTH ? 2 * CAU_PI * u / ANY_AZIMUTH
                                     : (double)seed->azimuth +
                                           AZIMUTH_WIDTH * (2 * (u - ANY_AZIMUTH) / (1 - ANY_AZIMUTH) - 1);
    V3 turned, light = grazing_light(ng, azimuth, &turned), n = normal_between(&b, v * b.tilt);
    *dir = v3_normalize(v3_mad(v3_neg(light), 2 * v3_dot(n, light), n));
    return v3_dot(n, light) > 0 && v3_dot(*dir, ng) * MIRROR_SHARE > MIRROR_HEIGHT;
}

/* How densely, per radian, the seeds of a face draw that azimuth, all of them together. */
static double azimuth_pdf(const BentGuide *guide, uint64_t face, double azimuth) {
    size_t low = 0, high = guide->count, near = 0, all = 0;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (guide->seeds[middle].face < face)
            low = middle + 1;
        else
            high = middle;
    }
    for (; low < guide->count && guide->seeds[low].face == face; low++) {
        double off = fabs(remainder(azimuth - (double)guide->seeds[low].azimuth, 2 * CAU_PI));
        near += off <= AZIMUTH_WIDTH;
        all++;
    }
    return ((1 - ANY_AZIMUTH) * (double)near / (2 * AZIMUTH_WIDTH) +
               ANY_AZIMUTH * (double)all / (2 * CAU_PI)) /
           (double)guide->count;
}

double bent_guide_pdf(const BentGuide *guide, uint64_t face, double area, V3 ng, V3 ns, V3 bent, V3 dir) {
    Between b;
    V3 light = v3_mad(v3_neg(dir), 2 * v3_dot(bent, dir), bent), turned;
    /* From lower down it shows what is lower still. */
    if (!between(ng, ns, &b) || !(v3_dot(dir, ng) * MIRROR_SHARE > MIRROR_HEIGHT)) return 0;
    double azimuth = azimuth_of(ng, light);
    double drawn = azimuth_pdf(guide, face, azimuth);
    if (!(drawn > 0)) return 0;
    light = grazing_light(ng, azimuth, &turned);
    double t = atan2(v3_dot(bent, b.side), v3_dot(bent, ng)), facing = v3_dot(bent, light);
    V3 tipped = v3_mad(v3_scale(b.side, cos(t)), -sin(t), ng); /* the normal's derivative by t */
    V3 by_t = v3_mad(v3_scale(bent, 2 * v3_dot(tipped, light)), 2 * facing, tipped);
    V3 by_azimuth = v3_mad(v3_neg(turned), 2 * v3_dot(bent, turned), bent);
    double spread = fabs(v3_dot(dir, v3_cross(by_t, by_azimuth))); /* steradians per both */
    return spread > 0 ? drawn / (b.tilt * spread * area) : 0;
}
