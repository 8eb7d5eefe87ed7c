/* Threads that take pieces of a kernel's range by a counter, so that Python crosses into machine code once a query.
 *
 * They start when they are first needed, wait for more work, and never touch Python. There are as many as all callers
 * wish at once; those beyond the largest wish of one end after their work. A child of a fork begins without any.
 *
 * For queries of many rays: to start costs 2 µs, a piece 10 ns, where a chunk of Python's threads takes its one lock
 * twice. Of what a million camera rays took beyond their kernel, this and scratch.c save three quarters.
 */
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>

#include "pool.h"

enum { STACK = 4 << 20, MOST_USED = 512, SHARES = 4 }; /* a piece is at most this part of what is left for a thread */
enum { LINE = 128 }; /* bytes that no two threads write to: processors fetch lines of 64 in pairs */

struct Work {
    _Alignas(LINE) _Atomic int64_t next; /* what threads write once a piece */
    _Atomic int64_t done;
    _Atomic(Outcome *) outcomes;
    _Alignas(LINE) Range range; /* what threads read once a piece */
    int64_t most;
    int8_t *marks;
    int threads, keeps;
    atomic_int stopped, status;
    _Alignas(LINE) int wanted, running; /* threads that shall come, and that are there; under the lock */
    Work *after;                        /* in the queue of works that want threads; under the lock */
    int64_t process; /* in which it started: threads stay behind where a process forks */
    void *block;
    _Alignas(LINE) int64_t slots[];
};

_Static_assert(offsetof(Work, range) >= LINE && offsetof(Work, wanted) >= offsetof(Work, status) + sizeof(int) &&
                   offsetof(Work, wanted) % LINE == 0 && offsetof(Work, slots) % LINE == 0,
               "threads must not write to what others read once a piece");

Work *work_new(const Range *range, int64_t most, int8_t *marks, int keeps)
{
    int64_t count = range->begin < 0 ? range->used * range->last : range->used;
    void *block = range->used > MOST_USED ? NULL : malloc(sizeof(Work) + (size_t)count * 8 + LINE);
    if (block == NULL)
        return NULL;
    Work *work = (Work *)(((uintptr_t)block + LINE - 1) / LINE * LINE);
    *work = (Work){.next = range->first, .range = *range, .most = most, .marks = marks, .keeps = keeps, .threads = 1,
                   .block = block};
    for (int64_t k = 0; k < count; k++)
        work->slots[k] = range->slots[k];
    work->range.slots = work->slots;
    return work;
}

void work_free(Work *work) { free(work->block); }
void work_stop(Work *work) { work->stopped = 1; }
int64_t work_done(Work *work) { return work->done; }
int work_status(Work *work) { return work->status; }
Outcome *work_outcomes(Work *work) { return atomic_exchange(&work->outcomes, NULL); }

/* Call a kernel for a piece; its status. */
static int call_piece(const Range *range, int64_t *slots, int64_t begin, int64_t end, int64_t *result)
{
    if (range->begin >= 0) {
        slots[range->begin] = begin;
        slots[range->begin + 1] = end;
    }
    int status = range->kernel(result, range->begin < 0 ? range->slots + range->used * begin : slots);
    return status == -2 ? 0 : status; /* -2: it returned None */
}

/* Keep what a kernel returned; 0, or a status where there is no memory. */
static int keep_outcome(Work *work, const Outcome *outcome)
{
    Outcome *kept = malloc(sizeof(Outcome));
    if (kept == NULL)
        return -1;
    *kept = *outcome;
    kept->after = work->outcomes;
    while (!atomic_compare_exchange_weak(&work->outcomes, &kept->after, kept))
        continue;
    return 0;
}

void work_help(Work *work)
{
    int64_t slots[MOST_USED], last = work->range.last, next = work->next;
    for (int k = 0; k < work->range.used; k++)
        slots[k] = work->range.slots[k];
    while (next < last && !work->stopped) {
        int64_t size = (last - next) / (SHARES * work->threads);
        size = size < 1 ? 1 : size > work->most ? work->most : size;
        if (!atomic_compare_exchange_weak(&work->next, &next, next + size))
            continue;
        Outcome outcome = {.begin = next, .end = next + size};
        int status = call_piece(&work->range, slots, next, next + size, outcome.result);
        if (status == 0 && work->keeps && (status = keep_outcome(work, &outcome)) != 0)
            work->range.drop(outcome.result);
        if (work->marks != NULL)
            atomic_thread_fence(memory_order_release); /* what is marked is there */
        for (int64_t k = 0; status == 0 && work->marks != NULL && k < size; k++)
            work->marks[next - work->range.first + k] = 1;
        if (status != 0) {
            work->status = status;
            work->stopped = 1;
        }
        work->done += size;
        next = work->next;
    }
}

#ifdef __wasm__

int work_start(Work *work, int threads) { return (void)work, (void)threads, 0; }
int work_wait(Work *work, int milliseconds) { return (void)work, (void)milliseconds, 1; }
void pool_keep(int most) { (void)most; }
int pool_size(void) { return 0; }

#else

/* ---- The system's locks, signals and threads ---- */

#ifdef _WIN32
#define WIN32_LEAN_AND_MEAN
#include <windows.h>

enum { known = 0 }; /* no process forks */
static SRWLOCK gate = SRWLOCK_INIT;
static CONDITION_VARIABLE wished = CONDITION_VARIABLE_INIT, left = CONDITION_VARIABLE_INIT;

static void lock(void) { AcquireSRWLockExclusive(&gate); }
static void unlock(void) { ReleaseSRWLockExclusive(&gate); }
static void await_wish(void) { SleepConditionVariableSRW(&wished, &gate, INFINITE, 0); }
static int await_end(int milliseconds) { return SleepConditionVariableSRW(&left, &gate, (DWORD)milliseconds, 0) != 0; }
static void wake_one(void) { WakeConditionVariable(&wished); }
static void wake_all(void) { WakeAllConditionVariable(&wished); }
static void tell_end(void) { WakeAllConditionVariable(&left); }
static void serve(void);
static DWORD WINAPI body(void *nothing) { return (void)nothing, serve(), 0; }

static int add_thread(void)
{
    HANDLE thread = CreateThread(NULL, STACK, body, NULL, STACK_SIZE_PARAM_IS_A_RESERVATION, NULL);
    return thread != NULL && CloseHandle(thread);
}
#else
#include <pthread.h>
#include <time.h>
#include <unistd.h>

static pthread_mutex_t gate;
static pthread_cond_t wished, left;

static void unlock(void) { pthread_mutex_unlock(&gate); }
static void await_wish(void) { pthread_cond_wait(&wished, &gate); }
static void wake_one(void) { pthread_cond_signal(&wished); }
static void wake_all(void) { pthread_cond_broadcast(&wished); }
static void tell_end(void) { pthread_cond_broadcast(&left); }

static int await_end(int milliseconds)
{
#ifdef __APPLE__
    struct timespec wait = {milliseconds / 1000, milliseconds % 1000 * 1000000L};
    return pthread_cond_timedwait_relative_np(&left, &gate, &wait) == 0;
#else
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    int64_t nano = until.tv_nsec + (int64_t)milliseconds * 1000000;
    until.tv_sec += (time_t)(nano / 1000000000);
    until.tv_nsec = (long)(nano % 1000000000);
    return pthread_cond_timedwait(&left, &gate, &until) == 0;
#endif
}

static _Atomic int64_t known; /* the process that these threads belong to */
static void forget(void);

/* In a new process there is none of its parent's threads, and locks may be as one of these held them. The first thread
 * that comes here holds Python's lock. */
static void begin_process(void)
{
    pthread_mutex_init(&gate, NULL);
    pthread_cond_init(&wished, NULL);
    pthread_condattr_t clock;
    pthread_condattr_init(&clock);
#ifndef __APPLE__
    pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
#endif
    pthread_cond_init(&left, &clock);
    forget();
}

static void lock(void)
{
    pid_t now = getpid();
    if (known != now) {
        begin_process();
        known = now;
    }
    pthread_mutex_lock(&gate);
}

static void serve(void);
static void *body(void *nothing) { return serve(), nothing; }

static int add_thread(void)
{
    pthread_t thread;
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
    pthread_attr_setstacksize(&attributes, STACK);
    int made = pthread_create(&thread, &attributes, body, NULL) == 0;
    pthread_attr_destroy(&attributes);
    return made;
}
#endif

/* ---- The pool; all of it under the lock ---- */

static Work *queue;                        /* works that want threads */
static int alive, busy, wanted, largest; /* threads; those at work; that works want; that one work wanted at most */

__attribute__((unused)) static void forget(void)
{
    queue = NULL;
    alive = busy = wanted = largest = 0;
}

/* From now on no thread shall come to this work. */
static void close_work(Work *work)
{
    if (work->wanted == 0)
        return;
    Work **place = &queue;
    while (*place != work)
        place = &(*place)->after;
    *place = work->after;
    wanted -= work->wanted;
    work->wanted = 0;
}

/* What a thread does. */
static void serve(void)
{
    lock();
    for (;;) {
        while (queue == NULL) {
            if (alive - busy > largest) {
                alive--;
                unlock();
                return;
            }
            await_wish();
        }
        Work *work = queue;
        wanted--;
        busy++;
        work->running++;
        if (--work->wanted == 0)
            queue = work->after;
        unlock();
        work_help(work);
        lock();
        busy--;
        close_work(work);
        if (--work->running == 0)
            tell_end();
    }
}

int work_start(Work *work, int threads)
{
    lock();
    work->threads = threads;
    work->process = known;
    if (threads > largest)
        largest = threads; /* until `pool_keep` says less */
    int missing = busy + wanted + threads - alive;
    for (; missing > 0 && add_thread(); missing--)
        alive++;
    if (missing > 0) /* the system makes no more */
        threads = threads > missing ? threads - missing : 0;
    work->wanted = threads;
    wanted += threads;
    if (threads > 0) {
        Work **place = &queue;
        while (*place != NULL)
            place = &(*place)->after;
        *place = work;
        for (int k = 0; k < threads; k++)
            wake_one();
    }
    unlock();
    return threads;
}

int work_wait(Work *work, int milliseconds)
{
    lock();
    if (work->process != known && work->wanted + work->running > 0) { /* no thread of the parent is here */
        work->wanted = work->running = 0;
        work->stopped = 1;
    }
    for (int round = 0;; round++) {
        if (work->next >= work->range.last || work->stopped)
            close_work(work);
        int ended = work->running == 0 && work->wanted == 0;
        if (ended || round == 1 || milliseconds <= 0) {
            unlock();
            return ended;
        }
        await_end(milliseconds);
    }
}

void pool_keep(int most)
{
    lock();
    largest = most;
    wake_all();
    unlock();
}

int pool_size(void)
{
    lock();
    int size = alive;
    unlock();
    return size;
}

#endif
