/* SPDX-License-Identifier: Apache-2.0 */
/* The pieces of the photon estimator against brute force: kernel over a triangle, tree of deposits, film
 * sums, filters. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/rng.h"
#include "render/film/bandwidth.h"
#include "render/film/film.h"
#include "render/gather/disk.h"
#include "render/gather/photon_tree.h"
#include "render/trace/camera.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- support ---- */

static bool in_triangle(const double t[3][2], double x, double y) {
    double d[3];
    for (int k = 0; k < 3; k++) {
        const double *a = t[k], *b = t[(k + 1) % 3];
        d[k] = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
    }
    return (d[0] >= 0 && d[1] >= 0 && d[2] >= 0) || (d[0] <= 0 && d[1] <= 0 && d[2] <= 0);
}

static void kernel_over_a_triangle_is_its_quadrature(void **state) {
    (void)state;
    Rng rng = rng_make(7);
    for (int round = 0; round < 40; round++) {
        double t[3][2], r = 0.2 + 2 * rng_next(&rng), sum = 0;
        for (int k = 0; k < 6; k++) t[k / 2][k % 2] = 4 * rng_next(&rng) - 2;
        enum { N = 1200 };
        for (int i = 0; i < N; i++)
            for (int j = 0; j < N; j++) {
                double x = (2 * (i + 0.5) / N - 1) * r, y = (2 * (j + 0.5) / N - 1) * r,
                       k = 1 - (x * x + y * y) / (r * r);
                if (k > 0 && in_triangle((const double(*)[2])t, x, y)) sum += k;
            }
        sum *= square(2 * r / N);
        double exact = fabs(disk_triangle_integral(t[0], t[1], t[2], r));
        if (fabs(exact - sum) > 2e-3 * r * r) fail_msg("round %d: %g against %g", round, exact, sum);
    }
    double a[2] = {-90, -80}, b[2] = {100, -70}, c[2] = {3, 95}; /* holds the disk whole */
    assert_true(fabs(disk_triangle_integral(a, b, c, 2) - CAU_PI * 4 / 2) < 1e-9);
}

/* ---- tree ---- */

typedef struct Found {
    unsigned *times;
    const Deposit *base;
    size_t count;
} Found;

static void count_found(void *data, const Deposit *d, double distance2) {
    (void)distance2;
    Found *f = data;
    f->times[d->audience + 256u * d->diffuse + 65536u * d->glossy]++;
    f->count++;
}

static void check_tree(const Deposit *items, size_t count, uint64_t key) {
    PhotonTree tree = {0};
    assert_int_equal(photon_tree_build(&tree, items, count, NULL), CAU_OK);
    unsigned *times = calloc(count + 1, sizeof *times);
    Rng rng = rng_make(key);
    for (int q = 0; q < 60; q++) {
        V3 c = v3(rng_next(&rng), rng_next(&rng), rng_next(&rng) * 0.1);
        double r = pow(10, -4 + 4 * rng_next(&rng));
        memset(times, 0, (count + 1) * sizeof *times);
        Found found = {times, items, 0};
        photon_tree_query(&tree, c, r, count_found, &found);
        float cf[3] = {(float)c.x, (float)c.y, (float)c.z}, r2 = (float)(r * r);
        for (size_t i = 0; i < count; i++) {
            float d2 = 0;
            for (int k = 0; k < 3; k++) {
                float d = items[i].position[k] - cf[k];
                d2 += d * d;
            }
            /* Exactly once where inside, never outside. */
            if (times[i] != (d2 <= r2 ? 1u : 0u))
                fail_msg("deposit %zu met %u times, query %d", i, times[i], q);
        }
    }
    free(times);
    photon_tree_free(&tree);
}

static Deposit *make_deposits(size_t count, uint64_t key, double grid) {
    Deposit *items = calloc(count + 1, sizeof *items);
    Rng rng = rng_make(key);
    for (size_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) {
            double x = rng_next(&rng) * (k == 2 ? 0.1 : 1);
            items[i].position[k] = (float)(grid > 0 ? floor(x / grid) * grid : x);
        }
        items[i].audience = (uint8_t)(i & 255);
        items[i].diffuse = (uint8_t)(i >> 8 & 255);
        items[i].glossy = (uint8_t)(i >> 16 & 255);
    }
    return items;
}

static void tree_meets_each_deposit_once(void **state) {
    (void)state;
    static const size_t counts[] = {0, 1, 2, 7, 8, 9, 63, 64, 65, 511, 513, 5000};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        for (int kind = 0; kind < 3; kind++) { /* spread, on a coarse grid (ties), all in one point */
            Deposit *items = make_deposits(counts[i], 99 + i, kind == 0 ? 0 : (kind == 1 ? 0.125 : 10));
            check_tree(items, counts[i], i);
            free(items);
        }
}

static void ten_million_equal_points_build(void **state) {
    (void)state;
    size_t count = 10000000;
    Deposit *items = calloc(count, sizeof *items);
    PhotonTree tree = {0};
    assert_int_equal(photon_tree_build(&tree, items, count, NULL), CAU_OK);
    assert_int_equal(tree.box_count[tree.levels - 1], 1);
    photon_tree_free(&tree);
    free(items);
}

/* ---- normals, film, filter ---- */

static void packed_normals_point_the_same_way(void **state) {
    (void)state;
    Rng rng = rng_make(3);
    for (int i = 0; i < 100000; i++) {
        double z = 2 * rng_next(&rng) - 1, phi = 2 * CAU_PI * rng_next(&rng), s = sqrt(1 - z * z);
        V3 n = v3(s * cos(phi), s * sin(phi), z);
        int16_t packed[2];
        normal_encode(n, packed);
        assert_true(v3_dot(n, normal_decode(packed)) > 1 - 1e-8);
    }
}

static void film_sums_do_not_drift(void **state) {
    (void)state;
    Film film;
    assert_int_equal(film_create(&film, 1, 1, NULL), CAU_OK);
    /* A billion uniforms: 1000 passes, each holding the sum of a million as a pass of the estimator would. */
    Rng rng = rng_make(11);
    for (int pass = 0; pass < 1000; pass++) {
        double sum = 0;
        for (int i = 0; i < 1000000; i++) sum += rng_next(&rng);
        film_add(&film, &sum);
    }
    double mean = film_mean(&film, 0) / 1e6, error = film_error(&film, 0) / 1e6;
    assert_true(fabs(mean - 0.5) < 4 * error && error < 2e-5);
    film_free(&film);

    assert_int_equal(film_create(&film, 1, 1, NULL), CAU_OK);
    double x = 0.1f;
    for (int i = 0; i < 100000000; i++) film_add(&film, &x);
    assert_true(fabs(film_mean(&film, 0) / x - 1) < 1e-6);
    film_free(&film);
}

static void film_shows_the_old_until_there_is_new(void **state) {
    (void)state;
    Film film;
    assert_int_equal(film_create(&film, 1, 1, NULL), CAU_OK);
    assert_int_equal(film_halve(&film, FILM_DOUBLING, NULL), CAU_OK);
    for (int i = 0; i < 9; i++) film_add(&film, &(double){1 + i % 2});
    double mean = film_mean(&film, 0), error = film_error(&film, 0);
    assert_true(mean > 1.4 && mean < 1.6 && error > 0);
    for (int i = 0; i < 2; i++) {
        film_restart(&film); /* twice: stopped there, and started over again */
        assert_true(film_mean(&film, 0) == mean && film_error(&film, 0) == error);
        assert_true(film.passes == 0 && film_passes(&film) == 9);
    }
    for (int i = 0; i < 2; i++) film_add(&film, &(double){5});
    assert_true(film_mean(&film, 0) == 5 && film_error(&film, 0) == 0 && film_passes(&film) == 2);
    film_free(&film);
}

/* Passes at evenly spread places, turned by a number of each pixel's own, or at places drawn anew. */
static double even_place(bool even, int pixel, int pass) {
    Rng rng = rng_make((uint64_t)(even ? pixel : 1000 * pixel + pass + 1));
    double at = rng_next(&rng), bit = 0.5;
    for (int k = pass; even && k; k >>= 1, bit /= 2) at += (k & 1) * bit; /* van der Corput 1935 */
    return at - floor(at);
}

/* Of a mean that is 1/2: what the film states, over the true error. */
static double stated_over_true(bool even, int passes, uint64_t half) {
    enum { PIXELS = 4000 };
    Film film;
    double pass[PIXELS], stated = 0, true_error = 0;
    assert_int_equal(film_create(&film, PIXELS, 1, NULL), CAU_OK);
    if (half) assert_int_equal(film_halve(&film, half, NULL), CAU_OK);
    for (int k = 0; k < passes; k++) {
        for (int i = 0; i < PIXELS; i++) pass[i] = even_place(even, i, k);
        film_add(&film, pass);
    }
    for (size_t i = 0; i < PIXELS; i++) {
        stated += square(film_error(&film, i));
        true_error += square(film_mean(&film, i) - 0.5);
    }
    film_free(&film);
    return sqrt(stated / true_error);
}

static void halves_know_how_even_passes_are(void **state) {
    (void)state;
    for (int k = 0; k < 2; k++) {
        uint64_t half = k ? FILM_DOUBLING : 8;
        double apart = stated_over_true(false, 16, half), even = stated_over_true(true, 16, half);
        if (apart < 0.9 || apart > 1.1) fail_msg("independent passes: %g of the true error", apart);
        if (even < 1 || even > 2.5) fail_msg("even passes: %g of the true error", even);
    }
    assert_true(stated_over_true(true, 16, 0) > 3.5);
    /* No half, or all of it: as without. */
    assert_true(stated_over_true(true, 16, 16) > 3.5 && stated_over_true(true, 3, 1) > 1);
}

/* A focus whose passes are even says nothing of the faint light around it, whose passes are not. */
static void faint_light_has_its_own_evenness(void **state) {
    (void)state;
    enum { PIXELS = 4000, PASSES = 16 };
    Film film;
    double pass[PIXELS], stated[2] = {0}, error[2] = {0};
    assert_int_equal(film_create(&film, PIXELS, 1, NULL), CAU_OK);
    assert_int_equal(film_halve(&film, PASSES / 2, NULL), CAU_OK);
    for (int k = 0; k < PASSES; k++) {
        for (int i = 0; i < PIXELS; i++)
            pass[i] = i % 2 ? even_place(false, i, k) : 1000 * even_place(true, i, k);
        film_add(&film, pass);
    }
    for (size_t i = 0; i < PIXELS; i++) {
        stated[i % 2] += square(film_error(&film, i));
        error[i % 2] += square(film_mean(&film, i) - (i % 2 ? 0.5 : 500));
    }
    film_free(&film);
    assert_true(sqrt(stated[1] / error[1]) > 0.9 && sqrt(stated[1] / error[1]) < 1.15);
    assert_true(sqrt(stated[0] / error[0]) > 1 && sqrt(stated[0] / error[0]) < 2.5);
}

static void film_refuses_what_is_not_finite(void **state) {
    (void)state;
    Film film;
    assert_int_equal(film_create(&film, 2, 1, NULL), CAU_OK);
    double bad[2] = {NAN, 1}, good[2] = {2, 1};
    film_add(&film, bad);
    film_add(&film, good);
    assert_int_equal(film.non_finite, 1);
    assert_true(film_mean(&film, 0) == 1 && film_mean(&film, 1) == 1);
    film_free(&film);
}

static void filter_samples_have_its_density(void **state) {
    (void)state;
    static const FilterType types[] = {FILTER_BOX, FILTER_GAUSSIAN, FILTER_BLACKMAN_HARRIS};
    for (int t = 0; t < 3; t++) {
        PixelFilter f;
        filter_prepare(&f, types[t], 1.5);
        double integral = 0, second = 0, drawn = 0;
        enum { N = 20000 };
        for (int i = 0; i < N; i++) {
            double x = (2 * (i + 0.5) / N - 1) * f.half_width, v = filter_value(&f, x) * 2 * f.half_width / N;
            integral += v;
            second += v * x * x;
            drawn += square(filter_sample(&f, (i + 0.5) / N)) / N;
        }
        assert_true(fabs(integral - 1) < 1e-4);
        if (fabs(drawn / second - 1) > 2e-3)
            fail_msg("filter %d: second moment %g drawn, %g by its density", t, drawn, second);
    }
}

static void camera_projects_where_it_looks(void **state) {
    (void)state;
    for (int type = 0; type < 2; type++) {
        Camera c = {.type = type ? CAMERA_ORTHOGRAPHIC : CAMERA_PERSPECTIVE,
            .position = v3(1, 2, 3),
            .forward = v3_normalize(v3(-1, 2, -0.5)),
            .tan_half_width = 0.4,
            .ortho_width = 3,
            .shift_x = 0.1,
            .shift_y = -0.2,
            .clip_near = 0.01,
            .clip_far = 1e6,
            .width = 320,
            .height = 200,
            .pixel_aspect = 1.5};
        V3 s, t;
        v3_frame(c.forward, &s, &t);
        c.right = s;
        c.up = t;
        if (v3_dot(v3_cross(c.right, c.up), c.forward) > 0) c.up = v3_neg(c.up);
        for (double y = 0.5; y < 200; y += 33)
            for (double x = 0.5; x < 320; x += 41) {
                Ray ray = camera_ray(&c, x, y);
                CameraView view;
                assert_true(camera_project(&c, v3_mad(ray.origin, 7, ray.dir), &view));
                assert_true(fabs(view.x - x) < 1e-9 && fabs(view.y - y) < 1e-9);
                assert_true(fabs(v3_dot(view.to_camera, ray.dir) + 1) < 1e-12);
            }
    }
}

/* ---- kernels ---- */

/* A picture whose left half bends, so that a kernel of 3 footprints is wrong by 0.2, and whose right half
 * does not; noise of 0.5 per pass everywhere, and as much in what the kernels say of their bias. */
static void learned_radius_balances_noise_and_bias(void **state) {
    (void)state;
    enum { W = 64, H = 32, PASSES = 16 };
    const double radius = 3, bias = 0.2, noise = 0.5;
    CauError err = {0};
    Bandwidth b;
    Film film, *bias_film = &b.bias;
    BandwidthTrial trial = {1, 100, false};
    double falling;
    assert_int_equal(bandwidth_create(&b, W, H, radius, false, &err), CAU_OK);
    assert_int_equal(film_create(&film, (size_t)W * H, 3, &err), CAU_OK);
    double *pass = calloc(3 * W * H, sizeof *pass), *said = calloc(3 * W * H, sizeof *said),
           *cost = calloc(W * H, sizeof *cost);
    Rng rng = rng_make(11);
    for (int n = 0; n < PASSES; n++) {
        for (int i = 0; i < 3 * W * H; i++) {
            double b_here = i / 3 % W < W / 2 ? bias : 0;
            pass[i] = 1 + b_here + noise * sqrt(12) * (rng_next(&rng) - 0.5);
            said[i] = b_here + noise * sqrt(24) * (rng_next(&rng) - 0.5);
        }
        film_add(&film, pass);
        film_add(bias_film, said);
    }
    double left = 0, right = 0;
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            *(x < W / 2 ? &left : &right) += 2 * bandwidth_bias2(bias_film, (size_t)(y * W + x)) / (W * H);
    assert_true(fabs(left / (bias * bias) - 1) < 0.1);
    assert_true(fabs(right) < 0.1 * bias * bias);
    assert_true(fabs(sqrt(bandwidth_mean_bias2(&b)) / (bias / sqrt(2)) - 1) < 0.1);
    assert_true(fabs(bandwidth_bias(&b, (size_t)W * H / 2 + 8) / bias - 1) < 0.5);
    assert_int_equal(bandwidth_learn(&b, &film, bias_film, cost, &trial, &falling, &err), CAU_OK);
    /* r^6 = A / (12 n B^2): here noise^2 / n = 0.0156 beside bias^2 = 0.04. */
    double best = radius * pow(noise * noise / PASSES / (12 * bias * bias), 1.0 / 6);
    for (int y = 4; y < H - 4; y += 6) {
        double found = (double)b.radius[y * W + 10], flat = (double)b.radius[y * W + W - 10];
        if (fabs(found / best - 1) > 0.1) fail_msg("radius %g where %g is best", found, best);
        if (flat < 1.2 * radius || flat > 1.7 * radius)
            fail_msg("radius %g from %g without bias", flat, radius);
    }
    for (int i = 0; i < W * H; i++) cost[i] = 400; /* four times what is allowed: half the radius at most */
    float before = b.radius[W - 10];
    assert_int_equal(bandwidth_learn(&b, &film, bias_film, cost, &trial, &falling, &err), CAU_OK);
    assert_true((double)b.radius[W - 10] <= 0.501 * (double)before);
    /* Cost alone makes no kernel narrower than 2 footprints; strong bias does. */
    for (int k = 0; k < 8; k++)
        assert_int_equal(bandwidth_learn(&b, &film, bias_film, cost, &trial, &falling, &err), CAU_OK);
    assert_true(fabs((double)b.radius[W - 10] - 2) < 1e-6 && (double)b.radius[10] < 1);
    /* What still wants to fall is told; to settle is to go half of the way. */
    bandwidth_restart(&b, 4);
    memset(cost, 0, W * H * sizeof *cost);
    assert_int_equal(bandwidth_learn(&b, &film, bias_film, cost, &trial, &falling, &err), CAU_OK);
    double whole = (double)b.radius[W * H / 2 + 10];
    bandwidth_restart(&b, 4);
    trial.settle = true;
    assert_int_equal(bandwidth_learn(&b, &film, bias_film, cost, &trial, &falling, &err), CAU_OK);
    assert_true(fabs((double)b.radius[W * H / 2 + 10] / sqrt(4 * whole) - 1) < 0.02);
    assert_true(falling > 0.3 && falling < 0.5); /* of the half that has bias */
    bandwidth_free(&b);
    film_free(&film);
    free(pass);
    free(said);
    free(cost);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(learned_radius_balances_noise_and_bias),
        cmocka_unit_test(kernel_over_a_triangle_is_its_quadrature),
        cmocka_unit_test(tree_meets_each_deposit_once),
        cmocka_unit_test(ten_million_equal_points_build),
        cmocka_unit_test(packed_normals_point_the_same_way),
        cmocka_unit_test(film_sums_do_not_drift),
        cmocka_unit_test(film_shows_the_old_until_there_is_new),
        cmocka_unit_test(halves_know_how_even_passes_are),
        cmocka_unit_test(faint_light_has_its_own_evenness),
        cmocka_unit_test(film_refuses_what_is_not_finite),
        cmocka_unit_test(filter_samples_have_its_density),
        cmocka_unit_test(camera_projects_where_it_looks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
