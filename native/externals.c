/* What is left of Numba's own C functions in the code of kernels. */
#include <math.h>

#define LOCAL __attribute__((visibility("hidden")))

LOCAL double numba_frexp(double x, int *exponent)
{
    if (!isfinite(x) || x == 0.0) {
        *exponent = 0;
        return x;
    }
    return frexp(x, exponent);
}

LOCAL double numba_ldexp(double x, int exponent) { return isfinite(x) && x != 0.0 ? ldexp(x, exponent) : x; }

LOCAL double numba_nextafter(double x, double towards) { return nextafter(x, towards); }
