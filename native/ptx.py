"""Kernels for GPUs as PTX, for NVIDIA's driver: `python -m native.ptx FOLDER` writes NAME_SIZE.ptx of each.

The code is that of the CPU. `native.front` translates the functions of `conicoid.kernels.device` to LLVM code, which is
linked into one module (`base`); LLVM's own back end for NVPTX makes PTX of it. tests/emulation.py runs the same module
here, one thread after the other.

An entry is `int NAME_SIZE(int64 thread, int64 threads, ...)`, with an address for each array and its length unless the
shape says it. The kernel in PTX takes the same, but the address of a status in place of the two numbers.

Products and sums are `mul.rn` and `add.rn`, which no assembler may fuse; `fma.rn` are those that the code calls for.
"""

from __future__ import annotations

import math
import pickle
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir

from conicoid._jit.sources import stamp_of
from conicoid.kernels.device import EACH, SHARED, SIZES, sizes_of
from conicoid.kernels.tables import POLYGON

from . import objects
from .arithmetic import reordered, strange_functions
from .build import device_code, stamp_of as sources_of
from .signature import Leaf, on_device
from .targets import Level

TRIPLE = "nvptx64-nvidia-cuda"
LEVEL = Level("cuda", "sm_75", "+ptx63")
PREFIX = "conicoid_"
STAMP = "sources.stamp"
"""The file beside the kernels with the digest of their sources."""
REGISTERS = {"balls": 80}
"""Registers of a thread, by sizes of scratch memory, `MOST_REGISTERS` for others. With more, fewer threads are
resident; with less they spill (measured on an H200).
"""
MOST_REGISTERS = 128
_I32, _I64 = ir.IntType(32), ir.IntType(64)
_POINTER = ir.IntType(8).as_pointer()
_PREFETCH = re.compile(r"^.*call void @llvm\.prefetch\b.*\n", re.M)
_HALT = re.compile(r"= load atomic i64, ptr \S+ monotonic, align 8.*")
_SQRT = """
declare double @llvm.sqrt.f64(double)
define double @sqrt(double %x) alwaysinline {
  %y = call double @llvm.sqrt.f64(double %x)
  ret double %y
}
"""


def _sizes(function: str, leaves: list[Leaf]) -> tuple[str, ...]:
    """Return the sizes of scratch memory for which a function has kernels."""
    return sizes_of(function) if any(leaf.name.startswith("scratch.") for leaf in leaves) else (EACH,)


FAMILIES = {"queries": ("sm_80", "sm_90"), "pictures": ("sm_90",)}
"""Cards that get machine code, where NVIDIA's assembler is installed. They need not wait for the driver's."""
LEAVES = {part: {each.name: each.leaves for each in functions} for part, functions in on_device().items()}
"""The arguments of each function, by the parts that are compiled apart."""
PARTS = {
    part: [f"{name}_{size}" for name, leaves in functions.items() for size in _sizes(name, leaves)]
    for part, functions in LEAVES.items()
}
NAMES = [name for names in PARTS.values() for name in names]
CUBINS = [f"{name}.{family}.cubin" for part, names in PARTS.items() for name in names for family in FAMILIES[part]]


def _leaves(function: str) -> list[Leaf]:
    """Return the arguments of a function."""
    return next(functions[function] for functions in LEAVES.values() if function in functions)


def _is_local(leaf: Leaf, size: str) -> bool:
    """Return whether an array is memory that the entry makes: `scratch` of a fixed size, and all of `memory`."""
    return (leaf.name.startswith("scratch.") and size != SHARED) or leaf.name.startswith("memory.")


def _open_axis(leaf: Leaf) -> int | None:
    """Return the axis of an array whose length a caller passes: where the shape does not have it."""
    return next((axis for axis, length in enumerate(leaf.lengths) if length is None or length.names), None)


def _parameters(leaves: list[Leaf], size: str) -> list[Any]:
    """Return LLVM's types of a caller's arguments."""
    kinds: list[Any] = []
    for leaf in leaves:
        if leaf.kind == "array" and not _is_local(leaf, size):
            kinds += [_POINTER] if _open_axis(leaf) is None else [_POINTER, _I64]
        elif leaf.kind in ("int", "float", "bool") and leaf.name not in ("begin", "step", "kinds"):
            kinds.append(_I64)
    return kinds


def parameter_count(name: str) -> int:
    """Return how many numbers a kernel takes after the address of a status, by its name in `NAMES`."""
    function, _, size = name.rpartition("_")
    return len(_parameters(_leaves(function), size))


class _Entry:
    """The entry of a function for one size of scratch memory."""

    def __init__(self, module: ir.Module, name: str, kernel: dict[str, Any], inner: ir.Function, size: str) -> None:
        self.leaves, self.size = _leaves(name.removeprefix(PREFIX)), size
        kinds = [_I64, _I64, *_parameters(self.leaves, size)]
        function = ir.Function(module, ir.FunctionType(_I32, kinds), f"{name}_{size}")
        self.builder = ir.IRBuilder(function.append_basic_block())
        thread, threads, *self.passed = function.args
        self.thread = thread
        kinds_of_entries = SIZES[size].kinds if size in SIZES else POLYGON
        numbers = {"begin": thread, "step": threads, "kinds": _I64(kinds_of_entries)}
        error, result = (self.builder.alloca(_POINTER) for _ in range(2))
        self.builder.store(ir.Constant(_POINTER, None), error)
        arguments = [self.builder.bitcast(each, _POINTER) for each in (result, error)]
        for leaf in self.leaves:
            if leaf.kind == "array":
                arguments += self._array(leaf)
            elif leaf.kind == "int":
                arguments.append(numbers[leaf.name] if leaf.name in numbers else self._number(leaf))
            elif leaf.kind in ("float", "bool", "none"):
                arguments.append(self._other(leaf.kind, inner.args[len(arguments)].type))
        self.builder.ret(self.builder.call(inner, arguments))

    def _number(self, leaf: Leaf) -> Any:
        """Return a number that the caller passes; the end of rows is that of the row of this thread."""
        number, b = self.passed.pop(0), self.builder
        if leaf.name != "end":
            return number
        after = b.add(self.thread, _I64(1))
        return b.select(b.icmp_signed("<", after, number), after, number)

    def _other(self, kind: str, passed: Any) -> Any:
        """Return a float, whose bits the caller passes as a number, a truth value, or nothing, as Numba does."""
        if kind == "none":
            return ir.Constant(passed, None)
        number = self.passed.pop(0)
        return self.builder.bitcast(number, passed) if kind == "float" else self.builder.trunc(number, passed)

    def _array(self, leaf: Leaf) -> list[Any]:
        """Return an array as Numba passes it."""
        b, bytes_each = self.builder, leaf.dtype.itemsize
        shape = [_I64(length.constant) if length is not None else _I64(0) for length in leaf.lengths]
        if _is_local(leaf, self.size):
            if leaf.name.startswith("scratch."):
                shape[0] = _I64(SIZES[self.size].lengths[leaf.name.partition(".")[2]])
            room = b.alloca(ir.IntType(8 * bytes_each), max(1, math.prod(each.constant for each in shape)))
            data = b.bitcast(room, _POINTER)
        else:
            data = self.passed.pop(0)
            axis = _open_axis(leaf)
            if axis is not None:
                shape[axis] = self.passed.pop(0)
            if leaf.name.startswith("scratch."):  # the part of this thread
                data = b.gep(data, [b.mul(b.mul(self.thread, shape[0]), _I64(bytes_each))])
        steps, count = [_I64(bytes_each)], shape[-1]
        for length in reversed(shape[:-1]):
            steps.insert(0, b.mul(count, _I64(bytes_each)))
            count = b.mul(count, length)
        nothing = ir.Constant(_POINTER, None)
        return [nothing, nothing, count, _I64(bytes_each), data, *shape, *steps]


def _put_entries(module: ir.Module, name: str, kernel: dict[str, Any]) -> None:
    """Add the entries of a function, one for each size."""
    kinds = [objects.kind_of(each) for each in kernel["arguments"]]
    inner = ir.Function(module, ir.FunctionType(_I32, kinds), kernel["symbol"])
    for size in _sizes(name.removeprefix(PREFIX), _leaves(name.removeprefix(PREFIX))):
        _Entry(module, name, kernel, inner, size)


def base(code: Path) -> bytes:
    """Return the module of all entries, from what `native.front` wrote."""
    machine = objects.machine_for(TRIPLE, LEVEL)
    whole = objects.linked(*pickle.loads(code.read_bytes()), machine, TRIPLE, PREFIX, _put_entries)
    objects.simplify(whole, machine)
    whole.link_in(llvm.parse_assembly(_SQRT))
    whole.get_function("sqrt").linkage = "internal"
    # A GPU has no such instruction; and its queries are never halted, so they need not look for it in far memory
    whole = llvm.parse_assembly(_HALT.sub("= add i64 0, 0", _PREFETCH.sub("", str(whole))))
    whole.verify()
    return bytes(whole.as_bitcode())


def _wrapper(name: str, size: str, target_data: str) -> Any:
    """Return a module with the kernel that calls an entry as its thread."""
    module = ir.Module("kernel")
    module.triple, module.data_layout = TRIPLE, target_data
    kinds = _parameters(_leaves(name), size)
    inner = ir.Function(module, ir.FunctionType(_I32, [_I64, _I64, *kinds]), f"{PREFIX}{name}_{size}")
    outer = ir.Function(module, ir.FunctionType(ir.VoidType(), [_POINTER, *kinds]), f"{name}_{size}")
    outer.calling_convention = "ptx_kernel"
    builder = ir.IRBuilder(outer.append_basic_block())
    block, place, width, blocks = (
        builder.zext(
            builder.call(ir.Function(module, ir.FunctionType(_I32, []), f"llvm.nvvm.read.ptx.sreg.{register}.x"), []),
            _I64,
        )
        for register in ("ctaid", "tid", "ntid", "nctaid")
    )
    status = builder.call(
        inner, [builder.add(builder.mul(block, width), place), builder.mul(blocks, width), *outer.args[1:]]
    )
    with builder.if_then(builder.icmp_signed("!=", status, _I32(0))):
        builder.store(status, builder.bitcast(outer.args[0], _I32.as_pointer()))
    builder.ret_void()
    text = str(module).replace(")\n{", f') "nvvm.maxnreg"="{REGISTERS.get(size, MOST_REGISTERS)}"\n{{')
    return llvm.parse_assembly(text)


def ptx(module: bytes, name: str) -> str:
    """Return the PTX of one kernel, by its name in `NAMES`. ValueError if it has a fault."""
    function, _, size = name.rpartition("_")
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    llvm.set_option("", "--nvptx-fma-level=0")
    machine = objects.machine_for(TRIPLE, LEVEL)
    whole = llvm.parse_bitcode(module)
    whole.link_in(_wrapper(function, size, str(machine.target_data)))
    for each in (*whole.functions, *whole.global_variables):
        if not each.is_declaration:
            each.linkage = "external" if each.name == name else "internal"
            each.visibility = "default"
    objects.optimize(whole, machine, is_short=size in ("few", "many", SHARED))
    _shorten(whole, name)
    wrong = [*wrong_with_code(whole)]
    text = machine.emit_assembly(whole)
    wrong += wrong_with_ptx(text, _fused(whole))
    if wrong:
        raise ValueError(f"{name}: {'; '.join(wrong)}")
    return str(text)


def _shorten(module: Any, name: str) -> None:
    """Give all functions and constants short names, but the kernel."""
    kept = [each for each in (*module.functions, *module.global_variables) if not each.is_declaration]
    for number, each in enumerate(each for each in kept if each.name != name):
        each.name = f"c{number}"


_OWN = re.compile(r"llvm\.nvvm\.read\.ptx\.sreg\.\w+\.x|llvm\.(?:fabs|fma|maxnum|minnum)\.f32")
"""Functions that a GPU's code may call: places of threads, and float32 of short nodes (kernels/bvh/short_nodes.py)."""


def wrong_with_code(module: Any) -> Iterator[str]:
    """List functions that a kernel may not call, and operations that it may not have."""
    called = [each.name for each in module.functions if each.is_declaration]
    strange = strange_functions(each for each in called if not _OWN.fullmatch(each))
    if strange:
        yield f"calls {', '.join(strange)}"
    if reordered(str(module)):
        yield "has arithmetic that may be reordered"
    if " frem " in str(module):
        yield "has remainders, which NVPTX rounds twice"


def _fused(module: Any) -> int:
    """Return how many products the code of a module fuses with a sum."""
    calls = re.findall(r" call (double|<\d+ x double>) @llvm\.fma\.", str(module))
    return sum(1 if each == "double" else int(each[1:].partition(" ")[0]) for each in calls)


_ARITHMETIC = re.compile(
    r"^\s+(?:@!?%p\d+ )?((?:add|sub|mul|fma|mad|div|rcp|sqrt|rsqrt|sin|cos|ex2|lg2|tanh)\S*f(?:16|32|64))\s", re.M
)
"""Instructions that round."""


def wrong_with_ptx(text: str, fused: int) -> Iterator[str]:
    """List the faults of a kernel's PTX, whose code has at most so many fused products."""
    rounding = set(_ARITHMETIC.findall(text))
    short = {f"{each}.rn.f32" for each in ("add", "sub", "mul", "fma")}
    exact = {f"{each}.rn.f64" for each in ("add", "sub", "mul", "fma", "div", "sqrt", "rcp")}
    strange = sorted(rounding - exact - short)
    if strange:
        yield f"rounds by {', '.join(strange)}"
    yield from (f"has {each}" for each in sorted(set(re.findall(r"\.(?:approx|ftz|full|sat)\b", text))))
    if len(re.findall(r"\bfma\.rn\.f64\b", text)) > fused:
        yield "fuses what the code does not"
    called = set(re.findall(r"\bcall(?:\.uni)?\s+(?:\([^)]*\),\s*)?([^\s,;]+)", text))
    if ".extern" in text or not all(re.fullmatch(r"c\d+", each) for each in called):
        yield f"calls {', '.join(sorted(called))}"
    if "/" in re.sub(r"//.*", "", text):
        yield "names a place"


def build(folder: Path, out: Path, names: Sequence[str] = NAMES) -> None:
    """Write the PTX of kernels, and the stamp of their sources; `folder` holds intermediate files."""
    sources: set[str] = set()
    for part, every in PARTS.items():
        code, some = device_code(folder, part), [name for name in every if name in names]
        sources.update(sources_of(code).split("\n")[1:])
        _write(base(code) if some else b"", out, some, FAMILIES[part])
    (out / STAMP).write_text(stamp_of(sorted(sources), compilers=False), encoding="utf-8")


def _write(module: bytes, out: Path, names: Sequence[str], families: Sequence[str]) -> None:
    """Write the PTX of kernels of one part, and their machine code."""
    for name in names:
        file = out / f"{name}.ptx"
        file.write_text(ptx(module, name), encoding="ascii")
        for family in families:
            cubin = file.with_suffix(f".{family}.cubin")
            cubin.unlink(missing_ok=True)  # of an earlier build: drivers prefer it to the text
            if shutil.which("ptxas"):
                subprocess.run(["ptxas", f"-arch={family}", "-o", cubin, file], check=True)


if __name__ == "__main__":
    build(Path(sys.argv[1]), Path(sys.argv[1]), sys.argv[2:] or NAMES)
