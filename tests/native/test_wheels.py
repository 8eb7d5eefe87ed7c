"""Making wheels: a break or a fault leaves no wheel behind, and a finished wheel is whole."""

import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path

import pytest

import conicoid as co
from native import inspection, ptx, wheels
from native.targets import TARGETS, Target


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
