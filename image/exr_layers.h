/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Channels grouped into layers by their names: "ViewLayer.Combined.R" is channel R of layer
 * "ViewLayer.Combined". Where channels are bare (R,G,B), the part's name tells layers apart. The views of a
 * stereo picture are parts with an attribute "view", or words in the channels' names
 * ("ViewLayer.Combined.left.R") that the attribute "multiView" lists, the first of them for bare channels. */
#ifndef IMAGE_EXR_LAYERS_H
#define IMAGE_EXR_LAYERS_H

#include "image/exr_header.h"

typedef struct ExrLayer {
    char *name;     /**< "ViewLayer.Combined"; the part's name, or "", for bare channels */
    char *full;     /**< the name for people: with the view where that is said elsewhere */
    char *view;     /**< of a stereo picture: "left"; NULL */
    char *pass;     /**< the last word of the name but for the view: "Combined" */
    size_t pass_at; /**< where the pass begins in the name */
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
/** The name for messages: "R,G,B" when there is none. */
const char *exr_layer_shown(const ExrLayer *layer);
/** Both of the same view, or of none. */
bool exr_layer_same_view(const ExrLayer *a, const ExrLayer *b);

#endif
