/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Output that is old or new, never half: a temporary file in the same folder, synced, then renamed.
 *
 *  file_atomic_begin() creates a new file beside `path` with a random name (O_EXCL), file_atomic_commit()
 *  syncs it, renames it over `path` and syncs the folder; file_atomic_abort() removes it. A symbolic link at
 *  `path` is replaced, its target is never touched. */
#ifndef CORE_FILE_ATOMIC_H
#define CORE_FILE_ATOMIC_H

#include "core/error.h"

#include <stddef.h>

typedef struct FileAtomic {
    char *path;      /**< the final name */
    char *temp_path; /**< where to write; NULL when nothing is open */
} FileAtomic;

/** Creates the temporary file, empty and closed; the writer opens `out->temp_path` itself.
 *  Fails with CAU_ERROR_RESOURCE when the folder does not exist or is not writable, with CAU_ERROR_INPUT when
 *  `path` is empty or names a folder. */
cau_result file_atomic_begin(FileAtomic *out, const char *path, CauError *err);

/** fsync, rename over the final name, fsync the folder. On failure the temporary file is removed. */
cau_result file_atomic_commit(FileAtomic *file, CauError *err);

/** Removes the temporary file. Safe on a zeroed or committed FileAtomic. */
void file_atomic_abort(FileAtomic *file);

/** Writes `bytes` bytes as the whole new content of `path`, atomically. */
cau_result file_write_atomic(const char *path, const void *data, size_t bytes, CauError *err);

#endif
