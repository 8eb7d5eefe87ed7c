/* A call of a kernel in pieces of its range, or many calls, for the threads of pool.c: a part of door.c.
 *
 * The arguments of a range are tested once, for the whole range, and held until no thread uses them any more.
 */
#pragma once

typedef struct {
    PyObject base;
    const Entry *entry;
    Call *call;          /* of a range */
    PyObject *arguments; /* of many calls, whose memory their slots refer to */
    Py_buffer marks;
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

/* May a kernel be called for each piece of begin..end? No array must be as long as the piece. */
static int is_divisible(const Call *call)
{
    const Leaf *leaves = call->entry->leaves, *stop = leaves + call->entry->count, *begin = NULL;
    for (const Leaf *leaf = leaves; leaf < stop; leaf++)
        if (leaf->kind == INT && strcmp(leaf->name, "begin") == 0)
            begin = leaf;
    if (begin == NULL || begin + 1 == stop || strcmp(begin[1].name, "end") != 0)
        return 0;
    for (const Leaf *leaf = leaves; leaf < stop; leaf++)
        for (int k = 0; leaf->kind == ARRAY && k < leaf->dimensions; k++)
            for (int end = 0; end < 2; end++)
                if (refers(&leaf->length[k].sum, begin[end].symbol) || refers(&leaf->length[k].other, begin[end].symbol))
                    return 0;
    return call->slots[call->begin] >= 0 && call->slots[call->begin] <= call->slots[call->begin + 1];
}

static int is_tuple(PyObject *given) { return (PyType_GetFlags(given->type) & Py_TPFLAGS_TUPLE_SUBCLASS) != 0; }

/* The kernel that an argument is; NULL with an error. */
static const Entry *entry_of_kernel(PyObject *given)
{
    if (given->type == function_type)
        return ((Function *)given)->entry;
    PyErr_Format(PyExc_TypeError, "the threads take a kernel, and tuples of arguments");
    return NULL;
}

static void drop_array(int64_t *result) { conicoid_release(((Result *)(void *)result)->array.block); }
static void drop_numbers(int64_t *result) { (void)result; }

static Range range_of(const Entry *entry, const Call *call)
{
    Range range = {.kernel = entry->levels[level], .used = call->slot, .slots = call->slots, .begin = call->begin};
    range.first = range.begin < 0 ? 0 : call->slots[range.begin];
    range.last = range.begin < 0 ? 0 : call->slots[range.begin + 1];
    range.drop = entry->result[0] == 'A' ? drop_array : drop_numbers;
    return range;
}

/* A call of a kernel that can be divided, tested; NULL with an error. */
static Call *new_call(PyObject *kernel, PyObject *arguments)
{
    const Entry *entry = entry_of_kernel(kernel);
    if (entry == NULL)
        return NULL;
    if (!is_tuple(arguments))
        return (Call *)PyErr_Format(PyExc_TypeError, "%s: arguments must be a tuple", entry->name);
    Call *call = malloc(sizeof(Call));
    if (call == NULL)
        return (Call *)no_memory(entry);
    if (take_all(call, entry, arguments) == 0) {
        if (is_divisible(call))
            return call;
        PyErr_Format(PyExc_ValueError, "%s cannot be called in such pieces", entry->name);
    }
    release_all(call);
    free(call);
    return NULL;
}

/* Take the array of marks, an int8 for each item; 0, or -1 with an error. */
static int take_marks(Pieces *pieces, PyObject *given, int64_t count)
{
    if (given == Py_None)
        return 0;
    Py_buffer *marks = &pieces->marks;
    if (PyObject_GetBuffer(given, marks, PyBUF_FORMAT | PyBUF_C_CONTIGUOUS | PyBUF_WRITABLE) != 0)
        return -1;
    if (marks->itemsize == 1 && marks->len == count)
        return 0;
    PyErr_Format(PyExc_ValueError, "%s: marks must be one int8 for each item", pieces->entry->name);
    return -1;
}

/* pieces(kernel, arguments, most, marks), where `marks` may be None. */
static PyObject *module_pieces(PyObject *module, PyObject *given)
{
    (void)module;
    if (PyTuple_Size(given) != 4)
        return PyErr_Format(PyExc_TypeError, "pieces takes 4 arguments");
    long long most = PyLong_AsLongLong(PyTuple_GetItem(given, 2));
    if (most == -1 && PyErr_Occurred())
        return NULL;
    Pieces *made = made_of(pieces_type);
    if (made == NULL)
        return NULL;
    made->call = new_call(PyTuple_GetItem(given, 0), PyTuple_GetItem(given, 1));
    if (made->call != NULL) {
        const Entry *entry = made->entry = made->call->entry;
        Range range = range_of(entry, made->call);
        if (most < 1)
            PyErr_Format(PyExc_ValueError, "%s cannot be called in such pieces", entry->name);
        else if (take_marks(made, PyTuple_GetItem(given, 3), range.last - range.first) == 0 &&
                 (made->work = work_new(&range, most, made->marks.buf, entry->result[0] != 0)) == NULL)
            no_memory(entry);
    }
    if (made->work != NULL)
        return (PyObject *)made;
    Py_DecRef((PyObject *)made);
    return NULL;
}

/* calls(kernel, tuple of tuples of arguments). */
static PyObject *module_calls(PyObject *module, PyObject *given)
{
    (void)module;
    if (PyTuple_Size(given) != 2 || !is_tuple(PyTuple_GetItem(given, 1)))
        return PyErr_Format(PyExc_TypeError, "calls takes a kernel and a tuple of arguments for each call");
    const Entry *entry = entry_of_kernel(PyTuple_GetItem(given, 0));
    PyObject *all = PyTuple_GetItem(given, 1);
    Pieces *made = entry == NULL ? NULL : made_of(pieces_type);
    if (made == NULL)
        return NULL;
    made->entry = entry;
    made->arguments = new_reference(all);
    Py_ssize_t count = PyTuple_Size(all);
    int64_t *slots = NULL;
    Call call;
    call.slot = 0, call.begin = -1;
    for (Py_ssize_t n = 0; n < count; n++) {
        PyObject *each = PyTuple_GetItem(all, n);
        if (!is_tuple(each)) {
            PyErr_Format(PyExc_TypeError, "%s: arguments must be a tuple", entry->name);
            break;
        }
        int fits = take_all(&call, entry, each) == 0;
        release_all(&call);
        if (fits && slots == NULL && (slots = malloc(8 * (size_t)call.slot * (size_t)count)) == NULL)
            no_memory(entry);
        if (!fits || slots == NULL)
            break;
        for (int k = 0; k < call.slot; k++)
            slots[n * call.slot + k] = call.slots[k];
    }
    if (!PyErr_Occurred()) {
        Range range = range_of(entry, &call);
        range.slots = slots, range.begin = -1, range.first = 0, range.last = count;
        if ((made->work = work_new(&range, 1, NULL, entry->result[0] != 0)) == NULL)
            no_memory(entry);
    }
    free(slots);
    if (made->work != NULL)
        return (PyObject *)made;
    Py_DecRef((PyObject *)made);
    return NULL;
}

/* Give back what kernels returned and nobody took. */
static void drop_outcomes(const Entry *entry, Outcome *outcomes)
{
    while (outcomes != NULL) {
        Outcome *after = outcomes->after;
        if (entry->result[0] == 'A')
            drop_array(outcomes->result);
        free(outcomes);
        outcomes = after;
    }
}

/* Memory that threads still use is not given back: whoever interrupts a call keeps its pieces until these have ended. */
static void pieces_free(PyObject *self)
{
    Pieces *pieces = (Pieces *)self;
    PyTypeObject *type = self->type;
    if (pieces->work != NULL)
        work_stop(pieces->work);
    if (pieces->work == NULL || work_wait(pieces->work, 0)) {
        if (pieces->work != NULL) {
            drop_outcomes(pieces->entry, work_outcomes(pieces->work));
            work_free(pieces->work);
        }
        if (pieces->call != NULL)
            release_all(pieces->call);
        free(pieces->call);
        if (pieces->marks.obj != NULL)
            PyBuffer_Release(&pieces->marks);
        Py_DecRef(pieces->arguments);
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
        return no_memory(pieces->entry);
    return PyLong_FromLongLong(work_done(pieces->work));
}

/* A list of what the kernel returned, (begin, end, result) of each piece, in no order; once. */
static PyObject *pieces_results(PyObject *self, PyObject *nothing)
{
    (void)nothing;
    Pieces *pieces = (Pieces *)self;
    const Entry *entry = pieces->entry;
    if (!work_wait(pieces->work, 0))
        return PyErr_Format(PyExc_ValueError, "%s: threads are at work", entry->name);
    PyObject *all = PyList_New(0);
    Outcome *outcomes = work_outcomes(pieces->work);
    while (all != NULL && outcomes != NULL) {
        Outcome *first = outcomes;
        outcomes = first->after;
        PyObject *row = PyTuple_New(3), *result = as_python(entry->result, (Result *)(void *)first->result);
        int fits = row != NULL && result != NULL;
        if (row != NULL) {
            PyTuple_SetItem(row, 0, PyLong_FromLongLong(first->begin));
            PyTuple_SetItem(row, 1, PyLong_FromLongLong(first->end));
            PyTuple_SetItem(row, 2, result);
        } else
            Py_DecRef(result);
        free(first);
        if (!fits || PyErr_Occurred() || PyList_Append(all, row) != 0)
            all = (Py_DecRef(all), NULL);
        Py_DecRef(row);
    }
    drop_outcomes(entry, outcomes);
    return all;
}

static PyMethodDef pieces_methods[] = {
    {"start", pieces_start, METH_O, "Let so many threads begin; how many will come."},
    {"help", pieces_help, METH_NOARGS, "Take pieces in this thread until none is left."},
    {"wait", pieces_wait, METH_O, "Wait for so many milliseconds. True if no thread takes pieces any more."},
    {"stop", pieces_stop, METH_NOARGS, "Give out no more pieces."},
    {"results", pieces_results, METH_NOARGS, "What the kernel returned for each piece: (begin, end, result)."},
    {NULL, NULL, 0, NULL},
};
static PyGetSetDef pieces_fields[] = {{"done", pieces_done, NULL, NULL, NULL}, {NULL, NULL, NULL, NULL, NULL}};
static PyType_Slot pieces_slots[] = {
    {Py_tp_dealloc, pieces_free},
    {Py_tp_methods, pieces_methods},
    {Py_tp_getset, pieces_fields},
    {Py_tp_doc, "A call of a kernel in pieces of its range, or many calls."},
    {0, NULL},
};
static PyType_Spec pieces_spec = {
    "conicoid._kernels.Pieces", sizeof(Pieces), 0, Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, pieces_slots};
