/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IMAGE_EXR_SCAN_H
#define IMAGE_EXR_SCAN_H

#include "core/error.h"

/** Checks that the sizes in a file's headers are those of their types and lie within the file. OpenEXR's C++
 * library believes what they say: 2 kB of damage make it fill 4 GB. */
cau_result exr_scan(const char *path, CauError *err);

#endif
