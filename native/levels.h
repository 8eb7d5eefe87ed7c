/* Which level of processor this one is. */
#if defined(__x86_64__)
#include <cpuid.h>

static int bit(unsigned value, int place) { return (int)(value >> place & 1u); }

/* 0 for x86-64-v2 (or less), 1 for x86-64-v3, 2 for x86-64-v4.
 *
 * The last, whose vectors have 512 bits, is for processors that lose nothing by them: not for the first with AVX-512
 * (Skylake, Cascade Lake, Cooper Lake), which lower their clock. Those since have VBMI2 (Ice Lake, Zen 4). */
static int processor(void)
{
    static int known = -1;
    if (known >= 0)
        return known;
    unsigned a, b, c, d, b7 = 0, c7 = 0, d7, c81 = 0, low = 0, high;
    int found = 0;
    if (__get_cpuid(1, &a, &b, &c, &d)) {
        unsigned ignored;
        __get_cpuid_count(7, 0, &ignored, &b7, &c7, &d7);
        __get_cpuid(0x80000001u, &ignored, &ignored, &c81, &ignored);
        if (bit(c, 27)) /* the system saves the registers that xgetbv names */
            __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
        int avx2 = bit(c, 12) && bit(c, 28) && bit(c, 29) && bit(c, 22) && bit(b7, 3) && bit(b7, 5) && bit(b7, 8)
                   && bit(c81, 5) && (low & 6u) == 6u; /* fma, avx, f16c, movbe, bmi, avx2, bmi2, lzcnt */
        int avx512 = bit(b7, 16) && bit(b7, 17) && bit(b7, 28) && bit(b7, 30) && bit(b7, 31) && bit(c7, 6)
                     && (low & 0xe6u) == 0xe6u; /* f, dq, cd, bw, vl, vbmi2 */
        found = avx2 ? (avx512 ? 2 : 1) : 0;
    }
    return known = found;
}
#else
static int processor(void) { return 0; }
#endif
