/* SPDX-License-Identifier: Apache-2.0 */
/* libFuzzer target: any bytes as a picture. The last byte chooses what is done with it: listed, checked,
 * added to, added. See fuzz.sh. */
#include "caustics/composite.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void ignore(void *user, const char *text) {
    (void)user;
    (void)text;
}

static void add(cau_merge *merge, const char *beauty, const char *caustics) {
    cau_merge_options o = {.size = sizeof o,
        .beauty = beauty,
        .caustics = caustics,
        .output = getenv("FUZZ_OUTPUT"),
        .beauty_space = "ACEScg",
        .caustics_space = "ACEScg",
        .has_offset = 1,
        .threads = 1,
        .allow_incomplete = 1,
        .keep_layers = 1};
    cau_merge_add(merge, &o);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char path[64];
    cau_merge *merge = NULL;
    if (size < 1) return 0;
    int fd = memfd_create("picture", MFD_CLOEXEC);
    if (fd < 0 || cau_merge_create(&merge) != CAU_OK) abort();
    if (write(fd, data, size - 1) != (ssize_t)(size - 1)) abort();
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    switch (data[size - 1] % 8) {
    case 0:
        cau_merge_list_json(merge, path, ignore, NULL);
        cau_merge_list(merge, path, ignore, NULL);
        break;
    case 6:
        add(merge, path, getenv("FUZZ_CAUSTICS"));
        break;
    case 7:
        add(merge, getenv("FUZZ_BEAUTY"), path);
        break;
    default: /* most of them: it is the fastest, and reads all there is */
        cau_merge_check(merge, path, ignore, NULL);
    }
    cau_merge_destroy(&merge);
    close(fd);
    return 0;
}
