/* SPDX-License-Identifier: Apache-2.0 */
/** @file
 *  Numbered pieces of work on several threads whose results are taken in order.
 *
 *  What bounds the memory is the number of slots: a piece is begun only when a slot is free, and its slot is
 * free again once its result was taken. Unlike tasks.h the floating-point mode is left alone: denormals
 * count. */
#ifndef CORE_ORDERED_H
#define CORE_ORDERED_H

#include "core/error.h"

#include <stddef.h>

/** Does piece `index` with the memory of `slot`. Several run at once, each with its own slot and `err`. */
typedef cau_result OrderedWork(void *data, size_t index, unsigned slot, CauError *err);

/** Called on the calling thread about every 50 ms while it waits; may be NULL. */
typedef void OrderedPoll(void *data);

/** Takes the result of piece `index` out of `slot`: in order, on the calling thread. */
typedef cau_result OrderedTake(void *data, size_t index, unsigned slot, CauError *err);

/** Runs all `count` pieces. The first failure in the order of the pieces ends the run and is the one told.
 * With one thread everything happens on the calling thread, in slot 0. Fewer threads than asked for are no
 * error. `take` and `poll` may be NULL. */
cau_result ordered_run(unsigned threads, unsigned slots, size_t count, OrderedWork *work, OrderedTake *take,
    OrderedPoll *poll, void *data, CauError *err);

/** The number of processors online, at least 1. */
unsigned ordered_processors(void);

#endif
