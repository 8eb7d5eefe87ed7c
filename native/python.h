/* The part of Python's stable ABI (3.11) that the door uses, so that no platform's own headers are needed. */
#pragma once
#include <stddef.h>
#include <stdint.h>

#ifdef _WIN32
#define PYTHON extern __declspec(dllimport)
#define EXPORT __declspec(dllexport)
#else
#define PYTHON extern
#define EXPORT __attribute__((visibility("default")))
#endif

typedef ptrdiff_t Py_ssize_t;
typedef struct PyTypeObject PyTypeObject;
typedef struct PyObject {
    Py_ssize_t references;
    PyTypeObject *type;
} PyObject;
typedef struct PyThreadState PyThreadState;
typedef PyObject *(*PyCFunction)(PyObject *, PyObject *);

typedef struct {
    void *buf;
    PyObject *obj;
    Py_ssize_t len, itemsize;
    int readonly, ndim;
    char *format;
    Py_ssize_t *shape, *strides, *suboffsets;
    void *internal;
} Py_buffer;
enum {
    PyBUF_WRITABLE = 0x1,
    PyBUF_FORMAT = 0x4,
    PyBUF_STRIDES = 0x18,
    PyBUF_C_CONTIGUOUS = 0x38,
};

typedef struct {
    const char *name;
    PyCFunction function;
    int flags;
    const char *doc;
} PyMethodDef;
enum { METH_VARARGS = 0x1, METH_NOARGS = 0x4, METH_O = 0x8 };

typedef struct {
    const char *name;
    PyObject *(*get)(PyObject *, void *);
    int (*set)(PyObject *, PyObject *, void *);
    const char *doc;
    void *closure;
} PyGetSetDef;

typedef struct {
    PyObject base;
    PyObject *(*init)(void);
    Py_ssize_t index;
    PyObject *copy;
    const char *name, *doc;
    Py_ssize_t size;
    PyMethodDef *methods;
    void *slots, *traverse, *clear, *free;
} PyModuleDef;

typedef struct {
    int slot;
    void *function;
} PyType_Slot;
typedef struct {
    const char *name;
    int size, item_size;
    unsigned flags;
    PyType_Slot *slots;
} PyType_Spec;
enum { Py_bf_getbuffer = 1, Py_tp_alloc = 47, Py_tp_call = 50, Py_tp_dealloc = 52, Py_tp_doc = 56, Py_tp_repr = 66 };
enum { Py_tp_getset = 73, Py_tp_free = 74, Py_tp_methods = 64 };
#define Py_TPFLAGS_DEFAULT (1u << 18)
#define Py_TPFLAGS_DISALLOW_INSTANTIATION (1u << 7)
#define Py_TPFLAGS_TUPLE_SUBCLASS (1ul << 26)

PYTHON PyObject _Py_NoneStruct, _Py_TrueStruct, _Py_FalseStruct;
PYTHON PyTypeObject PyFloat_Type, PyLong_Type, PyTuple_Type, PyList_Type;
PYTHON PyObject *PyExc_TypeError, *PyExc_ValueError, *PyExc_MemoryError, *PyExc_ImportError;

PYTHON void Py_IncRef(PyObject *);
PYTHON void Py_DecRef(PyObject *);
PYTHON PyObject *PyErr_Format(PyObject *, const char *, ...);
PYTHON void PyErr_Clear(void);
PYTHON PyObject *PyErr_Occurred(void);
PYTHON int PyObject_GetBuffer(PyObject *, Py_buffer *, int);
PYTHON void PyBuffer_Release(Py_buffer *);
PYTHON PyObject *PyObject_GetAttrString(PyObject *, const char *);
PYTHON int PyObject_IsTrue(PyObject *);
PYTHON PyObject *PyNumber_Index(PyObject *);
PYTHON long long PyLong_AsLongLong(PyObject *);
PYTHON PyObject *PyLong_FromLongLong(long long);
PYTHON double PyFloat_AsDouble(PyObject *);
PYTHON PyObject *PyFloat_FromDouble(double);
PYTHON PyObject *PyBool_FromLong(long);
PYTHON const char *PyUnicode_AsUTF8AndSize(PyObject *, Py_ssize_t *);
PYTHON PyObject *PyUnicode_FromString(const char *);
PYTHON PyObject *PyUnicode_FromFormat(const char *, ...);
PYTHON Py_ssize_t PyTuple_Size(PyObject *);
PYTHON PyObject *PyTuple_GetItem(PyObject *, Py_ssize_t);
PYTHON PyObject *PyTuple_New(Py_ssize_t);
PYTHON int PyTuple_SetItem(PyObject *, Py_ssize_t, PyObject *);
PYTHON PyObject *PyList_New(Py_ssize_t);
PYTHON int PyList_Append(PyObject *, PyObject *);
PYTHON Py_ssize_t PyList_Size(PyObject *);
PYTHON PyObject *PyList_GetItem(PyObject *, Py_ssize_t);
PYTHON PyObject *PyBytes_FromStringAndSize(const char *, Py_ssize_t);
PYTHON char *PyBytes_AsString(PyObject *);
PYTHON Py_ssize_t PyDict_Size(PyObject *);
PYTHON PyThreadState *PyEval_SaveThread(void);
PYTHON void PyEval_RestoreThread(PyThreadState *);
PYTHON PyObject *PyType_FromSpec(PyType_Spec *);
PYTHON void *PyType_GetSlot(PyTypeObject *, int);
PYTHON unsigned long PyType_GetFlags(PyTypeObject *);
PYTHON int PyType_IsSubtype(PyTypeObject *, PyTypeObject *);
PYTHON PyObject *PyModule_Create2(PyModuleDef *, int);
PYTHON int PyModule_AddStringConstant(PyObject *, const char *, const char *);

#define Py_None (&_Py_NoneStruct)
#define Py_True (&_Py_TrueStruct)
#define Py_False (&_Py_FalseStruct)

static inline PyObject *new_reference(PyObject *object)
{
    Py_IncRef(object);
    return object;
}
