/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Channels grouped into layers by their names: "ViewLayer.Combined.R" is channel R of layer
 * "ViewLayer.Combined". Where channels are bare (R,G,B), the part's name tells layers apart. */
#ifndef IMAGE_EXR_LAYERS_H
#define IMAGE_EXR_LAYERS_H

#include "image/exr_header.h"

typedef struct ExrLayer {
    char *name; /**< "ViewLayer.Combined"; the part's name, or "", for bare channels */
    bool bare;
    size_t part;
    int rgb[3]; /**< channels R, G, B in the part; -1 where there is none */
    int luma;   /**< channel Y or V; -1 */
    size_t channel_count;
} ExrLayer;

typedef struct ExrLayers {
    ExrLayer *layers;
    size_t count, capacity;
} ExrLayers;

cau_result exr_layers_find(ExrLayers *out, const ExrHeader *header, CauError *err);
void exr_layers_free(ExrLayers *layers);

static inline bool exr_layer_is_rgb(const ExrLayer *l) {
    return l->rgb[0] >= 0 && l->rgb[1] >= 0 && l->rgb[2] >= 0;
}
/** What follows the last dot of a layer's name: the pass, in Blender's words. */
const char *exr_layer_pass(const ExrLayer *layer);
/** The name for messages: "R,G,B" when there is none. */
const char *exr_layer_shown(const ExrLayer *layer);

#endif
