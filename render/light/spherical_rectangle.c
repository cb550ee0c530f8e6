/* SPDX-License-Identifier: Apache-2.0 */
#include "render/light/spherical_rectangle.h"

static double angle_between(V3 a, V3 b) { return acos(clamp(-v3_dot(a, b), -1.0, 1.0)); }

void spherical_rectangle_make(V3 p, V3 c, V3 u, V3 v, SphericalRectangle *out) {
    SphericalRectangle r;
    double lu = v3_length(u), lv = v3_length(v);
    r.x = v3_scale(u, 1.0 / lu);
    r.y = v3_scale(v, 1.0 / lv);
    r.z = v3_cross(r.x, r.y);
    V3 d = v3_to_frame(v3_sub(c, p), r.x, r.y, r.z);
    if (d.z > 0.0) {
        r.z = v3_neg(r.z);
        d.z = -d.z;
    }
    r.x0 = d.x - lu;
    r.x1 = d.x + lu;
    r.y0 = d.y - lv;
    r.y1 = d.y + lv;
    r.z0 = d.z;
    /* Normals of the planes through p and each side, section 3.1; the angles between them give the area. */
    V3 n0 = v3_normalize(v3(0.0, r.z0, -r.y0)), n1 = v3_normalize(v3(-r.z0, 0.0, r.x1));
    V3 n2 = v3_normalize(v3(0.0, -r.z0, r.y1)), n3 = v3_normalize(v3(r.z0, 0.0, -r.x0));
    r.b0 = n0.z;
    r.b1 = n2.z;
    r.k = 2.0 * CAU_PI - angle_between(n2, n3) - angle_between(n3, n0);
    r.solid_angle = angle_between(n0, n1) + angle_between(n1, n2) - r.k;
    *out = r;
}

V3 spherical_rectangle_sample(const SphericalRectangle *r, double u, double v) {
    double au = u * r->solid_angle + r->k;
    double fu = (cos(au) * r->b0 - r->b1) / sin(au);
    double cu = copysign(1.0, fu) / sqrt(fu * fu + r->b0 * r->b0);
    cu = isnan(cu) ? 0.0 : clamp(cu, -1.0, 1.0);
    double xu = clamp(-(cu * r->z0) / sqrt(fmax(1.0 - cu * cu, 1e-300)), r->x0, r->x1);
    double d2 = xu * xu + r->z0 * r->z0, d = sqrt(d2);
    double h0 = r->y0 / sqrt(d2 + r->y0 * r->y0), h1 = r->y1 / sqrt(d2 + r->y1 * r->y1);
    double h = h0 + v * (h1 - h0), rest = 1.0 - h * h;
    double yv = rest > 1e-12 ? clamp(h * d / sqrt(rest), r->y0, r->y1) : (h > 0.0 ? r->y1 : r->y0);
    return v3_from_frame(v3(xu, yv, r->z0), r->x, r->y, r->z);
}
