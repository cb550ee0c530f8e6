/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Adds caustic layers to a finished picture and relights them.
 *
 *  A cau_merge holds the first error of the last call as one sentence; it may be used again. Different
 * handles may be used by different threads. Callbacks come on the calling thread. No string or array given to
 * a call is kept. */
#ifndef CAUSTICS_COMPOSITE_H
#define CAUSTICS_COMPOSITE_H

#include "caustics/error.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cau_merge cau_merge;

/** Which fields of a cau_merge_light count. */
enum {
    CAU_MERGE_GAIN = 1 << 0,
    CAU_MERGE_EV = 1 << 1,
    CAU_MERGE_TINT = 1 << 2,
    CAU_MERGE_MUTE = 1 << 3,
    CAU_MERGE_SOLO = 1 << 4,
    CAU_MERGE_TEMPERATURE = 1 << 5,
    CAU_MERGE_SATURATION = 1 << 6
};

/** A light's factor is gain x 2^ev x tint x the colour of its temperature, after its saturation. `light` is
 * its original name, its layer's name, or that without "caustics_"; the name of an indirect layer means that
 * layer alone, NULL means every light. A later entry for the same light wins, field by field. */
typedef struct cau_merge_light {
    const char *light;
    uint32_t set; /**< CAU_MERGE_... */
    double gain, ev, tint[3];
    double temperature_k; /**< of a black body, 1667 to 25000 K; 6500 changes nothing */
    double saturation;    /**< 0: grey of the same luminance, 1: unchanged, up to 100 */
} cau_merge_light;

/** Fill with zeros and set `size`; NULL and 0 are the defaults. */
typedef struct cau_merge_options {
    size_t size;          /**< sizeof(cau_merge_options) */
    const char *beauty;   /**< EXR file; required by cau_merge_add() */
    const char *caustics; /**< EXR file; required by cau_merge_add() */
    const char *output;   /**< EXR file; required by cau_merge_add() */
    const cau_merge_light *lights;
    size_t light_count;
    const char *recipe; /**< JSON file; `lights` wins over it */
    const char *pass;   /**< what is added to; default: Combined, or plain R,G,B */
    const char *albedo; /**< Diffuse Color pass: add pass x irradiance / pi + what is seen through glass */
    const char *ocio;   /**< colour configuration, "builtin", or "blender"; default $OCIO, then built-in */
    const char *beauty_space;   /**< default: what the beauty says of itself */
    const char *caustics_space; /**< default: what the caustics say of themselves */
    const char *tint_space;     /**< default: the beauty's */
    const char *compression;    /**< "none", "zip", ...; default: the beauty's, ZIP when that is lossy */
    const char *preview;        /**< PNG or JPEG file */
    const char *display, *view; /**< of the preview; default: the configuration's */
    int allow_incomplete;       /**< accept caustics whose render was stopped */
    int has_offset;             /**< the beauty was cropped and lost its place: */
    int offset_x, offset_y;     /**< where its first pixel lies in the whole picture */
    void *user;                 /**< given to the callbacks */
    void (*notice)(void *user, const char *sentence); /**< what the user should know, though it is no error */
    int (*cancelled)(void *user); /**< nonzero: stop, leave the old output, return CAU_ERROR_CANCELLED */
    const char *look;             /**< of the preview; default: none but the view's */
    double preview_ev;            /**< exposure of the preview, in stops */
    const char *contact_sheet;    /**< PNG or JPEG file: before, each light, their sum, after */
    const char *write_recipe;     /**< JSON file: what was applied, as a recipe */
    int into_groups;              /**< each light also into the pass Combined_NAME of its light group */
    int into_diffuse; /**< all also into the direct diffuse pass, divided by the diffuse colour as Cycles does
                       */
    int keep_layers;  /**< the caustic layers travel in the output, unchanged but for the space */
    const char *holdout;              /**< EXR mask, "FILE" or "FILE:CHANNEL": no light where it is 1 */
    int holdout_alpha;                /**< no light where the target's alpha is 0 */
    const char *const *holdout_names; /**< Cryptomatte names in the beauty: no light on them */
    size_t holdout_name_count;
    unsigned threads;    /**< 0: one per processor */
    size_t memory_bytes; /**< for bands on their way; 0: 1 GB. Less memory means fewer threads */
} cau_merge_options;

CAU_API cau_result cau_merge_create(cau_merge **out);
/** NULL inside is allowed; *merge becomes NULL. */
CAU_API void cau_merge_destroy(cau_merge **merge);
/** The sentence of the last call's error; "" when it succeeded. Valid until the next call. */
CAU_API const char *cau_merge_error(const cau_merge *merge);

/** Writes options->output = beauty + sum of factor x light layer, atomically. */
CAU_API cau_result cau_merge_add(cau_merge *merge, const cau_merge_options *options);

/** A sequence. `beauty`, `caustics` and `output` of the options hold "####" or "%04d", and so do all other
 * outputs; other inputs may. */
typedef struct cau_merge_frames {
    size_t size; /**< sizeof(cau_merge_frames) */
    int first, last, step;
    const char *report; /**< JSON file: what became of each frame; NULL */
    int resume;         /**< leave frames alone whose output has the stamp of these inputs and settings */
    /** Called in the order of the frames, on the calling thread. `sentence`: the error, or "done" or
     * "skipped". */
    void (*frame)(void *user, int frame, const char *output, cau_result result, const char *sentence);
} cau_merge_frames;

/** cau_merge_add() for every frame, several at once within options->threads and options->memory_bytes. A
 * frame whose inputs are missing or broken is told and the others are done; then the result is
 * CAU_ERROR_INPUT. A full disk, no memory and a cancel end the run. */
CAU_API cau_result cau_merge_add_frames(
    cau_merge *merge, const cau_merge_options *options, const cau_merge_frames *frames);

/** Shows layer `pass` of options->beauty (any EXR file) as options->preview. Of a caustics file,
 * without `pass`, the sum in its first part. */
CAU_API cau_result cau_merge_preview(cau_merge *merge, const cau_merge_options *options);

typedef enum cau_merge_host { CAU_MERGE_NUKE = 0, CAU_MERGE_BLENDER = 1 } cau_merge_host;

/** Writes the sum as nodes of a host, with a panel of every light's settings: a .nk file, or a Python script
 * for Blender 3.4 to 5.x. options->beauty is an output of cau_merge_add(), which records its inputs, recipe
 * and spaces, or a caustics file; `recipe` and `lights` win over the record. With `frames` (first, last) it
 * is a pattern with #### or %04d. Goes to options->output, or without one to `text`. */
CAU_API cau_result cau_merge_script(cau_merge *merge, cau_merge_host host, const cau_merge_options *options,
    const int frames[2], void (*text)(void *user, const char *text), void *user);

typedef enum cau_merge_source {
    CAU_MERGE_FROM_NUKE = 0, /**< a .nk file */
    CAU_MERGE_FROM_BLENDER =
        1,                    /**< a .blend file, which runs Blender ($BLENDER or "blender"), or our script */
    CAU_MERGE_FROM_RECIPE = 2 /**< a recipe */
} cau_merge_source;

/** Reads every light's settings back. They go as a recipe to the file `output`, and, multiplied into the
 * lights' strengths and colours, into the file `scene`, which is otherwise unchanged; with neither, as a
 * recipe to `text`. Both names may be NULL. A muted light's strength becomes 0. */
CAU_API cau_result cau_merge_recipe(cau_merge *merge, cau_merge_source source, const char *file,
    const char *output, const char *scene, void (*text)(void *user, const char *text), void *user);

/** Says what a file holds, line by line. */
CAU_API cau_result cau_merge_list(
    cau_merge *merge, const char *file, void (*line)(void *user, const char *text), void *user);

/** The same as a JSON object, with the plan and the errors of the render; `text` is called once. */
CAU_API cau_result cau_merge_list_json(
    cau_merge *merge, const char *file, void (*text)(void *user, const char *text), void *user);

/** Says in what two files differ - parts, channels, attributes, pixels bit for bit - line by line;
 * CAU_ERROR_INPUT when in anything. Channels are matched by name, whatever part they are in. */
CAU_API cau_result cau_merge_diff(
    cau_merge *merge, const char *a, const char *b, void (*line)(void *user, const char *text), void *user);

/** Joins renders of one scene made with different seeds, or as shards, into options->output: the mean of each
 * layer, weighted by photons; errors are combined, biases averaged. Refuses what does not belong together and
 * names the difference. Of the options `output`, `compression`, `allow_incomplete`, `threads`, `memory_bytes`
 * and the callbacks count. */
CAU_API cau_result cau_merge_shards(
    cau_merge *merge, const char *const *files, size_t count, const cau_merge_options *options);

/** Reads every pixel of a file and says what is wrong with it, line by line; CAU_ERROR_INPUT when anything
 * is. */
CAU_API cau_result cau_merge_check(
    cau_merge *merge, const char *file, void (*line)(void *user, const char *text), void *user);

#ifdef __cplusplus
}
#endif
#endif
