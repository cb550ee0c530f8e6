/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What the stages of one `add` pass on: open -> match -> gain -> add and write, band by band. A stage fills
 * its own fields and reads those above it. */
#ifndef COMPOSITE_JOB_H
#define COMPOSITE_JOB_H

#include "bridge/colour.h"
#include "caustics/composite.h"
#include "image/colour_tag.h"
#include "image/exr_layers.h"
#include "image/exr_reader.h"
#include "image/exr_writer.h"
#include "image/layer_names.h"

/** One open file and what is in it. */
typedef struct Picture {
    ExrReader *reader;
    const ExrHeader *header; /**< the reader's */
    ExrLayers layers;
} Picture;

/** What the user asked of one layer, or of both layers of a light. */
typedef struct Setting {
    double gain, ev, tint[3], temperature_k, saturation;
    bool mute, solo;
} Setting;

/** The layers of one light; -1 where it has none, else an index into the caustics' layers. */
typedef struct Light {
    char *name;  /**< original */
    char *base;  /**< "caustics_key" */
    char *place; /**< what a host put before it: "ViewLayer."; "" */
    int radiance, indirect, irradiance, seen;
    Setting both, indirect_only;
} Light;

typedef struct Lights {
    Light *lights;
    size_t count, capacity;
    char *tint_space; /**< as a recipe says; NULL */
} Lights;

/** A layer that is added: target += [albedo x] matrix x layer. */
typedef struct Term {
    int layer;         /**< in the caustics' layers */
    size_t light;      /**< whose it is */
    bool times_albedo; /**< and divided by pi, which is in the matrix already */
    bool diagonal;     /**< only the diagonal of the matrix counts: no colour conversion */
    double matrix[9];
} Term;

/** A layer of the beauty that is added to. */
typedef struct Target {
    const ExrLayer *layer;
    int light;               /**< only the terms of this light; -1: all */
    const ExrLayer *divisor; /**< the diffuse colour, by which Cycles divides its diffuse passes; NULL */
} Target;

/** A caustic layer that travels in the output as a part of its own. */
typedef struct Kept {
    int layer;    /**< in the caustics' layers */
    bool convert; /**< to the beauty's space */
} Kept;

/** Where caustics are kept off. */
typedef struct Holdout {
    Picture mask; /**< header NULL without one */
    size_t mask_part;
    int mask_channel;
    bool by_alpha;
    int alpha; /**< channel in the target's part */
    struct HoldoutRank {
        size_t part;
        int id, coverage; /**< channels */
    } * ranks;            /**< of the Cryptomattes that hold the names */
    size_t rank_count, rank_capacity;
    float *ids;
    size_t id_count;
} Holdout;

typedef struct Job {
    const cau_merge_options *options;
    CauError *err;
    const char *stamp; /**< of the inputs and settings, for the output's header; NULL */

    /* open */
    Picture beauty, caustics;
    Colour *colour;
    bool colour_lent; /**< by a sequence, for all its frames */

    /* match */
    const ExrLayer *target; /**< that of the first of `targets` */
    Target *targets;
    size_t target_count, target_capacity;
    const ExrLayer *albedo; /**< NULL without --albedo */
    Holdout holdout;
    Kept *kept;
    size_t kept_count;
    double keep_matrix[9]; /**< caustics' space to the beauty's */
    Lights lights;
    const char *beauty_space, *caustics_space, *tint_space; /**< the configuration's names */
    ColourTagSource beauty_tag;                             /**< COLOUR_TAG_NONE: the user said it */
    int32_t shift_x, shift_y;                               /**< caustics pixel = beauty pixel + shift */
    bool incomplete;                                        /**< the caustics are, and it was allowed */
    ColourView
        *view; /**< of the preview, opened early so that a wrong name fails before anything is written */

    /* gain */
    Term *terms;
    size_t term_count;

    /* stream */
    uint64_t repaired, clamped;
} Job;

cau_result job_open(Job *job);
cau_result job_match(Job *job);
cau_result job_gain(Job *job);
cau_result job_write(Job *job);
/** All of these, and job_close(); the counts stay. */
cau_result job_add(Job *job);
/** Refuses an output that is a device, or the very file `input` (NULL is allowed). */
cau_result output_check(const char *output, const char *input, CauError *err);
/** The colour configuration that the options name. */
cau_result job_open_colour(Colour **out, const cau_merge_options *o, CauError *err);
/** Joins shards; see cau_merge_shards(). */
cau_result shards_join(const char *const *files, size_t count, const cau_merge_options *o, CauError *err);
/** What bands on their way may take: options->memory_bytes, or 1 GB. */
static inline size_t job_memory(const cau_merge_options *o) {
    return o->memory_bytes ? o->memory_bytes : (size_t)1 << 30;
}
/** A guess at what one thread of an add takes, from the largest band. */
size_t job_lane_bytes(const ExrHeader *beauty, const ExrHeader *caustics);
/** The frames of a sequence, several at once. */
cau_result sequence_run(const cau_merge_options *o, const cau_merge_frames *frames, CauError *err);
enum { STAMP_MAX = 40 };
/** A hash of what the inputs hold and of all settings that change the output. */
cau_result stamp_make(char out[STAMP_MAX], const cau_merge_options *o, CauError *err);
/** Whether `file` is a whole output of that stamp. */
bool stamp_matches(const char *file, const char *stamp);
/** open -> preview: shows one layer of the beauty. */
cau_result job_preview(Job *job);
void job_close(Job *job);

/** Forgets the last call's error; the record for this one. */
CauError *merge_begin(cau_merge *merge);
/** Copies what a caller gave, and refuses what cannot be meant. */
cau_result options_take(cau_merge_options *out, const cau_merge_options *given, CauError *err);

/** Tells the user something that is no error. */
void job_notice(const Job *job, const char *format, ...) __attribute__((format(printf, 2, 3)));
/** CAU_ERROR_CANCELLED once the user has asked to stop. */
cau_result job_poll(const Job *job);

cau_result picture_open(Picture *out, const char *path, CauError *err);
void picture_close(Picture *picture);
/** The layer `wanted` names (whole name, or the part after the last dot), with R, G and B. */
cau_result picture_find_layer(
    const ExrLayer **out, const Picture *picture, const char *wanted, const char *option, CauError *err);
/** The layer to add to, or to show, when none is named: Combined, else plain R,G,B. */
cau_result picture_default_layer(
    const ExrLayer **out, const Picture *picture, const char *option, CauError *err);
/** Refuses what cannot be read: deep or sub-sampled parts. */
cau_result picture_check_readable(const Picture *picture, CauError *err);

/** Finds the light layers by the header's list, or by their names. */
cau_result lights_find(Lights *out, const Picture *caustics, CauError *err);
void lights_free(Lights *lights);
/** The light a user's `name` means; *indirect_only when it is the name of an indirect layer. */
cau_result lights_match(
    Light **out, bool *indirect_only, const Lights *lights, const char *name, CauError *err);

/** The part whose header says the space of a picture: of its light, else of its Combined or plain R,G,B, else
 * the first. */
size_t picture_colour_part(const Picture *picture, const Lights *lights);

/** The passes to add to besides the target: light groups, direct diffuse. */
cau_result targets_find(Job *job);

cau_result holdout_open(Job *job);
void holdout_close(Holdout *holdout);
static inline bool holdout_any(const Holdout *h) { return h->mask.header || h->by_alpha || h->rank_count; }
/** The float whose bits are the Cryptomatte id of a name. */
float holdout_name_id(const char *name);

/** Chooses the layers that travel in the output. */
cau_result keep_choose(Job *job);
/** Appends their parts to the output's header, and says in it what they are. */
cau_result keep_header(const Job *job, ExrHeader *header);

/** The space of a picture: `said`, or what its header says of `part`. Must be linear. */
cau_result space_find(const char **out, ColourTagSource *source, const Job *job, const Picture *picture,
    size_t part, const char *said, const char *option);
/** A space the user named, which must be linear. */
cau_result space_named(const char **out, const Job *job, const char *name, const char *option);
/** The interchange name of a space, or NULL. */
const char *space_id(const Colour *colour, const char *space);
/** The configuration's space of that interchange name, or NULL. */
const char *space_of_id(const Colour *colour, const char *id);

/** Between the spaces of the caustics, the tints and the beauty. */
typedef struct Conversion {
    double to_tint[9], to_beauty[9], direct[9];
    double luminance[3];   /**< weights in the tint's space; where a light has a temperature or saturation */
    double from_rec709[9]; /**< to the tint's space; likewise */
    bool same;             /**< caustics and beauty share a space */
    bool tint_in_beauty;
} Conversion;

/** From job->colour, the three spaces and the lights. */
cau_result conversion_find(Conversion *out, const Job *job);
/** Multiplies by what turns light of 6500 K into light of that temperature and the same luminance. */
void conversion_warm(double factor[3], const Conversion *c, double kelvin);

/** Nothing asked for. */
extern const Setting setting_plain;
/** The linear Rec.709 of a black body of `kelvin`, divided by that of 6500 K; luminance about 1. False beyond
 * 1667..25000 K. */
bool black_body_rgb(double rgb[3], double kelvin);

/** Applies a recipe file to the lights. */
cau_result recipe_apply(Lights *lights, const char *path, CauError *err);
/** The same from JSON text; `from` names it in messages. */
cau_result recipe_apply_text(Lights *lights, const char *json, const char *from, CauError *err);
/** Applies one entry. */
cau_result setting_apply(Lights *lights, const cau_merge_light *entry, CauError *err);
/** The settings as the text of a recipe file; to be freed. NULL when out of memory. */
char *recipe_text(const Job *job);
/** JSON record of what was done, for the output's header; to be freed. NULL when out of memory. */
char *recipe_record(const Job *job);

/** Opens the preview's view. */
cau_result preview_open(Job *job);
/** Before, each light, their sum and after as options->contact_sheet. */
cau_result sheet_write(const Job *job);
/** Shows a layer of `picture`, which is in the beauty's space, as options->preview. */
cau_result preview_write(const Job *job, const Picture *picture, const ExrLayer *layer);

#endif
