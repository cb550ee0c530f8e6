/* SPDX-License-Identifier: Apache-2.0 */
/* One replica of a light: fronts towards every caster, in chunks whose memory does not grow with the rays. */
#include "render/gather/wave/wave.h"

#include "render/gather/wave/wave_internal.h"

#include "core/checked.h"
#include "core/rng.h"

/* Tiles whose triangles are held at once; they depend on the grid alone, never on the threads. */
enum { SEEN_BANDS = 8, CHUNK_TILES = 16, CELLS_MIN = 24 };
/* Of a probe: cells along a front and along a tile; the part of the tiles that tells enough of what is dear.
 */
enum { PROBE_CELLS = 48, PROBE_TILE = 12, PROBE_PART = 4 };

typedef struct Tiles {
    WaveTile *items;
    size_t count, capacity;
} Tiles;

typedef struct Fronts {
    WaveFront *items;
    size_t count, capacity;
} Fronts;

typedef struct CellsJob {
    const WaveRun *run;
    const WaveView *view;
    const WaveSeen *seen; /* NULL: none */
    const PassImages *images;
    const WaveTile *tiles;
    size_t count;
    WaveBatch *batches;
} CellsJob;

static void trace_tile(void *data, size_t index, unsigned thread) {
    (void)thread;
    const CellsJob *job = data;
    wave_cells(job->run, job->view, job->seen != NULL, &job->tiles[index], &job->batches[index]);
}

static void light_band(void *data, size_t index, unsigned thread) {
    (void)thread;
    const CellsJob *job = data;
    wave_seen_light(job->seen, index, job->batches, job->count, job->images);
}

/* ---- what to trace ---- */

static cau_result all_fronts(const WaveRun *run, Fronts *out, CauError *err) {
    uint64_t key = rng_combine(run->key, 0x7761766575u);
    for (uint32_t k = 0; k < run->places; k++) {
        EmitStart start;
        uint32_t index = run->pass * run->places + k;
        run->light->kind->emit_start(
            run->light, sobol_owen(index, 0, key), sobol_owen(index, 1, key), &start);
        for (size_t o = 0; o < run->scene->object_count; o++) {
            if (!run->waved[o]) continue;
            WaveFront found[WAVE_FRONTS_MAX];
            int n = wave_fronts(run, &start, (int)o, found);
            if (!array_reserve(
                    (void **)&out->items, &out->capacity, out->count + (size_t)n, sizeof *out->items))
                return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %zu wavefronts", out->count);
            for (int i = 0; i < n; i++) out->items[out->count++] = found[i];
        }
    }
    return CAU_OK;
}

/* Square cells, so many that each front has its part of the rays. */
static void set_cells(WaveFront *f, double rays) {
    double w = f->hi[0] - f->lo[0], h = f->hi[1] - f->lo[1], longest = fmax(w, h);
    double ratio = longest > 0 ? clamp(fmin(w, h) / longest, 1e-3, 1) : 1;
    double along = fmax(sqrt(rays / ratio), CELLS_MIN), across = fmax(along * ratio, 3);
    f->n[0] = (int)(w >= h ? along : across) + 1;
    f->n[1] = (int)(w >= h ? across : along) + 1;
}

static cau_result add_tiles(const WaveFront *f, uint64_t key, Tiles *out, CauError *err) {
    for (int y = 0; y < f->n[1]; y += WAVE_TILE)
        for (int x = 0; x < f->n[0]; x += WAVE_TILE) {
            if (!array_reserve((void **)&out->items, &out->capacity, out->count + 1, sizeof *out->items))
                return error_set(
                    err, CAU_ERROR_RESOURCE, "out of memory for %zu tiles of wavefront", out->count);
            int x1 = x + WAVE_TILE < f->n[0] ? x + WAVE_TILE : f->n[0];
            int y1 = y + WAVE_TILE < f->n[1] ? y + WAVE_TILE : f->n[1];
            out->items[out->count++] = (WaveTile){f, key, x, y, x1, y1};
        }
    return CAU_OK;
}

static cau_result all_tiles(const WaveRun *run, Fronts *fronts, Tiles *out, CauError *err) {
    double sum = 0;
    for (size_t i = 0; i < fronts->count; i++) sum += run->share[fronts->items[i].object];
    for (size_t i = 0; i < fronts->count; i++) {
        WaveFront *f = &fronts->items[i];
        set_cells(f, run->rays * run->share[f->object] / sum);
        uint64_t key = rng_combine(rng_combine(run->key, run->pass), i);
        CAU_TRY(add_tiles(&fronts->items[i], key, out, err));
    }
    return CAU_OK;
}

/* ---- tracing it ---- */

static cau_result keep_deposits(const WaveBatch *b, DepositList *rest, FluxAccount *account, CauError *err) {
    if (b->out_of_memory || !array_reserve((void **)&rest->items, &rest->capacity,
                                rest->count + b->deposit_count, sizeof *rest->items))
        return error_set(err, CAU_ERROR_RESOURCE,
            "out of memory for a wavefront's %zu deposits; use fewer photons",
            rest->count + b->deposit_count);
    if (b->deposit_count)
        memcpy(rest->items + rest->count, b->deposits, b->deposit_count * sizeof *b->deposits);
    rest->count += b->deposit_count;
    flux_account_add(account, &b->account);
    return CAU_OK;
}

static cau_result trace_tiles(const WaveRun *run, WaveView *view, const WaveSeen *seen, TaskPool *pool,
    const Tiles *tiles, WaveBatch *batches, const PassImages *images, DepositList *rest, FluxAccount *account,
    CauError *err) {
    for (size_t first = 0; first < tiles->count; first += CHUNK_TILES) {
        size_t count = tiles->count - first < CHUNK_TILES ? tiles->count - first : CHUNK_TILES;
        CellsJob job = {run, view, seen, images, tiles->items + first, count, batches};
        tasks_run(pool, count, trace_tile, &job);
        if (run->cancel && atomic_load(run->cancel)) return CAU_ERROR_CANCELLED;
        for (size_t i = 0; i < count; i++) CAU_TRY(keep_deposits(&batches[i], rest, account, err));
        wave_draw(run->trace, view, pool, batches, count);
        if (seen) tasks_run(pool, SEEN_BANDS, light_band, &job);
    }
    return CAU_OK;
}

static bool any_seen(const WaveRun *run) {
    for (int y = run->y0; y < run->y1; y++)
        for (size_t i = 0; i < run->points->rows[y].count; i++)
            if (!run->points->rows[y].items[i].straight) return true;
    return false;
}

cau_result wave_pass(const WaveRun *run, WaveView *view, TaskPool *pool, const PassImages *images,
    DepositList *rest, FluxAccount *account, CauError *err) {
    Fronts fronts = {0};
    Tiles tiles = {0};
    WaveBatch *batches = array_new(CHUNK_TILES, sizeof *batches);
    cau_result result = batches ? all_fronts(run, &fronts, err)
                                : error_set(err, CAU_ERROR_RESOURCE, "out of memory for wavefronts");
    WaveSeen *seen = NULL;
    if (result == CAU_OK && any_seen(run))
        result = wave_seen_create(&seen, run->scene, run->points, run->y0, run->y1, SEEN_BANDS, err);
    if (result == CAU_OK) result = all_tiles(run, &fronts, &tiles, err);
    if (result == CAU_OK)
        result = trace_tiles(run, view, seen, pool, &tiles, batches, images, rest, account, err);
    wave_resolve(view, pool, images);
    wave_seen_free(&seen);
    for (size_t i = 0; batches && i < CHUNK_TILES; i++) {
        free(batches[i].triangles);
        free(batches[i].seen);
        free(batches[i].splats);
        free(batches[i].deposits);
    }
    free(batches);
    free(fronts.items);
    free(tiles.items);
    return result;
}

/* Adds a tile's part. */
static void probe_tile(const WaveRun *run, const WaveTile *tile, WaveBatch *batch, WaveProbe *out) {
    wave_cells(run, NULL, false, tile, batch);
    out->landed += batch->landed;
    out->left += batch->left;
    out->looked += batch->looked;
    out->looked_flux += batch->looked_flux;
    out->found += batch->found;
    out->rays += batch->account.rays;
    out->corners += (uint64_t)(tile->x1 - tile->x0 + 1) * (uint64_t)(tile->y1 - tile->y0 + 1);
}

/* Tiles of all fronts by turns, from all over each. */
cau_result wave_probe(const WaveRun *run, int object, double enough, WaveProbe *out, CauError *err) {
    enum { SIDE = PROBE_CELLS / PROBE_TILE, TILES = SIDE * SIDE, STRIDE = SIDE + 1 };
    *out = (WaveProbe){0};
    EmitStart start;
    run->light->kind->emit_start(run->light, 0.5, 0.5, &start);
    WaveFront fronts[WAVE_FRONTS_MAX];
    int count = wave_fronts(run, &start, object, fronts);
    WaveBatch batch = {0};
    for (int k = 0; k < TILES && !batch.out_of_memory; k++) {
        if (PROBE_PART * k >= TILES && (double)out->rays > enough * (double)out->corners) break;
        int x = PROBE_TILE * (k * STRIDE % TILES % SIDE), y = PROBE_TILE * (k * STRIDE % TILES / SIDE);
        for (int i = 0; i < count; i++) {
            fronts[i].n[0] = fronts[i].n[1] = PROBE_CELLS;
            WaveTile tile = {
                &fronts[i], rng_combine(run->key, (uint64_t)i), x, y, x + PROBE_TILE, y + PROBE_TILE};
            probe_tile(run, &tile, &batch, out);
        }
    }
    out->noise = out->looked_flux > 0 ? out->found * out->looked / square(out->looked_flux) : 0;
    free(batch.triangles);
    free(batch.deposits);
    return batch.out_of_memory ? error_set(err, CAU_ERROR_RESOURCE, "out of memory for a wavefront's probe")
                               : CAU_OK;
}
