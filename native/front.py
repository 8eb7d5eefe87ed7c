"""Kernels to LLVM code for no processor in particular: `python -m native.front FILE [KERNEL...]`.

It runs in a process of its own, because it changes Numba. No function is optimised or turned into machine code here.
Kernels compile as inner functions do, and so do Numba's own functions (of arrays, of counts of references), which Numba
would make for this processor.
"""

from __future__ import annotations

import argparse
import os
import pickle
import signal
import sys
from pathlib import Path
from typing import Any

os.environ["CONICOID_JIT"] = "own"

import numba
from numba import types
from numba.core import codegen, postproc, transforms

import conicoid
from conicoid._jit import compiler as functions
from conicoid._jit.sources import package_files, stamp_of

functions.Kernel = functions.Inner  # type: ignore[misc, assignment]

from .signature import Leaf, Signature, declared, on_device

SUFFIX = ".stamp"


def _keep_as_it_is(library: Any, module: Any) -> None:
    """Replace the optimisation for this processor."""
    module.data_layout = library._codegen._data_layout


_full_post_process = postproc.PostProcessor.run


def _post_process(processor: Any, emit_dels: bool = False, extend_lifetimes: bool = False) -> None:
    """Find the lives of variables where they end in code, not after each pass: a tenth of the front end's time."""
    if emit_dels:
        _full_post_process(processor, emit_dels, extend_lifetimes)
        return
    code = processor.func_ir
    code.blocks = transforms.canonicalize_cfg(code.blocks)
    code.variable_lifetime = postproc.VariableLifetime(code.blocks)


def bend() -> None:
    """Let Numba make nothing for this processor, and no more than kernels need."""
    postproc.PostProcessor.run = _post_process  # type: ignore[method-assign]
    functions._InnerLibrary._optimize_functions = _keep_as_it_is  # type: ignore[attr-defined]
    codegen.JITCPUCodegen._library_class = functions._InnerLibrary


def _scalar(leaf: Leaf) -> Any:
    if leaf.kind == "array":
        kind = numba.from_dtype(leaf.dtype)
        return types.Array(kind, len(leaf.lengths), "A" if leaf.strided else "C")
    return {"int": types.int64, "float": types.float64, "bool": types.boolean, "none": types.none}[leaf.kind]


def types_of(leaves: list[Leaf]) -> list[Any]:
    """Return Numba's types of arguments."""
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


def lowered(kernel: Signature, codes: dict[Any, bytes], entries: list[Any]) -> dict[str, Any]:
    """Return a kernel's symbol, how LLVM passes its arguments, and the numbers of its functions in `codes`.

    `codes` maps each of Numba's libraries to its LLVM code; it gets those that are new. A function that many kernels
    call is there once. `entries` gets the kernel's dispatcher.
    """
    dispatcher: Any = functions.Inner(kernel.function, nogil=True, error_model="numpy")
    arguments = tuple(types_of(kernel.leaves))
    dispatcher.compile(arguments)
    entries.append(dispatcher)
    result = dispatcher.overloads[arguments]
    calls = dispatcher.targetctx.call_conv.get_function_type(result.fndesc.restype, result.fndesc.argtypes)
    return dict(
        symbol=result.fndesc.llvm_func_name,
        arguments=[str(each) for each in calls.args],
        result=str(result.fndesc.restype),
        functions=_numbers([result.library], codes),
    )


def _numbers(libraries: list[Any], codes: dict[Any, bytes]) -> list[int]:
    """Return the places in `codes` of libraries and of those that they call, and add the code of new ones."""
    reached = functions._reachable_libraries(libraries)
    for library in reached:
        if library not in codes:
            codes[library] = getattr(library, "code", None) or functions._own_module(library).as_bitcode()
    places = {library: place for place, library in enumerate(codes)}
    return [places[library] for library in reached]


def main() -> None:
    """Write the code of every kernel, or of some, to a file, and beside it the stamp of the sources (SUFFIX)."""
    parser = argparse.ArgumentParser()
    parser.add_argument("out", type=Path)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--device", help="a part of the functions of a GPU's threads, in place of kernels")
    parser.add_argument("--memory", type=Path, help="a file that keeps the code of functions for the next build")
    wanted = parser.parse_args()
    before = stamp_of(package_files())
    bend()
    memory = None
    if wanted.memory:
        from .memory import Memory

        memory = Memory(wanted.memory)
        memory.bend()
    with functions._rare_collections():
        codes: dict[Any, bytes] = {}
        entries: list[Any] = []
        every, names = on_device()[wanted.device] if wanted.device else declared(), wanted.names
        kernels = {each.name: lowered(each, codes, entries) for each in every if not names or each.name in names}
    # A file that changed meanwhile may have been read before or after: no stamp, so that the code is built again
    unchanged = stamp_of(package_files()) == before
    if memory and unchanged:
        memory.keep(entries, codes)
    stamp = stamp_of(imported_files()) if unchanged else ""
    wanted.out.with_suffix(SUFFIX).write_text(stamp, encoding="utf-8")
    wanted.out.write_bytes(pickle.dumps((kernels, list(codes.values()))))


def imported_files() -> set[str]:
    """The source files of the package that this process has imported."""
    package = os.path.dirname(os.path.realpath(conicoid.__file__))
    modules = [module for name, module in sys.modules.items() if name.partition(".")[0] == "conicoid"]
    paths = {os.path.realpath(module.__file__) for module in modules if getattr(module, "__file__", None)}
    return {path.removeprefix(package).replace(os.sep, "/") for path in paths if path.endswith(".py")}


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends it without a trace: its parent prints the message
    main()
