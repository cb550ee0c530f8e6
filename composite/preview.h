/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  From linear values to a file for looking at. */
#ifndef COMPOSITE_PREVIEW_H
#define COMPOSITE_PREVIEW_H

#include "composite/job.h"

/** Refuses a name that ends in neither .png nor .jpg; NULL is allowed. */
cau_result preview_check_name(const char *path, CauError *err);
/** Exposure, look and view: interleaved RGB of the beauty's space, which is changed, to 8 bits. */
cau_result preview_show(const Job *job, float *rgb, size_t width, size_t height, uint8_t *out);
/** Atomically, as PNG or JPEG by the name. */
cau_result preview_save(const char *path, const uint8_t *rgb, size_t width, size_t height, CauError *err);

#endif
