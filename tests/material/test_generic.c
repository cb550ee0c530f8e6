/* SPDX-License-Identifier: Apache-2.0 */
/* What must hold for every kind of material: the tests loop over the tables, so a new kind is tested unasked.
 */
#include "cases.h"

#include <math.h>
#include <string.h>

/* More than the albedo of Burley's lobe and its ratio to the mean ever are. */
#define BURLEY_MOST 1.6

static const double cosines[] = {1.0, 0.8, 0.4, 0.1, 0.01};
#define COSINES (sizeof cosines / sizeof *cosines)

/* Whatever comes in, what goes out is finite, unit, on the stated side and no brighter. */
static void check_sample(
    const Case *c, const ShadingFrame *f, V3 wi, unsigned lobes, const ScatterSample *s) {
    expect_true(
        c, "one of the lobes asked for", (s->lobe & lobes & c->m.lobes) && !(s->lobe & (s->lobe - 1)));
    expect_near(c, "length of wo", v3_length(s->wo), 1.0, 1e-9);
    expect_true(c, "finite weight", rgb_finite(s->weight) && isfinite(s->pdf));
    expect_true(c, "weight and pdf not negative",
        s->weight.r >= 0 && s->weight.g >= 0 && s->weight.b >= 0 && s->pdf >= 0);
    expect_true(c, "bounded weight", rgb_max(s->weight) <= 20.0 + 1e-9);
    expect_true(
        c, "density of lobes with one", (s->lobe & (LOBE_DIFFUSE | LOBE_GLOSSY)) ? s->pdf > 0 : s->pdf == 0);
    if (s->lobe != LOBE_TRANSPARENT && !(s->transmit && s->eta == 1.0))
        expect_true(c, "wo on the stated side", (v3_dot(s->wo, f->ng) > 0) != s->transmit);
    expect_true(c, "eta of 1 unless refracted", s->transmit || s->eta == 1.0);
    expect_true(c, "finite eta", s->eta >= 0.1 && s->eta <= 10.0 + 1e-9);
    (void)wi;
}

static double edge_number(Rng *rng) {
    double x = rng_next(rng);
    return x < 0.1 ? 0.0 : x < 0.2 ? 1.0 - 0x1p-53 : x < 0.3 ? 0x1p-53 : rng_next(rng);
}

static void fuzz(const Case *c, Rng *rng) {
    for (int i = 0; i < 3000; i++) {
        double tilt = rng_next(rng) < 0.5 ? 0.0 : 1.5 * rng_next(rng);
        ShadingFrame f = make_frame(rng, rng_next(rng) < 0.5, tilt);
        /* From straight on to a grazing 1e-17, on ng's side as the contract has it. */
        V3 wi = direction_at(&f, rng_next(rng) < 0.5 ? rng_next(rng) : pow(10.0, -17.0 * rng_next(rng)), rng);
        if (v3_dot(wi, f.ng) < 0.0) wi = v3_sub(wi, v3_scale(f.ng, 2.0 * v3_dot(wi, f.ng)));
        unsigned lobes = 1 + (unsigned)(15 * rng_next(rng));
        double u[3] = {edge_number(rng), edge_number(rng), edge_number(rng)}, pdf = -1.0;
        ScatterSample s;
        if (c->m.kind->sample(&c->m, &f, wi, u, lobes, rng_next(rng) < 0.5, &s))
            check_sample(c, &f, wi, lobes, &s);
        if (c->m.kind->albedo) {
            Rgb a = c->m.kind->albedo(&c->m, &f, wi);
            double most = case_is_burley(c) ? BURLEY_MOST : 1.0;
            expect_true(c, "albedo in range", a.r >= 0 && a.g >= 0 && a.b >= 0 && rgb_max(a) <= most);
            double share = material_received(&c->m, &f, wi);
            expect_true(c, "received in range", share > 0.5 && share <= most);
        }
        if (!c->m.kind->eval) continue;
        V3 wo = rng_next(rng) < 0.1 ? wi : rng_next(rng) < 0.1 ? v3_neg(wi) : random_direction(rng);
        Rgb value = c->m.kind->eval(&c->m, &f, wi, wo, lobes, &pdf);
        expect_true(c, "eval finite", rgb_finite(value) && isfinite(pdf) && pdf >= 0 && value.r >= 0);
        expect_true(c, "a value only where there is a density", pdf > 0 || rgb_black(value));
    }
}

static void nothing_is_ever_nan(void **state) {
    (void)state;
    for_each_case(fuzz);
}

static void energy(const Case *c, Rng *rng) {
    for (size_t i = 0; i < COSINES; i++)
        for (int front = 0; front < 2; front++) {
            ShadingFrame f = make_frame(rng, front, 0.0);
            Shares s = sample_shares(&c->m, &f, direction_at(&f, cosines[i], rng), LOBE_ALL, 12, 32);
            double most = case_is_burley(c) ? 1.0 + BURLEY_MOST : 1.0; /* as Cycles has it */
            expect_true(c, "no surface makes light", rgb_max(s.total) <= most + 0.004);
        }
}

static void no_surface_makes_light(void **state) {
    (void)state;
    for_each_case(energy);
}

/* A white surface in a white room is white; rough GGX loses what it would scatter more than once. */
static void furnace(const Case *c, Rng *rng) {
    if (c->label[0] && !strstr(c->label, "variant 0")) return;
    double lost = c->roughness <= 0.0 ? 0.0 : c->roughness < 0.06 ? 0.03 : c->roughness < 0.21 ? 0.12 : 0.75;
    for (size_t i = 0; i + 1 < COSINES; i++) {
        ShadingFrame f = make_frame(rng, true, 0.0);
        Shares s = sample_shares(&c->m, &f, direction_at(&f, cosines[i], rng), LOBE_ALL, 16, 200);
        expect_true(c, "white furnace", s.total.g <= 1.003 && s.total.g >= 1.0 - lost - 0.003);
        if (c->m.kind->albedo) expect_near(c, "white furnace", s.total.g, 1.0, 0.004);
    }
}

static void white_furnace(void **state) {
    (void)state;
    for_each_case(furnace);
}

/* sample() and eval() tell the same story: same value, same density, at the directions drawn. */
static void agree(const Case *c, Rng *rng) {
    if (!c->m.kind->eval) return;
    for (int i = 0; i < 400; i++) {
        ShadingFrame f = make_frame(rng, rng_next(rng) < 0.5, 0.3 * (i % 2));
        V3 wi = direction_at(&f, 0.02 + 0.98 * rng_next(rng), rng);
        double u[3], pdf;
        random_u(rng, u);
        ScatterSample s;
        if (v3_dot(wi, f.ng) <= 0.0) continue;
        if (!c->m.kind->sample(&c->m, &f, wi, u, LOBE_ALL, false, &s)) continue;
        if (!(s.lobe & (LOBE_DIFFUSE | LOBE_GLOSSY))) continue;
        c->m.kind->eval(&c->m, &f, wi, s.wo, LOBE_ALL, &pdf);
        expect_near(c, "density of all lobes", pdf / s.pdf, 1.0, 1e-5);
        unsigned lobe = s.lobe;
        if (!c->m.kind->sample(&c->m, &f, wi, u, lobe, false, &s)) continue;
        Rgb value = c->m.kind->eval(&c->m, &f, wi, s.wo, lobe, &pdf);
        expect_near(c, "density of one lobe", pdf / s.pdf, 1.0, 1e-5);
        expect_near(c, "value", value.g, s.weight.g * s.pdf, 1e-5 * s.pdf);
    }
}

static void sample_and_eval_agree(void **state) {
    (void)state;
    for_each_case(agree);
}

/* Share of u[2] that leads to the outcome of `u`, by bisection: sample() turns from one outcome to the other
 * once.
 */
static double outcome_share(const Case *c, const ShadingFrame *f, V3 wi, const double u[3], unsigned lobe) {
    ScatterSample lo, hi, mid;
    double ends[3] = {u[0], u[1], 0.0};
    bool has_lo = c->m.kind->sample(&c->m, f, wi, ends, lobe, false, &lo), has_hi;
    ends[2] = 1.0 - 0x1p-53;
    has_hi = c->m.kind->sample(&c->m, f, wi, ends, lobe, false, &hi);
    if (has_lo && has_hi && lo.transmit == hi.transmit) return 1.0;
    double a = 0.0, b = 1.0;
    for (int i = 0; i < 50; i++) {
        ends[2] = 0.5 * (a + b);
        bool has = c->m.kind->sample(&c->m, f, wi, ends, lobe, false, &mid);
        bool like_lo = has == has_lo && (!has || mid.transmit == lo.transmit);
        *(like_lo ? &a : &b) = ends[2];
    }
    c->m.kind->sample(&c->m, f, wi, u, lobe, false, &mid);
    return has_lo && mid.transmit == lo.transmit ? a : 1.0 - a;
}

/* The density against the map itself: pdf times the area of the parallelogram that (u0, u1) spans on the
 * sphere is the probability of the outcome. Exact at any roughness, where counting in bins would see one full
 * bin. */
static void map_density(const Case *c, Rng *rng) {
    const double h = 1e-6;
    for (int i = 0; i < 150; i++) {
        ShadingFrame f = make_frame(rng, rng_next(rng) < 0.5, 0.0);
        V3 wi = direction_at(&f, 0.05 + 0.95 * rng_next(rng), rng);
        double u[3];
        random_u(rng, u);
        u[0] = 0.05 + 0.9 * u[0];
        u[1] = 0.05 + 0.9 * u[1];
        if (fabs(fabs(2 * u[0] - 1) - fabs(2 * u[1] - 1)) < 1e-4) continue; /* the disk map's creases */
        ScatterSample s, n[4];
        if (!c->m.kind->sample(&c->m, &f, wi, u, LOBE_ALL, false, &s) || s.pdf == 0.0) continue;
        unsigned lobe = s.lobe;
        bool ok = c->m.kind->sample(&c->m, &f, wi, u, lobe, false, &s);
        for (int k = 0; k < 4 && ok; k++) {
            double v[3] = {u[0] + (k == 0      ? h
                                      : k == 1 ? -h
                                               : 0),
                u[1] + (k == 2      ? h
                           : k == 3 ? -h
                                    : 0),
                u[2]};
            ok = c->m.kind->sample(&c->m, &f, wi, v, lobe, false, &n[k]) && n[k].transmit == s.transmit;
        }
        if (!ok) continue;
        V3 du = v3_sub(n[0].wo, n[1].wo), dv = v3_sub(n[2].wo, n[3].wo);
        double area = v3_length(v3_cross(du, dv)) / (4 * h * h);
        expect_near(c, "density times area", s.pdf * area, outcome_share(c, &f, wi, u, lobe), 2e-4);
    }
}

static void density_is_that_of_the_map(void **state) {
    (void)state;
    for_each_case(map_density);
}

/* Light carried from the lamp and light traced from the eye agree: a photon's weight times density is
 * eval(b, a) |b.n| / |a.n| (n_b / n_a)^2; symmetric kinds and plastic alike. */
static void adjoint(const Case *c, Rng *rng) {
    if (!c->m.kind->eval) return;
    for (int i = 0; i < 400; i++) {
        ShadingFrame f = make_frame(rng, rng_next(rng) < 0.5, 0.0);
        V3 a = direction_at(&f, 0.05 + 0.95 * rng_next(rng), rng);
        double u[3], pdf;
        random_u(rng, u);
        ScatterSample s;
        unsigned lobe = (i & 1) ? LOBE_DIFFUSE : LOBE_GLOSSY;
        if (!c->m.kind->sample(&c->m, &f, a, u, lobe, true, &s) || fabs(v3_dot(s.wo, f.ns)) < 2e-4) continue;
        ShadingFrame back = frame_from(&f, s.transmit);
        Rgb value = c->m.kind->eval(&c->m, &back, s.wo, a, lobe, &pdf);
        double factor = fabs(v3_dot(s.wo, f.ns)) / v3_dot(a, f.ns) * s.eta * s.eta;
        expect_near(c, "photon against eye path", s.weight.g * s.pdf, value.g * factor, 1e-4 * s.pdf);
    }
}

static void photons_match_eye_paths(void **state) {
    (void)state;
    for_each_case(adjoint);
}

enum { BINS_Z = 20, BINS_PHI = 16, BINS = BINS_Z * BINS_PHI, FINE = 16, DRAWS = 40000 };

static V3 bin_direction(const ShadingFrame *f, double z, double phi) {
    V3 s, t;
    v3_frame(f->ns, &s, &t);
    double r = sqrt(fmax(0.0, 1.0 - z * z));
    return v3_normalize(v3_from_frame(v3(r * cos(phi), r * sin(phi), z), s, t, f->ns));
}

static void expected_bins(const Case *c, const ShadingFrame *f, V3 wi, double *density, double *value) {
    for (int b = 0; b < BINS; b++) {
        density[b] = value[b] = 0.0;
        for (int i = 0; i < FINE * FINE; i++) {
            double z = -1.0 + 2.0 * (b / BINS_PHI + (i / FINE + 0.5) / FINE) / BINS_Z;
            double phi = 2.0 * CAU_PI * (b % BINS_PHI + (i % FINE + 0.5) / FINE) / BINS_PHI, pdf;
            Rgb v = c->m.kind->eval(&c->m, f, wi, bin_direction(f, z, phi), LOBE_ALL, &pdf);
            density[b] += pdf;
            value[b] += v.g;
        }
        density[b] *= 4.0 * CAU_PI / BINS / (FINE * FINE);
        value[b] *= 4.0 * CAU_PI / BINS / (FINE * FINE);
    }
}

static int bin_of(const ShadingFrame *f, V3 wo) {
    V3 s, t;
    v3_frame(f->ns, &s, &t);
    V3 l = v3_to_frame(wo, s, t, f->ns);
    double phi = atan2(l.y, l.x);
    if (phi < 0.0) phi += 2.0 * CAU_PI;
    int z = (int)clamp(0.5 * (l.z + 1.0) * BINS_Z, 0, BINS_Z - 1);
    return z * BINS_PHI + (int)clamp(phi / (2.0 * CAU_PI) * BINS_PHI, 0, BINS_PHI - 1);
}

/* Pearson's chi-square of the directions drawn, and the mean weight of each band of the sphere. */
static void chi_square_at(const Case *c, const ShadingFrame *f, V3 wi, Rng *rng) {
    double density[BINS], value[BINS], seen[BINS] = {0}, weight[BINS] = {0}, chi = 0.0, freedom = 0.0;
    double rest_seen = 0.0, rest = 0.0;
    expected_bins(c, f, wi, density, value);
    for (int i = 0; i < DRAWS; i++) {
        double u[3];
        random_u(rng, u);
        ScatterSample s;
        if (!c->m.kind->sample(&c->m, f, wi, u, LOBE_ALL, false, &s) || s.pdf == 0.0) continue;
        seen[bin_of(f, s.wo)] += 1.0;
        weight[bin_of(f, s.wo)] += s.weight.g / DRAWS;
    }
    for (int b = 0; b < BINS; b++) {
        double e = density[b] * DRAWS;
        expect_near(
            c, "weight of a bin", weight[b], value[b], 6.0 * 20.0 * sqrt(density[b] / DRAWS) * 0.5 + 1e-3);
        if (e < 20.0) {
            rest += e;
            rest_seen += seen[b];
            continue;
        }
        chi += square(seen[b] - e) / e;
        freedom += 1.0;
    }
    if (rest > 20.0) chi += square(rest_seen - rest) / rest;
    expect_true(c, "chi-square", chi < freedom + 1.0 + 5.0 * sqrt(2.0 * (freedom + 1.0)) + 5.0);
}

/* Lobes that the quadrature resolves: rough ones, and no glass of nearly no index, whose refraction stays
 * narrow. */
static bool is_broad(const Case *c) {
    const Param *ior = param_find(&c->m.kind->table, "ior");
    if (ior && fabs(*(const double *)(const void *)((const char *)c->m.data + ior->offset) - 1.0) < 0.25)
        return false;
    return c->roughness < 0.0 || c->roughness >= 0.5;
}

static void chi_square(const Case *c, Rng *rng) {
    if (!c->m.kind->eval || !is_broad(c)) return;
    for (int i = 0; i < 2; i++) {
        ShadingFrame f = make_frame(rng, i == 0, 0.0);
        chi_square_at(c, &f, direction_at(&f, 0.3 + 0.7 * rng_next(rng), rng), rng);
    }
}

static void directions_follow_the_density(void **state) {
    (void)state;
    for_each_case(chi_square);
}

/* Caustic energy does not jump where GGX gives way to the smooth surface. */
static void smooth_switch(void **state) {
    (void)state;
    Rng rng = rng_make(10);
    size_t kinds;
    for (size_t k = 0; k < (material_kinds(&kinds), kinds); k++) {
        const MaterialKind *kind = material_kinds(&kinds)[k];
        if (!param_find(&kind->table, "roughness")) continue;
        Material smooth = make_material(kind->name, "roughness", 0.0099999, NULL);
        Material rough = make_material(kind->name, "roughness", 0.0100001, NULL);
        assert_true(!(smooth.lobes & LOBE_GLOSSY) && (rough.lobes & LOBE_GLOSSY));
        for (size_t i = 0; i < COSINES; i++)
            for (int front = 0; front < 2; front++) {
                ShadingFrame f = make_frame(&rng, front, 0.0);
                V3 wi = direction_at(&f, cosines[i], &rng);
                Shares a = sample_shares(&smooth, &f, wi, LOBE_CASTING, 32, 100);
                Shares b = sample_shares(&rough, &f, wi, LOBE_CASTING, 32, 100);
                expect_near(NULL, kind->name, b.reflected.g, a.reflected.g, 0.005);
                expect_near(NULL, kind->name, b.transmitted.g, a.transmitted.g, 0.005);
            }
    }
}

static void albedo_is_what_the_base_sends(const Case *c, Rng *rng) {
    if (!c->m.kind->albedo) return;
    for (size_t i = 0; i < COSINES; i++) {
        ShadingFrame f = make_frame(rng, true, 0.0);
        V3 eye = direction_at(&f, cosines[i], rng);
        bool burley = case_is_burley(c); /* only Lambert's weight is the same all over */
        Shares s = sample_shares(&c->m, &f, eye, LOBE_DIFFUSE, burley ? 80 : 8, 1);
        Rgb a = c->m.kind->albedo(&c->m, &f, eye);
        double tolerance = burley ? 0.004 : 1e-12;
        expect_near(c, "albedo", a.r, s.diffuse.r, tolerance);
        expect_near(c, "albedo", a.b, s.diffuse.b, tolerance);
    }
}

static void receivers_show_their_albedo(void **state) {
    (void)state;
    for_each_case(albedo_is_what_the_base_sends);
}

static void kinds_are_complete(void **state) {
    (void)state;
    size_t n;
    const MaterialKind *const *kinds = material_kinds(&n);
    assert_true(n >= 5);
    for (size_t k = 0; k < n; k++) {
        assert_ptr_equal(material_find(kinds[k]->name), kinds[k]);
        assert_true(kinds[k]->data_size <= MATERIAL_DATA_MAX && kinds[k]->help && kinds[k]->prepare &&
                    kinds[k]->sample);
        for (size_t i = 0; i < kinds[k]->table.count; i++) {
            const Param *p = &kinds[k]->table.params[i];
            assert_true(p->help && p->help[0] && p->unit);
            if (param_is_stored(p)) assert_true(p->offset + param_components(p) * 8 <= kinds[k]->data_size);
        }
    }
    assert_null(material_find("emission"));
}

int run_generic_tests(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kinds_are_complete),
        cmocka_unit_test(nothing_is_ever_nan),
        cmocka_unit_test(no_surface_makes_light),
        cmocka_unit_test(white_furnace),
        cmocka_unit_test(sample_and_eval_agree),
        cmocka_unit_test(density_is_that_of_the_map),
        cmocka_unit_test(photons_match_eye_paths),
        cmocka_unit_test(directions_follow_the_density),
        cmocka_unit_test(smooth_switch),
        cmocka_unit_test(receivers_show_their_albedo),
    };
    return cmocka_run_group_tests_name("every material", tests, NULL, NULL);
}
