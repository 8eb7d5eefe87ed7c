/* Calls of kernels on one ray or point, or on few, without arrays of Python; a part of door.c.
 *
 * For programs that ask ray by ray or in small lots, as transport codes and lessons do. Around the kernel a query through
 * arrays takes 70 microseconds; this takes 3 for one ray, and 20 for a thousand.
 * `single(name, arguments, inputs, outputs, smallest, largest, most)` tests arguments once as any call does, and keeps
 * their addresses. Of the arrays in `inputs` and `outputs` it keeps the place alone: a call takes the numbers of its
 * inputs, and returns the bytes of vectors, the outputs, and the kernel's result. Inputs of three numbers are vectors:
 * tuples, lists or arrays; the second of them is a direction. With `most` > 0 at least one is an array of up to so many
 * vectors, and the outputs come as the bytes of one array after the other; else they are numbers. Whatever is not plain,
 * from texts to a direction of length 0, gives None: the caller then takes the route with messages.
 */
#include <math.h>
#include <stdlib.h>

enum { MOST_PARTS = 9 };

typedef struct {
    int slot;  /* the first of the array */
    int count; /* numbers of a ray or point */
    int size;  /* bytes of each */
    int is_float;
} Part;

typedef struct {
    PyObject base;
    const Entry *entry;
    PyObject *arguments;      /* whose memory the slots refer to */
    PyTypeObject *array_type; /* NumPy's, without subclasses such as masked arrays */
    int64_t *slots;
    int slot_count, input_count, output_count, vector_count;
    int most; /* rows of a call; 0 for single rays or points */
    Part inputs[MOST_PARTS], outputs[MOST_PARTS];
    double smallest, largest; /* ends of the domain of the magnitudes of components */
} Single;

static int plain_number(PyObject *given, double *number)
{
    if (given->type != &PyFloat_Type && given->type != &PyLong_Type && !PyType_IsSubtype(given->type, &PyFloat_Type))
        return 0;
    *number = PyFloat_AsDouble(given);
    if (*number == -1.0 && PyErr_Occurred()) {
        PyErr_Clear(); /* a whole number beyond all floats */
        return 0;
    }
    return 1;
}

/* A whole number of 32 bits, to where a number would be. */
static int plain_whole(PyObject *given, double *place)
{
    long long value = given->type == &PyLong_Type ? PyLong_AsLongLong(given) : INT64_MIN;
    int32_t kept = (int32_t)value;
    memcpy(place, &kept, 4);
    if (value == -1 && PyErr_Occurred()) {
        PyErr_Clear();
        return 0;
    }
    return kept == value;
}

/* An array of three numbers, or of rows of three; the caller releases the buffer. */
static int plain_array(const Single *single, PyObject *given, Py_buffer *buffer)
{
    if (PyObject_GetBuffer(given, buffer, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) != 0) {
        PyErr_Clear();
        buffer->obj = NULL;
        return 0;
    }
    int n = buffer->ndim;
    return (n == 1 || (n == 2 && single->most > 0 && buffer->shape[0] > 0 && buffer->shape[0] <= single->most)) &&
           buffer->shape[n - 1] == 3 && strcmp(buffer->format, "d") == 0;
}

static int plain_sequence(PyObject *given, double *numbers)
{
    int is_tuple = given->type == &PyTuple_Type;
    if ((!is_tuple && given->type != &PyList_Type) || (is_tuple ? PyTuple_Size(given) : PyList_Size(given)) != 3)
        return 0;
    for (Py_ssize_t k = 0; k < 3; k++)
        if (!plain_number(is_tuple ? PyTuple_GetItem(given, k) : PyList_GetItem(given, k), &numbers[k]))
            return 0;
    return 1;
}

/* What a call is given, before it is copied. */
typedef struct {
    Py_buffer buffers[MOST_PARTS]; /* obj is NULL where there is none */
    double numbers[MOST_PARTS][3];
    int64_t rows; /* 1 where all are single */
} Given;

static int take_given(const Single *single, PyObject *arguments, Given *given)
{
    int many = 0;
    given->rows = 1;
    for (int k = 0; k < single->input_count; k++)
        given->buffers[k].obj = NULL;
    if (PyTuple_Size(arguments) != single->input_count)
        return 0;
    for (int k = 0; k < single->input_count; k++) {
        PyObject *each = PyTuple_GetItem(arguments, k);
        Py_buffer *buffer = &given->buffers[k];
        if (!single->inputs[k].is_float) {
            if (!plain_whole(each, given->numbers[k]))
                return 0;
        } else if (single->inputs[k].count == 1) {
            if (!plain_number(each, given->numbers[k]) || given->numbers[k][0] != given->numbers[k][0])
                return 0;
        } else if (each->type != single->array_type) {
            if (!plain_sequence(each, given->numbers[k]))
                return 0;
        } else if (!plain_array(single, each, buffer)) {
            return 0;
        } else if (buffer->ndim == 1) {
            memcpy(given->numbers[k], buffer->buf, 24);
        } else {
            if (many && buffer->shape[0] != given->rows)
                return 0;
            many = 1;
            given->rows = buffer->shape[0];
        }
    }
    return many || single->most == 0;
}

/* Copy vectors; say whether all of their numbers are in the domain, and no direction is zero. */
static int copy_vectors(const Single *single, const Given *given, int part, double *to)
{
    const Py_buffer *buffer = &given->buffers[part];
    if (buffer->obj != NULL && buffer->ndim == 2)
        memcpy(to, buffer->buf, 24 * (size_t)given->rows);
    else
        for (int64_t k = 0; k < given->rows; k++)
            memcpy(to + 3 * k, given->numbers[part], 24);
    int wrong = 0;
    for (int64_t k = 0; k < 3 * given->rows; k++) {
        double size = fabs(to[k]);
        wrong |= !((size == 0.0) | ((size >= single->smallest) & (size <= single->largest)));
    }
    for (int64_t k = 0; k < given->rows && part == 1; k++)
        wrong |= (to[3 * k] == 0.0) & (to[3 * k + 1] == 0.0) & (to[3 * k + 2] == 0.0);
    return !wrong;
}

/* Let a part of the arguments be an array of so many rows at an address. */
static void place(int64_t *slots, const Part *part, int64_t rows, void *address)
{
    slots += part->slot;
    slots[2] = part->count * rows;
    slots[4] = (int64_t)(intptr_t)address;
    slots[5] = rows;
}

static PyObject *number_of(const Part *part, const void *place)
{
    if (part->is_float)
        return PyFloat_FromDouble(*(const double *)place);
    return PyLong_FromLongLong(part->size == 1 ? *(const int8_t *)place : *(const int32_t *)place);
}

/* The kernel on vectors and limits in `slots`, with memory for outputs; the tuple that a call returns. */
static PyObject *run_single(const Single *single, int64_t *slots, int64_t rows, PyObject *lines)
{
    int64_t size = 0, numbers[MOST_PARTS] = {0};
    for (int k = 0; k < single->output_count; k++)
        size += single->outputs[k].size * rows;
    PyObject *bytes = single->most > 0 ? PyBytes_FromStringAndSize(NULL, (Py_ssize_t)size) : NULL;
    if (single->most > 0 && bytes == NULL)
        return NULL;
    char *room = bytes == NULL ? NULL : memset(PyBytes_AsString(bytes), 0, (size_t)size);
    for (int k = 0; k < single->output_count; k++) {
        place(slots, &single->outputs[k], rows, room == NULL ? (void *)&numbers[k] : room);
        room = room == NULL ? NULL : room + single->outputs[k].size * rows;
    }
    int count = single->most > 0 ? 1 : single->output_count;
    PyObject *result = run(single->entry, slots), *answer = result == NULL ? NULL : PyTuple_New(2 + count);
    if (answer == NULL) {
        Py_DecRef(result);
        Py_DecRef(bytes);
        return NULL;
    }
    PyTuple_SetItem(answer, 0, new_reference(lines));
    for (int k = 0; k < count; k++)
        PyTuple_SetItem(answer, k + 1, bytes == NULL ? number_of(&single->outputs[k], &numbers[k]) : bytes);
    PyTuple_SetItem(answer, 1 + count, result);
    if (PyErr_Occurred())
        answer = (Py_DecRef(answer), NULL);
    return answer;
}

static PyObject *single_call(PyObject *self, PyObject *arguments, PyObject *named)
{
    const Single *single = (const Single *)self;
    int64_t slots[MOST_SLOTS];
    Given given;
    PyObject *lines = NULL, *answer = NULL;
    int plain = named == NULL && take_given(single, arguments, &given);
    if (plain)
        lines = PyBytes_FromStringAndSize(NULL, (Py_ssize_t)(24 * given.rows * single->vector_count));
    if (lines != NULL) {
        double *to = (double *)(void *)PyBytes_AsString(lines);
        for (int k = 0; k < single->slot_count; k++) /* memcpy would be checked on macOS, by a function more */
            slots[k] = single->slots[k];
        for (int k = 0; k < single->input_count; k++) {
            if (single->inputs[k].count == 1) {
                place(slots, &single->inputs[k], 1, given.numbers[k]);
                continue;
            }
            plain &= copy_vectors(single, &given, k, to);
            place(slots, &single->inputs[k], given.rows, to);
            to += 3 * given.rows;
        }
        if (plain)
            answer = run_single(single, slots, given.rows, lines);
        Py_DecRef(lines);
    }
    if (named == NULL)
        for (int k = 0; k < single->input_count; k++)
            if (given.buffers[k].obj != NULL)
                PyBuffer_Release(&given.buffers[k]);
    return plain ? answer : new_reference(Py_None);
}

static void single_free(PyObject *self)
{
    Single *single = (Single *)self;
    PyTypeObject *type = self->type;
    Py_DecRef(single->arguments);
    free(single->slots);
    void (*release)(void *) = PyType_GetSlot(type, Py_tp_free);
    release(self);
    Py_DecRef((PyObject *)type);
}

static PyType_Slot single_slots[] = {
    {Py_tp_call, single_call},
    {Py_tp_dealloc, single_free},
    {Py_tp_doc, "A call of a kernel on one ray or point."},
    {0, NULL},
};
static PyType_Spec single_spec = {
    "conicoid._kernels.Single", sizeof(Single), 0, Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION, single_slots};
static PyTypeObject *single_type;

/* Find arrays among those of a call: one number each, or three floats of an input. */
static int find_parts(const Call *call, PyObject *arrays, Part *parts, int are_inputs)
{
    Py_ssize_t count = PyTuple_Size(arrays);
    if (count < 0 || count > MOST_PARTS)
        return -1;
    for (Py_ssize_t k = 0; k < count; k++) {
        int n = 0;
        while (n < call->arrays && call->buffers[n].obj != PyTuple_GetItem(arrays, k))
            n++;
        if (n == call->arrays)
            return -1;
        const Py_buffer *found = &call->buffers[n];
        int numbers = (int)(found->len / found->itemsize), is_float = found->format[0] == 'd';
        if (numbers != 1 && !(are_inputs && is_float && numbers == 3))
            return -1;
        if (!is_float && found->itemsize != 4 && (are_inputs || found->itemsize != 1))
            return -1;
        parts[k] = (Part){call->first[n], numbers, (int)found->itemsize, is_float};
    }
    return (int)count;
}

static PyObject *module_single(PyObject *module, PyObject *given)
{
    (void)module;
    if (PyTuple_Size(given) != 7)
        return PyErr_Format(PyExc_TypeError, "single takes 7 arguments");
    const Entry *entry = entry_of(PyTuple_GetItem(given, 0));
    if (entry == NULL)
        return PyErr_Occurred() ? NULL : PyErr_Format(PyExc_ValueError, "single: there is no such kernel");
    PyObject *arguments = PyTuple_GetItem(given, 1), *inputs = PyTuple_GetItem(given, 2);
    Call call;
    Single *made = take_all(&call, entry, arguments) == 0 ? made_of(single_type) : NULL;
    if (made != NULL) {
        made->entry = entry;
        made->arguments = new_reference(arguments);
        made->slot_count = call.slot;
        made->slots = malloc(8 * (size_t)call.slot);
        made->smallest = PyFloat_AsDouble(PyTuple_GetItem(given, 4));
        made->largest = PyFloat_AsDouble(PyTuple_GetItem(given, 5));
        made->most = (int)PyLong_AsLongLong(PyTuple_GetItem(given, 6));
        made->input_count = find_parts(&call, inputs, made->inputs, 1);
        made->output_count = find_parts(&call, PyTuple_GetItem(given, 3), made->outputs, 0);
        if (made->slots != NULL)
            memcpy(made->slots, call.slots, 8 * (size_t)call.slot);
        for (int k = 0; k < made->input_count; k++)
            made->vector_count += made->inputs[k].count == 3;
        if (made->input_count > 0)
            made->array_type = PyTuple_GetItem(inputs, 0)->type;
        if (made->slots == NULL || made->input_count < 1 || made->output_count < 0 || PyErr_Occurred()) {
            Py_DecRef((PyObject *)made);
            made = NULL;
            if (!PyErr_Occurred())
                PyErr_Format(PyExc_ValueError, "single: inputs and outputs of %s must be among its arrays", entry->name);
        }
    }
    release_all(&call);
    return (PyObject *)made;
}
