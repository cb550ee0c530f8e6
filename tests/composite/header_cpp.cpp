// SPDX-License-Identifier: Apache-2.0
#include "caustics/composite.h"
#include "caustics/layers.h"

int composite_header_cpp();
int composite_header_cpp() { return static_cast<int>(sizeof(cau_merge_options)) + CAU_LAYER_BIAS; }
