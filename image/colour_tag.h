/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What an EXR header says of its colour space, in the order in which it is believed: acesImageContainerFlag,
 *  colorInteropID, chromaticities, and Blender's signature (its files are linear Rec.709 and do not say so).
 */
#ifndef IMAGE_COLOUR_TAG_H
#define IMAGE_COLOUR_TAG_H

#include "image/exr_header.h"

typedef enum ColourTagSource {
    COLOUR_TAG_NONE,
    COLOUR_TAG_ACES,           /**< acesImageContainerFlag */
    COLOUR_TAG_ID,             /**< colorInteropID, whatever its case */
    COLOUR_TAG_CHROMATICITIES, /**< within 0.001 of a known space */
    COLOUR_TAG_BLENDER
} ColourTagSource;

enum { COLOUR_ID_MAX = 63 };

typedef struct ColourTag {
    ColourTagSource source;
    char id[COLOUR_ID_MAX + 1];  /**< a Color Interop Forum name in lower case; "" with COLOUR_TAG_NONE */
    bool unknown_chromaticities; /**< there are some, but of no space in our list */
} ColourTag;

/** Looks in `part`, then in the first part unless that one holds no colour (its name is "data"). */
void colour_tag_read(ColourTag *out, const ExrHeader *header, size_t part);

/** What else the header says, of lesser rank than what is believed and other than it; false when nothing. */
bool colour_tag_other(ColourTag *out, const ExrHeader *header, size_t part, const ColourTag *believed);

/** Known interchange names, and the other names under which configurations list the same space. */
size_t colour_id_count(void);
const char *colour_id_at(size_t index);
const char *colour_id_other_name(size_t index, size_t which);

/** Makes the header say `id` where it says nothing. */
cau_result colour_tag_add(ExrHeader *header, size_t part, const char *id, CauError *err);
/** Makes the header of `part` and of all parts that hold colour say `id`, and nothing that contradicts it.
 * `id` NULL: the space has no interchange name, so only what contradicts is removed. */
cau_result colour_tag_replace(ExrHeader *header, size_t part, const char *id, CauError *err);

#endif
