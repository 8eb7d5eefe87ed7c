/* Callers by the dozen that ask the pool at once, stop, and give memory back: a program for sanitizers. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "pool.h"

enum { CALLERS = 8, ROUNDS = 150, LARGE = 5 << 20 };

void *conicoid_room(int64_t size, void **data);
void conicoid_release(void *block);

static pthread_mutex_t python = PTHREAD_MUTEX_INITIALIZER; /* stands for Python's lock */

static int count(void *result, const int64_t *slots)
{
    (void)result;
    for (int64_t k = slots[0]; k < slots[1]; k++)
        ((int32_t *)(intptr_t)slots[2])[k]++;
    return 0;
}

static atomic_int dropped;
static void drop(int64_t *result) { (void)result, dropped++; }

/* Return where the piece begins. */
static int answer(void *result, const int64_t *slots)
{
    *(int64_t *)result = slots[0];
    return 0;
}

static int wait_for_halt(void *result, const int64_t *slots)
{
    (void)result;
    while (!*(atomic_int *)(intptr_t)slots[2])
        ;
    return 0;
}

static void expect(int holds, const char *what)
{
    if (!holds) {
        puts(what);
        exit(1);
    }
}

static void *caller(void *number)
{
    unsigned seed = (unsigned)(intptr_t)number;
    for (int round = 0; round < ROUNDS; round++) {
        int n = rand_r(&seed) % 3000 + 1, threads = rand_r(&seed) % 4 + 1, most = rand_r(&seed) % 50 + 1;
        void *data, *block = conicoid_room(4 * n + (rand_r(&seed) % 4 == 0 ? LARGE : 0), &data);
        memset(data, 0, 4 * (size_t)n);
        int8_t *marks = calloc((size_t)n, 1);
        int64_t slots[3] = {0, n, (int64_t)(intptr_t)data};
        Range range = {count, slots, 3, 0, 0, n, drop};
        Work *work = work_new(&range, most, marks, 1);
        pthread_mutex_lock(&python);
        int came = work_start(work, threads);
        pthread_mutex_unlock(&python);
        if (came == 0 || rand_r(&seed) % 2)
            work_help(work);
        int stopped = rand_r(&seed) % 5 == 0;
        if (stopped)
            work_stop(work);
        while (!work_wait(work, 50))
            ;
        expect(stopped || work_done(work) == n, "items are missing");
        for (int k = 0; k < n; k++) {
            expect(((int32_t *)data)[k] == 1 || (stopped && ((int32_t *)data)[k] == 0), "not once");
            expect(marks[k] == ((int32_t *)data)[k], "a wrong mark");
        }
        int64_t kept = 0;
        for (Outcome *each = work_outcomes(work), *after; each != NULL; each = after) {
            kept += each->end - each->begin;
            after = each->after;
            free(each);
        }
        expect(kept == work_done(work), "outcomes are missing");
        work_free(work);
        free(marks);
        conicoid_release(block);
    }
    return NULL;
}

/* Calls with slots of their own. */
static void call_many(void)
{
    enum { CALLS = 500, USED = 2 };
    int64_t slots[CALLS * USED] = {0}, sum = 0;
    for (int k = 0; k < CALLS; k++)
        slots[USED * k] = k;
    Range range = {answer, slots, USED, -1, 0, CALLS, drop};
    Work *work = work_new(&range, 1, NULL, 1);
    memset(slots, 0, sizeof slots); /* the work has its own */
    work_start(work, 3);
    while (!work_wait(work, 50))
        ;
    for (Outcome *each = work_outcomes(work), *after; each != NULL; each = after) {
        expect(each->result[0] == each->begin, "another call's result");
        sum += each->begin;
        after = each->after;
        free(each);
    }
    expect(sum == CALLS * (CALLS - 1) / 2, "calls are missing");
    work_free(work);
    pool_keep(1);
    for (int k = 0; k < 1000 && pool_size() > 1; k++)
        nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
    expect(pool_size() <= 1, "idle threads stayed");
}

static int nothing(void *result, const int64_t *slots) { return (void)result, (void)slots, 0; }

/* Nanoseconds that a thread takes for a piece in which nothing is to be done, of a million. */
static double empty_piece(int threads)
{
    enum { PIECES = 1000000 };
    struct timespec begin, end;
    int64_t slots[2] = {0, PIECES};
    Range range = {nothing, slots, 2, 0, 0, PIECES, drop};
    Work *work = work_new(&range, 1, NULL, 0);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
    work_start(work, threads);
    while (!work_wait(work, 50))
        ;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    expect(work_done(work) == PIECES, "empty pieces are missing");
    work_free(work);
    return ((double)(end.tv_sec - begin.tv_sec) * 1e9 + (double)(end.tv_nsec - begin.tv_nsec)) / PIECES;
}

int main(void)
{
    for (int threads = 1; threads <= 2; threads++) {
        double time = empty_piece(threads);
        printf("%d threads: %.0f ns of a core for an empty piece\n", threads, time);
        expect(time < 5000, "the counter is contended");
    }
    call_many();
    pthread_t threads[CALLERS];
    atomic_int halt = 0;
    int64_t slots[3] = {0, 4, (int64_t)(intptr_t)&halt};
    Range range = {wait_for_halt, slots, 3, 0, 0, 4, drop};
    Work *dear = work_new(&range, 1, NULL, 0);
    work_start(dear, 2);
    for (int k = 0; k < CALLERS; k++)
        pthread_create(&threads[k], NULL, caller, (void *)(intptr_t)(k + 1));
    for (int k = 0; k < CALLERS; k++)
        pthread_join(threads[k], NULL);
    expect(!work_wait(dear, 10), "ended before the halt");
    work_stop(dear);
    halt = 1;
    while (!work_wait(dear, 50))
        ;
    expect(work_done(dear) < 4, "went on after the stop");
    work_free(dear);
    expect(dropped == 0, "dropped what was kept");
    return 0;
}
