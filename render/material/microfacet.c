/* SPDX-License-Identifier: Apache-2.0 */
#include "render/material/microfacet.h"

#include "core/sampling.h"

/* Heitz 2018, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4), listing 1: stretch to the
 * hemisphere, draw a point of its projection along wi, unstretch. */
V3 ggx_sample(V3 wi, double alpha, double u, double v) {
    V3 w = v3_normalize(v3(alpha * wi.x, alpha * wi.y, wi.z));
    double len2 = w.x * w.x + w.y * w.y;
    V3 t1 = len2 > 0.0 ? v3_scale(v3(-w.y, w.x, 0.0), 1.0 / sqrt(len2)) : v3(1.0, 0.0, 0.0);
    V3 t2 = v3_cross(w, t1);
    double r = sqrt(u), s = 0.5 * (1.0 + w.z), x, y;
    sincos_turn(v, &y, &x);
    x *= r;
    y = (1.0 - s) * sqrt(positive(1.0 - x * x)) + s * r * y;
    V3 n = v3_from_frame(v3(x, y, sqrt(positive(1.0 - x * x - y * y))), t1, t2, w);
    return v3_normalize(v3(alpha * n.x, alpha * n.y, positive(n.z)));
}
