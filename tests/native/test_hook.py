"""The results of `pip wheel .`: requirements of each kind of build, CONICOID_KERNELS, tags; no test builds a kernel."""

import importlib.util
import subprocess
import sys
import sysconfig
from collections import namedtuple
from pathlib import Path
from zipfile import ZipFile

import pytest
from hatchling.builders.wheel import WheelBuilder

from conicoid._util.environment import KNOWN
from native import backend, build, page
from native.hook import KernelsHook
from native.targets import TARGETS
from tests.children import ROOT

pytest.importorskip("ziglang", reason="wheels are made where compilers are")

Version = namedtuple("Version", "major minor")


@pytest.fixture(autouse=True)
def project(monkeypatch):
    monkeypatch.chdir(ROOT)  # front ends call the backend there
    monkeypatch.delenv("CONICOID_KERNELS", raising=False)


def names(requirements: list[str]) -> set[str]:
    return {each.partition(">")[0].partition("<")[0].partition("~")[0] for each in requirements}


def build_wheel(folder: Path, version: str = "standard") -> Path:
    """Make a wheel of existing parts."""
    return Path(next(WheelBuilder(str(ROOT)).build(directory=str(folder), versions=[version])))


def test_a_wheel_requires_compilers_and_a_source_archive_does_not():
    requirements = backend.get_requires_for_build_wheel()
    assert {"numba", "ziglang", "numpy"} <= names(requirements)
    assert any(each.startswith("numba") and "<" in each for each in requirements), "a limit, as for the extra `jit`"
    assert backend.get_requires_for_build_sdist() == []


def test_the_variable_is_one_of_those_that_conicoid_knows():
    assert "CONICOID_KERNELS" in KNOWN  # or every start would warn about it


def test_an_editable_install_requires_no_compilers(tmp_path):
    # In a process of its own, as front ends call it: it sets a variable
    program = "from native import backend; print(backend.get_requires_for_build_editable())"
    process = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    assert "numba" not in process.stdout
    assert "ziglang" not in process.stdout
    assert build_wheel(tmp_path, "editable").name.endswith("-py3-none-any.whl")


def test_without_kernels_a_wheel_is_pure(monkeypatch, tmp_path):
    monkeypatch.setenv("CONICOID_KERNELS", "none")
    assert backend.get_requires_for_build_wheel() == []
    wheel = build_wheel(tmp_path)
    assert wheel.name.endswith("-py3-none-any.whl")
    with ZipFile(wheel) as archive:
        found = archive.namelist()
        about = archive.read(next(name for name in found if name.endswith("/WHEEL"))).decode().splitlines()
    assert {"Root-Is-Purelib: true", "Tag: py3-none-any"} <= set(about)
    assert "conicoid/scene/scene.py" in found
    assert not [name for name in found if name.endswith((".so", ".pyd", ".wasm"))]


@pytest.mark.parametrize("chosen", ["", "last"])
def test_levels_are_those_of_this_machine_or_some(monkeypatch, tmp_path, chosen, capsys):
    levels = [level.name for level in build.host().levels]
    expected = [levels[-1]] if chosen else levels
    monkeypatch.setenv("CONICOID_KERNELS", levels[-1] if chosen else "")
    built = []

    def extension(target, folder):
        built.extend(level.name for level in target.levels)
        return written(folder / "_kernels.abi3.so")

    monkeypatch.setattr(build, "lowered", written)
    monkeypatch.setattr(page, "build", lambda folder: written(folder / "engine.wasm"))
    monkeypatch.setattr(build, "build", extension)
    wheel = build_wheel(tmp_path)
    assert built == expected
    assert wheel.name.endswith(f"-cp311-abi3-{build.host().tag}.whl")
    assert {"conicoid/_kernels.abi3.so", page.PAGE_ENGINE} <= set(ZipFile(wheel).namelist())
    assert f": {', '.join(expected)} ...\n  0 s\n" in capsys.readouterr().out


def written(file: Path) -> Path:
    if not file.is_dir():
        file.write_bytes(b"some")
    return file


@pytest.mark.parametrize("chosen", ["all", "x86-64-v9", "none,none"])
def test_unknown_levels_are_refused(monkeypatch, chosen):
    monkeypatch.setenv("CONICOID_KERNELS", chosen)
    with pytest.raises(SystemExit, match=f"^CONICOID_KERNELS must be none, or some of .*; got '{chosen}'$"):
        backend.get_requires_for_build_wheel()


def test_wheels_for_all_systems_take_the_levels_that_are_theirs(monkeypatch):
    def levels(target: str) -> list[str]:
        target_of_hook = KernelsHook(str(ROOT), {"target": target}, None, None, "", "wheel")._target()
        return [level.name for level in target_of_hook.levels]

    monkeypatch.setenv("CONICOID_KERNELS", "x86-64-v3")
    assert levels("linux-x86_64") == levels("windows-x86_64") == ["x86-64-v3"]
    assert levels("linux-aarch64") == [level.name for level in TARGETS["linux-aarch64"].levels]
    monkeypatch.setenv("CONICOID_KERNELS", "x86-64-v9")
    with pytest.raises(SystemExit, match="^CONICOID_KERNELS must be none, or some of .*; got 'x86-64-v9'$"):
        levels("linux-aarch64")


@pytest.mark.parametrize(
    ("patches", "reason"),
    [
        (
            [(sys, "version_info", Version(3, 15))],
            "Numba, which cannot be installed for Python 3.15 on .*`make wheels`",
        ),
        ([(build, "host", lambda: TARGETS["musl-x86_64"])], "Numba, which cannot be installed for .* on musl-x86_64;"),
        ([(sysconfig, "get_config_var", lambda name: 1)], "for CPython with its lock"),
        ([(sys, "platform", "sunos5")], "there is no target sunos5-"),
    ],
)
def test_the_message_without_kernels_names_the_remedy(monkeypatch, patches, reason):
    advice = r"CONICOID_KERNELS=none makes a wheel without machine code"
    with monkeypatch.context() as patch:
        patch.setattr(importlib.util, "find_spec", lambda name: None)  # the environment of a build is empty at first
        for place, name, value in patches:
            patch.setattr(place, name, value)
        with pytest.raises(SystemExit, match=rf"{reason}.*\. {advice}"):
            backend.get_requires_for_build_wheel()


def test_an_installed_numba_is_used(monkeypatch):
    monkeypatch.setattr(build, "host", lambda: TARGETS["musl-x86_64"])
    assert "numba" in names(backend.get_requires_for_build_wheel())
