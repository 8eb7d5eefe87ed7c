/* Threads for kernels (pool.c). */
#pragma once
#include <stdint.h>

typedef int (*Kernel)(void *result, const int64_t *slots);
typedef struct Work Work;

/* A kernel over first..last. The slot `begin` says where a piece begins, the next where it ends; where `begin` is below 0
 * each item is a call with `used` slots of its own. */
typedef struct {
    Kernel kernel;
    const int64_t *slots;
    int used, begin;
    int64_t first, last;
    void (*drop)(int64_t *result); /* give back what the kernel returned */
} Range;

/* What a kernel returned for a piece. */
typedef struct Outcome {
    int64_t result[16], begin, end;
    struct Outcome *after;
} Outcome;

/* A range in pieces of at most `most`. Each item that is done gets the mark 1, where there are marks; what the kernel
 * returns is kept, if `keeps`. NULL where there is no memory. */
Work *work_new(const Range *range, int64_t most, int8_t *marks, int keeps);
void work_free(Work *work); /* of which no thread takes pieces */

int work_start(Work *work, int threads);     /* how many threads of the pool take pieces from now on */
void work_help(Work *work);                  /* take pieces until none is left */
int work_wait(Work *work, int milliseconds); /* does no thread take pieces any more? */
void work_stop(Work *work);                  /* give out no more pieces */
int64_t work_done(Work *work);               /* items of the pieces that are done */
int work_status(Work *work);                 /* what a kernel returned that failed, else 0 */
Outcome *work_outcomes(Work *work);          /* what was kept, from now on the caller's */

void pool_keep(int most); /* let threads beyond so many end as soon as they have no work */
int pool_size(void);      /* threads that are there */
