/* Callers by the dozen that ask the pool at once, stop, and give memory back: a program for sanitizers. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
        int64_t slots[3] = {0, n, (int64_t)(intptr_t)data};
        Work *work = work_new(count, slots, 3, 0, n, most);
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
        for (int k = 0; k < n; k++)
            expect(((int32_t *)data)[k] == 1 || (stopped && ((int32_t *)data)[k] == 0), "not once");
        work_free(work);
        conicoid_release(block);
    }
    return NULL;
}

int main(void)
{
    pthread_t threads[CALLERS];
    atomic_int halt = 0;
    int64_t slots[3] = {0, 4, (int64_t)(intptr_t)&halt};
    Work *dear = work_new(wait_for_halt, slots, 3, 0, 4, 1);
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
    return 0;
}
