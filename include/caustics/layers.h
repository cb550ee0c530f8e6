/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  What the renderer and the compositor agree on: the names of layers and of header attributes.
 *
 *  A light's layers are CAU_LAYER_PREFIX + the light's name + one of the suffixes below; channels are the
 * layer name, a dot and R, G or B. The header attribute CAU_ATTRIBUTE_LAYERS says which layer is what, as a
 * JSON list of {"layer", "light", "kind"}: "light" is the original name, which the layer's name may have had
 * to change. */
#ifndef CAUSTICS_LAYERS_H
#define CAUSTICS_LAYERS_H

#ifdef __cplusplus
extern "C" {
#endif

#define CAU_LAYER_PREFIX "caustics_"

/** Suffixes; reserved, so that a light's own name never ends in one. */
#define CAU_SUFFIX_INDIRECT "_ind"
#define CAU_SUFFIX_IRRADIANCE "_E"
#define CAU_SUFFIX_SEEN "_S"
#define CAU_SUFFIX_ERROR "_err"
#define CAU_SUFFIX_BIAS "_bias"

/** Header attributes, all in the first part. */
#define CAU_ATTRIBUTE_LAYERS "caustics/layers"     /**< string: JSON list of {layer, light, kind} */
#define CAU_ATTRIBUTE_COMPLETE "caustics/complete" /**< int: 1, or 0 for a render that was stopped */
#define CAU_ATTRIBUTE_SCENE_HASH "caustics/scene_hash"
#define CAU_ATTRIBUTE_SEED "caustics/seed" /**< string: a number; several, with commas, of joined shards */
#define CAU_ATTRIBUTE_PHOTONS "caustics/photons"           /**< string: a number */
#define CAU_ATTRIBUTE_SHARD "caustics/shard"               /**< string: "2/8" */
#define CAU_ATTRIBUTE_PLAN "caustics/plan"                 /**< string: what was computed how */
#define CAU_ATTRIBUTE_ERROR "caustics/error"               /**< string: JSON, relative errors of each light */
#define CAU_ATTRIBUTE_REPAIRED_NAN "caustics/repaired_nan" /**< int: NaN and Inf values that became 0 */
#define CAU_ATTRIBUTE_CLAMPED "caustics/clamped" /**< int: values cut to the largest of their type */
#define CAU_ATTRIBUTE_MERGE "caustics/merge"     /**< string: JSON, what `caustic-merge add` did */
#define CAU_ATTRIBUTE_STAMP                                                                                  \
    "caustics/stamp" /**< string: hash of inputs and settings, of frames of a sequence */
#define CAU_ATTRIBUTE_COLOR_ID "colorInteropID" /**< string: the colour space, by the ASWF's list */

/** What a layer holds. In quotes: its name in CAU_ATTRIBUTE_LAYERS. */
typedef enum cau_layer_kind {
    CAU_LAYER_RADIANCE = 0,   /**< "radiance": added to the beauty */
    CAU_LAYER_INDIRECT = 1,   /**< "indirect": added to the beauty */
    CAU_LAYER_IRRADIANCE = 2, /**< "irradiance": what falls on the receiver, before its colour */
    CAU_LAYER_SEEN = 3,  /**< "seen": radiance seen through glass or in mirrors, beside an irradiance layer */
    CAU_LAYER_ERROR = 4, /**< "error": standard error of the radiance or indirect layer it is named after */
    CAU_LAYER_BIAS = 5   /**< "bias": estimated bias, likewise */
} cau_layer_kind;

#ifdef __cplusplus
}
#endif
#endif
