/* SPDX-License-Identifier: Apache-2.0 */
#include "render/material/cosine_table.h"

#include "core/vec.h"

double cosine_table_node(int i, int nodes) {
    double x = i / (nodes - 1.0);
    return x * x * x;
}

double cosine_table_at(const double *values, int nodes, double cos_i) {
    double x = cbrt(clamp(cos_i, 0.0, 1.0)) * (nodes - 1);
    int i = (int)x < nodes - 2 ? (int)x : nodes - 2;
    double t = x - i, b = values[i], d = values[i + 1];
    double a = i > 0 ? values[i - 1] : 2.0 * b - d;
    double e = i + 2 < nodes ? values[i + 2] : 2.0 * d - b;
    double y =
        b + 0.5 * t * ((d - a) + t * ((2.0 * a - 5.0 * b + 4.0 * d - e) + t * (3.0 * (b - d) + e - a)));
    return clamp(y, 0.0, 1.0);
}
