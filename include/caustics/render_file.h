/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  A render's layers as an EXR file, and its figures as JSON (library caustics-io). */
#ifndef CAUSTICS_RENDER_FILE_H
#define CAUSTICS_RENDER_FILE_H

#include "caustics/render.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct cau_write_options {
    size_t size;                       /**< sizeof(cau_write_options) */
    int half;                          /**< 1: 16-bit channels, clamped and counted; 0: 32-bit */
    int interleave;                    /**< 1: all channels in one part; 0: a part per layer */
    int crop;                          /**< 1: the data window is the rendered region; 0: the whole picture */
    int complete;                      /**< 0: marked as incomplete */
    uint64_t seed, photons;            /**< for the header */
    unsigned shard_index, shard_count; /**< for the header; both 0: no shard */
    int stamp; /**< 1: the header says what made the file (CAU_ATTRIBUTE_STAMP), for cau_render_is_written()
                */
} cau_write_options;

/** Writes all layers of an ended render to `path`, atomically: part 0 is the sum of all direct and indirect
 *  radiance layers. A beauty layer is written as channels R, G, B alone. */
CAU_API cau_result cau_render_write(
    cau_render *render, cau_scene *scene, const char *path, const cau_write_options *options);

/** Is `path` what this render would write with these options: whole, and with their stamp? A render need not
 * be started to know. */
CAU_API int cau_render_is_written(
    const cau_render *render, const char *path, const cau_write_options *options);

/** The layer name of light or group `index` (0 .. cau_render_light_count() - 1), e.g. "caustics_key"; `out`
 * has room for `size` bytes (32 are enough). *mapped becomes 1 when it is not simply "caustics_" + the
 * light's name: worth telling the user; the header keeps the original. */
CAU_API cau_result cau_render_layer_name(
    cau_render *render, cau_scene *scene, size_t index, char *out, size_t size, int *mapped);

/** cau_render_save() into a file, atomically: the file is the old state or the new one, never half. */
CAU_API cau_result cau_render_save_file(cau_render *render, cau_scene *scene, const char *path);
/** cau_render_load() from a file. */
CAU_API cau_result cau_render_load_file(cau_render *render, cau_scene *scene, const char *path);
/** cau_render_join() from a file. */
CAU_API cau_result cau_render_join_file(cau_render *render, cau_scene *scene, const char *path);

/** Writes the figures of an ended render (error, flux, photons per light, seconds) as JSON. */
CAU_API cau_result cau_render_write_report(cau_render *render, cau_scene *scene, const char *path);

#ifdef __cplusplus
}
#endif
#endif
