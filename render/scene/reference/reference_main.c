/* SPDX-License-Identifier: Apache-2.0 */
/* scene_reference markdown > docs/scene-reference.md
 * scene_reference schema > docs/scene.schema.json */
#include "render/scene/reference/reference.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

bool reference_has_default(const Param *p) {
    if ((p->flags & PARAM_REQUIRED) || isnan(p->def[0])) return false;
    return p->type == PARAM_CHOICE || p->type == PARAM_FLAGS || p->type == PARAM_BOOL ||
           (p->def[0] >= p->min && p->def[0] <= p->max);
}

int main(int argc, char **argv) {
    if (argc == 2 && strcmp(argv[1], "schema") == 0) return reference_schema();
    if (argc == 2 && strcmp(argv[1], "markdown") == 0) {
        reference_markdown();
        return 0;
    }
    fprintf(stderr, "usage: scene_reference markdown|schema\n");
    return 2;
}
