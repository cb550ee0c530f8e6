/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What the files of estimator W share: fronts, corners, landings, landed triangles, the view. */
#ifndef RENDER_GATHER_WAVE_WAVE_INTERNAL_H
#define RENDER_GATHER_WAVE_WAVE_INTERNAL_H

#include "render/gather/wave/wave.h"

/* ---- fronts: a rectangle of light rays towards one caster (wave_front.c) ---- */

/** (u, v) in the rectangle is a ray; `weight` of it times an area of (u, v) is flux. */
typedef struct WaveFront {
    const Light *light;
    EmitStart start;
    V3 axis, s, t; /* the plane's normal (direction of travel in the middle) and directions of u, v */
    V3 center;     /* infinite lights: origin of u, v */
    double back;   /* infinite lights: how far rays start before the plane of `center` */
    double lo[2], hi[2];
    double share; /* 1 / (density of the start * places) */
    int object;   /* the caster */
    bool tiled;   /* other fronts adjoin: rays must stay within lo and hi */
    int n[2];     /* cells */
} WaveFront;

/** Fronts of one caster from one place on the light: at most 6 (a lamp within the caster). Their n is not
 *  set. Returns how many. */
enum { WAVE_FRONTS_MAX = 6 };
int wave_fronts(const WaveRun *run, const EmitStart *start, int object, WaveFront *out);

/** The ray at (u, v) and the flux per area of (u, v) that flows along it. */
Ray wave_front_ray(const WaveFront *front, double u, double v, Rgb *weight);

/* ---- receivers ---- */

/** What tells receivers apart: four times the object, and 1 more on one that takes all light alike. Those are
 * one sheet wherever they lie in one: tiles and the grout between them. Of a subpixel WAVE_CONTACT more where
 *  something stands on the receiver: light on its far side does not show there. */
enum { WAVE_CONTACT = 2 };
static inline int wave_receiver(const Scene *scene, int object) {
    return 4 * object + !scene->materials[scene->objects[object].material].kind->received;
}
static inline int wave_object(int receiver) { return receiver / 4; }
static inline bool wave_same_receiver(int a, int b) { return ((a ^ b) & ~WAVE_CONTACT) == 0 || (a & b & 1); }

/* ---- corners: where a ray's light lands, along every path (wave_path.c) ---- */

/** Light of one path on a receiver. */
typedef struct WaveLanding {
    uint64_t path;        /* surfaces, sides and events of the path, and wave_receiver() */
    V3 position, normal;  /* normal: geometric, on the light's side */
    double x, y;          /* raster position in the view's subpixels, where there is a view */
    bool before;          /* the camera */
    Rgb weight;           /* irradiance-weighted flux per area of (u, v), as a Deposit's */
    int object, receiver; /* see wave_receiver() */
    uint32_t primitive;
    uint8_t glossy, transmission; /* as a Deposit's */
    bool shown;                   /* within the bounce limits at receivers that the camera sees directly */
} WaveLanding;

typedef struct WaveLandings {
    WaveLanding *items;
    size_t count, capacity;
    bool out_of_memory;
} WaveLandings;

/** A corner's landings are items [first, first + count) of its row. */
typedef struct WaveCorner {
    double u, v;
    uint32_t first, count;
    Rgb weight; /* what left the light and met the caster first; black: it did not */
} WaveCorner;

/** Follows the ray at (u, v). `area` (of (u, v)) is what the account counts for it; 0: not counted. */
WaveCorner wave_corner(const WaveRun *run, const WaveFront *front, double u, double v, double area,
    WaveLandings *landings, FluxAccount *account);

/* ---- landed triangles ---- */

/** How far off a flat triangle its receiver may be: a step that moves its light by less, in pixels; and in
 * the triangle's length, for what rounding does. */
#define WAVE_FLAT_OFF 0.1
#define WAVE_PLANE_OFF 1e-3
/** Facing test between a triangle's receiver and the surface that is to show its light. */
#define WAVE_FACING_COSINE 0.7

/** The plane around a landed triangle: where the surface lies that shows its light. */
typedef struct WavePlane {
    V3 normal, center; /* the mean of its corners' normals, on the light's side; the middle */
    double footprint;  /* edge of a pixel there, 0 where none shows it; scene units */
    double extent;     /* of the triangle */
    double reach;      /* how far off the plane the receiver may be */
    bool flat;         /* the normals are one */
} WavePlane;

void wave_plane(const Scene *scene, const WaveLanding *const landings[3], WavePlane *out);

typedef struct WaveTriangle {
    double x[3], y[3]; /* raster position in subpixels */
    float plane[4];    /* of the receiver around it: n.p + d */
    float normal[3];   /* of the receiver, the light's side */
    float reach;       /* how far off the plane the receiver may be, scene units */
    float flux[3];
    float per_area; /* 1 / scene area on a flat receiver; 0: spread by area in the picture */
    int receiver;
} WaveTriangle;

/** A photon's light, spread by a kernel over the receiver around it. */
typedef struct WaveSplat {
    EyePoint point; /* where it landed; of its fields those that support.h needs */
    Support support;
    double x, y, reach; /* raster position and bound of its extent, subpixels */
    V3 step[2];         /* along the receiver from one subpixel to the next, across and down */
    bool strays;        /* nothing of its own object shows: it lights what is seen there */
    float flux[3];
} WaveSplat;

/** A landed triangle for eye points that lie in it. */
typedef struct WaveSeenTriangle {
    V3 side[3], normal;    /* a point p is within when side . p > edge for all three */
    double edge[3], plane; /* plane: normal . p on it */
    Rgb irradiance;
    V3 center;
    double radius, reach; /* of a ball around it; how far off the plane an eye point may be; scene units */
    int receiver;
    uint8_t glossy, transmission;
} WaveSeenTriangle;

typedef struct WaveBatch {
    WaveTriangle *triangles;
    size_t count, capacity;
    WaveSeenTriangle *seen;
    size_t seen_count, seen_capacity;
    WaveSplat *splats;
    size_t splat_count, splat_capacity;
    Deposit *deposits;
    size_t deposit_count, deposit_capacity;
    FluxAccount account;
    double landed, left;        /* flux by triangles, flux left to photons */
    double looked, looked_flux; /* of a probe: how many triangles it looked into, and their flux */
    double found; /* squares of what it found that corners do not tell, over the chance of a look */
    bool out_of_memory;
} WaveBatch;

enum { WAVE_TILE = 64 }; /* cells along an edge of a tile */

/** Cells [x0, x1) x [y0, y1) of a front. */
typedef struct WaveTile {
    const WaveFront *front;
    uint64_t key; /* random stream of the front */
    int x0, y0, x1, y1;
} WaveTile;

/** Eye points that see their receiver through glass or in mirrors (wave_seen.c), in bands of the rows [y0,
 * y1). */
typedef struct WaveSeen WaveSeen;
cau_result wave_seen_create(
    WaveSeen **out, const Scene *scene, const EyePoints *points, int y0, int y1, size_t bands, CauError *err);
void wave_seen_free(WaveSeen **seen);

/** False when it is so small that a kernel must spread it. `even`: edge of a triangle there if all were
 * spread evenly over the picture, scene units. */
bool wave_seen_triangle(const WaveLanding *const landings[3], const WavePlane *plane, Rgb flux, double even,
    WaveSeenTriangle *out);

/** Adds the batches' triangles to the pixels of a band, in order. */
void wave_seen_light(const WaveSeen *seen, size_t band, const WaveBatch *batches, size_t batch_count,
    const PassImages *images);

/* ---- what lands as a triangle, and what is left to single rays (wave_cells.c, wave_rest.c) ---- */

/** A path that landed as a triangle. Its corners live as long as the triangle's parts are worked on. */
typedef struct WaveClaim {
    uint64_t path;
    const WaveCorner *corner[3];
    uint32_t landing[3]; /* theirs, in WaveCells.landings */
    Rgb weight;          /* their mean */
} WaveClaim;

enum { WAVE_CLAIMED_MAX = 192 };

/** A tile at work. */
typedef struct WaveCells {
    const WaveRun *run;
    const WaveView *view; /* NULL: nothing is drawn */
    bool seen;            /* some eye points see receivers through glass or in mirrors */
    const WaveFront *front;
    WaveBatch *out;
    double even;           /* edge of a triangle if all were spread evenly over the picture, pixels */
    double wide;           /* a triangle of a longer edge is split, subpixels */
    WaveLandings landings; /* of the two rows of corners, and of a triangle's midpoints on top */
    uint64_t key;
    WaveClaim claims[WAVE_CLAIMED_MAX];
    size_t claim_count;
    uint64_t leaves; /* triangles that were not split, so far */
    double found;    /* mean square of what rays lately found there that corners did not tell, relative */
} WaveCells;

/** The claim of a path, or NULL. */
const WaveClaim *wave_claimed(const WaveCells *c, uint64_t path);

/** Leaves the share `left` of a triangle's light to single rays. */
void wave_leave(WaveCells *c, const WaveCorner *const corner[3], double area, double left);

/** Light for receivers seen through glass or in mirrors. */
void wave_put_deposit(WaveCells *c, const WaveLanding *landing, Rgb flux);

/** A tile's triangles and deposits into `out`, which is emptied first (wave_cells.c). Without a view nothing
 * is drawn: only flux and rays are counted. */
void wave_cells(const WaveRun *run, const WaveView *view, bool seen, const WaveTile *tile, WaveBatch *out);

/* ---- the view (wave_view.c), and triangles drawn on it (wave_raster.c) ---- */

enum { WAVE_NOTHING = -2, WAVE_MIXED = -4 };

/** What a subpixel sees. */
typedef struct WaveSubpixel {
    float position[3], normal[3];
    union {
        float per_flux; /**< irradiance per flux that falls on all of it */
        uint32_t block; /**< of a mixed subpixel */
    };
    int receiver; /**< WAVE_NOTHING: none that the camera sees directly; WAVE_MIXED: see `block` */
} WaveSubpixel;

/** Subpixels in rows, and after them blocks of `parts` x `parts` smaller ones: where the grid is coarse (a
 *  filter that is a sum of whole pixels needs no finer one), a block stands for a subpixel whose surroundings
 *  are not one smooth sheet. */
struct WaveView {
    const Scene *scene;
    int scale;                 /* subpixels per pixel, along an edge */
    int parts;                 /* of a mixed subpixel, along an edge */
    int x0, y0, width, height; /* in subpixels, with a margin as wide as the filter around the region */
    int region[4];             /* pixels */
    int taps;                  /* length of `tap` */
    double *tap;               /* the filter over the subpixels around a pixel; they sum to 1 */
    size_t grid, blocks;       /* subpixels of the grid; blocks behind them */
    WaveSubpixel *subpixels;   /* [grid + blocks * parts * parts] */
    float *weight;             /* [... * 3] radiance at the pixel per irradiance */
    float *irradiance;         /* [... * 3] of the light being drawn */
    uint32_t *block;           /* [blocks] the subpixel that it stands for, ascending */
    uint32_t *row_blocks;      /* [height + 1] the first block of each row */
    bool *casts;               /* [pixels of the view] the camera meets a caster in it first */
    bool *busy;                /* [picture's pixels] see wave_view_busy() */
    double *columns;           /* [thread][width][6], scratch of wave_resolve() */
    unsigned char *lit;        /* [height] a row holds light */
};

/** The first of a mixed subpixel's parts. */
static inline size_t wave_block(const WaveView *v, const WaveSubpixel *mixed) {
    return v->grid + (size_t)mixed->block * (size_t)v->parts * (size_t)v->parts;
}

/** Raster position in subpixels; false: not in front of the camera. */
bool wave_project(const WaveView *view, V3 p, double *x, double *y);

/** The receiver around a triangle: its plane, and its area if flat. */
void wave_set_plane(const WaveLanding *const landings[3], const WavePlane *plane, WaveTriangle *out);

/** True when drawing the triangle would light what is seen at a raster position (in subpixels), which is of
 *  `object` then; beyond the view it is taken to. */
bool wave_shows(const TraceScene *trace, const WaveView *view, const WaveTriangle *triangle, double x,
    double y, int *object);

/** True when the camera sees the place, directly or through transparent surfaces. */
bool wave_view_sees(const WaveView *view, const TraceScene *trace, const WaveLanding *landing);

/** A surface seen at less than this cosine is not resolved within a subpixel. */
#define WAVE_GRAZING_COSINE 1e-2
/** Where the camera sees the plane through a point at a raster position in pixels; the point itself where it
 *  sees the plane at less than that cosine (wave_splat.c). */
V3 wave_seen_at(const Camera *camera, V3 point, V3 normal, double x, double y);

/** True when nothing stands between what the subpixel sees and its surface at a raster position
 * (wave_contact.c). */
bool wave_on_this_side(
    const TraceScene *trace, const WaveView *view, const WaveSubpixel *subpixel, double x, double y);

/** Sets WAVE_CONTACT of a subpixel, a square of that size around a raster position, when something stands on
 *  its receiver within it. */
void wave_mark_contact(WaveView *view, const TraceScene *trace, size_t at, double x, double y, double size);

/** Prepares a photon of that flux and kernel radius, in footprints, for the view: false when nothing of it
 * shows (wave_splat.c). */
bool wave_splat(const WaveRun *run, const WaveView *view, const WaveLanding *landing, Rgb flux,
    double radius_pixels, double turn, WaveSplat *out);

/** Adds a splat to the rows [y0, y1) of the view. */
void wave_splat_draw(const TraceScene *trace, WaveView *view, const WaveSplat *splat, int y0, int y1);

/** Adds triangles and splats to the view's irradiance, in order, whatever the number of threads. */
void wave_draw(
    const TraceScene *trace, WaveView *view, TaskPool *pool, const WaveBatch *batches, size_t batch_count);

/** Filters the irradiance into the pass's images and clears it (wave_resolve.c). */
void wave_resolve(WaveView *view, TaskPool *pool, const PassImages *images);

#endif
