/* What the generated tables of kernels are made of (native/tables.py writes them). */
#include <stdint.h>

#include "pool.h"

/* constant + sum of times * value of a symbol; a symbol from TABLE on is the length of a table of the geometry */
enum { TABLE = 1000, ANY = -2, NOTHING = -1 };
typedef struct {
    int64_t constant;
    int16_t symbol[2]; /* NOTHING for none; the first is ANY where everything will do */
    int16_t times[2];
} Sum;

typedef struct {
    Sum sum, other; /* `other` is ANY where there is no second choice */
} Length;

enum Kind { OPEN, OPEN_GEOMETRY, CLOSE, ARRAY, INT, FLOAT, BOOL, NONE };

typedef struct {
    const char *name;
    uint8_t kind;
    uint8_t dimensions; /* of an array; of a record how many parts it has */
    uint8_t written;
    uint8_t strided;    /* an array whose elements may lie apart */
    uint8_t divides;    /* an integer that is -1, 0 or a divisor of its upper limit */
    int16_t symbol;     /* of an integer that others refer to */
    uint16_t size;      /* of an element, in bytes */
    const char *format; /* of an element: letters of Python's `struct` that will do, or its whole description */
    Length length[3];   /* of an array, by dimension; of an integer its limits, ANY where there is none */
} Leaf;

typedef struct {
    const char *name;
    const char *result; /* a letter for each number, "d" or "q"; "A" for an array */
    const Leaf *leaves;
    int arguments, count;
    const Kernel *levels; /* the kernel for each level */
} Entry;
