/* Calls of kernels on one ray or one point; a part of door.c.
 *
 * For programs that ask ray by ray, as transport codes and lessons do: 3 microseconds around the kernel in place of 70.
 * `single(name, arguments, inputs, outputs, smallest, largest)` tests arguments once as any call does, and keeps their
 * addresses. Of the arrays in `inputs` and `outputs` it keeps the place alone: a call takes the numbers of its inputs
 * from tuples, lists and arrays, and returns them as bytes, then the numbers of its outputs, then the kernel's result.
 * Inputs of three numbers are vectors, and the second of these is a direction. Whatever is not plain, from texts to a
 * direction of length 0, gives None: the caller then takes the route with messages.
 */
#include <math.h>
#include <stdlib.h>

enum { MOST_PARTS = 6, MOST_NUMBERS = 3 * MOST_PARTS };

typedef struct {
    int slot;  /* where the address of its numbers goes */
    int count; /* of its numbers */
    int size;  /* of a whole number, in bytes; 0 for a float */
} Part;

typedef struct {
    PyObject base;
    const Entry *entry;
    PyObject *arguments;      /* whose memory the slots refer to */
    PyTypeObject *array_type; /* NumPy's, without subclasses such as masked arrays */
    int64_t *slots;
    int slot_count, input_count, output_count;
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

static int plain_array(PyObject *given, int count, double *numbers)
{
    Py_buffer buffer;
    if (PyObject_GetBuffer(given, &buffer, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) != 0) {
        PyErr_Clear();
        return 0;
    }
    int fine = buffer.ndim == 1 && buffer.shape[0] == count && strcmp(buffer.format, "d") == 0;
    if (fine)
        memcpy(numbers, buffer.buf, 8 * (size_t)count);
    PyBuffer_Release(&buffer);
    return fine;
}

static int plain_vector(const Single *single, PyObject *given, double *numbers)
{
    if (given->type == single->array_type) {
        if (!plain_array(given, 3, numbers))
            return 0;
    } else {
        int is_tuple = given->type == &PyTuple_Type;
        if (!is_tuple && given->type != &PyList_Type)
            return 0;
        if ((is_tuple ? PyTuple_Size(given) : PyList_Size(given)) != 3)
            return 0;
        for (Py_ssize_t k = 0; k < 3; k++)
            if (!plain_number(is_tuple ? PyTuple_GetItem(given, k) : PyList_GetItem(given, k), &numbers[k]))
                return 0;
    }
    for (int k = 0; k < 3; k++) {
        double size = fabs(numbers[k]);
        if (size != 0.0 && !(size >= single->smallest && size <= single->largest))
            return 0;
    }
    return 1;
}

static int plain_inputs(const Single *single, PyObject *arguments, double *numbers, int64_t *slots)
{
    if (PyTuple_Size(arguments) != single->input_count)
        return 0;
    for (int k = 0; k < single->input_count; k++) {
        const Part *part = &single->inputs[k];
        PyObject *given = PyTuple_GetItem(arguments, k);
        if (part->count == 3) {
            if (!plain_vector(single, given, numbers))
                return 0;
            if (k == 1 && numbers[0] == 0.0 && numbers[1] == 0.0 && numbers[2] == 0.0)
                return 0;
        } else if (!plain_number(given, numbers) || isnan(*numbers))
            return 0;
        slots[part->slot] = (int64_t)(intptr_t)numbers;
        numbers += part->count;
    }
    return 1;
}

static PyObject *number_of(const Part *part, const void *place)
{
    if (part->size == 0)
        return PyFloat_FromDouble(*(const double *)place);
    return PyLong_FromLongLong(part->size == 1 ? *(const int8_t *)place : *(const int32_t *)place);
}

static PyObject *single_call(PyObject *self, PyObject *arguments, PyObject *named)
{
    const Single *single = (const Single *)self;
    int64_t slots[MOST_SLOTS];
    double inputs[MOST_NUMBERS], outputs[MOST_PARTS];
    memcpy(slots, single->slots, 8 * (size_t)single->slot_count);
    if (named != NULL || !plain_inputs(single, arguments, inputs, slots))
        return new_reference(Py_None);
    for (int k = 0; k < single->output_count; k++)
        slots[single->outputs[k].slot] = (int64_t)(intptr_t)&outputs[k];
    memset(outputs, 0, sizeof outputs);
    PyObject *result = run(single->entry, slots);
    PyObject *answer = result == NULL ? NULL : PyTuple_New(2 + single->output_count);
    if (answer == NULL) {
        Py_DecRef(result);
        return NULL;
    }
    int count = 0;
    for (int k = 0; k < single->input_count; k++)
        count += single->inputs[k].count;
    int wrong = PyTuple_SetItem(answer, 0, PyBytes_FromStringAndSize((const char *)inputs, 8 * count));
    for (int k = 0; k < single->output_count; k++)
        wrong |= PyTuple_SetItem(answer, k + 1, number_of(&single->outputs[k], &outputs[k]));
    wrong |= PyTuple_SetItem(answer, 1 + single->output_count, result);
    if (wrong || PyErr_Occurred())
        answer = (Py_DecRef(answer), NULL);
    return answer;
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

/* Find arrays among those of a call: inputs are one or three floats, outputs one float or one whole number. */
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
        if (are_inputs ? !is_float || (numbers != 1 && numbers != 3) : numbers != 1)
            return -1;
        if (!is_float && found->itemsize != 1 && found->itemsize != 4)
            return -1;
        parts[k].slot = call->first[n] + 4;
        parts[k].count = numbers;
        parts[k].size = is_float ? 0 : (int)found->itemsize;
    }
    return (int)count;
}

static PyObject *module_single(PyObject *module, PyObject *given)
{
    (void)module;
    if (PyTuple_Size(given) != 6)
        return PyErr_Format(PyExc_TypeError, "single takes 6 arguments");
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
        made->input_count = find_parts(&call, inputs, made->inputs, 1);
        made->output_count = find_parts(&call, PyTuple_GetItem(given, 3), made->outputs, 0);
        if (made->slots != NULL)
            memcpy(made->slots, call.slots, 8 * (size_t)call.slot);
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
