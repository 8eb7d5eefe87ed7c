"""The build refuses objects whose answers another machine would not give to the bit."""

import pickle

import llvmlite.binding as llvm
import pytest

from native import objects
from native.arithmetic import reordered, strange_functions
from native.build import host, host_level

BODY = """
declare double @{function}(double)
define i32 @k({arguments}) {{
    %x = {instruction}
    store double %x, ptr %out
    ret i32 0
}}
"""
ARGUMENTS = "ptr %out, ptr %error, double %a"


def object_of(folder, instruction, function="llvm.sqrt.f64"):
    """Return the object of a kernel of one instruction."""
    text = BODY.format(function=function, arguments=ARGUMENTS, instruction=instruction)
    kernel = dict(symbol="k", arguments=["i8*", "i8*", "double"], result="none", functions=[0])
    codes = [llvm.parse_assembly(text).as_bitcode()]
    (folder / "code").write_bytes(pickle.dumps(({"kernel": kernel}, codes)))
    objects.write_base(str(folder / "code"), host().name, str(folder / "base"))
    objects.write_object(str(folder / "base"), host().name, host_level(host()), str(folder / "object"))
    return folder / "object"


@pytest.mark.parametrize(
    "instruction",
    ["fadd double %a, 1.0", "fdiv double 1.0, %a", "fneg double %a", "call double @llvm.sqrt.f64(double %a)"],
)
def test_ieee_arithmetic_is_built(tmp_path, instruction):
    assert object_of(tmp_path, instruction).stat().st_size > 0


@pytest.mark.parametrize(
    "instruction",
    [
        "fadd fast double %a, 0.1",
        "fmul contract double %a, 0.1",
        "fdiv arcp double 0.1, %a",
        "fsub nsz double 0.1, %a",
        "tail call nnan double @llvm.sqrt.f64(double %a)",
        "frem double %a, 0.1",
    ],
)
def test_reorderable_arithmetic_is_refused(tmp_path, instruction):
    with pytest.raises(ValueError, match="kernels have arithmetic that may be reordered"):
        object_of(tmp_path, instruction)
    assert not (tmp_path / "object").exists()


@pytest.mark.parametrize("function", ["sin", "pow", "exp", "fmod", "llvm.sin.f64", "llvm.exp.f64", "cbrt"])
def test_mathematics_of_a_library_is_refused(tmp_path, function):
    with pytest.raises(ValueError, match=rf"kernels may not call {function}"):
        object_of(tmp_path, f"call double @{function}(double %a)", function)
    assert not (tmp_path / "object").exists()


def test_names_are_read_whole():
    assert strange_functions(["llvm.fma.v8f64", "llvm.fma.f32", "sqrtf", "NRT_Free", "memcpy"]) == [
        "llvm.fma.f32", "memcpy", "sqrtf"
    ]  # fmt: skip


def test_flags_are_looked_for_in_instructions_alone():
    assert reordered('  store ptr @"fast", ptr %x ; contract\n  %y = fadd <8 x double> %a, %fast\n') == []
    assert len(reordered("  %y = fadd reassoc <8 x double> %a, %b\n  %z = frem double %a, %b\n")) == 2
