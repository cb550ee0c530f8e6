/* SPDX-License-Identifier: Apache-2.0 */
#include "render/trace/path.h"

bool normal_bends(V3 ng, V3 ns, V3 wi) {
    double z = v3_dot(wi, ng);
    return 2 * v3_dot(ns, wi) * v3_dot(ns, ng) - z < fmin(MIRROR_SHARE * z, MIRROR_HEIGHT);
}

/* With b the elevation in that plane, the mirror direction's height is r sin(b - 2 tilt) and that of wi r sin
 * b. */
double bend_elevation(double tilt, double r) {
    double below_share = atan2(sin(2 * tilt), cos(2 * tilt) - MIRROR_SHARE);
    double below_height = r > MIRROR_HEIGHT ? fmin(2 * tilt + asin(MIRROR_HEIGHT / r), CAU_PI) : CAU_PI;
    return fmin(below_share, below_height);
}

/* In the plane of ns and ng let t be the angle of the normal from ng, and (x, z) what wi has in that plane.
 * The mirror direction's height is x sin 2t + z cos 2t = A cos(2t - phi): the largest t that keeps it is
 * closed form. */
static V3 shading_bend(V3 ng, V3 ns, V3 wi) {
    if (!normal_bends(ng, ns, wi)) return ns;
    double z = v3_dot(wi, ng), limit = fmin(MIRROR_SHARE * z, MIRROR_HEIGHT);
    double cosine = clamp(v3_dot(ns, ng), -1, 1);
    V3 side = v3_mad(ns, -cosine, ng);
    double length = v3_length(side);
    if (!(length > 1e-9)) return ng;
    side = v3_scale(side, 1 / length);
    double x = v3_dot(wi, side), amplitude = hypot(x, z);
    if (!(amplitude > 0)) return ng;
    double t = 0.5 * (atan2(x, z) + acos(clamp(limit / amplitude, -1, 1)));
    t = clamp(t, 0, acos(cosine));
    return v3_add(v3_scale(side, sin(t)), v3_scale(ng, cos(t)));
}

ShadingFrame frame_from_light(const Hit *hit, V3 wi) {
    if (v3_dot(hit->ng, wi) >= 0) return (ShadingFrame){hit->ng, hit->ns, true};
    return (ShadingFrame){v3_neg(hit->ng), v3_neg(hit->ns), false};
}

ShadingFrame frame_from_hit(const Hit *hit, V3 wi) {
    ShadingFrame f = frame_from_light(hit, wi);
    bool flat = hit->ns.x == hit->ng.x && hit->ns.y == hit->ng.y && hit->ns.z == hit->ng.z;
    if (!flat) f.ns = shading_bend(f.ng, f.ns, wi);
    return f;
}
