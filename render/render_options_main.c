/* SPDX-License-Identifier: Apache-2.0 */
#include "render/render_options.h"

#include "core/frames.h"
#include "core/nearest.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXIT_USAGE = 2 };
/* Less than shows beside a picture that took a hundred times as long. */
#define DEFAULT_ERROR 0.02

static const char help_text[] =
    "caustic-render - the light that glass, water and metal focus, one EXR layer per light\n"
    "\n"
    "  caustic-render still_life.json -o caustics.exr --error 0.05\n"
    "\n"
    "usage: caustic-render SCENE -o OUT.exr [options]\n"
    "\n"
    "  -o FILE                where the layers go; written beside and renamed when whole\n"
    "  --photons N            photons per light; of estimator R camera paths\n"
    "  --time S               stop after S seconds\n"
    "  --error E              stop when the error (RMSE / RMS of the layers) is E\n"
    "                         [0.02 or 4000000 photons, whichever comes first;\n"
    "                         frames, shards and R 4000000]\n"
    "  --seed K               another set of random numbers [0]\n"
    "  --threads T            [one per processor]; the bytes do not depend on it\n"
    "  --resolution WxH       instead of the scene's\n"
    "  --region X0,Y0,X1,Y1   only these pixels, ends exclusive\n"
    "  --estimator auto|W|P|R wavefronts, photons, or the unbiased reference [auto]\n"
    "  --effects LIST         direct,indirect [automatic]: what to compute\n"
    "  --layers LIST          radiance,indirect,irradiance,error,bias; beauty with R:\n"
    "                         what Cycles renders with caustics off\n"
    "  --type float|half      of the channels [float]\n"
    "  --interleave           all layers in one part\n"
    "  --crop                 data window = region\n"
    "  --memory SIZE          budget, e.g. 512M, 4G [2G]\n"
    "  --physical             scale radiance by n^2 as in nature, not as Cycles\n"
    "  --frames A-B[xS]       a picture per frame; #### or %04d in the names\n"
    "  --checkpoint FILE      keep the render's state there, so that a kill loses little\n"
    "  --checkpoint-every S   seconds between two [60]\n"
    "  --resume               go on from the checkpoint, if there is one: same bytes\n"
    "  --shard I/N            render only share I of N, with -o, --checkpoint or both\n"
    "  --join FILE...         last: the checkpoints of all shards become one picture\n"
    "  --explain              print the plan; without -o render nothing\n"
    "  --report FILE.json     figures: error, flux, seconds, memory\n"
    "  --progress             a line of JSON on standard error four times a second\n"
    "  --quiet, --version, --help\n"
    "\n"
    "exit codes: 0 done, 1 bad input, 2 usage, 3 cancelled (what exists is in\n"
    "NAME.incomplete.exr), 4 memory or disk\n";

static int usage_error(const char *option, const char *value, const char *want) {
    fprintf(
        stderr, "caustic-render: %s is \"%s\"; it must be %s\n", option, value ? value : "(missing)", want);
    return EXIT_USAGE;
}

static bool parse_double(const char *text, double lo, double *out) {
    char *end;
    if (!text || !*text || isspace((unsigned char)*text)) return false;
    errno = 0;
    *out = strtod(text, &end);
    return *end == '\0' && errno == 0 && isfinite(*out) && *out >= lo;
}

static bool parse_count(const char *text, double most, uint64_t *out) {
    double x;
    if (!parse_double(text, 0, &x) || x != floor(x) || x > most) return false;
    *out = (uint64_t)x;
    return true;
}

static bool parse_ints(const char *text, const char *separators, int *out, int count) {
    char *end;
    for (int i = 0; i < count; i++) {
        if (!text || (!isdigit((unsigned char)*text) && *text != '-')) return false;
        errno = 0;
        long v = strtol(text, &end, 10);
        if (errno || v < -1000000 || v > 1000000 || *end != (i + 1 < count ? separators[0] : '\0'))
            return false;
        out[i] = (int)v;
        text = end + 1;
    }
    return true;
}

static bool parse_size(const char *text, size_t *out) {
    char *end;
    if (!text || !isdigit((unsigned char)*text)) return false;
    errno = 0;
    double v = strtod(text, &end);
    switch (toupper((unsigned char)*end)) {
    case 'K':
        v *= 0x1p10, end++;
        break;
    case 'M':
        v *= 0x1p20, end++;
        break;
    case 'G':
        v *= 0x1p30, end++;
        break;
    default:
        break;
    }
    if (*end || errno || !(v >= 0x1p20) || !(v <= 0x1p50)) return false;
    *out = (size_t)v;
    return true;
}

typedef struct Word {
    const char *name;
    unsigned bit;
} Word;

/* A comma-separated list of known words as a mask; 0 and a printed error otherwise. */
static unsigned parse_words(const char *option, const char *text, const Word *words, size_t count) {
    unsigned mask = 0;
    const char *names[8];
    for (size_t i = 0; i < count; i++) names[i] = words[i].name;
    while (text && *text) {
        size_t n = strcspn(text, ","), i = 0;
        while (i < count && (strlen(words[i].name) != n || strncmp(words[i].name, text, n) != 0)) i++;
        if (i == count) {
            char word[32];
            snprintf(word, sizeof word, "%.*s", (int)(n < 31 ? n : 31), text);
            fprintf(stderr, "caustic-render: %s: unknown word \"%s\"; did you mean \"%s\"?\n", option, word,
                names[nearest_name(word, names, count)]);
            return 0;
        }
        mask |= words[i].bit;
        text += n + (text[n] == ',');
    }
    if (!mask) usage_error(option, text, "a list of words");
    return mask;
}

static int parse_estimator(const char *value, RenderArguments *a) {
    static const struct {
        const char *name;
        int estimator;
    } known[] = {
        {"auto", CAU_ESTIMATOR_AUTO}, {"W", CAU_ESTIMATOR_W}, {"P", CAU_ESTIMATOR_P}, {"R", CAU_ESTIMATOR_R}};
    for (size_t i = 0; value && i < sizeof known / sizeof *known; i++)
        if (strcmp(value, known[i].name) == 0) {
            a->options.estimator = known[i].estimator;
            return -1;
        }
    if (!value || strcmp(value, "D") != 0) return usage_error("--estimator", value, "auto, W, P or R");
    fprintf(stderr, "caustic-render: not yet supported: estimator D; use auto, W, P or R\n");
    return 1;
}

static int parse_effects(const char *value, RenderArguments *a) {
    static const Word words[] = {{"direct", 1}, {"indirect", 2}};
    unsigned mask = parse_words("--effects", value, words, 2);
    if (!mask) return EXIT_USAGE;
    a->options.indirect = mask & 2 ? CAU_INDIRECT_ON : CAU_INDIRECT_OFF;
    return -1;
}

static int parse_layers(const char *value, RenderArguments *a) {
    static const Word words[] = {{"radiance", CAU_WANT_RADIANCE}, {"indirect", CAU_WANT_INDIRECT},
        {"irradiance", CAU_WANT_IRRADIANCE}, {"error", CAU_WANT_ERROR}, {"bias", CAU_WANT_BIAS},
        {"beauty", CAU_WANT_BEAUTY}};
    a->options.layers = parse_words("--layers", value, words, 6);
    if (!a->options.layers) return EXIT_USAGE;
    if (!(a->options.layers & CAU_WANT_BEAUTY)) a->options.layers |= CAU_WANT_RADIANCE;
    return -1;
}

static int parse_type(const char *value, RenderArguments *a) {
    if (!value || (strcmp(value, "float") != 0 && strcmp(value, "half") != 0))
        return usage_error("--type", value, "float or half");
    a->half = value[0] == 'h';
    return -1;
}

static bool is_file_name(const char *value) { return value && value[0] && strcmp(value, "-") != 0; }

static int parse_files(const char *option, const char *value, RenderArguments *a) {
    if (strcmp(option, "-o") == 0 || strcmp(option, "--output") == 0) {
        a->output = value;
        return is_file_name(value) ? -1 : usage_error(option, value, "a file name (\"-\" is not one)");
    }
    if (strcmp(option, "--report") == 0) {
        a->report = value;
        return is_file_name(value) ? -1 : usage_error(option, value, "a file name");
    }
    if (strcmp(option, "--checkpoint") == 0) {
        a->checkpoint = value;
        return is_file_name(value) ? -1 : usage_error(option, value, "a file name");
    }
    return -2;
}

static int parse_frames(const char *value, RenderArguments *a) {
    CauError error = {0};
    a->frames = value;
    if (frames_parse(value ? value : "", &a->first, &a->last, &a->step, &error) == CAU_OK) return -1;
    fprintf(stderr, "caustic-render: %s\n", error.text);
    return EXIT_USAGE;
}

static int parse_shard(const char *option, const char *value, RenderArguments *a) {
    if (strcmp(option, "--checkpoint-every") == 0)
        return parse_double(value, 0, &a->checkpoint_s) ? -1 : usage_error(option, value, "seconds");
    if (strcmp(option, "--frames") == 0) return parse_frames(value, a);
    if (strcmp(option, "--shard") != 0) return -2;
    int shard[2] = {0, 0};
    bool ok = parse_ints(value, "/", shard, 2) && shard[0] >= 1 && shard[0] <= shard[1] &&
              shard[1] <= CAU_SHARDS_MAX;
    a->options.shard_index = (unsigned)shard[0];
    a->options.shard_count = (unsigned)shard[1];
    return ok ? -1 : usage_error(option, value, "I/N, I from 1 to N, N up to 65536");
}

/* An option with a value. -1: taken; -2: not one of these; else the exit code. */
static int parse_valued(const char *option, const char *value, RenderArguments *a) {
    cau_render_options *o = &a->options;
    uint64_t n;
    bool ok;
    int code = parse_files(option, value, a);
    if (code == -2) code = parse_shard(option, value, a);
    if (code != -2) return code;
    if (strcmp(option, "--photons") == 0) {
        ok = parse_count(value, 1e15, &o->photons) && o->photons > 0;
        return ok ? -1 : usage_error(option, value, "a whole number from 1 to 1e15");
    }
    if (strcmp(option, "--time") == 0)
        return parse_double(value, 0, &o->time_s) && o->time_s > 0
                   ? -1
                   : usage_error(option, value, "seconds, more than 0");
    if (strcmp(option, "--error") == 0)
        return parse_double(value, 0, &o->error) && o->error > 0
                   ? -1
                   : usage_error(option, value, "a number more than 0, e.g. 0.05");
    if (strcmp(option, "--seed") == 0)
        return parse_count(value, 9007199254740992.0, &o->seed)
                   ? -1
                   : usage_error(option, value, "a whole number, at least 0");
    if (strcmp(option, "--threads") == 0) {
        ok = parse_count(value, 1024, &n) && n > 0;
        o->threads = ok ? (unsigned)n : 0;
        return ok ? -1 : usage_error(option, value, "a whole number from 1 to 1024");
    }
    if (strcmp(option, "--resolution") == 0) {
        int size[2] = {0, 0};
        ok = parse_ints(value, "x", size, 2) && size[0] > 0 && size[1] > 0 && size[0] <= 65536 &&
             size[1] <= 65536;
        o->width = size[0];
        o->height = size[1];
        return ok ? -1 : usage_error(option, value, "WxH, each from 1 to 65536");
    }
    if (strcmp(option, "--region") == 0)
        return parse_ints(value, ",", o->region, 4) ? -1 : usage_error(option, value, "X0,Y0,X1,Y1");
    if (strcmp(option, "--memory") == 0)
        return parse_size(value, &o->memory_bytes)
                   ? -1
                   : usage_error(option, value, "a size of at least 1M, e.g. 512M");
    if (strcmp(option, "--estimator") == 0) return parse_estimator(value, a);
    if (strcmp(option, "--effects") == 0) return parse_effects(value, a);
    if (strcmp(option, "--layers") == 0) return parse_layers(value, a);
    if (strcmp(option, "--type") == 0) return parse_type(value, a);
    return -2;
}

static int parse_flag(const char *option, RenderArguments *a) {
    if (strcmp(option, "--interleave") == 0)
        a->interleave = true;
    else if (strcmp(option, "--crop") == 0)
        a->crop = true;
    else if (strcmp(option, "--explain") == 0)
        a->explain = true;
    else if (strcmp(option, "--quiet") == 0)
        a->quiet = true;
    else if (strcmp(option, "--resume") == 0)
        a->resume = true;
    else if (strcmp(option, "--progress") == 0)
        a->progress = true;
    else if (strcmp(option, "--physical") == 0)
        a->options.physical_radiance = 1;
    else
        return -2;
    return -1;
}

static int unknown_option(const char *option) {
    static const char *const known[] = {"-o", "--photons", "--time", "--error", "--seed", "--threads",
        "--resolution", "--region", "--estimator", "--effects", "--layers", "--type", "--interleave",
        "--crop", "--memory", "--physical", "--explain", "--report", "--progress", "--quiet", "--version",
        "--help", "--checkpoint", "--checkpoint-every", "--resume", "--frames", "--shard", "--join"};
    fprintf(stderr, "caustic-render: unknown option \"%s\"; did you mean \"%s\"?\n", option,
        known[nearest_name(option, known, sizeof known / sizeof *known)]);
    return EXIT_USAGE;
}

/* Without a limit a picture is rendered until it shows no error, or as far as the default number of photons
 * goes. Frames, whose passes must be the same so that they do not flicker, and shares of a known number have
 * photons alone, as paths have. */
static void set_limits(RenderArguments *a, bool photons_given) {
    cau_render_options *o = &a->options;
    bool limited = o->time_s > 0 || o->error > 0;
    if (photons_given) return;
    if (limited) o->photons = 0;
    if (limited || a->frames || a->joined || o->shard_count || o->estimator == CAU_ESTIMATOR_R) return;
    o->error = DEFAULT_ERROR;
}

/* One place for the number is needed in whatever is written; without one in the scene's name it stands still.
 */
static int check_frames(const RenderArguments *a) {
    const char *names[] = {a->output, a->report, a->checkpoint};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        size_t begin, length;
        int digits;
        if (!names[i] || frame_place(names[i], &begin, &length, &digits)) continue;
        fprintf(stderr,
            "caustic-render: --frames needs #### or %%04d in the name of each file that is written: \"%s\" "
            "has "
            "none\n",
            names[i]);
        return EXIT_USAGE;
    }
    if (a->output && !a->joined) return -1;
    fprintf(stderr, "caustic-render: --frames needs -o OUT.####.exr, and goes without --join\n");
    return EXIT_USAGE;
}

static int check(RenderArguments *a, bool photons_given) {
    if (!a->scene) {
        fprintf(stderr, "caustic-render: no scene given; try caustic-render --help\n");
        return EXIT_USAGE;
    }
    if (a->joined && !a->joined_count)
        return usage_error("--join", NULL, "followed by state files of shards");
    bool state_alone = a->checkpoint && a->options.shard_count;
    if (!a->output && !a->explain && !state_alone) {
        fprintf(stderr, "caustic-render: no output given; name one with -o OUT.exr\n");
        return EXIT_USAGE;
    }
    if (a->frames) {
        int code = check_frames(a);
        if (code >= 0) return code;
    }
    if (a->resume && !a->checkpoint && !a->frames) {
        fprintf(stderr,
            "caustic-render: --resume needs the file to go on from; name it with --checkpoint FILE\n");
        return EXIT_USAGE;
    }
    if (a->joined && (a->checkpoint || a->options.shard_count)) {
        fprintf(stderr, "caustic-render: --join renders nothing; leave out --checkpoint and --shard\n");
        return EXIT_USAGE;
    }
    set_limits(a, photons_given);
    return -1;
}

int render_arguments_parse(int argc, char **argv, RenderArguments *out) {
    *out = (RenderArguments){.options = cau_render_defaults(), .checkpoint_s = 60};
    bool photons_given = false;
    for (int i = 1; i < argc; i++) {
        char name[32];
        char *value = NULL, *equals = argv[i][0] == '-' ? strchr(argv[i], '=') : NULL;
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) return fputs(help_text, stdout), 0;
        if (strcmp(argv[i], "--version") == 0) return printf("caustic-render %s\n", cau_version()), 0;
        if (strcmp(argv[i], "--join") == 0) { /* all that follows */
            out->joined = (const char *const *)argv + i + 1;
            out->joined_count = (size_t)(argc - i - 1);
            break;
        }
        if (argv[i][0] != '-' || strcmp(argv[i], "-") == 0) {
            if (out->scene || strcmp(argv[i], "-") == 0) {
                fprintf(stderr, "caustic-render: \"%s\": exactly one scene file is wanted\n", argv[i]);
                return EXIT_USAGE;
            }
            out->scene = argv[i];
            continue;
        }
        snprintf(name, sizeof name, "%.*s", equals ? (int)(equals - argv[i]) : 31, argv[i]);
        int code = equals ? -2 : parse_flag(name, out);
        if (code == -2) {
            value = equals ? equals + 1 : (i + 1 < argc ? argv[i + 1] : NULL);
            code = parse_valued(name, value, out);
            if (code == -1 && !equals) i++;
            photons_given |= strcmp(name, "--photons") == 0;
        }
        if (code == -2) return unknown_option(argv[i]);
        if (code >= 0) return code;
    }
    return check(out, photons_given);
}
