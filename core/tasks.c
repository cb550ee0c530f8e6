/* SPDX-License-Identifier: Apache-2.0 */
#include "core/tasks.h"

#include "core/checked.h"

#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

enum { THREADS_MAX = 1024 };

typedef struct Worker {
    struct TaskPool *pool;
    pthread_t thread;
    unsigned index;
} Worker;

struct TaskPool {
    pthread_mutex_t mutex;
    pthread_cond_t wake, done;
    Worker *workers; /* [threads - 1] */
    unsigned threads, started, running;
    unsigned long generation;
    bool quit;
    TaskFunction *function;
    void *data;
    size_t count;
    atomic_size_t next;
};

/* Embree asks for flush-to-zero; results must not depend on a host's mode either. */
static unsigned denormals_flush(void) {
#if defined(__SSE2__)
    unsigned old = _mm_getcsr();
    _mm_setcsr(old | 0x8040u);
    return old;
#else
    return 0;
#endif
}

static void denormals_restore(unsigned old) {
#if defined(__SSE2__)
    _mm_setcsr(old);
#else
    (void)old;
#endif
}

static void work(TaskPool *pool, unsigned thread) {
    for (;;) {
        size_t i = atomic_fetch_add_explicit(&pool->next, 1, memory_order_relaxed);
        if (i >= pool->count) return;
        pool->function(pool->data, i, thread);
    }
}

static void *worker_main(void *argument) {
    Worker *self = argument;
    TaskPool *pool = self->pool;
    denormals_flush();
    unsigned long seen = 0;
    pthread_mutex_lock(&pool->mutex);
    for (;;) {
        while (!pool->quit && pool->generation == seen) pthread_cond_wait(&pool->wake, &pool->mutex);
        if (pool->quit) break;
        seen = pool->generation;
        pthread_mutex_unlock(&pool->mutex);
        work(pool, self->index);
        pthread_mutex_lock(&pool->mutex);
        if (--pool->running == 0) pthread_cond_signal(&pool->done);
    }
    pthread_mutex_unlock(&pool->mutex);
    return NULL;
}

cau_result tasks_create(TaskPool **out, unsigned threads, CauError *err) {
    *out = NULL;
    if (threads == 0) {
        long online = sysconf(_SC_NPROCESSORS_ONLN);
        threads = online > 0 ? (unsigned)online : 1;
    }
    if (threads > THREADS_MAX)
        return error_set(
            err, CAU_ERROR_INPUT, "%u threads asked for, at most %d are possible", threads, THREADS_MAX);
    TaskPool *pool = array_new(1, sizeof *pool);
    Worker *workers = array_new(threads, sizeof *workers);
    if (!pool || !workers) {
        free(pool);
        free(workers);
        return error_set(err, CAU_ERROR_RESOURCE, "out of memory for %u threads", threads);
    }
    pool->workers = workers;
    pool->threads = threads;
    pthread_mutex_init(&pool->mutex, NULL);
    pthread_cond_init(&pool->wake, NULL);
    pthread_cond_init(&pool->done, NULL);
    for (unsigned i = 0; i + 1 < threads; i++) {
        workers[i] = (Worker){.pool = pool, .index = i + 1};
        if (pthread_create(&workers[i].thread, NULL, worker_main, &workers[i]) != 0) break;
        pool->started++;
    }
    if (pool->started + 1 < threads) {
        tasks_destroy(&pool);
        return error_set(
            err, CAU_ERROR_RESOURCE, "the system refused to start %u threads; use fewer", threads);
    }
    *out = pool;
    return CAU_OK;
}

void tasks_destroy(TaskPool **pool_pointer) {
    TaskPool *pool = *pool_pointer;
    if (!pool) return;
    pthread_mutex_lock(&pool->mutex);
    pool->quit = true;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->mutex);
    for (unsigned i = 0; i < pool->started; i++) pthread_join(pool->workers[i].thread, NULL);
    pthread_cond_destroy(&pool->done);
    pthread_cond_destroy(&pool->wake);
    pthread_mutex_destroy(&pool->mutex);
    free(pool->workers);
    free(pool);
    *pool_pointer = NULL;
}

unsigned tasks_threads(const TaskPool *pool) { return pool->threads; }

void tasks_run(TaskPool *pool, size_t count, TaskFunction *f, void *data) {
    if (count == 0) return;
    pthread_mutex_lock(&pool->mutex);
    pool->function = f;
    pool->data = data;
    pool->count = count;
    atomic_store(&pool->next, 0);
    pool->running = pool->started;
    pool->generation++;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->mutex);
    unsigned mode = denormals_flush();
    work(pool, 0);
    denormals_restore(mode);
    pthread_mutex_lock(&pool->mutex);
    while (pool->running) pthread_cond_wait(&pool->done, &pool->mutex);
    pthread_mutex_unlock(&pool->mutex);
}
