/* a b + c with one rounding, by integers, for processors without the instruction.
 *
 * LLVM calls `fma` there. The C library's own would decide bits, so it is not asked: this one is linked in, hidden. The
 * product has up to 106 bits, so both terms stand as W 2^E with W of 126 bits; what the smaller one loses as it is
 * brought to the other's exponent is remembered in its last bit, which is far below the one that is rounded.
 */
#include <stdint.h>

#pragma STDC FP_CONTRACT OFF

#ifndef FMA
#define FMA __attribute__((visibility("hidden"))) double fma
#endif

typedef unsigned __int128 Wide;
typedef struct {
    Wide w;      /* with bit 125 as its highest */
    int e;       /* times 2^e */
    int negative;
} Term;

enum { FRACTION = 52, TOP = 125, LEAST = -1074, MOST = 1023 }; /* LEAST: of the smallest number; MOST: of the largest */

static uint64_t bits_of(double x)
{
    uint64_t bits;
    __builtin_memcpy(&bits, &x, sizeof bits);
    return bits;
}

static double of_bits(uint64_t bits)
{
    double x;
    __builtin_memcpy(&x, &bits, sizeof x);
    return x;
}

static int is_finite(uint64_t bits) { return (bits >> FRACTION & 0x7ff) != 0x7ff; }

/* The highest bit of a number other than 0. */
static int highest(Wide w)
{
    uint64_t high = (uint64_t)(w >> 64);
    return high != 0 ? 127 - __builtin_clzll(high) : 63 - __builtin_clzll((uint64_t)w);
}

/* w 2^e with its highest bit where it should be; it gets no shorter. */
static Term term(Wide w, int e, int negative)
{
    int shift = TOP - highest(w);
    return (Term){w << shift, e - shift, negative};
}

/* A whole number m and e, where m 2^e is |x|: finite and not 0. */
static uint64_t parts(uint64_t bits, int *e)
{
    int biased = (int)(bits >> FRACTION & 0x7ff);
    uint64_t fraction = bits & (((uint64_t)1 << FRACTION) - 1);
    *e = LEAST + (biased > 0 ? biased - 1 : 0);
    return biased > 0 ? fraction | (uint64_t)1 << FRACTION : fraction;
}

/* w 2^-shift, whose last bit says as well whether a bit was lost. */
static Wide shifted(Wide w, int shift)
{
    if (shift == 0)
        return w;
    if (shift > TOP)
        return 1;
    return w >> shift | ((w << (128 - shift)) != 0);
}

/* The nearest float, the even one of two. */
static double rounded(Wide w, int e, int negative)
{
    int top = highest(w), drop = top - FRACTION;
    uint64_t sign = (uint64_t)negative << 63;
    if (e + top > MOST)
        return of_bits(sign | (uint64_t)0x7ff << FRACTION);
    if (drop < LEAST - e)
        drop = LEAST - e; /* among the numbers that have fewer bits */
    uint64_t whole;
    if (drop <= 0)
        whole = (uint64_t)(w << -drop);
    else if (drop > top + 1)
        whole = 0; /* less than half of the smallest */
    else {
        Wide rest = w & (((Wide)1 << drop) - 1), half = (Wide)1 << (drop - 1);
        whole = (uint64_t)(w >> drop);
        whole += rest > half || (rest == half && (whole & 1));
    }
    return of_bits(sign | (((uint64_t)(e + drop - LEAST) << FRACTION) + whole)); /* carries into the exponent, or to inf */
}

FMA(double a, double b, double c)
{
    uint64_t p = bits_of(a), q = bits_of(b), r = bits_of(c);
    if (is_finite(p) && is_finite(q) && !is_finite(r))
        return c; /* though the product may overflow */
    if (!is_finite(p) || !is_finite(q) || a == 0.0 || b == 0.0)
        return a * b + c;
    if (c == 0.0)
        return a * b; /* where it comes to 0, its sign stays */
    int ea, eb, ec;
    uint64_t ma = parts(p, &ea), mb = parts(q, &eb), mc = parts(r, &ec);
    Term x = term((Wide)ma * mb, ea + eb, (int)((p ^ q) >> 63)), y = term(mc, ec, (int)(r >> 63));
    if (x.e < y.e || (x.e == y.e && x.w < y.w)) {
        Term other = x;
        x = y;
        y = other;
    }
    Wide small = shifted(y.w, x.e - y.e);
    Wide sum = x.negative == y.negative ? x.w + small : x.w - small;
    return sum == 0 ? 0.0 : rounded(sum, x.e, x.negative);
}
