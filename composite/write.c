/* SPDX-License-Identifier: Apache-2.0 */
/* The output: the beauty's own header and channels, with the target's three channels and our record
 * exchanged. */
#include "composite/stream.h"
#include "core/file_atomic.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static cau_result choose_codecs(const Job *job, ExrHeader *header) {
    ExrCodec wanted = EXR_CODEC_ZIP;
    if (job->options->compression && !exr_codec_from_name(job->options->compression, &wanted))
        return error_set(job->err, CAU_ERROR_USAGE,
            "unknown compression \"%s\", not one of none, rle, zips, zip, piz, pxr24, b44, b44a, dwaa, dwab",
            job->options->compression);
    size_t lossy = header->part_count;
    for (size_t i = 0; i < header->part_count; i++) {
        ExrPart *part = &header->parts[i];
        if (exr_codec_is_lossy(part->codec) && lossy == header->part_count) lossy = i;
        if (job->options->compression || exr_codec_is_lossy(part->codec)) part->codec = wanted;
        part->levels = EXR_LEVELS_ONE;
    }
    if (lossy < header->part_count && !job->options->compression)
        job_notice(job,
            "the beauty is compressed with loss (%s): it is written as zip, so that nothing is lost twice "
            "(--compression overrides)",
            exr_codec_name(job->beauty.header->parts[lossy].codec));
    return CAU_OK;
}

/* Room for a count that is known only at the end. */
static cau_result add_count(ExrPart *part, const char *name, CauError *err) {
    return exr_attr_set_int32(part, name, 0, err);
}

static cau_result patch_count(const Job *job, const char *file, const char *name, uint64_t count) {
    int32_t before = 0; /* of an earlier add to the same picture */
    exr_attr_int32(exr_attr_find(&job->beauty.header->parts[0], name), &before);
    count += before > 0 ? (uint64_t)before : 0;
    if (count == 0) return CAU_OK;
    return exr_writer_patch_int(
        file, job->options->output, name, count > INT32_MAX ? INT32_MAX : (int32_t)count, job->err);
}

static cau_result build_header(const Job *job, ExrHeader *header) {
    CAU_TRY(exr_header_copy(header, job->beauty.header, job->err));
    CAU_TRY(choose_codecs(job, header));
    ExrPart *first = &header->parts[0];
    CAU_TRY(add_count(first, CAU_ATTRIBUTE_REPAIRED_NAN, job->err));
    CAU_TRY(add_count(first, CAU_ATTRIBUTE_CLAMPED, job->err));
    if (job->incomplete) CAU_TRY(exr_attr_set_int32(first, CAU_ATTRIBUTE_COMPLETE, 0, job->err));
    if (job->stamp) CAU_TRY(exr_attr_set_text(first, CAU_ATTRIBUTE_STAMP, job->stamp, job->err));
    char *record = recipe_record(job);
    cau_result result = record ? exr_attr_set_text(first, CAU_ATTRIBUTE_MERGE, record, job->err)
                               : error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for the record");
    free(record);
    CAU_TRY(result);
    if (job->kept_count) CAU_TRY(keep_header(job, header));
    const char *id = space_id(job->colour, job->beauty_space);
    if (job->beauty_tag == COLOUR_TAG_NONE)
        return colour_tag_replace(header, job->target->part, id, job->err);
    return id ? colour_tag_add(header, job->target->part, id, job->err) : CAU_OK;
}

static cau_result write_temporary(Job *job, const ExrHeader *header, const char *path) {
    ExrWriter *writer = NULL;
    cau_result result = exr_writer_open(&writer, path, job->options->output, header, job->err);
    if (result == CAU_OK) result = stream_run(job, header, writer);
    if (result == CAU_OK)
        result = exr_writer_close(&writer, job->err);
    else
        exr_writer_abort(&writer);
    if (result == CAU_OK) result = patch_count(job, path, CAU_ATTRIBUTE_REPAIRED_NAN, job->repaired);
    if (result == CAU_OK) result = patch_count(job, path, CAU_ATTRIBUTE_CLAMPED, job->clamped);
    return result == CAU_OK ? job_poll(job) : result;
}

static cau_result write_file(Job *job, const ExrHeader *header) {
    FileAtomic file;
    CAU_TRY(file_atomic_begin(&file, job->options->output, job->err));
    cau_result result = write_temporary(job, header, file.temp_path);
    if (result == CAU_OK) return file_atomic_commit(&file, job->err);
    file_atomic_abort(&file);
    return result;
}

static void say_counts(const Job *job) {
    if (job->repaired)
        job_notice(job, "%" PRIu64 " NaN or infinite values of the caustics became 0", job->repaired);
    if (job->clamped)
        job_notice(job, "%" PRIu64 " values were too large for the beauty's type and were cut", job->clamped);
}

/* What is shown is what was written. */
static cau_result show(const Job *job) {
    Picture picture;
    cau_result result = picture_open(&picture, job->options->output, job->err);
    const ExrLayer *layer = NULL;
    for (size_t i = 0; result == CAU_OK && i < picture.layers.count; i++) {
        const ExrLayer *l = &picture.layers.layers[i];
        if (l->part == job->target->part && l->rgb[0] == job->target->rgb[0]) layer = l;
    }
    if (result == CAU_OK)
        result = layer
                     ? preview_write(job, &picture, layer)
                     : error_set(job->err, CAU_ERROR_INTERNAL, "\"%s\" lost its layer", job->options->output);
    picture_close(&picture);
    return result;
}

static cau_result write_recipe(const Job *job) {
    char *text = recipe_text(job);
    if (!text) return error_set(job->err, CAU_ERROR_RESOURCE, "out of memory for the recipe");
    cau_result result = file_write_atomic(job->options->write_recipe, text, strlen(text), job->err);
    free(text);
    return result;
}

cau_result job_write(Job *job) {
    ExrHeader header = {0};
    cau_result result = build_header(job, &header);
    if (result == CAU_OK) result = write_file(job, &header);
    exr_header_free(&header);
    if (result == CAU_OK) say_counts(job);
    if (result == CAU_OK && job->options->write_recipe) result = write_recipe(job);
    if (result == CAU_OK && job->options->preview) result = show(job);
    if (result == CAU_OK && job->options->contact_sheet) result = sheet_write(job);
    return result;
}
