/* SPDX-License-Identifier: Apache-2.0 */
/* The output: the beauty's own header and channels, with the target's three channels and our record
 * exchanged. */
#include "composite/band.h"
#include "composite/job.h"
#include "core/checked.h"
#include "core/file_atomic.h"
#include "image/exr_writer.h"

static cau_result choose_codecs(const Job *job, ExrHeader *header) {
    ExrCodec wanted = EXR_CODEC_ZIP;
    if (job->options->compression && !exr_codec_from_name(job->options->compression, &wanted))
        return error_set(job->err, CAU_ERROR_USAGE,
            "unknown compression \"%s\", not one of none, rle, zips, zip, piz, pxr24, b44, b44a, dwaa, dwab",
            job->options->compression);
    for (size_t i = 0; i < header->part_count; i++) {
        ExrPart *part = &header->parts[i];
        if (exr_codec_is_lossy(part->codec) && !job->options->compression)
            job_notice(job,
                "part %zu of the beauty is compressed with loss (%s): it is written as zip, so that "
                "nothing is lost twice (--compression overrides)",
                i, exr_codec_name(part->codec));
        if (job->options->compression || exr_codec_is_lossy(part->codec)) part->codec = wanted;
        part->levels = EXR_LEVELS_ONE;
    }
    return CAU_OK;
}

static cau_result add_count(ExrPart *part, const char *name, uint64_t count, CauError *err) {
    int32_t before = 0; /* of an earlier add to the same picture */
    exr_attr_int32(exr_attr_find(part, name), &before);
    count += before > 0 ? (uint64_t)before : 0;
    return exr_attr_set_int32(part, name, count > INT32_MAX ? INT32_MAX : (int32_t)count, err);
}

static cau_result build_header(const Job *job, ExrHeader *header) {
    CAU_TRY(exr_header_copy(header, job->beauty.header, job->err));
    CAU_TRY(choose_codecs(job, header));
    ExrPart *first = &header->parts[0];
    CAU_TRY(add_count(first, CAU_ATTRIBUTE_REPAIRED_NAN, job->repaired, job->err));
    CAU_TRY(add_count(first, CAU_ATTRIBUTE_CLAMPED, job->clamped, job->err));
    if (job->incomplete) CAU_TRY(exr_attr_set_int32(first, CAU_ATTRIBUTE_COMPLETE, 0, job->err));
    char *record = recipe_record(job);
    cau_result result = record ? exr_attr_set_text(first, CAU_ATTRIBUTE_MERGE, record, job->err)
                               : error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for the record");
    free(record);
    CAU_TRY(result);
    const char *id = space_id(job->colour, job->beauty_space);
    if (job->beauty_tag == COLOUR_TAG_NONE)
        return colour_tag_replace(header, job->target->part, id, job->err);
    return id ? colour_tag_add(header, job->target->part, id, job->err) : CAU_OK;
}

/* The band's planes, with those of the target pointing into the result. */
static void exchange(const Job *job, const void **planes, const ExrPart *part, int32_t y0) {
    size_t first = (size_t)((int64_t)y0 - part->data_window.y0) * (size_t)exr_box_width(part->data_window);
    for (int c = 0; c < 3; c++) {
        int channel = job->target->rgb[c];
        planes[channel] = (const char *)job->result[c] + first * exr_type_bytes(part->channels[channel].type);
    }
}

static cau_result write_part(const Job *job, ExrWriter *writer, const ExrHeader *header, size_t index,
    Band *band, const void **planes) {
    const ExrPart *part = &header->parts[index];
    for (size_t b = 0; b < exr_band_count(part); b++) {
        int32_t y0, y1;
        exr_band_at(part, b, &y0, &y1);
        CAU_TRY(job_poll(job));
        CAU_TRY(exr_reader_band(job->beauty.reader, index, y0, y1, band->planes, job->err));
        for (size_t c = 0; c < part->channel_count; c++) planes[c] = band->planes[c];
        if (index == job->target->part) exchange(job, planes, part, y0);
        CAU_TRY(exr_writer_band(writer, index, y0, y1, planes, job->err));
    }
    return CAU_OK;
}

static cau_result write_parts(const Job *job, ExrWriter *writer, const ExrHeader *header) {
    cau_result result = CAU_OK;
    for (size_t i = 0; result == CAU_OK && i < header->part_count; i++) {
        Band band;
        CAU_TRY(band_create(&band, &header->parts[i], NULL, job->err));
        const void **planes = array_new(band.count, sizeof *planes);
        result = planes ? write_part(job, writer, header, i, &band, planes)
                        : error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for a list of channels");
        free(planes);
        band_free(&band);
    }
    return result;
}

static cau_result write_file(const Job *job, const ExrHeader *header) {
    FileAtomic file;
    ExrWriter *writer = NULL;
    CAU_TRY(file_atomic_begin(&file, job->options->output, job->err));
    cau_result result = exr_writer_open(&writer, file.temp_path, job->options->output, header, job->err);
    if (result == CAU_OK) result = write_parts(job, writer, header);
    if (result == CAU_OK)
        result = exr_writer_close(&writer, job->err);
    else
        exr_writer_abort(&writer);
    if (result == CAU_OK) result = job_poll(job);
    if (result == CAU_OK) return file_atomic_commit(&file, job->err);
    file_atomic_abort(&file);
    return result;
}

static cau_result write_preview(const Job *job) {
    const ExrPart *part = &job->beauty.header->parts[job->target->part];
    size_t width = (size_t)exr_box_width(part->data_window),
           height = (size_t)exr_box_height(part->data_window);
    float *rgb = array_new(width * height, 3 * sizeof *rgb);
    if (!rgb) return error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for the preview");
    for (size_t i = 0; i < width * height; i++)
        for (int c = 0; c < 3; c++)
            rgb[3 * i + (size_t)c] =
                (float)sample_get(job->result[c], i, part->channels[job->target->rgb[c]].type);
    cau_result result = preview_write(job, rgb, width, height);
    free(rgb);
    return result;
}

cau_result job_write(Job *job) {
    ExrHeader header = {0};
    cau_result result = build_header(job, &header);
    if (result == CAU_OK) result = write_file(job, &header);
    exr_header_free(&header);
    if (result == CAU_OK && job->options->preview) result = write_preview(job);
    return result;
}
