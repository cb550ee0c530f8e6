/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Colour spaces by OpenColorIO: names, matrices between linear spaces, display views. */
#ifndef BRIDGE_COLOUR_H
#define BRIDGE_COLOUR_H

#include "core/error.h"

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct Colour Colour;
typedef struct ColourView ColourView;

typedef enum ColourKind {
    COLOUR_LINEAR,  /**< scene-referred and linear: light can be added */
    COLOUR_ENCODED, /**< scene-referred with a curve: logarithmic, sRGB texture */
    COLOUR_DISPLAY, /**< after a view */
    COLOUR_DATA     /**< not a colour */
} ColourKind;

/** `config`: a file, "builtin", or NULL for $OCIO and, where that is not set, the built-in one. A
 * configuration that is named but cannot be used is an error; nothing takes its place. */
cau_result colour_open(Colour **out, const char *config, CauError *err);
void colour_close(Colour **colour);

/** "the built-in colour configuration" or "the colour configuration \"/path\"", for messages. */
const char *colour_origin(const Colour *colour);

/** The configuration's own name for a space, alias or role; NULL when there is none. Valid until
 * colour_close(). */
const char *colour_resolve(const Colour *colour, const char *name);
size_t colour_name_count(const Colour *colour);
const char *colour_name_at(const Colour *colour, size_t index);
/** Aliases of a space, for finding its interchange name; NULL beyond the last. */
const char *colour_alias_at(const Colour *colour, const char *space, size_t index);
ColourKind colour_kind(const Colour *colour, const char *space);

/** The matrix (row by row) that takes RGB in `from` to RGB in `to`, both linear. `*same` when none is needed.
 */
cau_result colour_matrix(
    const Colour *colour, const char *from, const char *to, double matrix[9], bool *same, CauError *err);

/** `display`, `view`: NULL for the configuration's default; `look`: NULL for none but the view's own. An
 * unknown one is an error that lists the others. */
cau_result colour_view_open(ColourView **out, const Colour *colour, const char *space, const char *display,
    const char *view, const char *look, CauError *err);
void colour_view_close(ColourView **view);
/** In place, interleaved RGB. */
cau_result colour_view_apply(const ColourView *view, float *rgb, size_t width, size_t height, CauError *err);

/** The text of the built-in configuration: no look-up tables, every matrix from the primaries. */
extern const char *const colour_builtin_config;

#ifdef __cplusplus
}
#endif
#endif
