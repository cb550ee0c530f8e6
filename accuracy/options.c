/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/options.h"

#include "caustics/render.h"
#include "core/nearest.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXIT_USAGE = 2 };

static const char help_text[] =
    "caustic-accuracy - what each bit of accuracy costs on a scene, for every estimator\n"
    "\n"
    "  caustic-accuracy scenes/a_ball.json --resolution 160x90 -o accuracy\n"
    "\n"
    "usage: caustic-accuracy SCENE [options]\n"
    "\n"
    "  -o DIR                 CSV, SVG plots, pictures and an HTML page; without it\n"
    "                         only the table on standard output\n"
    "  --ladder N,N,...       budgets in photons per light [1e4,3e4,1e5,3e5,1e6];\n"
    "                         as many camera paths with R and Cycles\n"
    "  --estimators LIST      of W,P,R,auto [W,P,R]\n"
    "  --reference FILE.exr   what is compared with, made by caustic-render\n"
    "  --reference-photons N  else rendered: W where it applies, or P, with so many\n"
    "                         photons [16 times the largest budget], another seed\n"
    "  --effects LIST         direct,indirect [direct,indirect]: what is compared\n"
    "  --cycles FILE.py       Cycles too, by scenes/blender_scenes.py in Blender\n"
    "  --resolution WxH       instead of the scene's\n"
    "  --threads T            of each render [1]\n"
    "  --seed K               first set of random numbers [0]; one for each budget\n"
    "  --quiet, --version, --help\n"
    "\n"
    "Each render is a process of its own: its CPU seconds and its peak memory.\n"
    "POV-Ray is not run. exit codes: 0 done, 1 bad input, or a --reference that the\n"
    "estimators contradict, 2 usage, 3 cancelled (what was measured is written),\n"
    "4 memory or disk\n";

static int usage_error(const char *option, const char *value, const char *want) {
    fprintf(
        stderr, "caustic-accuracy: %s is \"%s\"; it must be %s\n", option, value ? value : "(missing)", want);
    return EXIT_USAGE;
}

/* A whole number lo..hi, also as 1e5; `end` is where it ends. */
static bool parse_count(const char *text, double lo, double hi, uint64_t *out, char **end) {
    if (!text || !isdigit((unsigned char)*text)) return false;
    double x = strtod(text, end);
    if (!(x >= lo) || !(x <= hi) || x != floor(x)) return false;
    *out = (uint64_t)x;
    return true;
}

static bool parse_whole(const char *text, double lo, double hi, uint64_t *out) {
    char *end;
    return parse_count(text, lo, hi, out, &end) && *end == '\0';
}

static int parse_ladder(const char *value, Options *o) {
    static const char want[] = "1 to 16 rising whole numbers of 1 to 1e12 with commas, e.g. 1e4,3e4,1e5";
    const char *text = value;
    for (o->rungs = 0; text; o->rungs++) {
        char *end;
        uint64_t n;
        if (o->rungs == LADDER_MAX || !parse_count(text, 1, 1e12, &n, &end) || (*end && *end != ',') ||
            (o->rungs && n <= o->ladder[o->rungs - 1]))
            return usage_error("--ladder", value, want);
        o->ladder[o->rungs] = n;
        text = *end ? end + 1 : NULL;
    }
    return o->rungs ? -1 : usage_error("--ladder", value, want);
}

static const struct {
    const char *name;
    int estimator;
} estimators[] = {
    {"auto", CAU_ESTIMATOR_AUTO}, {"W", CAU_ESTIMATOR_W}, {"P", CAU_ESTIMATOR_P}, {"R", CAU_ESTIMATOR_R}};

static int parse_estimators(const char *value, Options *o) {
    o->estimator_count = 0;
    for (const char *text = value; text && *text;) {
        size_t n = strcspn(text, ","), i = 0;
        while (i < 4 && (strlen(estimators[i].name) != n || strncmp(estimators[i].name, text, n) != 0)) i++;
        for (int j = 0; i < 4 && j < o->estimator_count; j++)
            if (o->estimators[j] == estimators[i].estimator) i = 4;
        if (i == 4) return usage_error("--estimators", value, "a list of W, P, R and auto, each once");
        o->estimators[o->estimator_count++] = estimators[i].estimator;
        text += n + (text[n] == ',');
    }
    return o->estimator_count ? -1
                              : usage_error("--estimators", value, "a list of W, P, R and auto, each once");
}

static int parse_effects(const char *value, Options *o) {
    if (!value || (strcmp(value, "direct") != 0 && strcmp(value, "direct,indirect") != 0))
        return usage_error("--effects", value, "direct or direct,indirect");
    o->indirect = strchr(value, ',') != NULL;
    return -1;
}

static int parse_file(const char *option, const char *value, const char **out) {
    *out = value;
    return value && value[0] && strcmp(value, "-") != 0 ? -1 : usage_error(option, value, "a file name");
}

static int parse_resolution(const char *value, Options *o) {
    char *end;
    uint64_t w, h;
    if (!parse_count(value, 1, 65536, &w, &end) || *end != 'x' || !parse_whole(end + 1, 1, 65536, &h))
        return usage_error("--resolution", value, "WxH, each from 1 to 65536");
    o->width = (int)w;
    o->height = (int)h;
    return -1;
}

/* An option with a value. -1: taken; -2: not one of these; else the exit code. */
static int parse_valued(const char *option, const char *value, Options *o) {
    uint64_t n;
    if (strcmp(option, "-o") == 0) return parse_file(option, value, &o->folder);
    if (strcmp(option, "--reference") == 0) return parse_file(option, value, &o->reference);
    if (strcmp(option, "--cycles") == 0) return parse_file(option, value, &o->cycles);
    if (strcmp(option, "--ladder") == 0) return parse_ladder(value, o);
    if (strcmp(option, "--estimators") == 0) return parse_estimators(value, o);
    if (strcmp(option, "--effects") == 0) return parse_effects(value, o);
    if (strcmp(option, "--resolution") == 0) return parse_resolution(value, o);
    if (strcmp(option, "--reference-photons") == 0)
        return parse_whole(value, 1, 1e15, &o->reference_photons)
                   ? -1
                   : usage_error(option, value, "a whole number from 1 to 1e15");
    if (strcmp(option, "--seed") == 0)
        return parse_whole(value, 0, 2147480000.0, &o->seed)
                   ? -1
                   : usage_error(option, value, "a whole number from 0 to 2147480000");
    if (strcmp(option, "--threads") == 0) {
        if (!parse_whole(value, 1, 1024, &n))
            return usage_error(option, value, "a whole number from 1 to 1024");
        o->threads = (unsigned)n;
        return -1;
    }
    return -2;
}

static int unknown_option(const char *option) {
    static const char *const known[] = {"-o", "--ladder", "--estimators", "--reference",
        "--reference-photons", "--effects", "--cycles", "--resolution", "--threads", "--seed", "--quiet",
        "--version", "--help"};
    fprintf(stderr, "caustic-accuracy: unknown option \"%s\"; did you mean \"%s\"?\n", option,
        known[nearest_name(option, known, sizeof known / sizeof *known)]);
    return EXIT_USAGE;
}

static int check(const Options *o) {
    if (!o->scene) {
        fprintf(stderr, "caustic-accuracy: no scene given; try caustic-accuracy --help\n");
        return EXIT_USAGE;
    }
    if (o->reference && o->reference_photons) {
        fprintf(
            stderr, "caustic-accuracy: --reference and --reference-photons exclude each other; leave one\n");
        return EXIT_USAGE;
    }
    if (o->cycles && !o->indirect) {
        fprintf(stderr, "caustic-accuracy: Cycles renders direct and indirect caustics together; leave "
                        "\"--effects direct\" or --cycles out\n");
        return EXIT_USAGE;
    }
    return -1;
}

int options_parse(int argc, char **argv, Options *out) {
    *out = (Options){.ladder = {10000, 30000, 100000, 300000, 1000000},
        .rungs = 5,
        .estimators = {CAU_ESTIMATOR_W, CAU_ESTIMATOR_P, CAU_ESTIMATOR_R},
        .estimator_count = 3,
        .threads = 1,
        .indirect = true};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) return fputs(help_text, stdout), 0;
        if (strcmp(argv[i], "--version") == 0) return printf("caustic-accuracy %s\n", cau_version()), 0;
        if (strcmp(argv[i], "--quiet") == 0) {
            out->quiet = true;
            continue;
        }
        if (argv[i][0] != '-' || strcmp(argv[i], "-") == 0) {
            if (out->scene || strcmp(argv[i], "-") == 0) {
                fprintf(stderr, "caustic-accuracy: \"%s\": exactly one scene file is wanted\n", argv[i]);
                return EXIT_USAGE;
            }
            out->scene = argv[i];
            continue;
        }
        char name[32], *equals = strchr(argv[i], '=');
        snprintf(name, sizeof name, "%.*s", equals ? (int)(equals - argv[i]) : 31, argv[i]);
        const char *value = equals ? equals + 1 : (i + 1 < argc ? argv[i + 1] : NULL);
        int code = parse_valued(name, value, out);
        if (code == -2) return unknown_option(argv[i]);
        if (code >= 0) return code;
        if (!equals) i++;
    }
    return check(out);
}
