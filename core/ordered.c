/* SPDX-License-Identifier: Apache-2.0 */
#include "core/ordered.h"

#include "core/checked.h"

#include <pthread.h>
#include <stdbool.h>
#include <time.h>
#include <unistd.h>

enum { STACK_BYTES = 2 << 20, THREADS_MOST = 1024, POLL_NANOSECONDS = 50000000 };

typedef enum State { SLOT_FREE, SLOT_BUSY, SLOT_DONE } State;

typedef struct Slot {
    State state;
    size_t index;
    cau_result result;
    CauError err;
} Slot;

typedef struct Run {
    pthread_mutex_t mutex;
    pthread_cond_t changed; /* a slot became free or done, or the run ends */
    Slot *slots;
    unsigned slot_count;
    size_t next, count; /* the next piece that nobody has begun */
    bool stop;
    OrderedWork *work;
    void *data;
} Run;

unsigned ordered_processors(void) {
    long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online < 1 ? 1 : online > THREADS_MOST ? THREADS_MOST : (unsigned)online;
}

static Slot *free_slot(Run *run) {
    for (unsigned i = 0; i < run->slot_count; i++)
        if (run->slots[i].state == SLOT_FREE) return &run->slots[i];
    return NULL;
}

static void *worker_main(void *argument) {
    Run *run = argument;
    pthread_mutex_lock(&run->mutex);
    while (!run->stop && run->next < run->count) {
        Slot *slot = free_slot(run);
        if (!slot) {
            pthread_cond_wait(&run->changed, &run->mutex);
            continue;
        }
        slot->state = SLOT_BUSY;
        slot->index = run->next++;
        error_clear(&slot->err);
        pthread_mutex_unlock(&run->mutex);
        cau_result result = run->work(run->data, slot->index, (unsigned)(slot - run->slots), &slot->err);
        pthread_mutex_lock(&run->mutex);
        slot->result = result;
        slot->state = SLOT_DONE;
        pthread_cond_broadcast(&run->changed);
    }
    pthread_mutex_unlock(&run->mutex);
    return NULL;
}

static unsigned start_threads(Run *run, pthread_t *threads, unsigned wanted) {
    unsigned started = 0;
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, STACK_BYTES);
    while (started < wanted && pthread_create(&threads[started], &attributes, worker_main, run) == 0)
        started++;
    pthread_attr_destroy(&attributes);
    return started;
}

static Slot *wait_for(Run *run, size_t index, OrderedPoll *poll) {
    for (;;) {
        for (unsigned i = 0; i < run->slot_count; i++)
            if (run->slots[i].state == SLOT_DONE && run->slots[i].index == index) return &run->slots[i];
        struct timespec until;
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_nsec += POLL_NANOSECONDS;
        until.tv_sec += until.tv_nsec / 1000000000;
        until.tv_nsec %= 1000000000;
        pthread_cond_timedwait(&run->changed, &run->mutex, &until);
        if (!poll) continue;
        pthread_mutex_unlock(&run->mutex);
        poll(run->data);
        pthread_mutex_lock(&run->mutex);
    }
}

static cau_result take_all(Run *run, OrderedTake *take, OrderedPoll *poll, CauError *err) {
    cau_result result = CAU_OK;
    pthread_mutex_lock(&run->mutex);
    for (size_t index = 0; result == CAU_OK && index < run->count; index++) {
        Slot *slot = wait_for(run, index, poll);
        result = slot->result;
        pthread_mutex_unlock(&run->mutex);
        if (result != CAU_OK)
            error_set(err, result, "%s", slot->err.text);
        else if (take)
            result = take(run->data, index, (unsigned)(slot - run->slots), err);
        pthread_mutex_lock(&run->mutex);
        slot->state = SLOT_FREE;
        pthread_cond_broadcast(&run->changed);
    }
    run->stop = true;
    pthread_cond_broadcast(&run->changed);
    pthread_mutex_unlock(&run->mutex);
    return result;
}

static cau_result run_here(size_t count, OrderedWork *work, OrderedTake *take, void *data, CauError *err) {
    for (size_t i = 0; i < count; i++) {
        CAU_TRY(work(data, i, 0, err));
        if (take) CAU_TRY(take(data, i, 0, err));
    }
    return CAU_OK;
}

cau_result ordered_run(unsigned threads, unsigned slots, size_t count, OrderedWork *work, OrderedTake *take,
    OrderedPoll *poll, void *data, CauError *err) {
    if (threads > slots) threads = slots;
    if (threads > count) threads = (unsigned)count;
    if (threads <= 1) return run_here(count, work, take, data, err);
    Run run = {.slots = array_new(slots, sizeof *run.slots),
        .slot_count = slots,
        .count = count,
        .work = work,
        .data = data};
    pthread_t *ids = array_new(threads, sizeof *ids);
    if (!run.slots || !ids) {
        free(run.slots);
        free(ids);
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %u threads", threads);
    }
    pthread_mutex_init(&run.mutex, NULL);
    pthread_cond_init(&run.changed, NULL);
    unsigned started = start_threads(&run, ids, threads);
    cau_result result = started ? take_all(&run, take, poll, err) : run_here(count, work, take, data, err);
    for (unsigned i = 0; i < started; i++) pthread_join(ids[i], NULL);
    pthread_cond_destroy(&run.changed);
    pthread_mutex_destroy(&run.mutex);
    free(run.slots);
    free(ids);
    return result;
}
