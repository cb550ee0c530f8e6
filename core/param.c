/* SPDX-License-Identifier: Apache-2.0 */
#include "core/param.h"

#include "core/checked.h"
#include "core/nearest.h"

#include <math.h>
#include <stdio.h>

enum { KNOWN_MAX = 64 };

unsigned param_components(const Param *p) {
    switch (p->type) {
    case PARAM_VEC2:
        return 2;
    case PARAM_VEC3:
    case PARAM_COLOR:
        return 3;
    case PARAM_MATRIX:
        return 16;
    case PARAM_LIST:
        return p->tuple;
    case PARAM_TEXT:
    case PARAM_PART:
        return 0;
    default:
        return 1;
    }
}

bool param_is_stored(const Param *p) {
    return !(p->flags & PARAM_UNSUPPORTED) && p->type != PARAM_TEXT && p->type != PARAM_PART;
}

const Param *param_find(const ParamTable *table, const char *name) {
    for (size_t i = 0; i < table->count; i++)
        if (strcmp(table->params[i].name, name) == 0) return &table->params[i];
    return NULL;
}

static void *param_address(const Param *p, void *data) { return (char *)data + p->offset; }

void param_defaults(const ParamTable *table, void *data) {
    for (size_t i = 0; i < table->count; i++) {
        const Param *p = &table->params[i];
        if (!param_is_stored(p)) continue;
        if (p->type == PARAM_LIST) {
            *(ParamList *)param_address(p, data) = (ParamList){0};
            continue;
        }
        double *value = param_address(p, data);
        for (unsigned c = 0; c < param_components(p); c++) {
            if (p->flags & PARAM_REQUIRED)
                value[c] = NAN;
            else
                value[c] = p->type == PARAM_MATRIX ? (c % 5 == 0 ? 1.0 : 0.0) : p->def[c];
        }
    }
}

cau_result param_check_required(const ParamTable *table, const void *data, const char *owner, CauError *err) {
    for (size_t i = 0; i < table->count; i++) {
        const Param *p = &table->params[i];
        if (!param_is_stored(p) || !(p->flags & PARAM_REQUIRED)) continue;
        const void *value = (const char *)data + p->offset;
        bool missing = p->type == PARAM_LIST ? ((const ParamList *)value)->values == NULL
                                             : isnan(*(const double *)value);
        if (missing)
            return error_set(err, CAU_ERROR_INPUT, "%s: \"%s\" is missing (%s)", owner, p->name, p->help);
    }
    return CAU_OK;
}

cau_result param_unknown(const char *owner, const char *what, const char *name, const char *const *known,
    size_t known_count, CauError *err) {
    int nearest = nearest_name(name, known, known_count);
    if (nearest < 0) return error_set(err, CAU_ERROR_INPUT, "%s: unknown %s \"%s\"", owner, what, name);
    return error_set(err, CAU_ERROR_INPUT, "%s: unknown %s \"%s\"; did you mean \"%s\"?", owner, what, name,
        known[nearest]);
}

static cau_result find(
    const ParamTable *table, const char *owner, const char *name, const Param **out, CauError *err) {
    *out = param_find(table, name);
    if (!*out) {
        const char *known[KNOWN_MAX];
        size_t n = table->count < KNOWN_MAX ? table->count : KNOWN_MAX;
        for (size_t i = 0; i < n; i++) known[i] = table->params[i].name;
        return param_unknown(owner, "key", name, known, n, err);
    }
    if ((*out)->flags & PARAM_UNSUPPORTED)
        return error_set(
            err, CAU_ERROR_UNSUPPORTED, "%s.%s: not yet supported: %s; remove it", owner, name, (*out)->help);
    return CAU_OK;
}

static const char *expected(const Param *p) {
    switch (p->type) {
    case PARAM_BOOL:
        return "true or false";
    case PARAM_CHOICE:
    case PARAM_TEXT:
        return "a word";
    case PARAM_FLAGS:
        return "a list of words";
    case PARAM_PART:
        return "a part with keys of its own";
    default:
        return "a number or numbers";
    }
}

static cau_result wrong_type(const Param *p, const char *owner, const char *given, CauError *err) {
    return error_set(err, CAU_ERROR_INPUT, "%s.%s must be %s, not %s", owner, p->name, expected(p), given);
}

static cau_result check_value(const Param *p, const char *owner, double x, CauError *err) {
    if (!isfinite(x)) return error_set(err, CAU_ERROR_INPUT, "%s.%s is not a finite number", owner, p->name);
    bool low = (p->flags & PARAM_MIN_EXCLUDED) ? !(x > p->min) : !(x >= p->min);
    bool high = (p->flags & PARAM_MAX_EXCLUDED) ? !(x < p->max) : !(x <= p->max);
    const char *space = p->unit[0] ? " " : "";
    if (low)
        return error_set(err, CAU_ERROR_INPUT, "%s.%s is %g%s%s; it must be %s %g", owner, p->name, x, space,
            p->unit, (p->flags & PARAM_MIN_EXCLUDED) ? "greater than" : "at least", p->min);
    if (high)
        return error_set(err, CAU_ERROR_INPUT, "%s.%s is %g%s%s; it must be %s %g", owner, p->name, x, space,
            p->unit, (p->flags & PARAM_MAX_EXCLUDED) ? "less than" : "at most", p->max);
    if ((p->flags & PARAM_POSITIVE_INT) && x != floor(x))
        return error_set(err, CAU_ERROR_INPUT, "%s.%s is %g; it must be a whole number", owner, p->name, x);
    return CAU_OK;
}

/* Singular relative to the lengths of the columns, so that a scene in micrometres is as good as one in
 * metres. */
static cau_result check_matrix(const Param *p, const char *owner, const double m[16], CauError *err) {
    if (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
        return error_set(err, CAU_ERROR_INPUT, "%s.%s has the last row %g %g %g %g; it must be 0 0 0 1",
            owner, p->name, m[12], m[13], m[14], m[15]);
    double det = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
                 m[2] * (m[4] * m[9] - m[5] * m[8]);
    double lengths = 1;
    for (int c = 0; c < 3; c++) lengths *= sqrt(m[c] * m[c] + m[4 + c] * m[4 + c] + m[8 + c] * m[8 + c]);
    if (!(fabs(det) > 1e-14 * lengths))
        return error_set(err, CAU_ERROR_INPUT,
            "%s.%s is singular (determinant %g); its first three columns must be independent", owner, p->name,
            det);
    return CAU_OK;
}

static cau_result set_list(
    const Param *p, void *data, const char *owner, const double *values, size_t count, CauError *err) {
    if (count % p->tuple != 0)
        return error_set(err, CAU_ERROR_INPUT, "%s.%s has %zu numbers; it must have %u per entry", owner,
            p->name, count, p->tuple);
    double *copy = array_new(count, sizeof *copy);
    if (!copy) return error_set(err, CAU_ERROR_RESOURCE, "%s: out of memory for \"%s\"", owner, p->name);
    if (count) memcpy(copy, values, count * sizeof *copy);
    ParamList *list = param_address(p, data);
    free(list->values);
    *list = (ParamList){copy, count / p->tuple};
    return CAU_OK;
}

cau_result param_set(const ParamTable *table, void *data, const char *owner, const char *name,
    const double *values, size_t count, CauError *err) {
    const Param *p = NULL;
    CAU_TRY(find(table, owner, name, &p, err));
    if (p->type == PARAM_CHOICE || p->type == PARAM_FLAGS || !param_is_stored(p))
        return wrong_type(p, owner, "a number", err);
    for (size_t i = 0; i < count; i++) CAU_TRY(check_value(p, owner, values[i], err));
    if (p->type == PARAM_LIST) return set_list(p, data, owner, values, count, err);
    if (count == 1 && (p->flags & PARAM_BROADCAST)) {
        for (unsigned c = 0; c < param_components(p); c++) ((double *)param_address(p, data))[c] = values[0];
        return CAU_OK;
    }
    if (count != param_components(p))
        return error_set(err, CAU_ERROR_INPUT, "%s.%s has %zu numbers; it must have %u", owner, name, count,
            param_components(p));
    if (p->type == PARAM_MATRIX) CAU_TRY(check_matrix(p, owner, values, err));
    memcpy(param_address(p, data), values, count * sizeof *values);
    return CAU_OK;
}

static cau_result find_word(const Param *p, const char *owner, const char *word, size_t *out, CauError *err) {
    size_t n = 0;
    for (; p->choices[n]; n++)
        if (strcmp(p->choices[n], word) == 0) {
            *out = n;
            return CAU_OK;
        }
    char where[256];
    snprintf(where, sizeof where, "%s.%s", owner, p->name);
    return param_unknown(where, "word", word, p->choices, n, err);
}

cau_result param_set_choice(const ParamTable *table, void *data, const char *owner, const char *name,
    const char *word, CauError *err) {
    const Param *p = NULL;
    CAU_TRY(find(table, owner, name, &p, err));
    if (p->type == PARAM_BOOL && (strcmp(word, "true") == 0 || strcmp(word, "false") == 0)) {
        *(double *)param_address(p, data) = word[0] == 't';
        return CAU_OK;
    }
    char given[80];
    snprintf(given, sizeof given, "the word \"%.60s\"", word);
    if (p->type != PARAM_CHOICE) return wrong_type(p, owner, given, err);
    size_t n = 0;
    CAU_TRY(find_word(p, owner, word, &n, err));
    *(double *)param_address(p, data) = (double)n;
    return CAU_OK;
}

cau_result param_set_flags(const ParamTable *table, void *data, const char *owner, const char *name,
    const char *const *words, size_t count, CauError *err) {
    const Param *p = NULL;
    CAU_TRY(find(table, owner, name, &p, err));
    if (p->type != PARAM_FLAGS) return wrong_type(p, owner, "a list of words", err);
    unsigned mask = 0;
    for (size_t i = 0; i < count; i++) {
        size_t n = 0;
        CAU_TRY(find_word(p, owner, words[i], &n, err));
        mask |= 1u << n;
    }
    *(double *)param_address(p, data) = mask;
    return CAU_OK;
}

void param_free(const ParamTable *table, void *data) {
    for (size_t i = 0; i < table->count; i++) {
        const Param *p = &table->params[i];
        if (p->type != PARAM_LIST || !param_is_stored(p)) continue;
        ParamList *list = param_address(p, data);
        free(list->values);
        *list = (ParamList){0};
    }
}
