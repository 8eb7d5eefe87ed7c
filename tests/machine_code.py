"""Marks for tests of kernels in machine code, and of kernels that Numba compiles.

A build makes the former (`python -m native.build --in-place`). The latter need a compiler, which a wheel lacks.
"""

from importlib.util import find_spec

import pytest

from conicoid._jit.machine_code import SHIPPED

needs_compiler = pytest.mark.skipif(find_spec("numba") is None, reason="needs the compiler (the extra jit)")
needs_machine_code = pytest.mark.skipif(SHIPPED is None, reason="no machine code for these sources has been built")
