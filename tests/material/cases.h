/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Instances of every kind of material, made from the parameter tables, and what the tests share. */
#ifndef TESTS_MATERIAL_CASES_H
#define TESTS_MATERIAL_CASES_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "core/rng.h"
#include "render/material/material.h"

typedef struct Case {
    Material m;
    double roughness; /**< -1: the kind has none */
    char label[80];
} Case;

/** A material with its defaults (colours white), then `key = value` pairs up to NULL. */
Material make_material(const char *kind, ...);

/** For every kind and a ladder of roughnesses: one with defaults and white, some random within the tables'
 *  limits. Calls `visit` with each; the label is printed on failure. */
void for_each_case(void (*visit)(const Case *c, Rng *rng));

/** A base that gets all the light although a coat above it reflects some, as Cycles' does: it makes light. */
bool case_is_burley(const Case *c);

/** Facets that give light back, by the eye's side alone. */
bool case_gives_back(const Case *c);

/** Fails with the label, the name of the quantity and the numbers. */
void expect_near(const Case *c, const char *what, double got, double want, double tolerance);
void expect_true(const Case *c, const char *what, bool ok);

/** A frame and a direction on its side at `cos_i` to the shading normal. tilt: angle from ng to ns. */
ShadingFrame make_frame(Rng *rng, bool front, double tilt);
V3 direction_at(const ShadingFrame *f, double cos_i, Rng *rng);
V3 random_direction(Rng *rng);

/** The frame of the same point as seen from wo. */
ShadingFrame frame_from(const ShadingFrame *f, bool transmit);

/** Mean weights over stratified points, by outcome. */
typedef struct Shares {
    Rgb reflected, transmitted, diffuse, total;
} Shares;
Shares sample_shares(
    const Material *m, const ShadingFrame *f, V3 wi, unsigned lobes, int per_axis, int choices);

void random_u(Rng *rng, double u[3]);

int run_generic_tests(void);
int run_glass_tests(void);
int run_coat_tests(void);
int run_burley_tests(void);
int run_normal_tests(void);

#endif
