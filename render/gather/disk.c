/* SPDX-License-Identifier: Apache-2.0 */
#include "render/gather/disk.h"

#include "core/vec.h"

/* Wedge of angle phi bounded by the circle: integral of (1 - rho^2/r^2) rho drho dphi = phi r^2 / 4. */
static double wedge_circle(double angle, double r) { return angle * r * r / 4; }

/* Directions by their tangents p <= q from the foot of the line's perpendicular, along the line. */
static double angle_between(double p, double q) { return atan2(q - p, 1 + p * q); }

/* Wedge bounded by a line at distance h: integral of h^2 / (2 cos^2) - h^4 / (4 r^2 cos^4). */
static double wedge_line(double h, double p, double q, double r) {
    double second = q - p, fourth = second + (q * q * q - p * p * p) / 3;
    return h * h / 2 * second - square(h * h) / (4 * r * r) * fourth;
}

/* Angles are taken only of what lies outside the circle: most edges of small triangles need none. */
static double edge_integral(const double a[2], const double b[2], double r) {
    double dx = b[0] - a[0], dy = b[1] - a[1], cross = a[0] * b[1] - a[1] * b[0];
    double length = sqrt(dx * dx + dy * dy);
    if (length == 0 || cross == 0) return 0;
    double h = fabs(cross) / length;
    double ta = (a[0] * dx + a[1] * dy) / fabs(cross), tb = (b[0] * dx + b[1] * dy) / fabs(cross);
    double integral = 0;
    if (h >= r) {
        integral = wedge_circle(angle_between(ta, tb), r);
    } else {
        double in = sqrt(r * r - h * h) / h; /* the line is inside the circle between -in and in */
        double p = clamp(ta, -in, in), q = clamp(tb, -in, in);
        if (ta < p) integral += wedge_circle(angle_between(ta, fmin(p, tb)), r);
        if (tb > q) integral += wedge_circle(angle_between(fmax(q, ta), tb), r);
        if (p < q) integral += wedge_line(h, p, q, r);
    }
    return cross > 0 ? integral : -integral;
}

/* On which side of the line the whole disk lies: left 1, right -1; 0 where the line cuts it. */
static int side_of(const double a[2], const double b[2], double r) {
    double cross = a[0] * b[1] - a[1] * b[0], length2 = square(b[0] - a[0]) + square(b[1] - a[1]);
    if (square(cross) < square(r) * length2) return 0;
    return (cross > 0) - (cross < 0);
}

double disk_triangle_integral(const double a[2], const double b[2], const double c[2], double radius) {
    /* Most disks lie within one triangle or beside it, which takes no angles. */
    double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    int inward = (area > 0) - (area < 0),
        side[3] = {side_of(a, b, radius), side_of(b, c, radius), side_of(c, a, radius)};
    if (side[0] == -inward || side[1] == -inward || side[2] == -inward) return 0;
    if (side[0] == inward && side[1] == inward && side[2] == inward)
        return inward * wedge_circle(2 * CAU_PI, radius);
    return edge_integral(a, b, radius) + edge_integral(b, c, radius) + edge_integral(c, a, radius);
}
