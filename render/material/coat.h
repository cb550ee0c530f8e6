/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  A GGX coat and its directional albedo: the share of light from a direction that the coat reflects, which
 *  what lies below it does not get. Its Fresnel term is Schlick's (F90 = 1), or that of the dielectric which
 *  reflects f0 seen straight on. */
#ifndef RENDER_MATERIAL_COAT_H
#define RENDER_MATERIAL_COAT_H

#include "core/vec.h"

enum { COAT_NODES = 64 };

/** Doubles only: it lives in Material.derived. */
typedef struct Coat {
    double alpha; /**< 0: smooth, no table */
    double f0;
    double eta;                /**< of the dielectric; 0: Schlick */
    double albedo[COAT_NODES]; /**< at the cosines of cosine_table_node() */
} Coat;

void coat_prepare(Coat *coat, double f0, bool dielectric, double alpha);

/** Reflectance at a cosine in [0, 1] to the (micro)surface's normal. */
double coat_fresnel(const Coat *coat, double cos_i);

/** The directional albedo at a cosine in [0, 1]. */
double coat_albedo(const Coat *coat, double cos_i);

#endif
