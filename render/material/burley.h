/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Burley's diffuse lobe (Burley 2012, "Physically based shading at Disney", 5.3): darker than Lambert's at
 * grazing angles where the surface is smooth, brighter where it is rough. Reciprocal. Roughness in [0, 1]. */
#ifndef RENDER_MATERIAL_BURLEY_H
#define RENDER_MATERIAL_BURLEY_H

#include "core/vec.h"

/** The lobe relative to Lambert's for unit directions a and b in a frame whose z is the normal, both above
 * it. */
double burley_lobe(double roughness, V3 a, V3 b);

/** Its albedo for white: the mean of burley_lobe() over the other direction, by cosine. cos_a in [0, 1]. */
double burley_albedo(double roughness, double cos_a);

/** The mean of burley_albedo() by cosine: what a white surface reflects of light from everywhere. */
double burley_mean_albedo(double roughness);

#endif
