/* A call of a kernel in pieces of its range, for the threads of pool.c: a part of door.c.
 *
 * Its arguments are tested once, for the whole range, and held until no thread uses them any more.
 */
#pragma once

typedef struct {
    PyObject base;
    Call *call;
    Work *work;
} Pieces;
static PyTypeObject *pieces_type;

static PyObject *no_memory(const Entry *entry)
{
    return PyErr_Format(PyExc_MemoryError, "%s: there is not enough memory", entry->name);
}

static int refers(const Sum *sum, int16_t symbol)
{
    return symbol >= 0 && (sum->symbol[0] == symbol || sum->symbol[1] == symbol);
}

/* May a kernel be called for each piece of begin..end? It must begin at 0, and no array be as long as the piece. */
static int is_divisible(const Call *call)
{
    const Leaf *leaves = call->entry->leaves, *stop = leaves + call->entry->count, *begin = NULL;
    for (const Leaf *leaf = leaves; leaf < stop; leaf++)
        if (leaf->kind == INT && strcmp(leaf->name, "begin") == 0)
            begin = leaf;
    if (begin == NULL || begin + 1 == stop || strcmp(begin[1].name, "end") != 0 || call->entry->result[0] != 0)
        return 0;
    for (const Leaf *leaf = leaves; leaf < stop; leaf++)
        for (int k = 0; leaf->kind == ARRAY && k < leaf->dimensions; k++)
            for (int end = 0; end < 2; end++)
                if (refers(&leaf->length[k].sum, begin[end].symbol) || refers(&leaf->length[k].other, begin[end].symbol))
                    return 0;
    return call->slots[call->begin] == 0;
}

static PyObject *module_pieces(PyObject *module, PyObject *given)
{
    (void)module;
    PyObject *function = PyTuple_Size(given) == 3 ? PyTuple_GetItem(given, 0) : NULL;
    PyObject *arguments = function == NULL ? NULL : PyTuple_GetItem(given, 1);
    if (function == NULL || function->type != function_type || !(PyType_GetFlags(arguments->type) & Py_TPFLAGS_TUPLE_SUBCLASS))
        return PyErr_Format(PyExc_TypeError, "pieces takes a kernel, a tuple of arguments and a number");
    long long most = PyLong_AsLongLong(PyTuple_GetItem(given, 2));
    if (most == -1 && PyErr_Occurred())
        return NULL;
    const Entry *entry = ((Function *)function)->entry;
    Call *call = malloc(sizeof(Call));
    if (call == NULL)
        return no_memory(entry);
    Pieces *made = NULL;
    Work *work = NULL;
    if (take_all(call, entry, arguments) == 0) {
        if (most < 1 || !is_divisible(call))
            PyErr_Format(PyExc_ValueError, "%s cannot be called in such pieces", entry->name);
        else {
            work = work_new(entry->levels[level], call->slots, call->slot, call->begin, call->slots[call->begin + 1], most);
            PyObject *(*make)(PyTypeObject *, Py_ssize_t) = PyType_GetSlot(pieces_type, Py_tp_alloc);
            made = work == NULL ? NULL : (Pieces *)make(pieces_type, 0);
            if (work == NULL)
                no_memory(entry);
        }
    }
    if (made == NULL) {
        if (work != NULL)
            work_free(work);
        release_all(call);
        free(call);
        return NULL;
    }
    made->call = call;
    made->work = work;
    return (PyObject *)made;
}

/* Memory that threads still use is not given back: whoever interrupts a call keeps its pieces until these have ended. */
static void pieces_free(PyObject *self)
{
    Pieces *pieces = (Pieces *)self;
    PyTypeObject *type = self->type;
    work_stop(pieces->work);
    if (work_wait(pieces->work, 0)) {
        release_all(pieces->call);
        free(pieces->call);
        work_free(pieces->work);
    }
    void (*release)(void *) = PyType_GetSlot(type, Py_tp_free);
    release(self);
    Py_DecRef((PyObject *)type);
}

static PyObject *pieces_start(PyObject *self, PyObject *threads)
{
    long long count = PyLong_AsLongLong(threads);
    if (count == -1 && PyErr_Occurred())
        return NULL;
    if (count < 1 || count > 65536 || !work_wait(((Pieces *)self)->work, 0))
        return PyErr_Format(PyExc_ValueError, "there is no such number of threads, or they have come");
    return PyLong_FromLongLong(work_start(((Pieces *)self)->work, (int)count));
}

static PyObject *pieces_help(PyObject *self, PyObject *nothing)
{
    (void)nothing;
    PyThreadState *state = PyEval_SaveThread();
    work_help(((Pieces *)self)->work);
    PyEval_RestoreThread(state);
    return new_reference(Py_None);
}

static PyObject *pieces_wait(PyObject *self, PyObject *given)
{
    Pieces *pieces = (Pieces *)self;
    long long milliseconds = PyLong_AsLongLong(given);
    if (milliseconds == -1 && PyErr_Occurred())
        return NULL;
    if (milliseconds <= 0) /* the first call in a child of a fork may be this one: it keeps Python's lock */
        return PyBool_FromLong(work_wait(pieces->work, 0));
    PyThreadState *state = PyEval_SaveThread();
    int ended = work_wait(pieces->work, milliseconds > 1000 ? 1000 : (int)milliseconds);
    PyEval_RestoreThread(state);
    return PyBool_FromLong(ended);
}

static PyObject *pieces_stop(PyObject *self, PyObject *nothing)
{
    (void)nothing;
    work_stop(((Pieces *)self)->work);
    return new_reference(Py_None);
}

static PyObject *pieces_done(PyObject *self, void *closure)
{
    (void)closure;
    Pieces *pieces = (Pieces *)self;
    if (work_status(pieces->work) != 0)
        return no_memory(pieces->call->entry);
    return PyLong_FromLongLong(work_done(pieces->work));
}

static PyMethodDef pieces_methods[] = {
    {"start", pieces_start, METH_O, "Let so many threads begin; how many will come."},
    {"help", pieces_help, METH_NOARGS, "Take pieces in this thread until none is left."},
    {"wait", pieces_wait, METH_O, "Wait for so many milliseconds. True if no thread takes pieces any more."},
    {"stop", pieces_stop, METH_NOARGS, "Give out no more pieces."},
    {NULL, NULL, 0, NULL},
};
static PyGetSetDef pieces_fields[] = {{"done", pieces_done, NULL, NULL, NULL}, {NULL, NULL, NULL, NULL, NULL}};
static PyType_Slot pieces_slots[] = {
    {Py_tp_dealloc, pieces_free},
    {Py_tp_methods, pieces_methods},
    {Py_tp_getset, pieces_fields},
    {Py_tp_doc, "A call of a kernel in pieces of its range."},
    {0, NULL},
};
static PyType_Spec pieces_spec = {
    "conicoid._kernels.Pieces", sizeof(Pieces), 0, Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, pieces_slots};
