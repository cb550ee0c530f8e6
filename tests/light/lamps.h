/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Lights to test with. */
#ifndef TESTS_LIGHT_LAMPS_H
#define TESTS_LIGHT_LAMPS_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "core/rng.h"
#include "render/light/light.h"

/** A light of a kind with `key, value` pairs up to NULL (values are doubles; "size" sets both sides, "shape"
 * the index of the word; what is required and not given is 1), placed by a matrix in a scene of
 * `units_per_m`. */
typedef struct Lamp {
    Light light;
    LightSource source;
    Affine to_scene;
    double units_per_m;
    char label[64];
} Lamp;

/** At the origin, shining along -Z, one unit per metre. */
Lamp make_lamp(const char *kind, ...);
/** Prepares again at another place: to_scene in metres, then scaled by units_per_m. */
void place_lamp(Lamp *lamp, const Affine *to_world, double units_per_m);
cau_result try_lamp(Lamp *lamp, CauError *err);

/** Visits lamps of every kind, delta and not, in several poses and units. */
void for_each_lamp(void (*visit)(const Lamp *l, Rng *rng));
Affine random_pose(Rng *rng, double scale);
V3 unit_vector(Rng *rng);

/** A point of scene space that finite lights shine at, at about `distance` metres. */
V3 lit_point(const Lamp *l, double distance, Rng *rng);

void expect_near(const Lamp *l, const char *what, double got, double want, double tolerance);
void expect_true(const Lamp *l, const char *what, bool ok);

/** Irradiance (green) at p on a surface of normal n, from sample(); stratified, `per_axis` squared points. */
double irradiance(const Light *l, V3 p, V3 n, int per_axis);

/** Emitted flux (green) by emit_start() and emit_direction(). */
double emitted_flux(const Light *l, int per_axis, Rng *rng);

int run_unit_tests(void);
int run_generic_tests(void);

#endif
