"""Kernels to LLVM code for no processor in particular: `python -m native.front FILE [KERNEL...]`.

Works in a process of its own, because it bends Numba: no function is optimised or turned into machine code here,
kernels are compiled as inner functions are, and so are Numba's own (of arrays, of counts of references), which it would
make for this processor.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
from pathlib import Path
from typing import Any

os.environ["CONICOID_JIT"] = "own"

import numba
from numba import types
from numba.core import codegen

from conicoid._jit import compiler as functions
from conicoid._jit import dispatch

dispatch.Kernel = functions.Inner  # type: ignore[misc, assignment]

from .signature import Leaf, Signature, declared


def _keep_as_it_is(library: Any, module: Any) -> None:
    """In place of optimising for this processor."""
    module.data_layout = library._codegen._data_layout


def bend() -> None:
    """Let nothing be made for this processor."""
    functions.bits = lambda codegen: 0  # type: ignore[assignment]
    functions._InnerLibrary._optimize_functions = _keep_as_it_is  # type: ignore[attr-defined]
    codegen.JITCPUCodegen._library_class = functions._InnerLibrary


def _scalar(leaf: Leaf) -> Any:
    if leaf.kind == "array":
        kind = numba.from_dtype(leaf.dtype)
        return types.Array(kind, len(leaf.lengths), "C")
    return {"int": types.int64, "float": types.float64, "bool": types.boolean, "none": types.none}[leaf.kind]


def types_of(leaves: list[Leaf]) -> list[Any]:
    """Numba's types of arguments."""
    waiting: list[list[Any]] = [[]]
    for leaf in leaves:
        if leaf.kind == "(":
            waiting.append([])
        elif leaf.kind == ")":
            parts = waiting.pop()
            waiting[-1].append(types.BaseTuple.from_types(parts, leaf.record))
        else:
            waiting[-1].append(_scalar(leaf))
    return waiting[0]


def lowered(kernel: Signature) -> dict[str, Any]:
    """The LLVM code of a kernel with all that it calls, its symbol, and how LLVM passes its arguments."""
    dispatcher: Any = functions.Inner(kernel.function, nogil=True, error_model="numpy")
    arguments = tuple(types_of(kernel.leaves))
    dispatcher.compile(arguments)
    result = dispatcher.overloads[arguments]
    calls = dispatcher.targetctx.call_conv.get_function_type(result.fndesc.restype, result.fndesc.argtypes)
    return dict(
        symbol=result.fndesc.llvm_func_name,
        arguments=[str(each) for each in calls.args],
        result=str(result.fndesc.restype),
        code=result.library._get_module_for_linking().as_bitcode(),
    )


def main() -> None:
    """Write the code of every kernel, or of some, to a file."""
    out, *names = sys.argv[1:]
    bend()
    with functions._rare_collections():
        found = {kernel.name: lowered(kernel) for kernel in declared() if not names or kernel.name in names}
    Path(out).write_bytes(pickle.dumps(found))


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends it without a trace: whoever started it tells
    main()
