"""A GPU that is this processor: the LLVM code that becomes PTX, run here, one thread after the other."""

from __future__ import annotations

import ctypes
from typing import Any

import llvmlite.binding as llvm

from native import ptx


class Kernels:
    """The entries of `native.ptx.base`, as functions of this machine."""

    def __init__(self, module: bytes) -> None:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        target, features = llvm.Target.from_default_triple(), llvm.get_host_cpu_features().flatten()
        machine = target.create_target_machine(cpu=llvm.get_host_cpu_name(), features=features, opt=2, jit=True)
        whole = llvm.parse_bitcode(module)
        whole.triple, whole.data_layout = target.triple, str(machine.target_data)
        builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=1))
        builder.getModulePassManager().run(whole, builder)
        self._engine = llvm.create_mcjit_compiler(whole, machine)
        self._engine.finalize_object()
        self._functions: dict[str, Any] = {}

    def run(self, name: str, arguments: list[int], threads: int) -> None:
        """Run all threads of a kernel, in order."""
        if name not in self._functions:
            address = self._engine.get_function_address(ptx.PREFIX + name)
            kinds = [ctypes.c_int64] * (2 + len(arguments))
            self._functions[name] = ctypes.CFUNCTYPE(ctypes.c_int32, *kinds)(address)
        for thread in range(threads):
            assert self._functions[name](thread, threads, *arguments) == 0
