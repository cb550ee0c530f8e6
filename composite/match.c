/* SPDX-License-Identifier: Apache-2.0 */
/* What is added to what: the pass, the light layers, the pixels' places, the colour spaces. */
#include "composite/job.h"

#include <inttypes.h>
#include <math.h>

static const ExrPart *target_part(const Job *job) { return &job->beauty.header->parts[job->target->part]; }

/* The part of the first light layer, for what all have alike; in *window what all of them cover. */
static const ExrPart *caustics_part(const Job *job, ExrBox *window) {
    const ExrPart *first = NULL;
    for (size_t i = 0; i < job->lights.count; i++) {
        const Light *l = &job->lights.lights[i];
        const int layers[] = {l->radiance, l->indirect, l->irradiance, l->seen};
        for (size_t k = 0; k < sizeof layers / sizeof *layers; k++) {
            if (layers[k] < 0) continue;
            const ExrPart *part = &job->caustics.header->parts[job->caustics.layers.layers[layers[k]].part];
            *window = first ? exr_box_union(*window, part->data_window) : part->data_window;
            if (!first) first = part;
        }
    }
    if (!first) *window = job->caustics.header->parts[0].data_window;
    return first ? first : &job->caustics.header->parts[0];
}

static cau_result match_target(Job *job) {
    const char *pass = job->options->pass;
    CAU_TRY(pass ? picture_find_layer(&job->target, &job->beauty, pass, "--pass", job->err)
                 : picture_default_layer(&job->target, &job->beauty, "--pass", job->err));
    for (int c = 0; c < 3; c++) {
        const ExrChannel *channel = &target_part(job)->channels[job->target->rgb[c]];
        if (channel->type == EXR_TYPE_UINT)
            return error_set(job->err, CAU_ERROR_INPUT,
                "\"%s\": channel \"%s\" holds whole numbers, to which light cannot be added: save it as half "
                "or float",
                job->options->beauty, channel->name);
    }
    if (job->options->albedo)
        return picture_find_layer(&job->albedo, &job->beauty, job->options->albedo, "--albedo", job->err);
    return CAU_OK;
}

static cau_result match_lights(Job *job) {
    CAU_TRY(lights_find(&job->lights, &job->caustics, job->err));
    for (size_t i = 0; i < job->lights.count; i++)
        if (job->lights.lights[i].radiance >= 0 || job->lights.lights[i].indirect >= 0 ||
            (job->albedo && job->lights.lights[i].irradiance >= 0))
            return CAU_OK;
    return error_set(job->err, CAU_ERROR_INPUT,
        "\"%s\" has no light layers: their channels are called %sNAME.R, .G and .B", job->options->caustics,
        CAU_LAYER_PREFIX);
}

static cau_result check_complete(Job *job) {
    int32_t complete = 1;
    if (!exr_attr_int32(exr_attr_find(&job->caustics.header->parts[0], CAU_ATTRIBUTE_COMPLETE), &complete) ||
        complete)
        return CAU_OK;
    if (!job->options->allow_incomplete)
        return error_set(job->err, CAU_ERROR_INPUT,
            "\"%s\" is the state of a render that was stopped (%s is 0): finish it, or accept it with "
            "--allow-incomplete",
            job->options->caustics, CAU_ATTRIBUTE_COMPLETE);
    job->incomplete = true;
    job_notice(job, "\"%s\" is incomplete; the output is marked so too", job->options->caustics);
    return CAU_OK;
}

static cau_result check_frame(const Job *job, const ExrPart *b, const ExrPart *c) {
    if (exr_box_width(b->display_window) != exr_box_width(c->display_window) ||
        exr_box_height(b->display_window) != exr_box_height(c->display_window))
        return error_set(job->err, CAU_ERROR_INPUT,
            "the pictures differ in size: \"%s\" is %" PRId64 " x %" PRId64 ", \"%s\" is %" PRId64
            " x %" PRId64 "; render both alike, or give --offset X,Y if the beauty was cropped",
            job->options->beauty, exr_box_width(b->display_window), exr_box_height(b->display_window),
            job->options->caustics, exr_box_width(c->display_window), exr_box_height(c->display_window));
    return CAU_OK;
}

static cau_result match_windows(Job *job) {
    ExrBox v;
    const ExrPart *b = target_part(job), *c = caustics_part(job, &v);
    if (fabsf(b->pixel_aspect - c->pixel_aspect) > 1e-4f * b->pixel_aspect)
        return error_set(job->err, CAU_ERROR_INPUT, "the pixel aspects differ: %g in \"%s\", %g in \"%s\"",
            (double)b->pixel_aspect, job->options->beauty, (double)c->pixel_aspect, job->options->caustics);
    if (job->options->has_offset) {
        job->shift_x = job->options->offset_x - b->data_window.x0;
        job->shift_y = job->options->offset_y - b->data_window.y0;
    } else {
        CAU_TRY(check_frame(job, b, c));
    }
    ExrBox w = b->data_window;
    int64_t x0 = (int64_t)w.x0 + job->shift_x, x1 = (int64_t)w.x1 + job->shift_x;
    int64_t y0 = (int64_t)w.y0 + job->shift_y, y1 = (int64_t)w.y1 + job->shift_y;
    if (x1 < v.x0 || x0 > v.x1 || y1 < v.y0 || y0 > v.y1)
        return error_set(job->err, CAU_ERROR_INPUT,
            "the pictures do not overlap: \"%s\" covers (%" PRId64 ",%" PRId64 ")-(%" PRId64 ",%" PRId64
            "), \"%s\" covers (%d,%d)-(%d,%d)",
            job->options->beauty, x0, y0, x1, y1, job->options->caustics, v.x0, v.y0, v.x1, v.y1);
    if (v.x0 < x0 || v.x1 > x1 || v.y0 < y0 || v.y1 > y1)
        job_notice(job,
            "the caustics cover (%d,%d)-(%d,%d), the beauty only (%" PRId64 ",%" PRId64 ")-(%" PRId64
            ",%" PRId64 "): what lies outside is dropped",
            v.x0, v.y0, v.x1, v.y1, x0, y0, x1, y1);
    return CAU_OK;
}

static void say_levels(const Job *job, const Picture *picture) {
    for (size_t i = 0; i < picture->header->part_count; i++)
        if (picture->header->parts[i].tiled && picture->header->parts[i].levels != EXR_LEVELS_ONE) {
            job_notice(job, "\"%s\" is mip-mapped: level 0 is used, the smaller levels are not written",
                exr_reader_path(picture->reader));
            return;
        }
}

cau_result job_match(Job *job) {
    const cau_merge_options *o = job->options;
    ColourTagSource unused;
    CAU_TRY(match_target(job));
    CAU_TRY(match_lights(job));
    CAU_TRY(targets_find(job));
    CAU_TRY(holdout_open(job));
    CAU_TRY(check_complete(job));
    CAU_TRY(match_windows(job));
    say_levels(job, &job->beauty);
    say_levels(job, &job->caustics);
    CAU_TRY(space_find(&job->beauty_space, &job->beauty_tag, job, &job->beauty, job->target->part,
        o->beauty_space, "--beauty-space"));
    CAU_TRY(space_find(&job->caustics_space, &unused, job, &job->caustics,
        picture_colour_part(&job->caustics, &job->lights), o->caustics_space, "--caustics-space"));
    if (o->keep_layers) CAU_TRY(keep_choose(job));
    job->tint_space = job->beauty_space;
    if (o->tint_space) CAU_TRY(space_named(&job->tint_space, job, o->tint_space, "--tint-space"));
    if (o->preview || o->contact_sheet) CAU_TRY(preview_open(job));
    if (exr_attr_find(&job->beauty.header->parts[0], CAU_ATTRIBUTE_MERGE))
        job_notice(job, "\"%s\" is itself an output of caustic-merge add: make sure nothing is added twice",
            o->beauty);
    return CAU_OK;
}
