/* SPDX-License-Identifier: Apache-2.0 */
/* The state of a render as bytes: what it is of, in words; what walk_course() and walk_sums() list; a
 * checksum.
 *
 * Reading adds to what is there, so that going on from a state and joining shards are the same code. */
#include "render/render_internal.h"

#include "core/checked.h"

#include <inttypes.h>
#include <stdio.h>

enum { IDENTITY_MAX = 2048, BLOCK = 1024, SHOWN_MAX = 60 };
static const char state_magic[8] = "CAUSTAT9";
#define STATE_BYTE_ORDER 0x0102030405060708u
/* No kernel nor pass is ever scaled beyond this, nor takes so many millions of rays; a state that says so is
 * damaged. */
#define SCALE_MAX 1e12

/* How the parts of several shards become one. */
typedef enum StateKind {
    STATE_SUM,   /* doubles with what their rounding lost: added, see film.h */
    STATE_FLUX,  /* doubles: added */
    STATE_COUNT, /* uint64_t: added */
    STATE_SCALE  /* doubles that all shards agree on; 0: not known yet */
} StateKind;

typedef struct StateItem {
    StateKind kind;
    void *values;
    float *low; /* of STATE_SUM */
    size_t count;
} StateItem;

typedef cau_result (*StateVisit)(void *data, const StateItem *item);

/* ---- what the state is ---- */

static cau_result walk_film(Film *f, StateVisit visit, void *data) {
    if (!f->sum) return CAU_OK;
    size_t values = f->pixels * f->channels;
    CAU_TRY(visit(data, &(StateItem){STATE_SUM, f->sum, f->sum_low, values}));
    CAU_TRY(visit(data, &(StateItem){STATE_SUM, f->square_sum, f->square_low, values}));
    CAU_TRY(visit(data, &(StateItem){STATE_COUNT, &f->passes, NULL, 1}));
    if (f->first) {
        CAU_TRY(visit(data, &(StateItem){STATE_FLUX, f->first, NULL, values}));
        CAU_TRY(visit(data, &(StateItem){STATE_COUNT, &f->first_passes, NULL, 1}));
    }
    return visit(data, &(StateItem){STATE_COUNT, &f->non_finite, NULL, 1});
}

static cau_result walk_account(FluxAccount *a, StateVisit visit, void *data) {
    enum { FLUXES = offsetof(FluxAccount, photons) / sizeof(double) };
    enum { COUNTS = (sizeof *a - offsetof(FluxAccount, photons)) / sizeof(uint64_t) };
    CAU_TRY(visit(data, &(StateItem){STATE_FLUX, &a->emitted, NULL, FLUXES}));
    return visit(data, &(StateItem){STATE_COUNT, &a->photons, NULL, COUNTS});
}

/* How far it is, and by which estimators: what settles which films there are. */
static cau_result walk_course(cau_render *r, StateVisit visit, void *data) {
    CAU_TRY(visit(data, &(StateItem){STATE_COUNT, &r->passes, NULL, 1}));
    CAU_TRY(visit(data, &(StateItem){STATE_SCALE, &r->pass_scale, NULL, 1}));
    CAU_TRY(visit(data, &(StateItem){STATE_SCALE, &r->race, NULL, sizeof r->race / sizeof(double)}));
    CAU_TRY(visit(data, &(StateItem){STATE_SCALE, &r->past, NULL, sizeof r->past / sizeof(double)}));
    CAU_TRY(visit(data, &(StateItem){STATE_SCALE, &r->stated, NULL, sizeof r->stated / sizeof(double)}));
    for (size_t i = 0; i < r->group_count; i++) {
        RaceTry *race = &r->groups[i].race;
        CAU_TRY(visit(data, &(StateItem){STATE_SCALE, race, NULL, sizeof *race / sizeof(double)}));
        CAU_TRY(visit(data, &(StateItem){STATE_SCALE, r->groups[i].share, NULL, 2}));
    }
    return CAU_OK;
}

/* All that passes leave behind; a further array is a further line. */
static cau_result walk_sums(cau_render *r, StateVisit visit, void *data) {
    CAU_TRY(walk_film(&r->beauty, visit, data));
    for (size_t i = 0; i < r->group_count; i++) {
        RenderGroup *g = &r->groups[i];
        Film *films[GROUP_FILMS];
        group_films(g, films);
        for (size_t f = 0; f < GROUP_FILMS; f++) CAU_TRY(walk_film(films[f], visit, data));
        CAU_TRY(visit(data, &(StateItem){STATE_SCALE, g->radius_scale, NULL, 2}));
        CAU_TRY(visit(data, &(StateItem){STATE_COUNT, g->eye_points, NULL, 2}));
        FluxAccount *accounts[] = {
            &g->accounts[0], &g->accounts[1], &g->bent[0], &g->bent[1], &g->wave_account};
        for (size_t a = 0; a < sizeof accounts / sizeof *accounts; a++)
            CAU_TRY(walk_account(accounts[a], visit, data));
    }
    return CAU_OK;
}

/* FNV-1a (Fowler, Noll and Vo) over words: damage by accident, not by intent. */
static uint64_t checksum_add(uint64_t sum, const void *bytes, size_t size) {
    const unsigned char *p = bytes;
    for (; size >= 8; size -= 8, p += 8) {
        uint64_t word;
        memcpy(&word, p, 8);
        sum = (sum ^ word) * 0x100000001b3u;
        sum ^= sum >> 29;
    }
    for (; size; size--, p++) sum = (sum ^ *p) * 0x100000001b3u;
    return sum;
}

/* What settles the bytes of a render, one field a line; the shard stands last. Limits by time and error are
 * not among them, nor is the number of threads. */
static void identity_write(const cau_render *r, const char *plan, char out[IDENTITY_MAX]) {
    static const char *const estimators[] = {"auto", "P", "R", "W"}, *const effects[] = {"auto", "on", "off"};
    const cau_render_options *o = &r->options;
    snprintf(out, IDENTITY_MAX,
        "version=%s\ncompiler=%s\nscene hash=%016" PRIx64 "\nseed=%" PRIu64 "\nphotons=%" PRIu64
        "\nresolution=%dx%d\nregion=%d,%d,%d,%d\nestimator=%s\nlayers=%x\nindirect effects=%s\n"
        "physical=%d\nmemory=%zu\nplan hash=%016" PRIx64 "\nshard=%u/%u\n",
        cau_version(), __VERSION__, cau_scene_hash(r->source), o->seed, render_has_rounds(r) ? 0 : o->photons,
        r->scene.camera.width, r->scene.camera.height, r->region[0], r->region[1], r->region[2], r->region[3],
        estimators[o->estimator & 3], o->layers, effects[o->indirect % 3], o->physical_radiance,
        o->memory_bytes, checksum_add(0, plan, strlen(plan)), o->shard_index, o->shard_count);
}

uint64_t cau_render_stamp(const cau_render *r) {
    char identity[IDENTITY_MAX];
    identity_write(r, "", identity); /* it may have no plan yet, and the rest settles the plan */
    double limits[3] = {r->options.time_s, r->options.error, (double)r->options.photons};
    return checksum_add(checksum_add(0, identity, strlen(identity)), limits, sizeof limits);
}

/* ---- writing ---- */

typedef struct Writer {
    cau_state_write write;
    void *data;
    uint64_t sum;
    CauError *err;
} Writer;

static cau_result put(Writer *w, const void *bytes, size_t size) {
    w->sum = checksum_add(w->sum, bytes, size);
    if (w->write(w->data, bytes, size) == 0) return CAU_OK;
    return error_set(w->err, CAU_ERROR_RESOURCE, "the state of the render could not be written");
}

static cau_result put_item(void *data, const StateItem *item) {
    CAU_TRY(put(data, item->values, item->count * sizeof(double)));
    return item->low ? put(data, item->low, item->count * sizeof(float)) : CAU_OK;
}

static cau_result save(cau_render *r, Writer *w) {
    char identity[IDENTITY_MAX];
    identity_write(r, cau_render_explain(r), identity);
    uint64_t head[2] = {STATE_BYTE_ORDER, strlen(identity)};
    CAU_TRY(put(w, state_magic, sizeof state_magic));
    CAU_TRY(put(w, head, sizeof head));
    CAU_TRY(put(w, identity, strlen(identity)));
    CAU_TRY(walk_course(r, put_item, w));
    CAU_TRY(walk_sums(r, put_item, w));
    uint64_t sum = w->sum;
    return put(w, &sum, sizeof sum);
}

void render_pause(cau_render *r) {
    pthread_mutex_lock(&r->mutex);
    if (r->pause_wanted) {
        r->paused = true;
        pthread_cond_broadcast(&r->ended);
        while (r->pause_wanted) pthread_cond_wait(&r->ended, &r->mutex);
        r->paused = false;
    }
    pthread_mutex_unlock(&r->mutex);
}

cau_result cau_render_save(cau_render *r, cau_state_write write, void *data) {
    Writer w = {.write = write, .data = data, .err = &r->source->context->error};
    pthread_mutex_lock(&r->mutex);
    r->pause_wanted = true;
    while (r->running && !r->paused && !r->has_ended) pthread_cond_wait(&r->ended, &r->mutex);
    pthread_mutex_unlock(&r->mutex);
    cau_result result = r->planned
                            ? save(r, &w)
                            : error_set(w.err, CAU_ERROR_CANCELLED,
                                  "the render was stopped while it probed the scene, and has no state yet");
    pthread_mutex_lock(&r->mutex);
    r->pause_wanted = false;
    pthread_cond_broadcast(&r->ended);
    pthread_mutex_unlock(&r->mutex);
    return result;
}

/* ---- reading ---- */

typedef struct Reader {
    cau_render *render;
    const char *name;
    cau_state_read read;
    void *data;
    uint64_t sum;
    CauError *err;
} Reader;

static cau_result damaged(const Reader *in, const char *what) {
    return error_set(in->err, CAU_ERROR_INPUT,
        "\"%s\" is damaged: %s; delete it and render anew, or use a copy", in->name, what);
}

static cau_result get(Reader *in, void *bytes, size_t size) {
    if (in->read(in->data, bytes, size) != 0) return damaged(in, "it is shorter than the render's state is");
    in->sum = checksum_add(in->sum, bytes, size);
    return CAU_OK;
}

static cau_result join_sums(Reader *in, const StateItem *item) {
    double block[BLOCK], *high = item->values;
    for (size_t at = 0; at < item->count; at += BLOCK) {
        size_t n = item->count - at < BLOCK ? item->count - at : BLOCK;
        CAU_TRY(get(in, block, n * sizeof *block));
        for (size_t i = 0; i < n; i++) {
            if (!isfinite(block[i])) return damaged(in, "a sum in it is not a finite number");
            if (item->low)
                film_add_value(&high[at + i], &item->low[at + i], block[i]);
            else
                high[at + i] += block[i];
        }
    }
    float lost[BLOCK];
    for (size_t at = 0; item->low && at < item->count; at += BLOCK) {
        size_t n = item->count - at < BLOCK ? item->count - at : BLOCK;
        CAU_TRY(get(in, lost, n * sizeof *lost));
        for (size_t i = 0; i < n; i++) {
            if (!isfinite(lost[i])) return damaged(in, "a sum in it is not a finite number");
            item->low[at + i] += lost[i];
        }
    }
    return CAU_OK;
}

static cau_result join_scales(Reader *in, const StateItem *item) {
    double *scale = item->values, value;
    for (size_t i = 0; i < item->count; i++) {
        CAU_TRY(get(in, &value, sizeof value));
        if (!(value >= 0 && value <= SCALE_MAX)) return damaged(in, "a width or a size in it is impossible");
        if (scale[i] > 0 && value > 0 && scale[i] != value)
            return error_set(in->err, CAU_ERROR_INPUT,
                "\"%s\" is not of the same render as the other shards: its kernels have a mean radius of "
                "%.17g, "
                "theirs of %.17g; render all shards with one build on one kind of processor",
                in->name, value, scale[i]);
        if (value > 0) scale[i] = value;
    }
    return CAU_OK;
}

static cau_result join_item(void *data, const StateItem *item) {
    Reader *in = data;
    if (item->kind == STATE_SUM || item->kind == STATE_FLUX) return join_sums(in, item);
    if (item->kind == STATE_SCALE) return join_scales(in, item);
    uint64_t *count = item->values, value;
    for (size_t i = 0; i < item->count; i++) {
        CAU_TRY(get(in, &value, sizeof value));
        count[i] += value;
    }
    return CAU_OK;
}

/* Field by field: the first that differs is named with both values. With a shard wanted, that line is its
 * own. */
static cau_result identity_compare(
    const Reader *in, const char *theirs, const char *ours, unsigned shard[2]) {
    while (*ours) {
        size_t n = strcspn(ours, "\n"), m = strcspn(theirs, "\n"), key = strcspn(ours, "=") + 1;
        bool last = !ours[n + 1];
        if (m < key || strncmp(theirs, ours, key) != 0 || theirs[m] != '\n')
            return damaged(in, "its description is not one of this version");
        if (last && sscanf(theirs + key, "%u/%u", &shard[0], &shard[1]) != 2)
            return damaged(in, "its description names no shard");
        bool free_field = last && in->render->joined;
        if (!free_field && (m != n || strncmp(theirs, ours, n) != 0))
            return error_set(in->err, CAU_ERROR_INPUT,
                "\"%s\" is the state of another render: %.*s is %.*s there and %.*s here; make both the "
                "same, "
                "or name another file",
                in->name, (int)key - 1, ours, (int)(m - key < SHOWN_MAX ? m - key : SHOWN_MAX), theirs + key,
                (int)(n - key < SHOWN_MAX ? n - key : SHOWN_MAX), ours + key);
        ours += n + 1;
        theirs += m + 1;
    }
    return *theirs ? damaged(in, "its description is too long") : CAU_OK;
}

static cau_result read_head(Reader *in, unsigned shard[2]) {
    char magic[sizeof state_magic], theirs[IDENTITY_MAX + 1] = "", ours[IDENTITY_MAX];
    uint64_t head[2];
    bool ok = in->read(in->data, magic, sizeof magic) == 0 && memcmp(magic, state_magic, sizeof magic) == 0;
    if (!ok)
        return error_set(in->err, CAU_ERROR_INPUT,
            "\"%s\" is not a render's state of this version, which begins with %.8s; name one that "
            "--checkpoint "
            "wrote",
            in->name, state_magic);
    in->sum = checksum_add(0, magic, sizeof magic);
    CAU_TRY(get(in, head, sizeof head));
    if (head[0] != STATE_BYTE_ORDER) return damaged(in, "its byte order is not this machine's");
    if (head[1] > IDENTITY_MAX) return damaged(in, "its description is too long");
    CAU_TRY(get(in, theirs, (size_t)head[1]));
    identity_write(in->render, cau_render_explain(in->render), ours);
    return identity_compare(in, theirs, ours, shard);
}

/* Of a stopped render, some films may hold the pass that it was at. */
static cau_result check_passes(const Reader *in) {
    const cau_render *r = in->render;
    bool ok = !r->passes_wanted || r->passes <= (r->joined ? r->passes_wanted : r->passes_share);
    for (size_t g = 0; g < r->group_count; g++) {
        const RenderGroup *group = &r->groups[g];
        for (int k = 0; k < 2; k++) {
            const Film *f = &group->films[k];
            ok &= f->first_passes <= f->passes;
            if (f->sum) ok &= f->passes == r->passes || (!r->joined && f->passes == r->passes + 1);
        }
        const Film *beside[] = {group->seen, group->irradiance, group->coverage};
        for (int i = 0; i < 3; i++) ok &= !beside[i]->sum || beside[i]->passes == group->films[0].passes;
    }
    if (r->beauty.sum) ok &= r->beauty.passes == r->passes;
    return ok ? CAU_OK : damaged(in, "its numbers of passes contradict each other");
}

/* Where a render was stopped in the first pass of a round the sums are of the one before it. */
static void forget_stale(RenderGroup *g) {
    Film *films[GROUP_FILMS];
    group_films(g, films);
    for (size_t i = 0; i < GROUP_FILMS; i++)
        if (films[i]->passes == 0) film_clear(films[i]);
}

static cau_result read_rest(Reader *in) {
    CAU_TRY(walk_course(in->render, join_item, in));
    CAU_TRY(race_resume(in->render, in->err));
    CAU_TRY(walk_sums(in->render, join_item, in));
    uint64_t wanted = in->sum, sum;
    CAU_TRY(get(in, &sum, sizeof sum));
    if (sum != wanted) return damaged(in, "its checksum does not fit");
    for (size_t g = 0; g < in->render->group_count; g++) {
        RenderGroup *group = &in->render->groups[g];
        forget_stale(group);
        film_settle(&group->films[0]);
    }
    return CAU_OK;
}

cau_result cau_render_load(cau_render *r, const char *name, cau_state_read read, void *data) {
    Reader in = {r, name, read, data, 0, &r->source->context->error};
    unsigned shard[2];
    if (r->running || r->has_ended || r->passes || r->joined)
        return error_set(in.err, CAU_ERROR_USAGE, "a state is loaded once, and before the render starts");
    cau_result result = cau_render_plan(r);
    if (result != CAU_OK) return error_set(in.err, result, "%s", r->error.text);
    result = read_head(&in, shard);
    if (result == CAU_OK) result = read_rest(&in);
    if (result == CAU_OK) result = check_passes(&in);
    r->has_ended = result != CAU_OK;
    return result;
}

static cau_result join_prepare(Reader *in) {
    cau_render *r = in->render;
    if (r->running || r->has_ended || r->options.shard_count || (r->passes && !r->joined) ||
        !r->options.photons || render_has_rounds(r))
        return error_set(in->err, CAU_ERROR_USAGE,
            "shards are joined before the render starts, in one that is limited by photons alone and no "
            "shard");
    if (r->joined) return CAU_OK;
    cau_result result = cau_render_plan(r);
    if (result != CAU_OK) return error_set(in->err, result, "%s", r->error.text);
    r->joined = array_new(CAU_SHARDS_MAX + 1, sizeof *r->joined);
    return r->joined ? CAU_OK : error_set(in->err, CAU_ERROR_RESOURCE, "out of memory for shards");
}

static cau_result join_one(Reader *in) {
    cau_render *r = in->render;
    unsigned shard[2] = {0, 0};
    CAU_TRY(read_head(in, shard));
    if (shard[0] < 1 || shard[0] > shard[1] || shard[1] > CAU_SHARDS_MAX || shard[1] > r->passes_wanted)
        return error_set(in->err, CAU_ERROR_INPUT,
            "\"%s\" is not the state of a shard (its shard is %u/%u); join what --shard I/N wrote", in->name,
            shard[0], shard[1]);
    if (r->joined_count && r->joined_count != shard[1])
        return error_set(in->err, CAU_ERROR_INPUT, "\"%s\" is shard %u of %u, but the others are of %u",
            in->name, shard[0], shard[1], r->joined_count);
    if (r->joined[shard[0]])
        return error_set(
            in->err, CAU_ERROR_INPUT, "\"%s\" is shard %u again: join each once", in->name, shard[0]);
    r->joined_count = shard[1];
    r->joined[shard[0]] = true;
    uint64_t before = r->passes, share = (r->passes_wanted - shard[0]) / shard[1] + 1;
    CAU_TRY(read_rest(in));
    if (r->passes - before != share && render_has_layers(r))
        return error_set(in->err, CAU_ERROR_INPUT,
            "\"%s\" is not finished: shard %u has %" PRIu64 " of its %" PRIu64
            " passes; finish it with --resume",
            in->name, shard[0], r->passes - before, share);
    return check_passes(in);
}

cau_result cau_render_join(cau_render *r, const char *name, cau_state_read read, void *data) {
    Reader in = {r, name, read, data, 0, &r->source->context->error};
    cau_result result = join_prepare(&in);
    if (result == CAU_OK) result = join_one(&in);
    r->has_ended |= result != CAU_OK;
    return result;
}

cau_result render_check_joined(const cau_render *r, CauError *err) {
    for (unsigned i = 1; i <= r->joined_count; i++)
        if (!r->joined[i])
            return error_set(err, CAU_ERROR_INPUT,
                "shard %u of %u is missing: the picture needs the state of each", i, r->joined_count);
    return CAU_OK;
}
