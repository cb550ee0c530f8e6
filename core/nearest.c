/* SPDX-License-Identifier: Apache-2.0 */
#include "core/nearest.h"

#include <ctype.h>
#include <string.h>

enum { NAME_MAX_COMPARED = 63 };

/* Levenshtein distance, doubled so that a difference of case alone costs 1. */
static int edit_distance(const char *a, const char *b) {
    size_t la = strnlen(a, NAME_MAX_COMPARED), lb = strnlen(b, NAME_MAX_COMPARED);
    int row[NAME_MAX_COMPARED + 1];
    for (size_t j = 0; j <= lb; j++) row[j] = (int)(2 * j);
    for (size_t i = 1; i <= la; i++) {
        int diagonal = row[0];
        row[0] = (int)(2 * i);
        for (size_t j = 1; j <= lb; j++) {
            unsigned char ca = (unsigned char)a[i - 1], cb = (unsigned char)b[j - 1];
            int cost = ca == cb ? 0 : (tolower(ca) == tolower(cb) ? 1 : 2);
            int best = diagonal + cost;
            if (row[j] + 2 < best) best = row[j] + 2;
            if (row[j - 1] + 2 < best) best = row[j - 1] + 2;
            diagonal = row[j];
            row[j] = best;
        }
    }
    return row[lb];
}

/* A name cut short ("hfov") means the whole one ("hfov_deg"), whatever short name is nearer by letters. */
static int distance(const char *wanted, const char *name) {
    size_t length = strlen(wanted);
    return length >= 3 && strncmp(wanted, name, length) == 0 ? 1 : edit_distance(wanted, name);
}

int nearest_name(const char *wanted, const char *const *names, size_t count) {
    int best = -1, best_distance = 0;
    for (size_t i = 0; i < count; i++) {
        int d = distance(wanted, names[i]);
        if (best < 0 || d < best_distance) {
            best = (int)i;
            best_distance = d;
        }
    }
    return best;
}
