/* SPDX-License-Identifier: Apache-2.0 */
#include "core/param.h"

#include "core/checked.h"
#include "core/nearest.h"

#include <math.h>
#include <stdio.h>

enum { KNOWN_MAX = 64 };

unsigned param_components(const Param *p) {
    switch (p->type) {
    case PARAM_VEC2: return 2;
    case PARAM_VEC3:
    case PARAM_COLOR: return 3;
    case PARAM_MATRIX: return 16;
    case PARAM_LIST: return p->tuple;
    default: return 1;
    }
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
        if (p->flags & PARAM_UNSUPPORTED) continue;
        if (p->type == PARAM_LIST) {
            *(ParamList *)param_address(p, data) = (ParamList){0};
            continue;
        }
        double *value = param_address(p, data);
        for (unsigned c = 0; c < param_components(p); c++)
            value[c] = p->type == PARAM_MATRIX ? (c % 5 == 0 ? 1.0 : 0.0) : p->def[c];
    }
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
        return error_set(err, CAU_ERROR_UNSUPPORTED, "%s: not yet supported: \"%s\" (%s); remove it", owner, name,
            (*out)->help);
    return CAU_OK;
}

static cau_result check_value(const Param *p, const char *owner, double x, CauError *err) {
    if (!isfinite(x))
        return error_set(err, CAU_ERROR_INPUT, "%s: \"%s\" is not a finite number", owner, p->name);
    bool low = (p->flags & PARAM_MIN_EXCLUDED) ? !(x > p->min) : !(x >= p->min);
    bool high = (p->flags & PARAM_MAX_EXCLUDED) ? !(x < p->max) : !(x <= p->max);
    const char *space = p->unit[0] ? " " : "";
    if (low)
        return error_set(err, CAU_ERROR_INPUT, "%s: \"%s\" is %g%s%s; it must be %s %g", owner, p->name, x, space,
            p->unit, (p->flags & PARAM_MIN_EXCLUDED) ? "greater than" : "at least", p->min);
    if (high)
        return error_set(err, CAU_ERROR_INPUT, "%s: \"%s\" is %g%s%s; it must be %s %g", owner, p->name, x, space,
            p->unit, (p->flags & PARAM_MAX_EXCLUDED) ? "less than" : "at most", p->max);
    if ((p->flags & PARAM_POSITIVE_INT) && x != floor(x))
        return error_set(err, CAU_ERROR_INPUT, "%s: \"%s\" is %g; it must be a whole number", owner, p->name, x);
    return CAU_OK;
}

static cau_result set_list(
    const Param *p, void *data, const char *owner, const double *values, size_t count, CauError *err) {
    if (count % p->tuple != 0)
        return error_set(err, CAU_ERROR_INPUT, "%s: \"%s\" has %zu numbers; entries have %u each", owner, p->name,
            count, p->tuple);
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
    const Param *p;
    CAU_TRY(find(table, owner, name, &p, err));
    if (p->type == PARAM_CHOICE || p->type == PARAM_FLAGS)
        return error_set(err, CAU_ERROR_INPUT, "%s: \"%s\" must be a word, not a number", owner, name);
    for (size_t i = 0; i < count; i++) CAU_TRY(check_value(p, owner, values[i], err));
    if (p->type == PARAM_LIST) return set_list(p, data, owner, values, count, err);
    if (count == 1 && (p->flags & PARAM_BROADCAST)) {
        for (unsigned c = 0; c < param_components(p); c++) ((double *)param_address(p, data))[c] = values[0];
        return CAU_OK;
    }
    if (count != param_components(p))
        return error_set(err, CAU_ERROR_INPUT, "%s: \"%s\" has %zu numbers; it must have %u", owner, name, count,
            param_components(p));
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
    char what[96];
    snprintf(what, sizeof what, "word for \"%s\"", p->name);
    return param_unknown(owner, what, word, p->choices, n, err);
}

cau_result param_set_choice(
    const ParamTable *table, void *data, const char *owner, const char *name, const char *word, CauError *err) {
    const Param *p;
    CAU_TRY(find(table, owner, name, &p, err));
    if (p->type != PARAM_CHOICE)
        return error_set(err, CAU_ERROR_INPUT, "%s: \"%s\" must be a number, not the word \"%s\"", owner, name, word);
    size_t n;
    CAU_TRY(find_word(p, owner, word, &n, err));
    *(double *)param_address(p, data) = (double)n;
    return CAU_OK;
}

cau_result param_set_flags(const ParamTable *table, void *data, const char *owner, const char *name,
    const char *const *words, size_t count, CauError *err) {
    const Param *p;
    CAU_TRY(find(table, owner, name, &p, err));
    if (p->type != PARAM_FLAGS)
        return error_set(err, CAU_ERROR_INPUT, "%s: \"%s\" is not a list of words", owner, name);
    unsigned mask = 0;
    for (size_t i = 0; i < count; i++) {
        size_t n;
        CAU_TRY(find_word(p, owner, words[i], &n, err));
        mask |= 1u << n;
    }
    *(double *)param_address(p, data) = mask;
    return CAU_OK;
}

void param_free(const ParamTable *table, void *data) {
    for (size_t i = 0; i < table->count; i++) {
        const Param *p = &table->params[i];
        if (p->type != PARAM_LIST || (p->flags & PARAM_UNSUPPORTED)) continue;
        ParamList *list = param_address(p, data);
        free(list->values);
        *list = (ParamList){0};
    }
}
