/* Threads for kernels (pool.c). */
#pragma once
#include <stdint.h>

typedef int (*Kernel)(void *result, const int64_t *slots);
typedef struct Work Work;

/* A kernel over a range, in pieces of at most `most`; `begin` is the slot of where a piece begins, the next of where it
 * ends. NULL where there is no memory. */
Work *work_new(Kernel kernel, const int64_t *slots, int used, int begin, int64_t count, int64_t most);
void work_free(Work *work); /* of which no thread takes pieces */

int work_start(Work *work, int threads);     /* how many threads of the pool take pieces from now on */
void work_help(Work *work);                  /* take pieces until none is left */
int work_wait(Work *work, int milliseconds); /* does no thread take pieces any more? */
void work_stop(Work *work);                  /* give out no more pieces */
int64_t work_done(Work *work);               /* items of the pieces that are done */
int work_status(Work *work);                 /* what a kernel returned that failed, else 0 */
