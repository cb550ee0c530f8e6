/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Vectors, colours and frames in double precision. Only what Embree sees is single precision. */
#ifndef CORE_VEC_H
#define CORE_VEC_H

#include <math.h>
#include <stdbool.h>

#define CAU_PI 3.14159265358979323846

typedef struct V3 {
    double x, y, z;
} V3;

/** Linear RGB: a colour, a throughput, a flux or a radiance, as the name of the variable says. */
typedef struct Rgb {
    double r, g, b;
} Rgb;

static inline V3 v3(double x, double y, double z) { return (V3){x, y, z}; }
static inline V3 v3_add(V3 a, V3 b) { return v3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline V3 v3_sub(V3 a, V3 b) { return v3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline V3 v3_scale(V3 a, double s) { return v3(a.x * s, a.y * s, a.z * s); }
static inline V3 v3_neg(V3 a) { return v3(-a.x, -a.y, -a.z); }
static inline double v3_dot(V3 a, V3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline V3 v3_cross(V3 a, V3 b) {
    return v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline double v3_length(V3 a) { return sqrt(v3_dot(a, a)); }
static inline V3 v3_normalize(V3 a) { return v3_scale(a, 1.0 / v3_length(a)); }
/** a + s b */
static inline V3 v3_mad(V3 a, double s, V3 b) { return v3(a.x + s * b.x, a.y + s * b.y, a.z + s * b.z); }
static inline V3 v3_mul(V3 a, V3 b) { return v3(a.x * b.x, a.y * b.y, a.z * b.z); }
static inline V3 v3_min(V3 a, V3 b) { return v3(fmin(a.x, b.x), fmin(a.y, b.y), fmin(a.z, b.z)); }
static inline V3 v3_max(V3 a, V3 b) { return v3(fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z)); }
static inline bool v3_finite(V3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }

static inline Rgb rgb(double r, double g, double b) { return (Rgb){r, g, b}; }
static inline Rgb rgb_grey(double v) { return rgb(v, v, v); }
static inline Rgb rgb_add(Rgb a, Rgb b) { return rgb(a.r + b.r, a.g + b.g, a.b + b.b); }
static inline Rgb rgb_sub(Rgb a, Rgb b) { return rgb(a.r - b.r, a.g - b.g, a.b - b.b); }
static inline Rgb rgb_mul(Rgb a, Rgb b) { return rgb(a.r * b.r, a.g * b.g, a.b * b.b); }
static inline Rgb rgb_scale(Rgb a, double s) { return rgb(a.r * s, a.g * s, a.b * s); }
static inline double rgb_max(Rgb a) {
    double m = a.g > a.b ? a.g : a.b;
    return a.r > m ? a.r : m;
}
static inline double rgb_mean(Rgb a) { return (a.r + a.g + a.b) / 3.0; }
static inline bool rgb_black(Rgb a) { return a.r == 0 && a.g == 0 && a.b == 0; }
static inline bool rgb_finite(Rgb a) { return isfinite(a.r) && isfinite(a.g) && isfinite(a.b); }

/** Two unit vectors that make a right-handed frame with the unit vector n.
 *  Duff et al. 2017, "Building an Orthonormal Basis, Revisited", JCGT 6(1), listing 3. */
static inline void v3_frame(V3 n, V3 *s, V3 *t) {
    double sign = copysign(1.0, n.z), a = -1.0 / (sign + n.z), b = n.x * n.y * a;
    *s = v3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    *t = v3(b, sign + n.y * n.y * a, -n.y);
}

static inline V3 v3_from_frame(V3 local, V3 s, V3 t, V3 n) {
    return v3_add(v3_add(v3_scale(s, local.x), v3_scale(t, local.y)), v3_scale(n, local.z));
}
static inline V3 v3_to_frame(V3 world, V3 s, V3 t, V3 n) {
    return v3(v3_dot(world, s), v3_dot(world, t), v3_dot(world, n));
}

static inline double clamp(double x, double lo, double hi) { return x < lo ? lo : (x > hi ? hi : x); }
static inline double square(double x) { return x * x; }
/** x, but 0 below 0 and for NaN. Without the care of fmax(), which costs a call. */
static inline double positive(double x) { return x > 0 ? x : 0; }

/** An affine map, row-major 3x4: p -> m[.][0..2] p + m[.][3]. */
typedef struct Affine {
    double m[3][4];
} Affine;

static inline V3 affine_vector(const Affine *a, V3 v) {
    return v3(a->m[0][0] * v.x + a->m[0][1] * v.y + a->m[0][2] * v.z,
        a->m[1][0] * v.x + a->m[1][1] * v.y + a->m[1][2] * v.z,
        a->m[2][0] * v.x + a->m[2][1] * v.y + a->m[2][2] * v.z);
}
static inline V3 affine_point(const Affine *a, V3 p) {
    V3 v = affine_vector(a, p);
    return v3(v.x + a->m[0][3], v.y + a->m[1][3], v.z + a->m[2][3]);
}
static inline V3 affine_column(const Affine *a, int c) { return v3(a->m[0][c], a->m[1][c], a->m[2][c]); }
static inline Affine affine_identity(void) { return (Affine){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}; }
/** Determinant of the linear part. */
static inline double affine_determinant(const Affine *a) {
    return v3_dot(affine_column(a, 0), v3_cross(affine_column(a, 1), affine_column(a, 2)));
}
/** The cofactor matrix applied to a vector: maps normals (unnormalised), with the sign of the determinant. */
static inline V3 affine_normal(const Affine *a, V3 n) {
    V3 x = affine_column(a, 0), y = affine_column(a, 1), z = affine_column(a, 2);
    return v3_add(
        v3_add(v3_scale(v3_cross(y, z), n.x), v3_scale(v3_cross(z, x), n.y)), v3_scale(v3_cross(x, y), n.z));
}
/** Inverse; the linear part must not be singular. */
static inline Affine affine_inverse(const Affine *a) {
    V3 x = affine_column(a, 0), y = affine_column(a, 1), z = affine_column(a, 2), p = affine_column(a, 3);
    double inv = 1.0 / affine_determinant(a);
    V3 r0 = v3_scale(v3_cross(y, z), inv), r1 = v3_scale(v3_cross(z, x), inv),
       r2 = v3_scale(v3_cross(x, y), inv);
    return (Affine){{{r0.x, r0.y, r0.z, -v3_dot(r0, p)}, {r1.x, r1.y, r1.z, -v3_dot(r1, p)},
        {r2.x, r2.y, r2.z, -v3_dot(r2, p)}}};
}
/** a after b. */
static inline Affine affine_compose(const Affine *a, const Affine *b) {
    Affine c;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            c.m[i][j] = a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] + a->m[i][2] * b->m[2][j] +
                        (j == 3 ? a->m[i][3] : 0.0);
    return c;
}

#endif
