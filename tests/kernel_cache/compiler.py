"""Imported once by the process that the tests' processes are forked from: the compiler, and what it imports late."""

from conicoid._jit.decorators import kernel

assert kernel()(lambda x: x + 1.0)(1.0) == 2.0
