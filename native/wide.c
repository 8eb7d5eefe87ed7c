/* Whole numbers of 128 bits, as compilers ask for them where the processor has none (WebAssembly). */
#include <stdint.h>

#define LOCAL __attribute__((visibility("hidden")))

typedef unsigned __int128 Wide;
typedef union {
    Wide whole;
    struct {
        uint64_t low, high;
    };
} Halves;

LOCAL Wide __multi3(Wide first, Wide second)
{
    Halves a = {first}, b = {second}, c;
    uint64_t a0 = (uint32_t)a.low, a1 = a.low >> 32, b0 = (uint32_t)b.low, b1 = b.low >> 32;
    uint64_t low = a0 * b0, middle = a1 * b0 + (low >> 32), other = a0 * b1 + (uint32_t)middle;
    c.low = (other << 32) | (uint32_t)low;
    c.high = a1 * b1 + (middle >> 32) + (other >> 32) + a.low * b.high + a.high * b.low;
    return c.whole;
}

LOCAL Wide __ashlti3(Wide value, int by)
{
    Halves a = {value}, c;
    if (by == 0)
        return value;
    c.low = by < 64 ? a.low << by : 0;
    c.high = by < 64 ? a.high << by | a.low >> (64 - by) : a.low << (by - 64);
    return c.whole;
}

LOCAL Wide __lshrti3(Wide value, int by)
{
    Halves a = {value}, c;
    if (by == 0)
        return value;
    c.high = by < 64 ? a.high >> by : 0;
    c.low = by < 64 ? a.low >> by | a.high << (64 - by) : a.high >> (by - 64);
    return c.whole;
}
