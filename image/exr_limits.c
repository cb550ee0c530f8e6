/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_limits.h"

#include "core/checked.h"

#include <inttypes.h>
#include <math.h>

/* How many times its own size a chunk can unpack to. Deflate: 1032. Constant rows cost PIZ and DWA next to
 * nothing, so theirs is a guard against attacks, not a property of the format. */
static const int largest_ratio[EXR_CODEC_COUNT] = {1, 128, 1040, 1040, 20000, 1400, 32, 32, 20000, 20000};

/* Small pictures need no such guard: they cannot hurt. */
static const uint64_t harmless_bytes = 32u << 20;

static cau_result check_box(ExrBox b, const char *what, const char *path, CauError *err) {
    int32_t limit = EXR_LARGEST_COORD;
    if (b.x1 < b.x0 || b.y1 < b.y0)
        return error_set(err, CAU_ERROR_INPUT, "\"%s\": the %s (%d,%d)-(%d,%d) is empty", path, what, b.x0,
            b.y0, b.x1, b.y1);
    if (b.x0 < -limit || b.y0 < -limit || b.x1 > limit || b.y1 > limit)
        return error_set(err, CAU_ERROR_INPUT, "\"%s\": the %s (%d,%d)-(%d,%d) lies beyond %d", path, what,
            b.x0, b.y0, b.x1, b.y1, limit);
    if (exr_box_width(b) > EXR_LARGEST_SIDE || exr_box_height(b) > EXR_LARGEST_SIDE)
        return error_set(err, CAU_ERROR_INPUT,
            "\"%s\": the %s is %" PRId64 " x %" PRId64 " pixels, at most %d", path, what, exr_box_width(b),
            exr_box_height(b), EXR_LARGEST_SIDE);
    return CAU_OK;
}

static uint64_t chunk_count(const ExrPart *part) {
    uint64_t height = (uint64_t)exr_box_height(part->data_window), rows = (uint64_t)exr_chunk_rows(part);
    return (height + rows - 1) / rows * (uint64_t)exr_chunk_columns(part);
}

static cau_result check_part(const ExrPart *part, uint64_t file_bytes, const char *path, CauError *err) {
    CAU_TRY(check_box(part->data_window, "data window", path, err));
    CAU_TRY(check_box(part->display_window, "display window", path, err));
    if (part->channel_count == 0 || part->channel_count > EXR_MOST_CHANNELS)
        return error_set(err, CAU_ERROR_INPUT, "\"%s\": a part has %zu channels, not 1 to %d", path,
            part->channel_count, EXR_MOST_CHANNELS);
    if (!isfinite(part->pixel_aspect) || part->pixel_aspect <= 0)
        return error_set(err, CAU_ERROR_INPUT, "\"%s\": the pixel aspect %g is no ratio", path,
            (double)part->pixel_aspect);
    if (part->tiled && (part->tile_width < 1 || part->tile_height < 1 ||
                           part->tile_width > EXR_LARGEST_SIDE || part->tile_height > EXR_LARGEST_SIDE))
        return error_set(err, CAU_ERROR_INPUT, "\"%s\": tiles of %u x %u pixels", path, part->tile_width,
            part->tile_height);
    /* Each chunk has an entry in the table and at least a coordinate, a size and a byte. */
    uint64_t chunks = chunk_count(part);
    if (chunks > file_bytes / 17)
        return error_set(err, CAU_ERROR_INPUT,
            "\"%s\": the header promises %" PRIu64 " chunks, too many for a file of %" PRIu64
            " bytes: it is damaged or cut off",
            path, chunks, file_bytes);
    uint64_t pixels =
        (uint64_t)exr_box_width(part->data_window) * (uint64_t)exr_box_height(part->data_window);
    uint64_t bytes = pixels * exr_part_pixel_bytes(part); /* 2^16 * 2^16 * 2^12 at most */
    if (bytes > harmless_bytes && bytes / (uint64_t)largest_ratio[part->codec] > file_bytes)
        return error_set(err, CAU_ERROR_INPUT,
            "\"%s\": the header promises %" PRIu64 " bytes of pixels in a file of %" PRIu64
            ", more than %s can hold: it is damaged",
            path, bytes, file_bytes, exr_codec_name(part->codec));
    return CAU_OK;
}

cau_result exr_limits_check(const ExrHeader *header, int64_t file_bytes, const char *path, CauError *err) {
    if (header->part_count < 1 || header->part_count > EXR_MOST_PARTS)
        return error_set(err, CAU_ERROR_INPUT, "\"%s\" has %zu parts, not 1 to %d", path, header->part_count,
            EXR_MOST_PARTS);
    for (size_t i = 0; i < header->part_count; i++)
        if (!header->parts[i].deep) CAU_TRY(check_part(&header->parts[i], (uint64_t)file_bytes, path, err));
    return CAU_OK;
}
