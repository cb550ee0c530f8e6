/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Result codes shared by every public call.
 *
 *  Every call that can fail returns a cau_result. The context (cau_context, see scene.h) keeps the first
 *  error as one full sentence: what failed, in which file or object, the offending value, the limit, and what
 *  to do about it. */
#ifndef CAUSTICS_ERROR_H
#define CAUSTICS_ERROR_H

#include <stdint.h>

#if defined(_WIN32)
#define CAU_API
#else
#define CAU_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** A fixed-width result, so that the ABI does not move when codes are added. 0 is success. */
typedef int32_t cau_result;

enum {
    CAU_OK = 0,
    CAU_ERROR_INPUT = 1,       /**< bad or inconsistent input: a file, a scene, a value */
    CAU_ERROR_USAGE = 2,       /**< a call or command line that makes no sense */
    CAU_ERROR_CANCELLED = 3,   /**< stopped on request; what exists is saved and marked incomplete */
    CAU_ERROR_RESOURCE = 4,    /**< memory, disk, permissions */
    CAU_ERROR_UNSUPPORTED = 5, /**< understood, but not built yet; the programs exit with 1 */
    CAU_ERROR_INTERNAL = 6     /**< our own mistake; please report */
};

/** The program exit code that stands for a result: 0 done, 1 input, 2 usage, 3 cancelled, 4 resource. */
CAU_API int cau_exit_code(cau_result result);

/** A static English name of a result code, never NULL. */
CAU_API const char *cau_result_name(cau_result result);

#ifdef __cplusplus
}
#endif
#endif
