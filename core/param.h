/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Parameter tables: each kind of material, light, shape, camera... lists its parameters once.
 *
 *  The C API, the scene reader, the validation, the defaults, the generated reference and the generic tests
 * all loop over these tables, so a field is never listed in a second place. A parameter is `count` doubles at
 *  `offset` of the kind's data struct; booleans are 0 or 1, a choice is its index. */
#ifndef CORE_PARAM_H
#define CORE_PARAM_H

#include "core/error.h"

#include <stdbool.h>
#include <stddef.h>

typedef enum ParamType {
    PARAM_NUMBER,
    PARAM_VEC2,
    PARAM_VEC3,
    PARAM_COLOR,  /**< three numbers, linear RGB */
    PARAM_BOOL,   /**< 0 or 1 */
    PARAM_CHOICE, /**< one word of `choices` */
    PARAM_FLAGS,  /**< any set of words of `choices`; stored as a bit mask, the first word is bit 0 */
    PARAM_MATRIX, /**< 16 numbers, row-major 4x4, last row 0 0 0 1 */
    PARAM_LIST,   /**< a ParamList of tuples, see `tuple` */
    PARAM_TEXT, /**< a text, stored by a call of its own: listed so that names, reference and schema are whole
                 */
    PARAM_PART  /**< a nested part with a table of its own, likewise ("look", "filter", "shape") */
} ParamType;

/** A list parameter's value: `count` tuples, owned, freed by param_free(). */
typedef struct ParamList {
    double *values;
    size_t count;
} ParamList;

enum {
    PARAM_REQUIRED = 1,     /**< has no default: NaN (a list: empty) until set, see param_check_required() */
    PARAM_UNSUPPORTED = 2,  /**< known to the format, not built yet: setting it is an error that says so */
    PARAM_MIN_EXCLUDED = 4, /**< the value must be greater than `min`, not equal */
    PARAM_POSITIVE_INT = 8, /**< whole numbers only */
    PARAM_MAX_EXCLUDED = 16,
    PARAM_BROADCAST = 32, /**< one number stands for all components */
    PARAM_OR_FILE = 64    /**< a list that a scene file may give as the name of a text file of numbers */
};

typedef struct Param {
    const char *name;
    ParamType type;
    const char *unit; /**< "m", "W", "deg", ... or "" */
    size_t offset;    /**< of the value in the data struct */
    double def[3]; /**< default, per component; a choice: its index; a list: how many numbers of an entry must
                        be given where they have names (the others are 0), 0: all */
    double min, max; /**< inclusive limits of every component unless a flag says otherwise */
    unsigned flags;
    const char *const
        *choices;     /**< NULL-terminated; PARAM_CHOICE, PARAM_FLAGS; a list: the names of its tuple */
    unsigned tuple;   /**< PARAM_LIST: numbers per entry */
    const char *help; /**< half a sentence for the reference */
} Param;

typedef struct ParamTable {
    const Param *params;
    size_t count;
} ParamTable;

/** Number of doubles a value of this parameter takes (a list: per entry). */
unsigned param_components(const Param *p);

/** The parameter of that name, or NULL. */
const Param *param_find(const ParamTable *table, const char *name);

/** True when a value lives in the data struct: not unsupported, not a text, not a nested part. */
bool param_is_stored(const Param *p);

/** Fills `data` with the defaults, required parameters with NaN. */
void param_defaults(const ParamTable *table, void *data);

/** An error that names the first required parameter that was not set. */
cau_result param_check_required(const ParamTable *table, const void *data, const char *owner, CauError *err);

/** Stores values after checking count, finiteness and limits; a matrix must be affine and not singular.
 * `owner` is the place in the sentence of the error, e.g. "materials.glass", to which ".ior" is added. An
 * unknown name gives an error that names the nearest known one. */
cau_result param_set(const ParamTable *table, void *data, const char *owner, const char *name,
    const double *values, size_t count, CauError *err);

/** The same for a word: PARAM_CHOICE (and "true"/"false" for PARAM_BOOL). */
cau_result param_set_choice(const ParamTable *table, void *data, const char *owner, const char *name,
    const char *word, CauError *err);

/** The same for a set of words: PARAM_FLAGS. */
cau_result param_set_flags(const ParamTable *table, void *data, const char *owner, const char *name,
    const char *const *words, size_t count, CauError *err);

/** Error for an unknown name, naming the nearest. `what` is "key", "material type", ... */
cau_result param_unknown(const char *owner, const char *what, const char *name, const char *const *known,
    size_t known_count, CauError *err);

/** Frees the lists inside `data`. */
void param_free(const ParamTable *table, void *data);

/** A convenience for tables: {P_NUMBER(...), ...} */
#define PARAM_TABLE(array)                                                                                   \
    { (array), sizeof(array) / sizeof((array)[0]) }

#endif
