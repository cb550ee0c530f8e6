/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  A function of a cosine in [0, 1] as a table. Its nodes crowd towards grazing angles, where the albedos of
 * GGX bend within a cosine of alpha. */
#ifndef RENDER_MATERIAL_COSINE_TABLE_H
#define RENDER_MATERIAL_COSINE_TABLE_H

/** Where the value of node `i` of `nodes` belongs: (i / (nodes - 1))^3. */
double cosine_table_node(int i, int nodes);

/** Catmull-Rom in the cube root of the cosine; the ends are continued in a line. Within [0, 1]. */
double cosine_table_at(const double *values, int nodes, double cos_i);

#endif
