/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The sheets of surface near a point, in coordinates of its tangent plane (z: height), and places on them.
 *
 *  Sheets lie in the point's plane, over it or under it: tiles over their grout, paper on a table. Where each
 *  lies apart from the plane, what falls on the others is not light of the point's own sheet. */
#ifndef RENDER_GATHER_SHEETS_H
#define RENDER_GATHER_SHEETS_H

#include "render/trace/eye.h"

/** Meshes so fine that a disk holds more triangles are looked at by rays alone. */
enum { NEAR_MAX = 192 };

/** Largest height over the tangent plane, in radii, at which a deposit still counts as on the same surface.
 */
#define SUPPORT_HEIGHT 0.25
/** Smallest cosine between its normal and the point's. */
#define SUPPORT_COSINE 0.5

/** Tangent plane: n is the point's normal; s and t are turned at random. */
typedef struct Plane {
    V3 origin, s, t, n;
} Plane;

/** A triangle. */
typedef struct Patch {
    V3 corner[3];
    double cosine;   /**< between its normal and the plane's */
    double integral; /**< of the kernel, as seen along the plane's normal */
    int object;
} Patch;

/** What lies near a point. */
typedef struct Near {
    Patch sheet[NEAR_MAX];
    size_t sheets;       /**< so many; once set apart: the point's own, those above, those below */
    size_t above, below; /**< so many once set apart, else 0 */
    double flat;   /**< heights up to this are none: a share of the radius, or the rounding of deposits */
    double top;    /**< of the sheets that lie higher than the point as a whole; 0: none */
    bool blockers; /**< something that is no sheet rises out of the disk, or stands on it */
    bool full;     /**< an exact surface of the point's own object */
    bool dense;    /**< more triangles than `sheet` holds: none is listed */
} Near;

/** Some of the sheets: of one object, or of all. */
enum { ALL_OBJECTS = -1 };
typedef struct Sheets {
    const Patch *patch;
    size_t count;
    int object;
} Sheets;

/** The point's tangent plane. */
Plane plane_at(const EyePoint *point);

/** Lists what lies within `radius` of the point. */
void near_find(const TraceScene *trace, const EyePoint *point, const Plane *plane, double radius, Near *out);

/** Where every sheet lies in the point's plane or at a distance from it: puts them in order and returns the
 *  largest height at which deposits are the plane's own. Leaves all as they are and returns 0 where sheets
 *  cross the plane, or none lies elsewhere. */
double near_set_apart(Near *near);

/** Shifts what lies above to where it hides the plane for one who looks along `from` (plane coordinates), and
 *  returns the radius, at least half of the old one, in which all that does is listed; of that radius the
 *  integrals are then. Slants `from` less where it would take more, and scales it to a height of 1. */
double near_look_along(Near *near, double radius, V3 *from);

static inline Sheets sheets_own(const Near *near) {
    return (Sheets){near->sheet, near->sheets - near->above - near->below, ALL_OBJECTS};
}

static inline Sheets sheets_above(const Near *near) {
    return (Sheets){near->sheet + sheets_own(near).count, near->above, ALL_OBJECTS};
}

static inline Sheets sheets_below(const Near *near) {
    return (Sheets){near->sheet + near->sheets - near->below, near->below, ALL_OBJECTS};
}

static inline Sheets sheets_all(const Near *near) { return (Sheets){near->sheet, near->sheets, ALL_OBJECTS}; }

/** Of the kernel over one, of any radius. */
double patch_integral(const Patch *patch, double radius);

/** The same over all of them, of the radius they were found for. */
double sheets_sum(const Sheets *sheets);

/** Places of the plane, in radii, and their squared distances. */
enum { PLACES_MAX = 96 };
typedef struct Places {
    int count;
    float x[PLACES_MAX], y[PLACES_MAX], q[PLACES_MAX];
} Places;

/** Spreads places, PLACES_MAX at most, like the kernel. */
void places_spread(int count, Places *out);

/** On how many of them each place is. */
void sheets_count(const Sheets *sheets, const Places *places, double radius, int32_t *found);

/** True when places spread over the disk lie on two of them. */
bool sheets_overlap(const Sheets *sheets, double radius);

#endif
