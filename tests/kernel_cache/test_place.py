"""Folders that cannot be written, that are not ours, or that somebody else may have filled."""

from __future__ import annotations

import os
import pickle
import shutil
import stat
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from conicoid._jit.decorators import kernel
from conicoid._jit.disk_cache import PACKAGE

from .tiny import COMPILED, LOADED, apart, kept, posix_only, used

NOBODY = 65534
as_root = pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives files away")


def without_numbas_places(numba: str) -> object:
    """Numba's own locators would find a folder, given in its own way."""
    from numba.core import config

    config.CACHE_DIR = numba
    return used()


def without_a_home() -> object:
    """What platformdirs says for a user who is in no list and has no HOME."""
    import platformdirs

    del os.environ["CONICOID_CACHE_DIR"]
    platformdirs.user_cache_dir = lambda *_, **__: os.path.join("~", ".cache", "conicoid")
    os.chdir(tempfile.mkdtemp())
    result = used()
    assert os.listdir() == []
    return result


def test_where_no_folder_can_be_made_nobody_else_keeps_kernels(tmp_path):
    (tmp_path / "file").write_text("no folder")
    for folder in (tmp_path / "file", tmp_path / "file" / "below", tmp_path / ("x" * 300), Path("/dev/null/x")):
        outcome = apart(folder, without_numbas_places, str(tmp_path / "numba"))
        assert outcome.value == COMPILED
        assert outcome.one_line, outcome
        assert str(folder) in outcome.errors
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file"]


def test_without_a_home(tmp_path):
    outcome = apart(tmp_path / "kernels", without_a_home)
    assert outcome.value == COMPILED
    assert outcome.one_line
    assert "CONICOID_CACHE_DIR" in outcome.errors


def test_outside_of_the_package_nothing_is_kept(tmp_path):
    assert kernel()(lambda x: 3.0 * x).stats.cache_path is None


def as_another_user() -> object:
    """Without the rights of the owner of the files."""
    if os.geteuid() == 0:
        os.seteuid(NOBODY)
    return used()


@pytest.fixture
def open_folder():
    """Where every user gets to, unlike `tmp_path`."""
    with tempfile.TemporaryDirectory() as name:
        os.chmod(name, 0o755)
        yield Path(name) / "kernels"


def forbid_writing(folder: Path) -> None:
    for path in (folder, *folder.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o444)


@posix_only
def test_a_complete_cache_that_is_only_readable_is_read_and_nothing_said(open_folder):
    apart(open_folder)
    forbid_writing(open_folder)
    before = sorted(open_folder.rglob("*"))
    outcome = apart(open_folder, as_another_user)
    assert outcome.quiet, outcome
    assert outcome.value == LOADED
    assert sorted(open_folder.rglob("*")) == before


@posix_only
@pytest.mark.parametrize("what", ["incomplete", "damaged", "empty"])
def test_what_a_cache_lacks_that_is_only_readable_is_compiled_in_memory(open_folder, what):
    apart(open_folder)
    path = kept(open_folder)
    path.write_bytes(b"") if what == "damaged" else path.unlink()
    if what == "empty":
        for found in open_folder.glob("*/*"):
            found.unlink()
        path.parent.rmdir()
    forbid_writing(open_folder)
    outcome = apart(open_folder, as_another_user)
    assert outcome.value == COMPILED
    assert outcome.one_line, outcome


class Program:
    """Unpickled, it makes a file."""

    def __init__(self, trace: Path) -> None:
        self.trace = trace

    def __reduce__(self) -> object:
        return Path.touch, (self.trace,)


def plant(trace: str) -> None:
    """In place of a kernel, something that looks like one in every way, and runs a program."""
    from conicoid._jit import disk_cache as files

    name = kept(Path(os.environ["CONICOID_CACHE_DIR"])).name
    assert files.write_kernel(name, pickle.dumps(Program(Path(trace))))


def as_somebody_else() -> object:
    """As if the files belonged to another user."""
    number = os.geteuid() + 1000
    os.geteuid = lambda: number
    return used()


@pytest.fixture
def planted(tmp_path):
    """(folder with such a file, what it would make)."""
    folder, trace = tmp_path / "kernels", tmp_path / "the program ran"
    apart(folder)
    assert apart(folder, plant, str(trace)).quiet
    return folder, trace


def test_the_planted_program_would_run(planted):
    folder, trace = planted
    apart(folder)
    assert trace.exists()


@posix_only
@pytest.mark.parametrize("mode", [0o720, 0o702])
@pytest.mark.parametrize("below", [False, True], ids=["chosen", "below"])
def test_what_others_can_write_to_is_refused(planted, mode, below):
    folder, trace = planted
    place = kept(folder).parent if below else folder
    place.chmod(mode)
    outcome = apart(folder)
    assert not trace.exists()
    assert outcome.value == COMPILED
    assert outcome.one_line, outcome
    assert str(place) in outcome.errors
    place.chmod(0o700)
    apart(folder)
    assert trace.exists()


@posix_only
def test_a_file_that_others_can_write_to_is_not_read(planted):
    folder, trace = planted
    kept(folder).chmod(0o666)
    outcome = apart(folder)
    assert outcome.quiet, outcome
    assert outcome.value == COMPILED
    assert not trace.exists()
    assert stat.S_IMODE(kept(folder).stat().st_mode) == 0o600


@posix_only
def test_a_link_to_a_folder_is_refused(planted):
    folder, trace = planted
    place = kept(folder).parent
    place.rename(folder / "elsewhere")
    place.symlink_to(folder / "elsewhere")
    outcome = apart(folder)
    assert outcome.value == COMPILED
    assert outcome.one_line
    assert not trace.exists()


@posix_only
def test_what_belongs_to_another_user_is_refused(planted):
    folder, trace = planted
    for path in (folder, *folder.rglob("*")):
        if os.geteuid() == 0:
            os.chown(path, NOBODY, NOBODY)
    outcome = apart(folder, used if os.geteuid() == 0 else as_somebody_else)
    assert not trace.exists()
    assert outcome.value == COMPILED
    assert outcome.one_line, outcome
    assert "belongs to another user" in outcome.errors


@posix_only
@as_root
def test_one_foreign_file_is_not_read(planted):
    folder, trace = planted
    os.chown(kept(folder), NOBODY, NOBODY)
    assert apart(folder).value == COMPILED
    assert not trace.exists()


def careless() -> object:
    os.umask(0)
    return used()


@posix_only
def test_ours_is_for_us_alone(tmp_path):
    assert apart(tmp_path / "a" / "kernels", careless).value == COMPILED
    for path in (tmp_path / "a" / "kernels", *(tmp_path / "a" / "kernels").rglob("*")):
        assert stat.S_IMODE(path.stat().st_mode) == (0o700 if path.is_dir() else 0o600)
    assert apart(tmp_path / "a" / "kernels").value == LOADED


@posix_only
def test_beside_others_folders_in_one_that_is_everybodys(tmp_path):
    """As in /tmp: there nobody renames what belongs to others. It must be root's, who could do anything anyway."""
    if os.geteuid() != 0:
        pytest.skip("only root makes such a folder")
    tmp_path.chmod(0o1777)
    assert apart(tmp_path).value == COMPILED
    outcome = apart(tmp_path)
    assert outcome.quiet, outcome
    assert outcome.value == LOADED


def edited_meanwhile() -> object:
    """The sources are no longer those that were read."""
    from conicoid._jit import sources

    sources.source_hash()
    sources.hash_of_sources = lambda: "0" * 20
    return used()


def test_what_is_compiled_while_sources_change_is_not_kept(tmp_path):
    outcome = apart(tmp_path / "kernels", edited_meanwhile)
    assert outcome.quiet, outcome
    assert outcome.value == COMPILED
    assert not list(tmp_path.rglob("*.nbc"))


def without_sources(some: str) -> object:
    """As in an archive, or while the package is being replaced."""
    from conicoid._jit import sources

    sources._files = lambda _: [f"{sources._PACKAGE}/gone.py"] if some else []
    sources.source_hash.cache_clear()
    return [sources.source_hash(), *used()]


@pytest.mark.parametrize("some", ["", "some"])
def test_without_sources_nothing_is_kept(tmp_path, some):
    outcome = apart(tmp_path / "kernels", without_sources, some)
    assert outcome.quiet, outcome
    assert outcome.value == ["", *COMPILED]
    assert not (tmp_path / "kernels").exists()


def test_no_old_code_after_an_edit(tmp_path):
    """Of a function that a kernel calls, in another file; with a folder for kernels and without one."""
    shutil.copytree(PACKAGE, tmp_path / "conicoid", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "conicoid" / "tiny.py").write_text(
        "from ._jit.decorators import kernel\nfrom .factor import times\n\n@kernel()\ndef tiny(x):\n    return times(x)\n"
    )
    for folder in (tmp_path / "kernels", Path("/dev/null/x")):
        for factor in (2.0, 30.0):  # of another length: Python compares sizes and seconds
            (tmp_path / "conicoid" / "factor.py").write_text(
                f"from ._jit.decorators import inline\n\n@inline\ndef times(x):\n    return {factor} * x\n"
            )
            environment = os.environ | {"CONICOID_CACHE_DIR": str(folder)}
            program = "from conicoid.tiny import tiny; print(tiny(7.0))"
            command = [sys.executable, "-c", program]
            run = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
            assert run.stdout == f"{7.0 * factor}\n", run.stderr
    assert not [path for path in (tmp_path / "conicoid").rglob("*") if path.suffix in (".nbi", ".nbc")]
