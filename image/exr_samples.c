/* SPDX-License-Identifier: Apache-2.0 */
#include "image/exr_samples.h"

void exr_samples(double *out, const uint8_t *row, size_t count, ExrPixelType type) {
    if (type == EXR_TYPE_FLOAT)
        for (size_t i = 0; i < count; i++) out[i] = exr_sample(row, i, EXR_TYPE_FLOAT);
    else if (type == EXR_TYPE_HALF)
        for (size_t i = 0; i < count; i++) out[i] = exr_sample(row, i, EXR_TYPE_HALF);
    else
        for (size_t i = 0; i < count; i++) out[i] = exr_sample(row, i, EXR_TYPE_UINT);
}
