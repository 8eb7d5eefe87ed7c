/* conicoid._kernels: the kernels as functions of Python.
 *
 * Every argument is tested for all that machine code relies on, as its tables (native/tables.py) say: the type and order
 * of elements, alignment, that it may be written to, lengths that belong together, limits of whole numbers, and that the
 * tables of a geometry lie within its arrays. What is wrong raises TypeError or ValueError with the argument's name. Not
 * tested is what index arrays hold. Kernels run without the interpreter's lock.
 */
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "python.h"

#include "door.h"
#include "levels.h"
#include "tables.h" /* generated: ENTRIES, LEVELS, GEOMETRY_TABLES, GEOMETRY_IS_REAL, SOURCES */

void conicoid_release(void *block);
void *conicoid_room(int64_t size, void **data);

static int level = 0;

/* The last level that this processor can run; -1 if there is none. */
static int best_level(void)
{
    int best = -1;
    for (int k = 0; k < (int)(sizeof LEVELS / sizeof *LEVELS); k++)
        if (NEEDS[k] <= processor())
            best = k;
    return best;
}

/* ---- One call ---- */

typedef struct {
    const Entry *entry;
    int64_t slots[MOST_SLOTS];
    int64_t lengths[MOST_ARRAYS][3]; /* of each array, for the second round */
    int first[MOST_ARRAYS];          /* slot of each array */
    int64_t ints[MOST_SLOTS];
    Py_buffer buffers[MOST_ARRAYS];
    int64_t value[MOST_SYMBOLS];
    uint32_t bound;            /* which symbols have a value */
    const int64_t *places;     /* of the first geometry */
    int slot, arrays, ints_used;
    int begin; /* the slot of the argument of this name, -1 for none */
} Call;

static int wrong(const Call *call, const Leaf *leaf, PyObject *kind, const char *what)
{
    PyErr_Format(kind, "%s: %s %s", call->entry->name, leaf->name, what);
    return -1;
}

static int knows(const Call *call, const Sum *sum)
{
    for (int k = 0; k < 2; k++) {
        int symbol = sum->symbol[k];
        if (symbol >= 0 && symbol < TABLE && !(call->bound >> symbol & 1))
            return 0;
    }
    return 1;
}

static int64_t amount(const Call *call, const Sum *sum)
{
    int64_t total = sum->constant;
    for (int k = 0; k < 2; k++) {
        int symbol = sum->symbol[k];
        if (symbol >= TABLE)
            total += sum->times[k] * call->places[GEOMETRY_TABLES + symbol - TABLE];
        else if (symbol >= 0)
            total += sum->times[k] * call->value[symbol];
    }
    return total;
}

static int is_any(const Sum *sum) { return sum->symbol[0] == ANY; }

/* The first array of length n, or 8*n, says what n is. */
static void bind(Call *call, const Length *length, int64_t found)
{
    const Sum *sum = &length->sum;
    int symbol = sum->symbol[0];
    if (symbol < 0 || symbol >= TABLE || (call->bound >> symbol & 1) || sum->symbol[1] != NOTHING || sum->constant)
        return;
    if (!is_any(&length->other)) /* n|1: another argument says what n is */
        return;
    if (found % sum->times[0] == 0) {
        call->value[symbol] = found / sum->times[0];
        call->bound |= 1u << symbol;
    }
}

/* Are two descriptions of a record the same? A whole number of 64 bits is l on one platform and q on another. */
static int alike(const char *a, const char *b)
{
    for (; *a != 0 && *b != 0; a++, b++)
        if (*a != *b && !(strchr("lq", *a) != NULL && strchr("lq", *b) != NULL))
            return 0;
    return *a == *b;
}

static int take_array(Call *call, const Leaf *leaf, PyObject *given)
{
    Py_buffer *buffer = &call->buffers[call->arrays];
    int flags = PyBUF_FORMAT | (leaf->strided ? PyBUF_STRIDES : PyBUF_C_CONTIGUOUS) | (leaf->written ? PyBUF_WRITABLE : 0);
    if (PyObject_GetBuffer(given, buffer, flags) != 0) {
        PyErr_Clear();
        if (leaf->strided)
            return wrong(call, leaf, PyExc_TypeError, "must be an array");
        return wrong(call, leaf, PyExc_TypeError,
                     leaf->written ? "must be a C-contiguous array that can be written to" : "must be a C-contiguous array");
    }
    call->first[call->arrays] = call->slot;
    int64_t *lengths = call->lengths[call->arrays++];
    if (buffer->ndim != leaf->dimensions)
        return wrong(call, leaf, PyExc_TypeError, "has the wrong number of dimensions");
    const char *format = buffer->format == NULL ? "B" : buffer->format;
    int fits = leaf->format[0] == '|' ? alike(format, leaf->format + 1)
                                      : format[0] != 0 && format[1] == 0 && strchr(leaf->format, format[0]) != NULL;
    if (!fits || buffer->itemsize != leaf->size)
        return wrong(call, leaf, PyExc_TypeError, "has elements of the wrong type");
    int64_t *slot = call->slots + call->slot;
    int n = leaf->dimensions;
    uintptr_t align = leaf->size % 8 == 0 ? 8 : leaf->size;
    if ((uintptr_t)buffer->buf % align != 0)
        return wrong(call, leaf, PyExc_ValueError, "is not aligned in memory");
    slot[0] = slot[1] = 0; /* nothing counts references to it */
    slot[2] = buffer->len / buffer->itemsize;
    slot[3] = buffer->itemsize;
    slot[4] = (int64_t)(intptr_t)buffer->buf;
    int64_t stride = buffer->itemsize;
    for (int k = n - 1; k >= 0; k--) {
        lengths[k] = slot[5 + k] = buffer->shape[k];
        slot[5 + n + k] = leaf->strided ? buffer->strides[k] : stride;
        if ((uintptr_t)slot[5 + n + k] % align != 0)
            return wrong(call, leaf, PyExc_ValueError, "is not aligned in memory");
        stride *= buffer->shape[k];
        bind(call, &leaf->length[k], lengths[k]);
    }
    call->slot += 5 + 2 * n;
    return 0;
}

static int take_int(Call *call, const Leaf *leaf, PyObject *given)
{
    PyObject *whole = given == Py_True || given == Py_False ? NULL : PyNumber_Index(given);
    long long value = whole == NULL ? 0 : PyLong_AsLongLong(whole);
    Py_DecRef(whole);
    if (whole == NULL || (value == -1 && PyErr_Occurred())) {
        PyErr_Clear();
        return wrong(call, leaf, PyExc_TypeError, "must be a whole number of 64 bits");
    }
    if (leaf->symbol >= 0) {
        call->value[leaf->symbol] = value;
        call->bound |= 1u << leaf->symbol;
    }
    if (strcmp(leaf->name, "begin") == 0)
        call->begin = call->slot;
    call->slots[call->slot++] = call->ints[call->ints_used++] = value;
    return 0;
}

static int take_float(Call *call, const Leaf *leaf, PyObject *given)
{
    double value = PyFloat_AsDouble(given);
    if (value == -1.0 && PyErr_Occurred()) {
        PyErr_Clear();
        return wrong(call, leaf, PyExc_TypeError, "must be a number");
    }
    memcpy(&call->slots[call->slot++], &value, 8);
    return 0;
}

static int take_bool(Call *call, const Leaf *leaf, PyObject *given)
{
    int value = given == Py_True ? 1 : given == Py_False ? 0 : -1;
    if (value < 0) { /* NumPy's own are no subclass */
        PyObject *type = PyObject_GetAttrString((PyObject *)given->type, "__name__");
        const char *name = type == NULL ? NULL : PyUnicode_AsUTF8AndSize(type, NULL);
        if (name != NULL && (strcmp(name, "bool") == 0 || strcmp(name, "bool_") == 0))
            value = PyObject_IsTrue(given);
        Py_DecRef(type);
        PyErr_Clear();
    }
    if (value < 0)
        return wrong(call, leaf, PyExc_TypeError, "must be True or False");
    call->slots[call->slot++] = value;
    return 0;
}

static int take(Call *call, const Leaf **next, PyObject *given);

static int take_record(Call *call, const Leaf **next, PyObject *given)
{
    const Leaf *leaf = (*next)++;
    int first = call->arrays;
    if (!(PyType_GetFlags(given->type) & Py_TPFLAGS_TUPLE_SUBCLASS) || PyTuple_Size(given) != leaf->dimensions)
        return wrong(call, leaf, PyExc_TypeError, "must be a tuple of as many parts as its record has");
    for (Py_ssize_t k = 0; k < leaf->dimensions; k++)
        if (take(call, next, PyTuple_GetItem(given, k)) != 0)
            return -1;
    (*next)++; /* CLOSE */
    if (leaf->kind != OPEN_GEOMETRY)
        return 0;
    const int64_t *places = call->buffers[first].buf;
    if (call->lengths[first][0] < 2 * GEOMETRY_TABLES + 4)
        return wrong(call, leaf, PyExc_ValueError, "has too few places");
    if (places[2 * GEOMETRY_TABLES + 2] < 1 || places[2 * GEOMETRY_TABLES + 3] < 1)
        return wrong(call, leaf, PyExc_ValueError, "must have sizes of its largest body");
    for (int k = 0; k < GEOMETRY_TABLES; k++) {
        int64_t begin = places[k], length = places[GEOMETRY_TABLES + k];
        int64_t room = call->lengths[first + (GEOMETRY_IS_REAL[k] ? 2 : 1)][0];
        if (GEOMETRY_IS_REAL[k])
            room -= GEOMETRY_SPARE;
        if (begin < 0 || length < 0 || begin > room || length > room - begin)
            return wrong(call, leaf, PyExc_ValueError, "has tables that do not lie in its arrays");
    }
    if (call->places == NULL)
        call->places = places;
    return 0;
}

static int take(Call *call, const Leaf **next, PyObject *given)
{
    const Leaf *leaf = *next;
    if (given == NULL)
        return -1;
    switch (leaf->kind) {
    case OPEN:
    case OPEN_GEOMETRY:
        return take_record(call, next, given);
    case ARRAY:
        (*next)++;
        return take_array(call, leaf, given);
    case INT:
        (*next)++;
        return take_int(call, leaf, given);
    case FLOAT:
        (*next)++;
        return take_float(call, leaf, given);
    case BOOL:
        (*next)++;
        return take_bool(call, leaf, given);
    default:
        (*next)++;
        if (given != Py_None)
            return wrong(call, leaf, PyExc_TypeError, "must be None");
        call->slots[call->slot++] = 0;
        return 0;
    }
}

static int is_length(const Call *call, const Sum *sum, int64_t found)
{
    return knows(call, sum) && amount(call, sum) == found;
}

/* The second round: all names have their values. */
static int check(Call *call)
{
    int array = 0, number = 0;
    const Entry *entry = call->entry;
    for (const Leaf *leaf = entry->leaves; leaf < entry->leaves + entry->count; leaf++) {
        if (leaf->kind == ARRAY) {
            const int64_t *found = call->lengths[array++];
            for (int k = 0; k < leaf->dimensions; k++) {
                const Length *length = &leaf->length[k];
                if (is_any(&length->sum) || is_length(call, &length->sum, found[k]))
                    continue;
                if (is_any(&length->other) || !is_length(call, &length->other, found[k]))
                    return wrong(call, leaf, PyExc_ValueError, "has the wrong length");
            }
        } else if (leaf->kind == INT) {
            int64_t value = call->ints[number++];
            const Sum *low = &leaf->length[0].sum, *high = &leaf->length[1].sum;
            if (leaf->divides) {
                int64_t whole = amount(call, high);
                if (value != 0 && (value < 0 || whole % value != 0))
                    return wrong(call, leaf, PyExc_ValueError, "is no width of a picture of so many rays");
            } else if ((!is_any(low) && value < amount(call, low)) || (!is_any(high) && value > amount(call, high)))
                return wrong(call, leaf, PyExc_ValueError, "is out of range");
        }
    }
    return 0;
}

/* ---- Results ---- */

typedef struct {
    PyObject base;
    void *block;
    void *data;
    Py_ssize_t shape[2], strides[2];
} Rows;

static void rows_free(PyObject *self)
{
    PyTypeObject *type = self->type;
    conicoid_release(((Rows *)self)->block);
    void (*release)(void *) = PyType_GetSlot(type, Py_tp_free);
    release(self);
    Py_DecRef((PyObject *)type);
}

static int rows_buffer(PyObject *self, Py_buffer *view, int flags)
{
    (void)flags; /* whoever does not want strides gets contiguous memory all the same */
    Rows *rows = (Rows *)self;
    view->buf = rows->data;
    view->obj = new_reference(self);
    view->len = 8 * rows->shape[0] * rows->shape[1];
    view->itemsize = 8;
    view->readonly = 0;
    view->ndim = 2;
    view->format = (char *)"d";
    view->shape = rows->shape;
    view->strides = rows->strides;
    view->suboffsets = NULL;
    view->internal = NULL;
    return 0;
}

static PyType_Slot rows_slots[] = {
    {Py_tp_dealloc, rows_free},
    {Py_bf_getbuffer, rows_buffer},
    {Py_tp_doc, "An array (n, m) of floats that a kernel returned."},
    {0, NULL},
};
static PyType_Spec rows_spec = {
    "conicoid._kernels.Rows", sizeof(Rows), 0, Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, rows_slots};
static PyTypeObject *rows_type;

/* What a kernel leaves: numbers of 64 bits, or Numba's array of two dimensions. */
typedef union {
    int64_t numbers[9];
    struct {
        void *block, *parent;
        int64_t count, size; /* of one */
        void *data;
        int64_t shape[2], strides[2];
    } array;
} Result;

/* A new object, all zeros after its head. */
static void *made_of(PyTypeObject *type)
{
    PyObject *(*make)(PyTypeObject *, Py_ssize_t) = PyType_GetSlot(type, Py_tp_alloc);
    return make(type, 0);
}

static PyObject *rows_of(const Result *result)
{
    Rows *rows = made_of(rows_type);
    if (rows == NULL) {
        conicoid_release(result->array.block);
        return NULL;
    }
    rows->block = result->array.block;
    rows->data = result->array.data;
    for (int k = 0; k < 2; k++) {
        rows->shape[k] = (Py_ssize_t)result->array.shape[k];
        rows->strides[k] = (Py_ssize_t)result->array.strides[k];
    }
    return (PyObject *)rows;
}

static PyObject *as_python(const char *kind, const Result *result)
{
    if (kind[0] == 0)
        return new_reference(Py_None);
    if (kind[0] == 'A')
        return rows_of(result);
    int count = (int)strlen(kind);
    PyObject *all = count == 1 ? NULL : PyTuple_New(count);
    if (count > 1 && all == NULL)
        return NULL;
    for (int k = 0; k < count; k++) {
        double real;
        memcpy(&real, &result->numbers[k], 8);
        PyObject *one = kind[k] == 'd' ? PyFloat_FromDouble(real) : PyLong_FromLongLong(result->numbers[k]);
        if (count == 1)
            return one;
        if (one == NULL || PyTuple_SetItem(all, k, one) != 0) {
            Py_DecRef(all);
            return NULL;
        }
    }
    return all;
}

/* ---- The functions ---- */

typedef struct {
    PyObject base;
    const Entry *entry;
} Function;

/* The arguments of a call; its buffers are to be released in any case. */
static int take_all(Call *call, const Entry *entry, PyObject *arguments)
{
    call->entry = entry;
    call->bound = 0;
    memset(call->value, 0, sizeof call->value);
    call->places = NULL;
    call->slot = call->arrays = call->ints_used = 0;
    call->begin = -1;
    Py_ssize_t count = PyTuple_Size(arguments);
    if (count != entry->arguments) {
        PyErr_Format(PyExc_TypeError, "%s takes %d arguments, got %zd", entry->name, entry->arguments, count);
        return -1;
    }
    const Leaf *next = entry->leaves;
    for (Py_ssize_t k = 0; k < count; k++)
        if (take(call, &next, PyTuple_GetItem(arguments, k)) != 0)
            return -1;
    return check(call);
}

static void release_all(Call *call)
{
    for (int k = 0; k < call->arrays; k++)
        PyBuffer_Release(&call->buffers[k]);
}

static PyObject *run(const Entry *entry, const int64_t *slots)
{
    Result result = {{0}};
    Kernel kernel = entry->levels[level];
    PyThreadState *state = PyEval_SaveThread();
    int status = kernel(&result, slots);
    PyEval_RestoreThread(state);
    if (status == 0 || status == -2)
        return as_python(entry->result, &result);
    return PyErr_Format(PyExc_MemoryError, "%s: there is not enough memory", entry->name);
}

static PyObject *function_call(PyObject *self, PyObject *arguments, PyObject *named)
{
    const Entry *entry = ((Function *)self)->entry;
    if (named != NULL && PyDict_Size(named) > 0)
        return PyErr_Format(PyExc_TypeError, "%s: arguments have no names here", entry->name);
    Call call;
    PyObject *answer = take_all(&call, entry, arguments) == 0 ? run(entry, call.slots) : NULL;
    release_all(&call);
    return answer;
}

static PyObject *function_name(PyObject *self, void *closure)
{
    (void)closure;
    return PyUnicode_FromString(((Function *)self)->entry->name);
}

static PyObject *function_repr(PyObject *self)
{
    return PyUnicode_FromFormat("<kernel %s for %s>", ((Function *)self)->entry->name, LEVELS[level]);
}

static void function_free(PyObject *self)
{
    PyTypeObject *type = self->type;
    void (*release)(void *) = PyType_GetSlot(type, Py_tp_free);
    release(self);
    Py_DecRef((PyObject *)type);
}

static PyGetSetDef function_fields[] = {{"__name__", function_name, NULL, NULL, NULL}, {NULL, NULL, NULL, NULL, NULL}};
static PyType_Slot function_slots[] = {
    {Py_tp_call, function_call},
    {Py_tp_dealloc, function_free},
    {Py_tp_getset, function_fields},
    {Py_tp_repr, function_repr},
    {Py_tp_doc, "A kernel."},
    {0, NULL},
};
static PyType_Spec function_spec = {
    "conicoid._kernels.Kernel", sizeof(Function), 0, Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION,
    function_slots};
static PyTypeObject *function_type;

/* The entry with a name; NULL without an error where there is none. */
static const Entry *entry_of(PyObject *name)
{
    const char *wanted = PyUnicode_AsUTF8AndSize(name, NULL);
    for (size_t k = 0; wanted != NULL && k < sizeof ENTRIES / sizeof *ENTRIES; k++)
        if (strcmp(ENTRIES[k].name, wanted) == 0)
            return &ENTRIES[k];
    return NULL;
}

#include "single.h"
#include "pieces.h"

/* ---- The module ---- */

static PyObject *module_kernel(PyObject *module, PyObject *name)
{
    (void)module;
    const Entry *entry = entry_of(name);
    if (entry == NULL)
        return PyErr_Occurred() ? NULL : new_reference(Py_None);
    Function *made = made_of(function_type);
    if (made != NULL)
        made->entry = entry;
    return (PyObject *)made;
}

static PyObject *module_room(PyObject *module, PyObject *size)
{
    (void)module;
    long long bytes = PyLong_AsLongLong(size);
    if (bytes == -1 && PyErr_Occurred())
        return NULL;
    Result result = {.array = {.shape = {(bytes + 7) / 8, 1}, .strides = {8, 8}}};
    if (bytes >= 0 && bytes <= INT64_MAX - 7)
        result.array.block = conicoid_room(bytes, &result.array.data);
    if (result.array.block == NULL)
        return PyErr_Format(PyExc_MemoryError, "there is not enough memory");
    return rows_of(&result);
}

static PyObject *module_keep_threads(PyObject *module, PyObject *most)
{
    (void)module;
    long long count = PyLong_AsLongLong(most);
    if (count == -1 && PyErr_Occurred())
        return NULL;
    if (count >= 0 && count <= 65536)
        pool_keep((int)count);
    return PyLong_FromLongLong(pool_size());
}

/* Whoever has read a mark of an item sees behind this what its thread wrote before the mark (pool.c). */
static PyObject *module_acquire(PyObject *module, PyObject *nothing)
{
    (void)module, (void)nothing;
    atomic_thread_fence(memory_order_acquire);
    return new_reference(Py_None);
}

static PyObject *module_names(PyObject *module, PyObject *nothing)
{
    (void)module, (void)nothing;
    PyObject *names = PyList_New(0);
    for (size_t k = 0; names != NULL && k < sizeof ENTRIES / sizeof *ENTRIES; k++) {
        PyObject *name = PyUnicode_FromString(ENTRIES[k].name);
        if (name == NULL || PyList_Append(names, name) != 0)
            names = (Py_DecRef(names), NULL);
        Py_DecRef(name);
    }
    return names;
}

static PyObject *module_returns_array(PyObject *module, PyObject *name)
{
    (void)module;
    const Entry *entry = entry_of(name);
    if (entry == NULL && PyErr_Occurred())
        return NULL;
    return PyBool_FromLong(entry != NULL && entry->result[0] == 'A');
}

static PyObject *module_levels(PyObject *module, PyObject *nothing)
{
    (void)module, (void)nothing;
    int count = best_level() + 1;
    PyObject *names = PyTuple_New(count);
    for (int k = 0; names != NULL && k < count; k++)
        if (PyTuple_SetItem(names, k, PyUnicode_FromString(LEVELS[k])) != 0)
            names = (Py_DecRef(names), NULL);
    return names;
}

static PyObject *module_level(PyObject *module, PyObject *nothing)
{
    (void)module, (void)nothing;
    return PyUnicode_FromString(LEVELS[level]);
}

static PyObject *module_use(PyObject *module, PyObject *name)
{
    (void)module;
    const char *wanted = PyUnicode_AsUTF8AndSize(name, NULL);
    if (wanted == NULL)
        return NULL;
    for (int k = 0; k <= best_level(); k++)
        if (strcmp(LEVELS[k], wanted) == 0) {
            level = k;
            return new_reference(Py_None);
        }
    return PyErr_Format(PyExc_ValueError, "there is no machine code for %s that this processor can run", wanted);
}

static PyMethodDef functions[] = {
    {"kernel", module_kernel, METH_O, "A kernel by its name; None where there is none."},
    {"pieces", module_pieces, METH_VARARGS, "A call of a kernel over a range, for several threads (native/pieces.h)."},
    {"calls", module_calls, METH_VARARGS, "Many calls of a kernel, for several threads."},
    {"keep_threads", module_keep_threads, METH_O, "Let idle threads beyond so many end; how many there are."},
    {"acquire", module_acquire, METH_NOARGS, "See what threads wrote before the marks that were read."},
    {"room", module_room, METH_O, "So many bytes of memory, for an array."},
    {"single", module_single, METH_VARARGS, "A call of a kernel on the numbers of one ray or point (native/single.h)."},
    {"kernels", module_names, METH_NOARGS, "The names of all kernels."},
    {"returns_array", module_returns_array, METH_O, "Is what a kernel returns the memory of an array?"},
    {"levels", module_levels, METH_NOARGS, "The levels of processor that this one can run, the best last."},
    {"level", module_level, METH_NOARGS, "The level that is in use."},
    {"use", module_use, METH_O, "Use another level from now on. ValueError if this processor cannot."},
    {NULL, NULL, 0, NULL},
};

static PyModuleDef definition = {
    .base = {1, NULL}, .name = "_kernels", .doc = "Kernels as machine code.", .size = -1, .methods = functions};

EXPORT PyObject *PyInit__kernels(void)
{
    PyObject *module = PyModule_Create2(&definition, 3);
    if (module == NULL)
        return NULL;
    level = best_level();
    if (level < 0) {
        PyErr_Format(PyExc_ImportError, "the machine code in conicoid._kernels is for %s, which this processor is not",
                     LEVELS[0]);
        Py_DecRef(module);
        return NULL;
    }
    rows_type = (PyTypeObject *)PyType_FromSpec(&rows_spec);
    function_type = (PyTypeObject *)PyType_FromSpec(&function_spec);
    pieces_type = (PyTypeObject *)PyType_FromSpec(&pieces_spec);
    single_type = (PyTypeObject *)PyType_FromSpec(&single_spec);
    if (rows_type == NULL || function_type == NULL || pieces_type == NULL || single_type == NULL ||
        PyModule_AddStringConstant(module, "sources", SOURCES) != 0) {
        Py_DecRef(module);
        return NULL;
    }
    return module;
}
