/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Attributes between OpenEXRCore's structures and the bytes of the file. */
#ifndef IMAGE_EXR_ATTR_IO_H
#define IMAGE_EXR_ATTR_IO_H

#include "image/exr_core.h"
#include "image/exr_header.h"

/** Appends to part->attrs what the library read. */
cau_result exr_attr_from_core(ExrPart *part, const exr_attribute_t *attr, CauError *err);

/** Adds an attribute to part `index` of a file that is being defined. Strings are kept by reference: `attr`
 * must live until the header is written. */
exr_result_t exr_attr_to_core(exr_context_t context, int index, const ExrAttr *attr);

#endif
