/* Memory that kernels take and leave, by the names that Numba gives its own.
 *
 * A kernel's scratch is often more than 128 kB, which malloc would map anew each time. So blocks that are left go to a
 * shelf, from which the next kernel of any thread takes them: they belong to no thread, so none is lost with one.
 */
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define LOCAL __attribute__((visibility("hidden")))

/* What Numba's arrays refer to; the order of the first fields is Numba's. Sizes are int64_t, also where addresses have 32
 * bits: kernels were lowered for 64. */
typedef struct {
    int64_t references;
    void (*destroy)(void *, size_t, void *);
    void *destroy_info;
    void *data;
    int64_t size;
    void *external;
    size_t room; /* the whole block */
} Block;

enum { KINDS = 13, SMALLEST = 10, SHELF = 24 }; /* blocks of 2^10 to 2^22 bytes are kept, so many of a size */

static _Atomic(Block *) shelf[KINDS][SHELF];

static int kind_of(size_t size)
{
    int kind = 0;
    while (kind < KINDS && ((size_t)1 << (SMALLEST + kind)) < size)
        kind++;
    return kind;
}

static Block *taken(size_t size)
{
    int kind = kind_of(size);
    if (kind < KINDS) {
        for (int k = 0; k < SHELF; k++) {
            if (atomic_load_explicit(&shelf[kind][k], memory_order_relaxed) == NULL)
                continue;
            Block *found = atomic_exchange_explicit(&shelf[kind][k], NULL, memory_order_acquire);
            if (found != NULL)
                return found;
        }
        size = (size_t)1 << (SMALLEST + kind);
    }
    Block *made = malloc(size);
    if (made != NULL)
        made->room = size;
    return made;
}

static void leave(Block *block)
{
    int kind = kind_of(block->room);
    if (kind < KINDS)
        for (int k = 0; k < SHELF; k++) {
            Block *none = NULL;
            if (atomic_compare_exchange_strong_explicit(
                    &shelf[kind][k], &none, block, memory_order_release, memory_order_relaxed))
                return;
        }
    free(block);
}

LOCAL void *NRT_MemInfo_alloc_aligned(int64_t size, uint32_t align)
{
    if (align < 64)
        align = 64; /* a line of memory */
    if ((uint64_t)size > SIZE_MAX - sizeof(Block) - align)
        return NULL;
    Block *block = taken(sizeof(Block) + align + (size_t)size);
    if (block == NULL)
        return NULL;
    block->references = 1;
    block->destroy = NULL;
    block->destroy_info = block->external = NULL;
    block->size = size;
    block->data = (void *)(((uintptr_t)(block + 1) + align - 1) / align * align);
    return block;
}

LOCAL void *NRT_MemInfo_alloc(int64_t size)
{
    return NRT_MemInfo_alloc_aligned(size, 0);
}

LOCAL void NRT_MemInfo_call_dtor(Block *block)
{
    leave(block);
}

/* One reference less, for the door, which hands a kernel's result to Python. */
LOCAL void conicoid_release(void *result)
{
    Block *block = result;
    if (block != NULL && --block->references == 0)
        leave(block);
}
