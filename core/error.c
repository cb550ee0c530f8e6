/* SPDX-License-Identifier: Apache-2.0 */
#include "core/error.h"

#include <stdio.h>
#include <string.h>

static void replace_control(char *text) {
    for (unsigned char *c = (unsigned char *)text; *c; c++)
        if (*c < 32 || *c == 127) *c = '?';
}

cau_result error_set_v(CauError *err, cau_result code, const char *format, va_list args) {
    if (!err || err->code != CAU_OK) return code;
    err->code = code;
    vsnprintf(err->text, sizeof err->text, format, args);
    replace_control(err->text);
    return code;
}

cau_result error_set(CauError *err, cau_result code, const char *format, ...) {
    va_list args;
    va_start(args, format);
    cau_result result = error_set_v(err, code, format, args);
    va_end(args);
    return result;
}

void error_prefix(CauError *err, const char *format, ...) {
    if (!err || err->code == CAU_OK) return;
    char text[CAU_ERROR_TEXT_MAX];
    va_list args;
    va_start(args, format);
    int n = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (n < 0) return;
    size_t used = strlen(text), left = sizeof text - used - 1;
    strncat(text, err->text, left);
    memcpy(err->text, text, sizeof text);
    replace_control(err->text);
}

void error_clear(CauError *err) {
    if (!err) return;
    err->code = CAU_OK;
    err->text[0] = '\0';
}

int cau_exit_code(cau_result result) {
    switch (result) {
    case CAU_OK:
        return 0;
    case CAU_ERROR_USAGE:
        return 2;
    case CAU_ERROR_CANCELLED:
        return 3;
    case CAU_ERROR_RESOURCE:
    case CAU_ERROR_INTERNAL:
        return 4;
    default:
        return 1;
    }
}

const char *cau_result_name(cau_result result) {
    switch (result) {
    case CAU_OK:
        return "ok";
    case CAU_ERROR_INPUT:
        return "bad input";
    case CAU_ERROR_USAGE:
        return "bad usage";
    case CAU_ERROR_CANCELLED:
        return "cancelled";
    case CAU_ERROR_RESOURCE:
        return "out of a resource";
    case CAU_ERROR_UNSUPPORTED:
        return "not yet supported";
    case CAU_ERROR_INTERNAL:
        return "internal error";
    default:
        return "unknown result";
    }
}
