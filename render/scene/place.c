/* SPDX-License-Identifier: Apache-2.0 */
/* Matrices from what a scene says of a place. */
#include "render/scene/scene_internal.h"

Affine affine_from_matrix(const double m[16]) {
    Affine a;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++) a.m[r][c] = m[4 * r + c];
    return a;
}

/* Below this sine the view counts as vertical, and Y becomes its up. */
#define VERTICAL 1e-9

bool matrix_look(const double from[3], const double to[3], double out[16]) {
    V3 eye = v3(from[0], from[1], from[2]), way = v3_sub(v3(to[0], to[1], to[2]), eye);
    double largest = fmax(fabs(way.x), fmax(fabs(way.y), fabs(way.z)));
    if (!(largest > 0)) return false;
    V3 forward = v3_normalize(v3_scale(way, 1 / largest)); /* scaled first: squares of 1e-200 are 0 */
    V3 right = v3_cross(forward, v3(0, 0, 1));
    if (v3_length(right) < VERTICAL) right = v3_cross(forward, v3(0, 1, 0));
    right = v3_normalize(right);
    V3 up = v3_cross(right, forward);
    const double rows[16] = {right.x, up.x, -forward.x, eye.x, right.y, up.y, -forward.y, eye.y, right.z,
        up.z, -forward.z, eye.z, 0, 0, 0, 1};
    for (int i = 0; i < 16; i++) out[i] = rows[i];
    return true;
}

/* Right angles come out exact: a box turned by 90 degrees stays a box. */
static void sine_cosine(double degrees, double *sine, double *cosine) {
    static const double quarter[4][2] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
    double turns = degrees / 90;
    if (turns == rint(turns)) {
        int q = (int)fmod(turns, 4);
        *sine = quarter[(q + 4) % 4][0];
        *cosine = quarter[(q + 4) % 4][1];
        return;
    }
    *sine = sin(degrees * (CAU_PI / 180));
    *cosine = cos(degrees * (CAU_PI / 180));
}

static Affine rotation(int axis, double degrees) {
    double s, c;
    sine_cosine(degrees, &s, &c);
    int a = (axis + 1) % 3, b = (axis + 2) % 3;
    Affine r = affine_identity();
    r.m[a][a] = r.m[b][b] = c;
    r.m[a][b] = -s;
    r.m[b][a] = s;
    return r;
}

Affine affine_from_parts(const double position[3], const double rotation_deg[3], const double scale[3]) {
    Affine a = affine_identity();
    for (int i = 0; i < 3; i++) a.m[i][i] = scale[i];
    for (int axis = 0; axis < 3; axis++) {
        Affine r = rotation(axis, rotation_deg[axis]);
        a = affine_compose(&r, &a);
    }
    for (int i = 0; i < 3; i++) a.m[i][3] = position[i];
    return a;
}
