/* SPDX-License-Identifier: Apache-2.0 */
#include "caustics/composite.h"
#include "caustics/layers.h"

int composite_header_c99(void);
int composite_header_c99(void) { return (int)sizeof(cau_merge_options) + CAU_LAYER_BIAS; }
