/* SPDX-License-Identifier: Apache-2.0 */
/* Every band of every part, on all cores; chunks that nothing is added to are copied as they are. */
#include "composite/stream.h"

#include "core/checked.h"
#include "core/ordered.h"

typedef struct Piece {
    size_t part;
    int32_t y0, y1;
} Piece;

typedef struct Stream {
    Job *job;
    const ExrHeader *header;
    ExrWriter *writer;
    Lane *lanes;
    Piece *pieces;
    size_t piece_count;
    unsigned threads, slots;
} Stream;

/* The same chunks mean the same pixels in both files. */
static bool same_layout(const ExrPart *a, const ExrPart *b) {
    return a->codec == b->codec && a->tiled == b->tiled && a->order == b->order &&
           a->tile_width == b->tile_width && a->tile_height == b->tile_height;
}

/* Part `index` of the output comes from the beauty, those behind from the caustics. */
static bool is_kept(const Stream *s, size_t index) { return index >= s->job->beauty.header->part_count; }

static int piece_rows(const Stream *s, size_t index) {
    int out = exr_band_rows(&s->header->parts[index]);
    int in = is_kept(s, index) ? 0 : exr_band_rows(&s->job->beauty.header->parts[index]);
    return in > out ? in : out;
}

static cau_result cut(Stream *s) {
    size_t capacity = 0;
    for (size_t i = 0; i < s->header->part_count; i++) {
        const ExrPart *part = &s->header->parts[i];
        ExrBands bands = exr_bands(part, piece_rows(s, i));
        void *array = s->pieces;
        if (!array_reserve(&array, &capacity, s->piece_count + bands.count, sizeof *s->pieces))
            return error_set(s->job->err, CAU_ERROR_RESOURCE, "out of memory for %zu bands", bands.count);
        s->pieces = array;
        for (size_t b = 0; b < bands.count; b++) {
            Piece *piece = &s->pieces[s->piece_count++];
            piece->part = i;
            exr_band_at(&bands, b, &piece->y0, &piece->y1);
        }
    }
    return CAU_OK;
}

size_t job_lane_bytes(const ExrHeader *beauty, const ExrHeader *caustics) {
    size_t most = 0, light = 0;
    for (size_t i = 0; i < beauty->part_count; i++) {
        const ExrPart *part = &beauty->parts[i];
        size_t rows = (size_t)exr_band_rows(part);
        size_t bytes = (size_t)exr_box_width(part->data_window) * rows * exr_part_pixel_bytes(part);
        if (bytes > most) most = bytes;
    }
    for (size_t i = 0; i < caustics->part_count; i++) {
        const ExrPart *part = &caustics->parts[i];
        light += (size_t)exr_box_width(part->data_window) * exr_part_pixel_bytes(part) * 32;
    }
    return 5 * most + 2 * light;
}

static void choose_threads(Stream *s) {
    const cau_merge_options *o = s->job->options;
    size_t memory = job_memory(o), each = job_lane_bytes(s->job->beauty.header, s->job->caustics.header);
    s->threads = o->threads ? o->threads : ordered_processors();
    s->slots = s->threads == 1 ? 1 : s->threads + 2;
    while (s->slots > 1 && each > memory / s->slots) s->slots--;
}

cau_result lane_create(Lane *lane, const Job *job, CauError *err) {
    for (size_t t = 0; t < job->target_count; t++) {
        size_t width =
            (size_t)exr_box_width(job->beauty.header->parts[job->targets[t].layer->part].data_window);
        if (width > lane->width) lane->width = width;
    }
    lane->lines = array_new(LANE_LINES * lane->width, sizeof *lane->lines);
    if (!lane->lines)
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for a row of %zu pixels", lane->width);
    CAU_TRY(source_create(&lane->beauty, &job->beauty, 0, 0, err));
    CAU_TRY(source_create(&lane->caustics, &job->caustics, job->shift_x, job->shift_y, err));
    return job->holdout.mask.header ? source_create(&lane->mask, &job->holdout.mask, 0, 0, err) : CAU_OK;
}

void lane_free(Lane *lane) {
    source_free(&lane->beauty);
    source_free(&lane->caustics);
    source_free(&lane->mask);
    exr_rows_free(&lane->kept);
    exr_encoder_free(&lane->encoder);
    exr_packed_free(&lane->packed);
    free(lane->lines);
}

static cau_result create_lane(const Stream *s, Lane *lane, CauError *err) {
    CAU_TRY(lane_create(lane, s->job, err));
    return exr_writer_takes_packed(s->writer) ? exr_encoder_create(&lane->encoder, s->writer, err) : CAU_OK;
}

static cau_result blend(const Job *job, const Piece *piece, Lane *lane, bool *changed, CauError *err) {
    *changed = false;
    for (size_t t = 0; t < job->target_count; t++) {
        const Target *target = &job->targets[t];
        bool needed = false;
        if (target->layer->part != piece->part) continue;
        CAU_TRY(blend_needed(job, target, lane, &needed, err));
        if (!needed) continue;
        CAU_TRY(source_load(&lane->beauty, piece->part, err));
        CAU_TRY(blend_band(job, target, lane, err));
        *changed = true;
    }
    return CAU_OK;
}

static cau_result work(void *data, size_t index, unsigned slot, CauError *err) {
    const Stream *s = data;
    const Piece *piece = &s->pieces[index];
    Lane *lane = &s->lanes[slot];
    bool changed;
    lane->ready = NULL;
    source_begin(&lane->beauty, piece->y0, piece->y1);
    source_begin(&lane->caustics, piece->y0, piece->y1);
    if (lane->mask.decoder) source_begin(&lane->mask, piece->y0, piece->y1);
    if (is_kept(s, piece->part))
        return keep_band(s->job, s->header, piece->part - s->job->beauty.header->part_count, lane, piece->y0,
            piece->y1, err);
    CAU_TRY(blend(s->job, piece, lane, &changed, err));
    if (!changed && lane->encoder &&
        same_layout(&s->job->beauty.header->parts[piece->part], &s->header->parts[piece->part]))
        return exr_decoder_packed(
            lane->beauty.decoder, piece->part, piece->y0, piece->y1, &lane->packed, err);
    CAU_TRY(source_load(&lane->beauty, piece->part, err));
    lane->ready = &lane->beauty.rows[piece->part];
    if (!lane->encoder) return CAU_OK;
    CAU_TRY(exr_encoder_pack(lane->encoder, piece->part, lane->ready, &lane->packed, err));
    lane->ready = NULL;
    return CAU_OK;
}

static cau_result take(void *data, size_t index, unsigned slot, CauError *err) {
    Stream *s = data;
    const Piece *piece = &s->pieces[index];
    Lane *lane = &s->lanes[slot];
    s->job->repaired += lane->repaired;
    s->job->clamped += lane->clamped;
    lane->repaired = lane->clamped = 0;
    CAU_TRY(job_poll(s->job));
    if (lane->ready) return exr_writer_put_rows(s->writer, piece->part, lane->ready, err);
    return exr_writer_put_packed(s->writer, piece->part, piece->y0, &lane->packed, err);
}

cau_result stream_run(Job *job, const ExrHeader *header, ExrWriter *writer) {
    Stream s = {.job = job, .header = header, .writer = writer};
    choose_threads(&s);
    cau_result result = cut(&s);
    s.lanes = array_new(s.slots, sizeof *s.lanes);
    if (result == CAU_OK && !s.lanes)
        result = error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for %u threads", s.threads);
    for (unsigned i = 0; result == CAU_OK && i < s.slots; i++)
        result = create_lane(&s, &s.lanes[i], job->err);
    if (result == CAU_OK)
        result = ordered_run(s.threads, s.slots, s.piece_count, work, take, NULL, &s, job->err);
    for (unsigned i = 0; s.lanes && i < s.slots; i++) lane_free(&s.lanes[i]);
    free(s.lanes);
    free(s.pieces);
    return result;
}
