/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  A pool of pthreads that runs numbered pieces of work.
 *
 *  What a piece computes must depend on its number alone, never on the thread: then the same bytes come out
 * on any number of threads. The pool belongs to its owner and is joined with it. */
#ifndef CORE_TASKS_H
#define CORE_TASKS_H

#include "core/error.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct TaskPool TaskPool;

/** `index` is the piece, `thread` in [0, tasks_threads) says which scratch memory may be used. */
typedef void TaskFunction(void *data, size_t index, unsigned thread);

/** `threads` 0 means one per online processor. The calling thread works too: threads - 1 are started. */
cau_result tasks_create(TaskPool **out, unsigned threads, CauError *err);

/** Joins all threads. NULL is allowed; *pool becomes NULL. */
void tasks_destroy(TaskPool **pool);

unsigned tasks_threads(const TaskPool *pool);

/** Runs f(data, i, thread) for every i in [0, count) and returns when all are done. Not reentrant. Worker
 *  threads run with denormals flushed to zero, the caller's mode is restored. */
void tasks_run(TaskPool *pool, size_t count, TaskFunction *f, void *data);

#endif
