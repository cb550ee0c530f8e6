/* SPDX-License-Identifier: Apache-2.0 */
/* Shapes against brute force: exact intersections, closed and outward meshes, smooth normals. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "core/rng.h"
#include "render/scene/scene.h"

#include <stdlib.h>
#include <string.h>

static double between(Rng *rng, double lo, double hi) { return lo + (hi - lo) * rng_next(rng); }

static V3 random_direction(Rng *rng) {
    double z = between(rng, -1, 1), a = between(rng, 0, 2 * CAU_PI), r = sqrt(1 - z * z);
    return v3(r * cos(a), r * sin(a), z);
}

/* A kind with its parameters set as given, by name. */
typedef struct Made {
    const ShapeKind *kind;
    double data[16];
} Made;

static Made make(const char *name) {
    Made m = {.kind = shape_find(name)};
    assert_non_null(m.kind);
    assert_true(m.kind->data_size <= sizeof m.data);
    param_defaults(&m.kind->table, m.data);
    return m;
}

static void set(Made *m, const char *key, const double *values, size_t count) {
    CauError err = {0};
    if (param_set(&m->kind->table, m->data, "shape", key, values, count, &err) != CAU_OK)
        fail_msg("%s", err.text);
}

static void set1(Made *m, const char *key, double value) { set(m, key, &value, 1); }

static Mesh mesh_of(Made *m, bool smooth) {
    Mesh mesh;
    CauError err = {0};
    if (m->kind->check) assert_int_equal(m->kind->check(m->data, "shape", &err), CAU_OK);
    assert_int_equal(m->kind->tessellate(m->data, smooth, &mesh, &err), CAU_OK);
    return mesh;
}

/* ---- exact surfaces ---- */

/* The first root of a x^2 + 2 b x + c in (lo, hi), in extended precision. */
static bool first_root(
    long double a, long double b, long double c, long double lo, long double hi, long double *out) {
    long double d = b * b - a * c;
    if (a == 0 || d < 0) return false;
    long double s = sqrtl(d), r0 = (-b - s) / a, r1 = (-b + s) / a;
    *out = r0 > lo ? r0 : r1;
    return *out > lo && *out < hi;
}

static void sphere_is_exact(void **state) {
    (void)state;
    Made m = make("sphere");
    set1(&m, "radius", 0.75);
    Rng rng = rng_make(1);
    int hits = 0;
    for (int i = 0; i < 200000; i++) {
        V3 to = v3_scale(random_direction(&rng), 0.9 * rng_next(&rng)), d = random_direction(&rng);
        double away = pow(10, between(&rng, -2, 4)), t_min = i % 3 ? 0 : between(&rng, 0, away);
        V3 o = v3_mad(to, -away, d);
        d = v3_scale(d, between(&rng, 0.1, 3));
        long double a = 0, b = 0, c = -0.75L * 0.75L, t = 0;
        const double oo[3] = {o.x, o.y, o.z}, dd[3] = {d.x, d.y, d.z};
        for (int k = 0; k < 3; k++) {
            a += (long double)dd[k] * dd[k];
            b += (long double)oo[k] * dd[k];
            c += (long double)oo[k] * oo[k];
        }
        ShapeHit hit;
        bool expected = first_root(a, b, c, t_min, INFINITY, &t);
        bool found = m.kind->intersect(m.data, o, d, t_min, INFINITY, &hit);
        long double square = b * b - a * c; /* a graze may go either way */
        if (fabsl(square) < 1e-12L * b * b || fabs((double)t - t_min) < 1e-9 * away) continue;
        assert_int_equal(found, expected);
        if (!found) continue;
        hits++;
        double chord = sqrt((double)(square / a)), reach = 2e-15 * (away + 1) / (chord * v3_length(d));
        assert_true(fabs(hit.t - (double)t) <= 1e-14 * fabs((double)t) + reach);
        assert_true(fabs(v3_length(hit.position) - 0.75) < 1e-15);
        assert_true(v3_length(v3_sub(v3_scale(hit.normal, 0.75), hit.position)) < 1e-15);
    }
    assert_true(hits > 100000);
}

static bool cylinder_by_parts(V3 o, V3 d, double r, double h, bool caps, double *t) {
    long double a = (long double)d.x * d.x + (long double)d.y * d.y,
                b = (long double)o.x * d.x + (long double)o.y * d.y;
    long double c = (long double)o.x * o.x + (long double)o.y * o.y - (long double)r * r,
                disc = b * b - a * c;
    *t = INFINITY;
    for (int s = -1; s <= 1 && disc > 0; s += 2) {
        double x = (double)((-b + s * sqrtl(disc)) / a), z = o.z + x * d.z;
        if (x > 0 && x < *t && z >= 0 && z <= h) *t = x;
    }
    for (int end = 0; caps && end < 2; end++) {
        double x = (end * h - o.z) / d.z, px = o.x + x * d.x, py = o.y + x * d.y;
        if (x > 0 && x < *t && px * px + py * py < r * r) *t = x;
    }
    return isfinite(*t);
}

static void cylinder_is_exact(void **state) {
    (void)state;
    Rng rng = rng_make(2);
    int hits = 0;
    for (int i = 0; i < 200000; i++) {
        bool caps = i % 2;
        Made m = make("cylinder");
        set1(&m, "radius", 0.5);
        set1(&m, "height", 1.25);
        set1(&m, "caps", caps);
        V3 d = random_direction(&rng);
        V3 o = v3(between(&rng, -1, 1), between(&rng, -1, 1), between(&rng, -1, 2));
        double t;
        ShapeHit hit;
        bool expected = cylinder_by_parts(o, d, 0.5, 1.25, caps, &t);
        bool found = m.kind->intersect(m.data, o, d, 0, INFINITY, &hit);
        assert_int_equal(found, expected);
        if (!found) continue;
        hits++;
        assert_true(fabs(hit.t - t) < 1e-9);
        bool side = fabs(hypot(hit.position.x, hit.position.y) - 0.5) < 1e-15 && hit.normal.z == 0;
        assert_true(side || (caps && (hit.position.z == 0 || hit.position.z == 1.25)));
    }
    assert_true(hits > 20000);
}

static Made make_water(void) {
    static const double waves[] = {
        .020, 2.1, .3, 0, .016, 3.4, 1.2, 1, .010, 5.3, 2.2, 2, .007, 8.1, 4.0, .5, .005, 11, 5.2, 3};
    Made m = make("heightfield");
    set(&m, "size", (double[]){8, 6}, 2);
    set(&m, "waves", waves, sizeof waves / sizeof *waves);
    return m;
}

static double water(double x, double y) {
    static const double w[5][4] = {{.020, 2.1, .3, 0}, {.016, 3.4, 1.2, 1}, {.010, 5.3, 2.2, 2},
        {.007, 8.1, 4.0, .5}, {.005, 11, 5.2, 3}};
    double z = 0;
    for (int i = 0; i < 5; i++) z += w[i][0] * sin(w[i][1] * (x * cos(w[i][2]) + y * sin(w[i][2])) + w[i][3]);
    return z;
}

static double above(V3 o, V3 d, double t) {
    V3 p = v3_mad(o, t, d);
    return p.z - water(p.x, p.y);
}

/* A ray of one of four families: from above, from below, grazing inside the waves, from far away. */
static void random_ray(Rng *rng, int family, V3 *o, V3 *d) {
    V3 to = v3(between(rng, -4, 4), between(rng, -3, 3), between(rng, -.06, .06));
    double slope = family == 2 ? between(rng, -.03, .03) : (family == 1 ? 1 : -1) * between(rng, .05, 1);
    double a = between(rng, 0, 2 * CAU_PI);
    *d = v3_normalize(v3(cos(a), sin(a), slope));
    *o = v3_mad(to, -(family == 3 ? between(rng, 1e2, 1e3) : between(rng, 0, 4)), *d);
}

/* Where the ray is over the rectangle. */
static void over_sheet(V3 o, V3 d, double *t0, double *t1) {
    *t0 = 0;
    *t1 = INFINITY;
    const double oo[2] = {o.x, o.y}, dd[2] = {d.x, d.y}, half[2] = {4, 3};
    for (int c = 0; c < 2; c++) {
        double a = (-half[c] - oo[c]) / dd[c], b = (half[c] - oo[c]) / dd[c];
        *t0 = fmax(*t0, fmin(a, b));
        *t1 = fmin(*t1, fmax(a, b));
    }
}

static void heightfield_misses_nothing(void **state) {
    (void)state;
    enum { RAYS = 4000, SAMPLES = 4000 };
    Made m = make_water();
    Rng rng = rng_make(3);
    int hits = 0, dense_missed = 0;
    for (int i = 0; i < RAYS; i++) {
        V3 o, d;
        double t0, t1;
        random_ray(&rng, i % 4, &o, &d);
        over_sheet(o, d, &t0, &t1);
        ShapeHit hit;
        bool found = m.kind->intersect(m.data, o, d, 0, INFINITY, &hit);
        double end = found ? hit.t : t1, side = above(o, d, t0);
        /* Before the hit (or, without one, everywhere) the ray must stay on one side of the sheet. */
        for (int s = 1; s < SAMPLES && t0 < t1; s++) {
            double t = t0 + (end - t0) * s / SAMPLES;
            assert_true(above(o, d, t) * side >= -1e-18);
        }
        if (!found) continue;
        hits++;
        assert_true(hit.t >= t0 - 1e-9 && hit.t <= t1 + 1e-9);
        assert_true(fabs(above(o, d, hit.t)) < 1e-12 * fmax(1, hit.t / 10));
        assert_true(fabs(hit.position.z - water(hit.position.x, hit.position.y)) < 1e-15);
        /* A double root that dense marching at this step would miss is a bonus, not an error. */
        double after = above(o, d, hit.t + (t1 - t0) / SAMPLES);
        dense_missed += after * side > 0;
        double e = 1e-6, x = hit.position.x, y = hit.position.y;
        V3 n = v3_normalize(v3(
            (water(x - e, y) - water(x + e, y)) / (2 * e), (water(x, y - e) - water(x, y + e)) / (2 * e), 1));
        assert_true(v3_length(v3_sub(n, hit.normal)) < 1e-8);
    }
    print_message("heightfield: %d hits, %d of them closer to a second one than the marching step\n", hits,
        dense_missed);
    assert_true(hits > RAYS / 2);
    param_free(&m.kind->table, m.data);
}

/* Rays that leave a hit point, offset by far less than any size, must not find it again. */
static void leaving_a_surface_does_not_hit_it(void **state) {
    (void)state;
    Made water_sheet = make_water(), ball = make("sphere");
    set1(&ball, "radius", 0.5);
    Rng rng = rng_make(4);
    for (int i = 0; i < 100000; i++) {
        Made *m = i % 2 ? &ball : &water_sheet;
        V3 o, d;
        ShapeHit hit, again;
        if (m == &ball) {
            d = random_direction(&rng);
            o = v3_mad(v3_scale(random_direction(&rng), 0.4), -3, d);
        } else
            random_ray(&rng, i / 2 % 3, &o, &d);
        if (!m->kind->intersect(m->data, o, d, 0, INFINITY, &hit)) continue;
        V3 out = random_direction(&rng);
        if (fabs(v3_dot(out, hit.normal)) < 1e-3) continue;
        bool front = v3_dot(out, hit.normal) > 0;
        V3 start = v3_mad(hit.position, front ? 1e-13 : -1e-13, hit.normal);
        bool found = m->kind->intersect(m->data, start, out, 0, INFINITY, &again);
        if (m == &ball) assert_int_equal(found, !front);
        if (found) assert_true(again.t > 1e-5);
    }
    param_free(&water_sheet.kind->table, water_sheet.data);
}

/* ---- meshes ---- */

static V3 vertex(const Mesh *m, size_t t, int c) {
    const double *p = &m->positions[3 * (size_t)m->triangles[3 * t + (size_t)c]];
    return v3(p[0], p[1], p[2]);
}

static double volume(const Mesh *m) {
    double six = 0;
    for (size_t t = 0; t < m->triangle_count; t++)
        six += v3_dot(vertex(m, t, 0), v3_cross(vertex(m, t, 1), vertex(m, t, 2)));
    return six / 6;
}

static int compare_u64(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Every edge runs once each way. */
static void assert_closed(const Mesh *m) {
    size_t count = 3 * m->triangle_count;
    uint64_t *one = malloc(count * sizeof *one), *other = malloc(count * sizeof *other);
    assert_true(one && other);
    for (size_t i = 0; i < count; i++) {
        uint64_t a = m->triangles[i], b = m->triangles[i % 3 == 2 ? i - 2 : i + 1];
        assert_true(a < m->vertex_count && a != b);
        one[i] = a << 32 | b;
        other[i] = b << 32 | a;
    }
    qsort(one, count, sizeof *one, compare_u64);
    qsort(other, count, sizeof *other, compare_u64);
    for (size_t i = 0; i < count; i++) {
        assert_true(one[i] == other[i]);
        assert_true(i == 0 || one[i] != one[i - 1]);
    }
    free(one);
    free(other);
}

static void assert_normals_face_out(const Mesh *m) {
    for (size_t t = 0; t < m->triangle_count && m->normals; t++) {
        V3 n = v3_cross(v3_sub(vertex(m, t, 1), vertex(m, t, 0)), v3_sub(vertex(m, t, 2), vertex(m, t, 0)));
        assert_true(v3_length(n) > 0);
        for (size_t c = 0; c < 3; c++) {
            const float *f = &m->normals[9 * t + 3 * c];
            V3 s = v3((double)f[0], (double)f[1], (double)f[2]);
            assert_true(fabs(v3_length(s) - 1) < 1e-6);
            assert_true(v3_dot(s, n) > 0);
        }
    }
}

static void check_solid(Made *m, double expected, double tolerance) {
    for (int smooth = 0; smooth < 2; smooth++) {
        Mesh mesh = mesh_of(m, smooth);
        assert_closed(&mesh);
        assert_normals_face_out(&mesh);
        assert_true(fabs(volume(&mesh) / expected - 1) < tolerance);
        mesh_free(&mesh);
    }
}

static void solids_are_closed_and_outward(void **state) {
    (void)state;
    Made box = make("box"), ball = make("sphere"), can = make("cylinder"), cone = make("lathe"),
         ring = make("lathe");
    set(&box, "size", (double[]){1, 2, 3}, 3);
    check_solid(&box, 6, 1e-15);
    set1(&ball, "radius", 2);
    set1(&ball, "segments", 256);
    check_solid(&ball, 4.0 / 3 * CAU_PI * 8, 1e-3);
    set1(&ball, "segments", 3); /* the coarsest there is */
    check_solid(&ball, 4.0 / 3 * CAU_PI * 8, 0.8);
    set1(&can, "radius", 0.5);
    set1(&can, "height", 3);
    set1(&can, "caps", 1);
    set1(&can, "segments", 500);
    check_solid(&can, CAU_PI * 0.75, 1e-3);
    set(&cone, "profile", (double[]){0, 0, 1, 0, 0, 3}, 6);
    set1(&cone, "segments", 400);
    check_solid(&cone, CAU_PI, 1e-3);
    set(&ring, "profile", (double[]){2, 0, 3, 0, 3, 1, 2, 1, 2, 0}, 10);
    check_solid(&ring, 5 * CAU_PI, 1e-2);
    param_free(&cone.kind->table, cone.data);
    param_free(&ring.kind->table, ring.data);
}

static void sphere_normals_are_exact(void **state) {
    (void)state;
    Made ball = make("sphere");
    set1(&ball, "radius", 3);
    set1(&ball, "segments", 16);
    Mesh mesh = mesh_of(&ball, true);
    for (size_t corner = 0; corner < 3 * mesh.triangle_count; corner++)
        for (size_t c = 0; c < 3; c++)
            assert_true(fabs((double)mesh.normals[3 * corner + c] -
                             mesh.positions[3 * (size_t)mesh.triangles[corner] + c] / 3) < 1e-7);
    mesh_free(&mesh);
}

/* The normal of each vertex by the definition: faces are the quads, weights their angles. */
static void lathe_normals_are_those_of_its_quads(void **state) {
    (void)state;
    enum { N = 12 };
    static const double profile[] = {0, 0, 1, 0.1, 1.4, 0.8, 0.7, 1.6, 0.75, 2.5, 0, 2.6};
    Made m = make("lathe");
    set(&m, "profile", profile, 12);
    set1(&m, "segments", N);
    Mesh mesh = mesh_of(&m, true);
    V3 p[6][2 * N];
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 2 * N; j++) {
            double a = 2 * CAU_PI * j / N;
            p[i][j] = v3(profile[2 * i] * cos(a), profile[2 * i] * sin(a), profile[2 * i + 1]);
        }
    for (int i = 1; i < 5;
         i++) { /* vertex (i, N): its four faces, each as the corner and its two neighbours */
        V3 sum = {0, 0, 0};
        for (int up = -1; up <= 1; up += 2)
            for (int side = -1; side <= 1; side += 2) {
                V3 a = v3_sub(p[i][N + side], p[i][N]), b = v3_sub(p[i + up][N], p[i][N]);
                V3 n = v3_normalize(v3_scale(v3_cross(a, b), up * side));
                sum = v3_mad(sum, atan2(v3_length(v3_cross(a, b)), v3_dot(a, b)), n);
            }
        sum = v3_normalize(sum);
        int seen = 0;
        for (size_t corner = 0; corner < 3 * mesh.triangle_count; corner++) {
            const double *q = &mesh.positions[3 * (size_t)mesh.triangles[corner]];
            if (v3_length(v3_sub(v3(q[0], q[1], q[2]), p[i][0])) > 1e-12) continue;
            const float *n = &mesh.normals[3 * corner];
            assert_true(v3_length(v3_sub(v3((double)n[0], (double)n[1], (double)n[2]), sum)) < 1e-6);
            seen++;
        }
        assert_true(seen >= 4);
    }
    mesh_free(&mesh);
    param_free(&m.kind->table, m.data);
}

static void sheets_face_up(void **state) {
    (void)state;
    Made plane = make("plane"), sea = make_water(), grid = make("grid");
    set(&plane, "size", (double[]){2, 3}, 2);
    set1(&sea, "segments", 40);
    set(&grid, "size", (double[]){2, 1}, 2);
    set1(&grid, "columns", 3);
    set(&grid, "heights", (double[]){0, 0, 0, 0, 1, 0, 0, 0, 0.5}, 9);
    Made *all[] = {&plane, &sea, &grid};
    for (size_t i = 0; i < 3; i++) {
        Mesh mesh = mesh_of(all[i], true);
        for (size_t t = 0; t < mesh.triangle_count; t++)
            assert_true(v3_cross(v3_sub(vertex(&mesh, t, 1), vertex(&mesh, t, 0)),
                            v3_sub(vertex(&mesh, t, 2), vertex(&mesh, t, 0)))
                            .z > 0);
        assert_int_equal(mesh.normals != NULL, i > 0);
        if (i == 2)
            assert_true(
                mesh.positions[3 * 4 + 2] == 1 && mesh.positions[3 * 4] == 0 && mesh.positions[3 * 8] == 1);
        mesh_free(&mesh);
        param_free(&all[i]->kind->table, all[i]->data);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sphere_is_exact),
        cmocka_unit_test(cylinder_is_exact),
        cmocka_unit_test(heightfield_misses_nothing),
        cmocka_unit_test(leaving_a_surface_does_not_hit_it),
        cmocka_unit_test(solids_are_closed_and_outward),
        cmocka_unit_test(sphere_normals_are_exact),
        cmocka_unit_test(lathe_normals_are_those_of_its_quads),
        cmocka_unit_test(sheets_face_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
