/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  From the name of a light or light group to the name of its layer, and the list of layers in the header.
 *
 *  Hosts differ in what they make of dots, spaces, leading digits and long names, so a layer's name is
 * letters, digits and underscores, short enough that the channel of its longest-named companion
 * ("_ind_bias.R") fits in the 31 characters every EXR reader takes. A name that had to be shortened, that
 * clashes with another or ends like one of our suffixes, ends in four hexadecimal digits of a hash of the
 * original. */
#ifndef IMAGE_LAYER_NAMES_H
#define IMAGE_LAYER_NAMES_H

#include "caustics/layers.h"
#include "core/error.h"

#include <stdbool.h>
#include <stddef.h>

enum { LAYER_BASE_MAX = 20 }; /**< 31 - strlen("_ind_bias.R") */

typedef struct LayerBase {
    char name[LAYER_BASE_MAX + 1]; /**< "caustics_key"; append a suffix for the other kinds */
    bool mapped;                   /**< differs from CAU_LAYER_PREFIX + the light's name: report it */
} LayerBase;

/** Names for `count` lights, all different. The result for a light does not depend on the order of the
 * others, unless two lights have the very same name. `out` has room for `count`. */
cau_result layer_names_map(const char *const *lights, size_t count, LayerBase *out, CauError *err);

/** One entry of CAU_ATTRIBUTE_LAYERS. */
typedef struct LayerEntry {
    char *layer; /**< "caustics_key_ind" */
    char *light; /**< the original name, "Key.001" */
    cau_layer_kind kind;
} LayerEntry;

typedef struct LayerList {
    LayerEntry *entries;
    size_t count, capacity;
} LayerList;

/** Copies both names. */
cau_result layer_list_add(
    LayerList *list, const char *layer, const char *light, cau_layer_kind kind, CauError *err);
void layer_list_free(LayerList *list);

/** JSON for the header, to be freed; NULL when out of memory or a name is not UTF-8. */
char *layer_list_encode(const LayerList *list);
/** Reads what layer_list_encode() wrote. An unknown kind or key, a missing key, a layer named twice: error.
 */
cau_result layer_list_decode(LayerList *out, const char *json, CauError *err);

/** "radiance", "indirect", "irradiance", "seen", "error", "bias". */
const char *cau_layer_kind_name(cau_layer_kind kind);
bool layer_kind_from_name(const char *name, cau_layer_kind *out);

/** Judges a layer by its name alone: "caustics_X_ind" is the indirect layer of light "X". False when the name
 * does not begin with CAU_LAYER_PREFIX. `light` has room for strlen(layer) + 1. */
bool layer_name_parse(const char *layer, char *light, cau_layer_kind *kind);

#endif
