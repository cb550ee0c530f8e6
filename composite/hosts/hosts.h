/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The picture's sum as nodes of a host: plan -> a Nuke or Blender script, and the values of its panel back
 *  into a recipe or a scene file. */
#ifndef COMPOSITE_HOSTS_HOSTS_H
#define COMPOSITE_HOSTS_HOSTS_H

#include "composite/job.h"

#include <stdio.h>

enum { HOST_NAME_MAX = 63 };

/** The settings of a light, or of its indirect layer alone: one block of the panel. */
typedef struct HostControl {
    char key[HOST_NAME_MAX + 1]; /**< "caustics_key"; "caustics_key_ind" */
    int of;                      /**< index of the light whose settings count as well; -1 */
    bool saturates;              /**< its saturation is a setting too */
    Setting setting;
} HostControl;

/** A layer that is added. */
typedef struct HostLayer {
    const ExrLayer *layer; /**< of the caustics */
    int control;
    bool times_albedo; /**< and divided by pi */
} HostLayer;

/** A file as the script names it. */
typedef struct HostPath {
    char *path; /**< absolute, or relative to the script's folder */
    bool relative;
} HostPath;

/** What a script builds: beauty + to_beauty x sum of factor x to_tint x layer. */
typedef struct HostPlan {
    Picture caustics, beauty;
    bool has_beauty;
    HostPath caustics_path, beauty_path; /**< the beauty's is NULL when it is not known */
    Lights lights;
    const ExrLayer *target, *albedo; /**< of the beauty; NULL: its picture; no albedo */
    Conversion conversion;
    bool has_to_tint, has_to_beauty; /**< whether those matrices are more than the identity */
    char *tint_space;                /**< NULL: the beauty's */
    int32_t shift_x, shift_y;        /**< caustics pixel = beauty pixel + shift */
    bool has_frames;
    int first, last;
    HostControl *controls;
    HostLayer *layers;
    size_t control_count, layer_count;
} HostPlan;

/** `options->beauty` is an output of `add`, or a caustics file. */
cau_result host_plan(
    HostPlan *out, const cau_merge_options *options, const int frames[2], const char *script, CauError *err);
void host_plan_free(HostPlan *plan);

cau_result host_paths(HostPlan *plan, const char *file, const char *caustics, const char *beauty,
    const char *script, CauError *err);
/** `recorded` as it can be opened from here: itself, or beside `file`; to be freed. */
cau_result host_find_input(char **out, const char *recorded, const char *file, CauError *err);

cau_result host_write_nuke(FILE *out, const HostPlan *plan, CauError *err);
cau_result host_write_blender(FILE *out, const HostPlan *plan, CauError *err);

enum { HOST_NUMBER_MAX = 32 };
/** The shortest decimal that reads as the same double, in HOST_NUMBER_MAX bytes. */
void host_number(char *out, double value);

/** Values read back are Lights without layers: names as in a recipe, settings in `both`. */

/** The light of that name, made when there is none yet; "caustics_" is left away. */
cau_result host_light(Light **out, Lights *lights, const char *name, CauError *err);
/** The panel of a .nk file, as caustic-merge wrote it or Nuke saved it. */
cau_result host_read_nuke(Lights *out, const char *path, CauError *err);
/** A .blend file, by running Blender ($BLENDER or "blender"), or a script that host_write_blender() wrote. */
cau_result host_read_blender(Lights *out, const char *path, CauError *err);
/** A recipe's text; `from` names it in messages. */
cau_result host_read_recipe(Lights *out, const char *json, const char *from, CauError *err);
/** A recipe's JSON text; to be freed. NULL when out of memory. */
char *host_recipe_text(const Lights *lights);

/** Multiplies the lights of a scene file; nothing else in it changes, not even a blank. */
cau_result host_to_scene(const Lights *lights, const char *scene, CauError *err);

/** The whole of a text file of at most 64 MiB, to be freed. */
cau_result host_read_file(char **out, size_t *size, const char *path, CauError *err);

#endif
