"""Tests of the kernels that come as machine code, where they have been built (`python -m native.build --in-place`), and
of those that are compiled, where there is a compiler: beside an installed wheel there is none.
"""

from importlib.util import find_spec

import pytest

from conicoid._jit.machine_code import SHIPPED

needs_compiler = pytest.mark.skipif(find_spec("numba") is None, reason="needs the compiler (the extra jit)")
needs_machine_code = pytest.mark.skipif(SHIPPED is None, reason="no machine code for these sources has been built")
