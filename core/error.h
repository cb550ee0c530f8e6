/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  The error record: the first error of a run, kept as a full sentence.
 *
 *  A function that can fail takes a CauError* and returns a cau_result. error_set() keeps only the first
 *  sentence, so callers may add nothing and simply return: CAU_TRY(f(..., err)). */
#ifndef CORE_ERROR_H
#define CORE_ERROR_H

#include "caustics/error.h"

#include <stdarg.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { CAU_ERROR_TEXT_MAX = 1024 };

typedef struct CauError {
    cau_result code;               /**< CAU_OK until the first error */
    char text[CAU_ERROR_TEXT_MAX]; /**< one sentence, no newline, UTF-8 */
} CauError;

/** Records the first error and returns `code`. A later call leaves the text alone and returns `code`.
 *  `err` may be NULL. Control characters of the formatted text are replaced by '?'. */
cau_result error_set(CauError *err, cau_result code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

cau_result error_set_v(CauError *err, cau_result code, const char *format, va_list args);

/** Puts `prefix` before the recorded text, to say where (a file, a JSON path) a lower layer failed. */
void error_prefix(CauError *err, const char *format, ...) __attribute__((format(printf, 2, 3)));

void error_clear(CauError *err);

#define CAU_TRY(call)                                                                                        \
    do {                                                                                                     \
        cau_result cau_try_result_ = (call);                                                                 \
        if (cau_try_result_ != CAU_OK) return cau_try_result_;                                               \
    } while (0)

#ifdef __cplusplus
}
#endif
#endif
