/* Memory that kernels take and leave, by the names that Numba gives its own.
 *
 * A kernel's scratch is often more than 128 kB, which malloc would map anew each time. So blocks that are left go to a
 * shelf, from which the next kernel of any thread takes them: they belong to no thread, so none is lost with one. The
 * same holds for the arrays of rays and answers: to touch new pages for a million hits takes as long as a third of the
 * hits. These blocks have a shelf of their own, of which all together are bounded, in large pages where there are any.
 */
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifdef __linux__
#include <sys/mman.h>
#endif

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

enum { LARGE_SHELF = 32, LARGE_PAGE = 2 << 20, MOST_KEPT = 256 << 20 }; /* bytes of all large blocks that are kept */

static _Atomic(Block *) shelf[KINDS][SHELF], large[LARGE_SHELF];
static _Atomic int64_t kept;

static int kind_of(size_t size)
{
    int kind = 0;
    while (kind < KINDS && ((size_t)1 << (SMALLEST + kind)) < size)
        kind++;
    return kind;
}

/* A large block that was kept and has room for `size`, but not for twice as much; of any room if `size` is 0. */
static Block *taken_large(size_t size)
{
    for (int k = 0; k < LARGE_SHELF; k++) {
        if (atomic_load_explicit(&large[k], memory_order_relaxed) == NULL)
            continue;
        Block *found = atomic_exchange_explicit(&large[k], NULL, memory_order_acquire), *none = NULL;
        if (found == NULL)
            continue;
        if (size == 0 || (found->room >= size && found->room / 2 <= size)) {
            kept -= (int64_t)found->room;
            return found;
        }
        if (!atomic_compare_exchange_strong_explicit(
                &large[k], &none, found, memory_order_release, memory_order_relaxed)) {
            kept -= (int64_t)found->room;
            free(found);
        }
    }
    return NULL;
}

/* Keep a large block, in place of others where all together would be too much. */
static void leave_large(Block *block)
{
    int64_t room = (int64_t)block->room;
    Block *other;
    if (room <= MOST_KEPT) {
        kept += room;
        while (kept > MOST_KEPT && (other = taken_large(0)) != NULL)
            free(other);
        for (int k = 0; k < LARGE_SHELF; k++) {
            Block *none = NULL;
            if (atomic_compare_exchange_strong_explicit(
                    &large[k], &none, block, memory_order_release, memory_order_relaxed))
                return;
        }
        kept -= room;
    }
    free(block);
}

static Block *new_large(size_t size)
{
    Block *made = malloc(size), *other;
    while (made == NULL && (other = taken_large(0)) != NULL) {
        free(other);
        made = malloc(size);
    }
#ifdef __linux__
    uintptr_t begin = ((uintptr_t)made + LARGE_PAGE - 1) / LARGE_PAGE * LARGE_PAGE;
    uintptr_t end = ((uintptr_t)made + size) / LARGE_PAGE * LARGE_PAGE;
    if (made != NULL && end > begin)
        madvise((void *)begin, end - begin, MADV_HUGEPAGE);
#endif
    return made;
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
    Block *made = kind < KINDS ? NULL : taken_large(size);
    if (made != NULL)
        return made;
    made = kind < KINDS ? malloc(size) : new_large(size);
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
    if (kind < KINDS)
        free(block);
    else
        leave_large(block);
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

/* A block for the door, and where its `size` bytes begin; NULL where there is no memory. */
LOCAL void *conicoid_room(int64_t size, void **data)
{
    Block *block = NRT_MemInfo_alloc_aligned(size, 0);
    if (block != NULL)
        *data = block->data;
    return block;
}

/* One reference less, for the door, which hands a kernel's result to Python. */
LOCAL void conicoid_release(void *result)
{
    Block *block = result;
    if (block != NULL && --block->references == 0)
        leave(block);
}
