"""Making wheels: a break or a fault leaves no wheel behind, and a finished wheel is whole."""

import shutil
import struct
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path
from zipfile import ZipFile

import pytest

import conicoid as co
from native import build, inspection, page, ptx, wheels
from native.binary import read
from native.inspection import ROOT, STABLE, target_of, wrong_with_extension, wrong_with_wheel
from native.link import extension_name, side_module
from native.targets import TARGETS, Target
from native.wheels import wheel
from native.windows import import_library, stable_names

from ..samples import deep, marked


def run(monkeypatch, tmp_path: Path, build, *targets: str) -> int:
    """Return the exit status of `python -m native.wheels`, with letters in place of wheels."""
    monkeypatch.setattr(wheels, "wheel", build)
    monkeypatch.setattr(wheels, "cuda_wheel", lambda folder: build(Target("cuda", "", "", "any", ()), folder))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "scratch"))
    monkeypatch.setattr(sys, "argv", ["wheels", "--out", str(tmp_path / "dist"), *targets])
    (tmp_path / "scratch").mkdir(exist_ok=True)
    return wheels.main()


def letters_as_wheel(target, folder: Path) -> Path:
    path = folder / f"{target.name}.whl"
    path.write_text(target.tag)
    return path


def files_left(tmp_path: Path) -> set[str]:
    return {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()}


def test_all_arrive_with_the_source_archive(monkeypatch, tmp_path, capsys):
    assert run(monkeypatch, tmp_path, letters_as_wheel) == 0
    names = [*TARGETS, "cuda"]
    assert files_left(tmp_path) == {*(f"dist/{name}.whl" for name in names), f"dist/conicoid-{co.__version__}.tar.gz"}
    lines = capsys.readouterr().out.splitlines()
    assert "Wheel 2 of 9, for linux-aarch64:" in lines
    assert lines[-1] == f"To install it: pip install --find-links {tmp_path / 'dist'} conicoid"


def test_some_arrive_alone(monkeypatch, tmp_path, capsys):
    assert run(monkeypatch, tmp_path, letters_as_wheel, "macos-arm64") == 0
    assert files_left(tmp_path) == {"dist/macos-arm64.whl"}
    last = capsys.readouterr().out.splitlines()[-1]
    assert last == f"To install it: pip install {tmp_path / 'dist' / 'macos-arm64.whl'}"


@pytest.mark.parametrize(
    ("error", "status"), [(KeyboardInterrupt("interrupted"), 130), (ValueError("conicoid.whl: has no licence"), 1)]
)
def test_an_interrupted_or_faulty_wheel_withholds_all(error, status, monkeypatch, tmp_path, capsys):
    def faulty(target, folder: Path) -> Path:
        if target.name == "windows-x86_64":
            raise error
        return letters_as_wheel(target, folder)

    assert run(monkeypatch, tmp_path, faulty) == status
    assert files_left(tmp_path) == set()
    assert capsys.readouterr().err == f"{error}\n"


def test_unknown_targets_are_refused(monkeypatch, tmp_path, capsys):
    with pytest.raises(SystemExit):
        run(monkeypatch, tmp_path, letters_as_wheel, "amiga")
    assert "there is no target amiga" in capsys.readouterr().err


def test_the_wheel_of_kernels_for_gpus(monkeypatch, tmp_path):
    """Stand-ins take the place of the kernels, which tests/native/test_ptx.py tests."""

    def build(folder: Path, package: Path) -> None:
        for name in (ptx.STAMP, *(f"{each}.ptx" for each in ptx.NAMES)):
            (package / name).write_text(f"{name}, of nowhere")

    monkeypatch.setattr(ptx, "build", build)
    wheel = wheels.cuda_wheel(tmp_path)
    assert wheel.name == f"conicoid_cuda-{co.__version__}-py3-none-any.whl"
    with zipfile.ZipFile(wheel) as archive:
        about = archive.read(f"conicoid_cuda-{co.__version__}.dist-info/METADATA").decode()
    assert f"Requires-Dist: conicoid=={co.__version__}" in about
    project = tomllib.loads((inspection.ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["optional-dependencies"]["cuda"] == [f"conicoid-cuda=={co.__version__}"]
    with zipfile.ZipFile(wheel, "a") as archive:
        archive.writestr("conicoid_cuda/more.ptx", f"of {inspection.ROOT}")
    wrong = inspection.wrong_with_cuda_wheel(wheel)
    assert "holds what does not belong: conicoid_cuda/more.ptx" in wrong
    assert any(each.startswith("conicoid_cuda/more.ptx names a folder of the machine") for each in wrong)


# --- The inspection of a wheel before it gets its name: it finds each fault in a small extension


LINUX = TARGETS["linux-x86_64"]
GOOD = """
#include "python.h"
static PyModuleDef definition = {.base = {1, NULL}, .name = "_kernels", .size = -1};
EXPORT PyObject *PyInit__kernels(void) { return PyModule_Create2(&definition, 3); }
"""
START = "int DllMainCRTStartup(void *a, unsigned b, void *c) { (void)a, (void)b, (void)c; return 1; }"  # of a DLL


def compiled(folder: Path, source: str, target=LINUX, flags: tuple[str, ...] = ()) -> Path:
    """Return a file of the linker, without the runtime of a library, which the compiler makes at first use."""
    file, out = folder / "door.c", folder / extension_name(target)
    if target.system == "pyodide":
        file.write_text(source)
        return side_module(out, [file], [])
    file.write_text(source + START * (target.system == "windows"))
    more = {
        "windows": lambda: ["-nostdlib", str(import_library(folder))],
        "macos": lambda: ["-undefined", "dynamic_lookup", f"-Wl,-install_name,@rpath/{out.name}"],
    }.get(target.system, lambda: ["-nostdlib"] if not flags else [])()
    command = [sys.executable, "-m", "ziglang", "cc", "-target", target.zig, "-O2", "-fPIC", "-shared", "-s"]
    command += ["-fvisibility=hidden", f"-I{ROOT / 'native'}", str(file), "-o", str(out), *more, *flags]
    subprocess.run(command, check=True)
    return out


@pytest.mark.parametrize(
    "name", ["linux-x86_64", "musl-aarch64", "macos-arm64", deep("macos-x86_64"), "windows-x86_64", "pyodide-wasm32"]
)
def test_good_extension(tmp_path, name):
    """The inspection finds no fault, and lists the functions of Python in the format of every system."""
    target = TARGETS[name]
    extension = compiled(tmp_path, GOOD, target)
    assert wrong_with_extension(extension, target) == []
    binary = read(extension)
    assert "PyModule_Create2" in binary.imports
    assert binary.exports == {"PyInit__kernels"}


FAULTS = {
    "what the stable ABI does not have": (
        "PYTHON const char *PyUnicode_AsUTF8(PyObject *); EXPORT const char *PyInit__kernels(void) { return PyUnicode_AsUTF8(0); }",
        (),
        "takes what it may not: PyUnicode_AsUTF8",
    ),
    "mathematics of the platform": (
        "double sin(double); static volatile double x; EXPORT void *PyInit__kernels(void) { x = sin(x); return 0; }",
        ("-lm", "-fno-builtin"),
        "takes what it may not: sin",
    ),
    "something newer than its tag": (
        'int memfd_create(const char *, unsigned); EXPORT int PyInit__kernels(void) { return memfd_create("", 0); }',
        ("-target", "x86_64-linux-gnu.2.28"),
        "needs version 2.27, newer than its tag",
    ),
    "a second door": (
        GOOD + "EXPORT int other(void) { return 1; }",
        (),
        "offers PyInit__kernels, other, not PyInit__kernels alone",
    ),
    "another library": (
        "char *dlerror(void); EXPORT char *PyInit__kernels(void) { return dlerror(); }",
        ("-ldl",),
        "needs libraries: libdl.so.2",
    ),
    "a place for libraries": (GOOD, ("-Wl,-rpath,/opt/lib",), "says where libraries are to be looked for"),
    "a folder of this machine": (
        GOOD + f'EXPORT const char *PyInit_folder(void) {{ return "{ROOT}/native"; }}',
        (),
        f"names a folder of the machine it was built on: {ROOT}",
    ),
    "another processor": (GOOD, ("-target", "aarch64-linux-gnu.2.17"), "is for AARCH64"),
}
ELSEWHERE = "mathematics of the platform", "a second door", "another processor"
"""Tests of a browser's extension and of wheels find these faults, too."""


def test_faults_are_found_in_a_browsers(tmp_path):
    """The extension takes mathematics from Emscripten, or has a second door.

    The test compiles it as the build does, without C's library.
    """
    source = (
        "double sin(double); static volatile double x; EXPORT void *PyInit__kernels(void) { x = sin(x); return 0; }"
    )
    path = compiled(tmp_path, f'#include "python.h"\n{source}', TARGETS["pyodide-wasm32"])
    assert wrong_with_extension(path, TARGETS["pyodide-wasm32"]) == ["takes what it may not: sin"]
    assert wrong_with_extension(path, LINUX)[0] == "is for WASM32"


@pytest.mark.parametrize("fault", marked((fault, fault not in ELSEWHERE) for fault in FAULTS))
def test_faults_are_found(tmp_path, fault):
    source, flags, message = FAULTS[fault]
    if "#include" not in source:
        source = '#include "python.h"\n' + source
    assert message in wrong_with_extension(compiled(tmp_path, source, flags=flags), LINUX)


def test_a_stack_that_runs_code_is_found(tmp_path):
    path = compiled(tmp_path, GOOD)
    stack, read_write, run_too = 0x6474E551, 6, 7  # PT_GNU_STACK, and its flags
    content = path.read_bytes()
    assert struct.pack("<II", stack, read_write) in content
    path.write_bytes(content.replace(struct.pack("<II", stack, read_write), struct.pack("<II", stack, run_too)))
    assert wrong_with_extension(path, LINUX) == ["has a stack that runs code"]


def test_the_header_declares_nothing_but_the_stable_abi():
    functions, objects = stable_names()
    assert functions | objects <= STABLE
    assert {"PyErr_Format", "PyType_FromSpec"} <= functions
    assert {"PyExc_ValueError", "_Py_NoneStruct"} <= objects
    assert not functions & objects


def wheel_with(extension: Path, folder: Path) -> Path:
    """Return a wheel of hatchling and its hook, of existing parts."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build, "lowered", lambda folder: folder)
        patch.setattr(page, "build", page_engine)
        patch.setattr(build, "build", lambda target, folder: extension)
        return wheel(LINUX, folder)


@pytest.fixture
def good_wheel(tmp_path):
    (tmp_path / "extension").mkdir()
    return wheel_with(compiled(tmp_path / "extension", GOOD), tmp_path)


NO_MODULE = b"\0asm\1\0\0\0"
IMPORTING = NO_MODULE + bytes([1, 4, 1, 0x60, 0, 0]) + bytes([2, 7, 1, 1]) + b"m" + bytes([1]) + b"f" + bytes([0, 0])
"""A type () -> (), and a function of that type to import as m.f."""


def page_engine(folder: Path) -> Path:
    """Return an engine for pages that does nothing."""
    out = folder / "engine.wasm"
    out.write_bytes(NO_MODULE)
    return out


def test_a_wheel_holds_the_package_its_extension_and_the_licence(good_wheel):
    assert good_wheel.name.endswith("-cp311-abi3-manylinux_2_17_x86_64.whl")
    assert target_of(good_wheel) == LINUX
    with ZipFile(good_wheel) as archive:
        names = archive.namelist()
        metadata = archive.read(next(name for name in names if name.endswith("METADATA"))).decode().splitlines()
    assert "conicoid/_kernels.abi3.so" in names
    assert "conicoid/scene/scene.py" in names
    assert "conicoid/viewer/engine.wasm" in names
    assert [line for line in metadata if "numba" in line and "extra ==" not in line] == []
    assert not [name for name in names if name.startswith(("tests", "native"))]


def without(good: Path, out: Path, name: str, instead: dict[str, bytes]) -> Path:
    """Return a wheel without the files whose names end with `name`, and with other files."""
    with ZipFile(good) as archive, ZipFile(out, "w") as wheel_file:
        for each in archive.namelist():
            if not each.endswith(name):
                wheel_file.writestr(each, archive.read(each))
        for each, content in instead.items():
            wheel_file.writestr(each, content)
    return out


def test_faults_of_wheels_are_found(good_wheel, tmp_path):
    (tmp_path / "bad").mkdir()
    bad = tmp_path / "bad" / good_wheel.name
    engine = "conicoid/viewer/engine.wasm"
    for missing, instead, fault in (
        ("/LICENSE", {}, "has no licence"),
        ("_kernels.abi3.so", {}, "does not hold conicoid/_kernels.abi3.so alone"),
        ("//", {"tests/__init__.py": b""}, "holds what does not belong to the package: tests/__init__.py"),
        ("//", {"conicoid/pad": b"\0" * (8 << 20)}, "has {:,} bytes, more than 8,388,608"),
        ("engine.wasm", {}, f"has no {engine}"),
        ("engine.wasm", {engine: b""}, f"{engine} is no WebAssembly"),
        ("engine.wasm", {engine: IMPORTING}, f"{engine} takes something from the page"),
    ):
        findings = wrong_with_wheel(without(good_wheel, bad, missing, instead))
        assert findings == [fault.format(bad.stat().st_size)]
    other = bad.with_name(good_wheel.name.replace("x86_64", "aarch64"))
    shutil.copyfile(good_wheel, other)
    assert wrong_with_wheel(other) == ["does not say: Tag: cp311-abi3-manylinux_2_17_aarch64", "is for X86_64"]
    with pytest.raises(ValueError, match="a wheel for none of the targets"):
        wrong_with_wheel(good_wheel.with_name("conicoid-0.1.0-py3-none-any.whl"))


def test_a_faulty_extension_becomes_no_wheel(tmp_path):
    bad = compiled(tmp_path, GOOD + "EXPORT int other(void) { return 1; }")
    (tmp_path / "out").mkdir()
    with pytest.raises(ValueError, match="offers PyInit__kernels, other"):
        wheel_with(bad, tmp_path / "out")
