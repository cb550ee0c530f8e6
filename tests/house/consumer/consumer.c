/* SPDX-License-Identifier: Apache-2.0 */
/* A program outside the project: each library answers. */
#include <caustics/composite.h>
#include <caustics/render_file.h>
#include <caustics/scene_file.h>

#include <stdio.h>
#include <string.h>

int main(void) {
    cau_context *context = NULL;
    cau_scene *scene = NULL;
    cau_merge *merge = NULL;
    int good = cau_context_create(&context) == CAU_OK;
    good = good && cau_scene_load_file(context, "there is no such file", &scene) != CAU_OK;
    good = good && strstr(cau_error_text(context), "no such file") != NULL;
    good = good && cau_merge_create(&merge) == CAU_OK;
    printf("%s\n", cau_version());
    cau_merge_destroy(&merge);
    cau_context_destroy(&context);
    return good ? 0 : 1;
}
