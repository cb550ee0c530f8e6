/* SPDX-License-Identifier: Apache-2.0 */
/* A sheet of sine waves over a rectangle, exact unless `segments` asks for facets; its medium lies below.
 *
 * Along a ray the height above the sheet is f(s) = z0 + dz s - sum a sin(w s + p), again a sum of sines, and
 * its second derivative is bounded by B = sum |a| w^2. From s, no root can come before the first positive
 * root of |f| + |f|' x - B x^2 / 2, so the march steps there: it never passes a root, slows down only where
 * the ray grazes, and towards a root it converges as Newton's method does, from the safe side. (Second-order
 * form of Hart 1996, "Sphere Tracing".) */
#include "render/scene/shape_common.h"

#include "core/checked.h"

enum { WAVES_MAX = 256, STEPS_MAX = 1 << 22 };

typedef struct HeightfieldParams {
    double size[2];
    ParamList waves;
    double segments;
} HeightfieldParams;

typedef struct Wave {
    double amplitude, k, direction_rad, phase;
} Wave;

static const char *const wave_names[] = {"amplitude", "k", "direction_rad", "phase", NULL};

static const Param params[] = {
    SHAPE_SIZE(HeightfieldParams, PARAM_VEC2, "full sides, centred"),
    {.name = "waves",
        .type = PARAM_LIST,
        .unit = "m, rad/m, rad, rad",
        .offset = offsetof(HeightfieldParams, waves),
        .min = -SHAPE_SIZE_MAX,
        .max = SHAPE_SIZE_MAX,
        .flags = PARAM_REQUIRED,
        .def = {2},
        .choices = wave_names,
        .tuple = 4,
        .help = "z = sum of amplitude sin(k (x cos d + y sin d) + phase)"},
    SHAPE_SEGMENTS(HeightfieldParams, 0, 1, 4096, "cells along each side; without it: exact"),
};

static const Wave *waves_of(const HeightfieldParams *p) {
    return (const Wave *)(const void *)p->waves.values;
}

static double amplitude_sum(const HeightfieldParams *p) {
    double sum = 0;
    for (size_t i = 0; i < p->waves.count; i++) sum += fabs(waves_of(p)[i].amplitude);
    return sum;
}

static cau_result check(const void *data, const char *owner, CauError *err) {
    const HeightfieldParams *p = data;
    double side = fmax(p->size[0], p->size[1]);
    if (p->waves.count > WAVES_MAX)
        return error_set(err, CAU_ERROR_INPUT, "%s.waves has %zu entries; the limit is %d", owner,
            p->waves.count, WAVES_MAX);
    for (size_t i = 0; i < p->waves.count; i++) {
        const Wave *w = &waves_of(p)[i];
        if (!(fabs(w->k) * side <= 1e6))
            return error_set(err, CAU_ERROR_INPUT,
                "%s.waves[%zu].k is %g rad/m; over %g m it must be at most %g", owner, i, w->k, side,
                1e6 / side);
        if (!(fabs(w->phase) <= 1e6 && fabs(w->direction_rad) <= 1e6))
            return error_set(err, CAU_ERROR_INPUT, "%s.waves[%zu] has an angle of %g rad; the limit is 1e6",
                owner, i, fmax(fabs(w->phase), fabs(w->direction_rad)));
    }
    return CAU_OK;
}

static bool is_exact(const void *data) { return ((const HeightfieldParams *)data)->segments == 0; }

static double height(const HeightfieldParams *p, double x, double y, V3 *normal) {
    double z = 0, dx = 0, dy = 0;
    for (size_t i = 0; i < p->waves.count; i++) {
        const Wave *w = &waves_of(p)[i];
        double c = cos(w->direction_rad), s = sin(w->direction_rad),
               angle = w->k * (x * c + y * s) + w->phase;
        double slope = w->amplitude * w->k * cos(angle);
        z += w->amplitude * sin(angle);
        dx += slope * c;
        dy += slope * s;
    }
    *normal = v3_normalize(v3(-dx, -dy, 1));
    return z;
}

static cau_result tessellate(const void *data, bool smooth, Mesh *out, CauError *err) {
    const HeightfieldParams *p = data;
    size_t n = (size_t)p->segments;
    CAU_TRY(mesh_sheet(out, p->size, n, n, smooth, err));
    V3 normal;
    for (size_t i = 0; i < out->vertex_count; i++)
        out->positions[3 * i + 2] = height(p, out->positions[3 * i], out->positions[3 * i + 1], &normal);
    for (size_t corner = 0; smooth && corner < 3 * out->triangle_count; corner++) {
        const double *q = &out->positions[3 * (size_t)out->triangles[corner]];
        height(p, q[0], q[1], &normal);
        mesh_put_normal(out, corner, normal);
    }
    return CAU_OK;
}

/* The ray over the sheet, from where it enters the box that holds the sheet. Sines take most of the time of
 * water, so none is computed twice: those of the waves' directions and of the last step serve the normal. */
typedef struct March {
    size_t count;
    double amplitude[WAVES_MAX], w[WAVES_MAX], p[WAVES_MAX];
    double k_x[WAVES_MAX], k_y[WAVES_MAX]; /* wave vectors */
    double gap, cosine[WAVES_MAX];         /* f and the phases' cosines where they were computed last */
    double z, dz, bend;                    /* bend: the bound B */
    double noise;                          /* rounding error of f */
    double end;
} March;

static double march_height(March *m, double s, double *slope) {
    double f = m->z + m->dz * s, d = m->dz;
    for (size_t i = 0; i < m->count; i++) {
        double angle = m->w[i] * s + m->p[i];
        f -= m->amplitude[i] * sin(angle);
        m->cosine[i] = cos(angle);
        d -= m->amplitude[i] * m->w[i] * m->cosine[i];
    }
    *slope = d;
    return m->gap = f;
}

static V3 march_normal(const March *m) {
    double dx = 0, dy = 0;
    for (size_t i = 0; i < m->count; i++) {
        dx += m->amplitude[i] * m->cosine[i] * m->k_x[i];
        dy += m->amplitude[i] * m->cosine[i] * m->k_y[i];
    }
    return v3_normalize(v3(-dx, -dy, 1));
}

static bool clip(double origin, double direction, double half, double *t0, double *t1) {
    if (direction == 0) return fabs(origin) <= half;
    double a = (-half - origin) / direction, b = (half - origin) / direction;
    *t0 = fmax(*t0, fmin(a, b));
    *t1 = fmin(*t1, fmax(a, b));
    return *t0 <= *t1;
}

static void march_start(const HeightfieldParams *p, V3 origin, V3 d, double length, March *m) {
    double rough = fabs(origin.z) + fabs(d.z) * length;
    m->count = p->waves.count;
    m->z = origin.z;
    m->dz = d.z;
    m->bend = 0;
    m->end = length;
    for (size_t i = 0; i < m->count; i++) {
        const Wave *w = &waves_of(p)[i];
        m->amplitude[i] = w->amplitude;
        m->k_x[i] = w->k * cos(w->direction_rad);
        m->k_y[i] = w->k * sin(w->direction_rad);
        m->w[i] = d.x * m->k_x[i] + d.y * m->k_y[i];
        m->p[i] = origin.x * m->k_x[i] + origin.y * m->k_y[i] + w->phase;
        m->bend += fabs(w->amplitude) * m->w[i] * m->w[i];
        rough += fabs(w->amplitude) * (1 + fabs(m->p[i]) + fabs(m->w[i]) * length);
    }
    m->noise = 0x1p-52 * rough;
}

/* The step that cannot pass a root, `f` and its slope `d` counted from the side we are on. */
static double safe_step(const March *m, double f, double d) {
    double root = sqrt(d * d + 2 * m->bend * f);
    if (d < 0) return 2 * f / (root - d);
    return m->bend > 0 ? (d + root) / m->bend : INFINITY;
}

/* The first root in (0, end). A start within the rounding error of the sheet lies on it and leaves it. */
static bool march(March *m, double *out) {
    double slope, f = march_height(m, 0, &slope), s = 0, least = 0x1p-50 * m->end;
    bool on_sheet = fabs(f) <= m->noise;
    double side = (on_sheet ? slope : f) < 0 ? -1 : 1;
    double step = safe_step(m, on_sheet ? 0 : side * f, side * slope);
    for (int i = 0; i < STEPS_MAX; i++) {
        s += fmax(step, least);
        if (!(s < m->end)) return false;
        f = side * march_height(m, s, &slope);
        if (f <= (side * slope < 0 ? m->noise : 0)) {
            *out = s;
            return true;
        }
        step = safe_step(m, f, side * slope);
    }
    return false;
}

static bool intersect(const void *data, V3 origin, V3 direction, double t_min, double t_max, ShapeHit *hit) {
    const HeightfieldParams *p = data;
    double t0 = t_min, t1 = t_max, half_z = amplitude_sum(p) + 1e-9 * fmax(p->size[0], p->size[1]);
    if (!clip(origin.z, direction.z, half_z, &t0, &t1) ||
        !clip(origin.x, direction.x, 0.5 * p->size[0], &t0, &t1) ||
        !clip(origin.y, direction.y, 0.5 * p->size[1], &t0, &t1))
        return false;
    March m;
    double s;
    V3 start = v3_mad(origin, t0, direction);
    march_start(p, start, direction, t1 - t0, &m);
    if (!march(&m, &s)) return false;
    V3 at = v3_mad(start, s, direction);
    hit->t = t0 + s;
    at.z -= m.gap;
    hit->position = at;
    hit->normal = march_normal(&m);
    return hit->t > t_min && hit->t < t_max;
}

static void bounds(const void *data, V3 *lo, V3 *hi) {
    const HeightfieldParams *p = data;
    double z = amplitude_sum(p);
    *lo = v3(-0.5 * p->size[0], -0.5 * p->size[1], -z);
    *hi = v3(0.5 * p->size[0], 0.5 * p->size[1], z);
}

const ShapeKind shape_heightfield = {
    .name = "heightfield",
    .help = "a sheet of sine waves over a rectangle, its medium below",
    .table = PARAM_TABLE(params),
    .data_size = sizeof(HeightfieldParams),
    .sheet = true,
    .check = check,
    .is_exact = is_exact,
    .tessellate = tessellate,
    .intersect = intersect,
    .bounds = bounds,
};
