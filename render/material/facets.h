/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What rough facets give back of the light that met more than one of them, which GGX alone loses: its lobes
 * times 1 / E(eye), as Blender's Multiscatter GGX has it from 4.0 on (Turquin 2019, "Practical multiple
 * scattering compensation for microfacet models"). A tint counts once more with every meeting (Kulla and
 * Conty 2017). */
#ifndef RENDER_MATERIAL_FACETS_H
#define RENDER_MATERIAL_FACETS_H

#include "core/vec.h"

enum { FACETS_NODES = 36 };

/** One side of an interface; doubles only, as it lives in Material.derived. */
typedef struct Facets {
    double mean;                 /**< of E over the hemisphere, by cosine */
    double albedo[FACETS_NODES]; /**< E: what GGX reflects and refracts in all, at the cosines of
                                    cosine_table_node() */
} Facets;

/** `eta`: n(other side) / n(this side). */
void facets_prepare(Facets *facets, double alpha, double eta);

/** E at a cosine in [0, 1]. */
double facets_albedo(const Facets *facets, double cos_eye);

/** Times this are lobes tinted by `color`, seen from a cosine in [0, 1]. */
Rgb facets_gain(const Facets *facets, Rgb color, double cos_eye);

#endif
