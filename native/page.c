/* Memory for kernels in a page (WebAssembly), by the names that Numba gives its own.
 *
 * There is one thread, and nothing of C's library. Sizes are int64_t, because the kernels were lowered for 64 bits.
 * What a kernel leaves is kept for the next by powers of two; memory only grows.
 */
#include <stddef.h>
#include <stdint.h>

#define EXPORT(name) __attribute__((export_name(name)))

/* What Numba's arrays refer to; the order of the first fields is Numba's. */
typedef struct Block {
    int64_t references;
    void (*destroy)(void *, size_t, void *);
    void *destroy_info;
    void *data;
    int64_t size;
    void *external;
    struct Block *next; /* of those that are free */
    int kind;
} Block;

enum { LINE = 64, PAGE = 65536, SMALLEST = 10, KINDS = 20 }; /* blocks of 2^10 to 2^29 bytes */

extern unsigned char __heap_base;
static uintptr_t end; /* of what has been taken; 0 before anything was */
static Block *left[KINDS];

/* So many bytes, at a line of memory, which nobody takes back; NULL where there are no more. */
EXPORT("room") void *room(uint32_t size)
{
    uintptr_t begin = end == 0 ? (uintptr_t)&__heap_base : end;
    begin = (begin + LINE - 1) / LINE * LINE;
    uint64_t last = (uint64_t)begin + size, have = (uint64_t)__builtin_wasm_memory_size(0) * PAGE;
    if (last > have && __builtin_wasm_memory_grow(0, (size_t)((last - have + PAGE - 1) / PAGE)) == SIZE_MAX)
        return NULL;
    end = (uintptr_t)last;
    return (void *)begin;
}

void *NRT_MemInfo_alloc_aligned(int64_t size, uint32_t align)
{
    int kind = 0;
    if (align < LINE)
        align = LINE;
    int64_t whole = size + (int64_t)sizeof(Block) + align;
    while (kind < KINDS && ((int64_t)1 << (SMALLEST + kind)) < whole)
        kind++;
    if (kind == KINDS)
        return NULL;
    Block *block = left[kind];
    if (block != NULL)
        left[kind] = block->next;
    else if ((block = room((uint32_t)1 << (SMALLEST + kind))) == NULL)
        return NULL;
    void *data = (void *)(((uintptr_t)(block + 1) + align - 1) / align * align);
    *block = (Block){.references = 1, .data = data, .size = size, .kind = kind};
    return block;
}

void *NRT_MemInfo_alloc(int64_t size) { return NRT_MemInfo_alloc_aligned(size, 0); }

void NRT_MemInfo_call_dtor(Block *block)
{
    block->next = left[block->kind];
    left[block->kind] = block;
}

/* One reference less, for a page that has read a kernel's result. */
EXPORT("release") void release(Block *block)
{
    if (--block->references == 0)
        NRT_MemInfo_call_dtor(block);
}
