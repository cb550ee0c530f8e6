/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The command line of caustic-merge. */
#ifndef COMPOSITE_CLI_ARGUMENTS_H
#define COMPOSITE_CLI_ARGUMENTS_H

#include "caustics/composite.h"
#include "core/error.h"

#include <stdbool.h>

typedef struct Arguments {
    const char *command; /**< "add"; NULL when none was given */
    const char **files;  /**< what is no option, in order */
    size_t file_count;
    cau_merge_options options; /**< files not filled in; `lights` belongs to this structure */
    cau_merge_light *lights;
    char **light_names; /**< storage for lights[i].light */
    size_t light_count;
    const char **holdout_names; /**< storage for options.holdout_names */
    size_t holdout_name_count;
    const char *output, *frames, *report;
    const char *from_nuke, *from_blender, *to_scene;
    bool quiet, help, version, resume, json;
    bool any_option; /**< any that changes what a command does */
} Arguments;

/** CAU_ERROR_USAGE with a sentence for anything that cannot be understood. Free in any case. */
cau_result arguments_parse(Arguments *out, int argc, char **argv, CauError *err);
void arguments_free(Arguments *arguments);

/** At most 40 lines, an example first. */
const char *arguments_help(void);

#endif
