/* SPDX-License-Identifier: Apache-2.0 */
/* What reading and writing a single-part scan-line file costs with OpenEXRCore's own routines and nothing
 * else, in one thread: the measure for caustic-merge. usage: bare_core IN.exr OUT.exr */
#include <openexr.h>

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

static void must(exr_result_t code, const char *what) {
    if (code == EXR_ERR_SUCCESS) return;
    fprintf(stderr, "bare_core: %s: %s\n", what, exr_get_error_code_as_string(code));
    exit(1);
}

static void open_out(exr_context_t in, exr_context_t *out, const char *path) {
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    const exr_attr_chlist_t *channels;
    init.zip_level = 4; /* as newer versions of the library, and as caustic-merge */
    must(exr_start_write(out, path, EXR_WRITE_FILE_DIRECTLY, &init), "create");
    int part;
    must(exr_add_part(*out, NULL, EXR_STORAGE_SCANLINE, &part), "add part");
    must(exr_copy_unset_attributes(*out, 0, in, 0), "copy attributes");
    must(exr_get_channels(in, 0, &channels), "channels");
    must(exr_write_header(*out), "write header");
}

int main(int argc, char **argv) {
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t in, out;
    exr_decode_pipeline_t decode = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_encode_pipeline_t encode = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_attr_box2i_t window;
    int32_t step;
    if (argc != 3) return 2;
    must(exr_start_read(&in, argv[1], &init), "open");
    open_out(in, &out, argv[2]);
    must(exr_get_data_window(in, 0, &window), "window");
    must(exr_get_scanlines_per_chunk(in, 0, &step), "chunks");
    size_t width = (size_t)(window.max.x - window.min.x + 1);
    uint8_t **planes = NULL;
    for (int y = window.min.y; y <= window.max.y; y += step) {
        exr_chunk_info_t info, to;
        must(exr_read_scanline_chunk_info(in, 0, y, &info), "find chunk");
        must(exr_write_scanline_chunk_info(out, 0, y, &to), "place chunk");
        must(planes ? exr_decoding_update(in, 0, &info, &decode)
                    : exr_decoding_initialize(in, 0, &info, &decode),
            "decoder");
        must(planes ? exr_encoding_update(out, 0, &to, &encode)
                    : exr_encoding_initialize(out, 0, &to, &encode),
            "encoder");
        if (!planes) planes = calloc((size_t)decode.channel_count, sizeof *planes);
        for (int c = 0; c < decode.channel_count; c++) {
            exr_coding_channel_info_t *a = &decode.channels[c], *b = &encode.channels[c];
            int bytes = a->bytes_per_element;
            if (!planes[c]) planes[c] = malloc(width * (size_t)step * (size_t)bytes);
            a->user_data_type = b->user_data_type = a->data_type;
            a->user_bytes_per_element = b->user_bytes_per_element = (int16_t)bytes;
            a->user_pixel_stride = b->user_pixel_stride = bytes;
            a->user_line_stride = b->user_line_stride = bytes * (int)width;
            a->decode_to_ptr = planes[c];
            b->encode_from_ptr = planes[c];
        }
        must(exr_decoding_choose_default_routines(in, 0, &decode), "decoder");
        must(exr_decoding_run(in, 0, &decode), "read");
        must(exr_encoding_choose_default_routines(out, 0, &encode), "encoder");
        must(exr_encoding_run(out, 0, &encode), "write");
    }
    exr_decoding_destroy(in, &decode);
    exr_encoding_destroy(out, &encode);
    must(exr_finish(&out), "finish");
    exr_finish(&in);
    return 0;
}
