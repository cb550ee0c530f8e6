/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Ranges of frames, and the place for a frame's number in the name of a file: "####" or "%04d". */
#ifndef CORE_FRAMES_H
#define CORE_FRAMES_H

#include "core/error.h"

#include <stdbool.h>
#include <stddef.h>

/** Where the number goes in `pattern`: its beginning, its length and its least number of digits. False: it
 * has no place. */
bool frame_place(const char *pattern, size_t *begin, size_t *length, int *digits);

/** `pattern` with the frame's number, to be freed by the caller; NULL without a place or out of memory. */
char *frame_name(const char *pattern, int frame);

/** "A", "A-B" or "A-BxS", 0 <= A <= B, S >= 1. */
cau_result frames_parse(const char *text, int *first, int *last, int *step, CauError *err);

#endif
