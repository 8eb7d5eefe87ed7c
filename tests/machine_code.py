"""Tests of the kernels that come as machine code, where they have been built (`python -m native.build --in-place`)."""

from __future__ import annotations

import pytest

from conicoid.compiler.machine_code import SHIPPED

needs_machine_code = pytest.mark.skipif(SHIPPED is None, reason="no machine code for these sources has been built")
