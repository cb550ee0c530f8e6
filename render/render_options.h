/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The command line of caustic-render. */
#ifndef RENDER_RENDER_OPTIONS_H
#define RENDER_RENDER_OPTIONS_H

#include "caustics/render.h"

#include <stdbool.h>

typedef struct RenderArguments {
    const char *scene, *output, *report, *checkpoint;
    const char *const *joined; /**< state files of shards, see --join */
    size_t joined_count;
    const char *frames;    /**< a range, see core/frames.h; NULL: one picture */
    int first, last, step; /**< what it says */
    double checkpoint_s;   /**< between two checkpoints */
    cau_render_options options;
    bool half, interleave, crop, explain, quiet, progress, resume;
} RenderArguments;

/** Parses the command line. Returns -1 to go on, or the exit code (after --help, --version or a usage error,
 *  which it has printed). Strings point into argv. */
int render_arguments_parse(int argc, char **argv, RenderArguments *out);

#endif
