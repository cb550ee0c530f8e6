/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The command line of caustic-accuracy. */
#ifndef ACCURACY_OPTIONS_H
#define ACCURACY_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

enum { LADDER_MAX = 16, ESTIMATORS_MAX = 4 };

typedef struct Options {
    const char *scene;
    const char *reference; /**< EXR file, or NULL: rendered */
    const char *cycles;    /**< Python script that renders the scene in Blender, or NULL */
    const char *folder;    /**< where files go, or NULL: the table on standard output is all */
    uint64_t ladder[LADDER_MAX];
    int rungs;
    int estimators[ESTIMATORS_MAX]; /**< CAU_ESTIMATOR_* */
    int estimator_count;
    uint64_t reference_photons; /**< 0: 16 times the largest rung */
    uint64_t seed;
    unsigned threads;
    int width, height; /**< 0: the scene's */
    bool indirect, quiet;
} Options;

/** Parses the command line. Returns -1 to go on, or the exit code (after --help, --version or a usage error,
 *  which it has printed). Strings point into argv. */
int options_parse(int argc, char **argv, Options *out);

#endif
