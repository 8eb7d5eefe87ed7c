"""The kernels as machine code, which comes with the package: `conicoid._kernels`, built by `native/`.

It holds them for several levels of processor and takes the best that this one has; all give the same bits.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

import numpy as np

from .._util.environment import LEVEL, read_jit_mode, read_processor_level
from .address_space import TO_RUN, require_memory


def _load_extension() -> Any:
    """The extension; None where there is none, where it was made of other sources, or where compiling is asked for."""
    if read_jit_mode():
        return None
    require_memory(TO_RUN, "Conicoid")
    try:
        _kernels: Any = importlib.import_module(__name__.partition(".")[0] + "._kernels")
    except ModuleNotFoundError:
        return None
    if _kernels.sources:  # it was built in place: the sources may have been edited since
        from .sources import hash_of_sources

        if _kernels.sources != hash_of_sources():
            return None
    wanted, levels = read_processor_level(), _kernels.levels()
    if wanted and wanted not in levels:
        raise ValueError(f"{LEVEL} must be {' or '.join(levels)} on this processor, got {wanted[:80]!r}")
    if wanted:
        _kernels.use(wanted)
    return _kernels


SHIPPED: Any = _load_extension()
"""The extension module, or None: then kernels are compiled as they are called."""


def _ask_for_compiler() -> None:
    """ImportError where there is nothing to run kernels with."""
    from importlib.util import find_spec

    if find_spec("numba") is None:
        what = "Conicoid came without machine code for this processor, so it needs a compiler"
        raise ImportError(f"{what}: pip install 'conicoid[jit]'")


if SHIPPED is None:
    _ask_for_compiler()


def entry(name: str) -> Callable[..., Any] | None:
    """A kernel of the extension; None: it has to be compiled."""
    if SHIPPED is None:
        return None
    found: Callable[..., Any] = SHIPPED.kernel(name)
    return _as_array(found) if SHIPPED.returns_array(name) else found


def _as_array(found: Callable[..., Any]) -> Callable[..., Any]:
    """A kernel whose result is memory of its own, as an array."""

    def call(*arguments: Any) -> Any:
        return np.asarray(found(*arguments))

    return call


def levels() -> tuple[str, ...]:
    """The levels of processor that this one can run and the package has machine code for, the best last."""
    return () if SHIPPED is None else tuple(SHIPPED.levels())


def describe_code() -> str:
    """For a report: where kernels come from."""
    if SHIPPED is None:
        return "compiled by Numba"
    return f"machine code of the package, for {SHIPPED.level()}"
