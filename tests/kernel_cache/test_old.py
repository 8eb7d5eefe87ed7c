"""Kernels of older sources go when those of new ones come; nothing else in the folder ever does."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from conicoid._jit.disk_cache import MARK, MARK_TEXT, MOST_FOLDERS

from .tiny import COMPILED, apart, kept

DAY = 24 * 3600.0


def older(parent: Path, number: int, age: float, mark: bytes | None = MARK_TEXT) -> Path:
    """A folder as other sources would have left it, last used so long ago."""
    folder = parent / f"kernels-{number:020x}"
    folder.mkdir()
    for name in ("doubled-0123.nbc", "doubled-0123.nbc.lock", "doubled-0123.x8fe.tmp"):
        (folder / name).write_bytes(b"")
    if mark is not None:
        (folder / MARK).write_bytes(mark)
        os.utime(folder / MARK, (time.time() - age,) * 2)
    return folder


@pytest.fixture
def parent(tmp_path):
    """A folder for kernels with as many old ones in it as are kept."""
    folder = tmp_path / "kernels"
    folder.mkdir(mode=0o700)
    for k in range(MOST_FOLDERS):
        older(folder, k, 2 * DAY)
    return folder


def tree(folder: Path) -> set[Path]:
    return set(folder.rglob("*"))


def test_the_last_used_are_kept(parent):
    last = [older(parent, 100 + k, (3 + k) * DAY) for k in range(3)]
    before = tree(parent)
    assert apart(parent).value == COMPILED
    gone = before - tree(parent)
    assert gone == {path for folder in last for path in (folder, *(folder / name for name in _NAMES))}


_NAMES = ("doubled-0123.nbc", "doubled-0123.nbc.lock", "doubled-0123.x8fe.tmp", MARK)


def test_what_was_used_today_is_kept(parent):
    for k in range(10):
        older(parent, 100 + k, 0.5 * DAY)
    before = tree(parent)
    apart(parent)
    removed = {path.name for path in before - tree(parent) if path.is_dir()}
    assert removed == set()
    # those of two days ago, which had been the last used, are now the oldest
    assert {f"kernels-{k:020x}" for k in range(MOST_FOLDERS)} == {
        path.name for path in before if path.parent == parent and path not in tree(parent)
    }


def test_use_counts(parent):
    """A folder that is read is not old, whenever it was made."""
    apart(parent)
    mark = kept_here(parent) / MARK
    os.utime(mark, (time.time() - 100 * DAY,) * 2)
    apart(parent)
    assert time.time() - mark.stat().st_mtime < DAY


def kept_here(parent: Path) -> Path:
    return next(path.parent for path in parent.rglob("*.nbc") if path.stat().st_size)


def strangers(parent: Path) -> list[Path]:
    """What looks like an old folder of ours in part, each with a file in it."""
    made = [
        older(parent, 200, 9 * DAY, mark=None),
        older(parent, 201, 9 * DAY, mark=b""),
        older(parent, 202, 9 * DAY, mark=MARK_TEXT.splitlines(keepends=True)[0]),
        older(parent, 203, 9 * DAY, mark=MARK_TEXT + b"more\n"),
    ]
    named = older(parent, 204, 9 * DAY)
    for name in ("other", "kernels", "kernels-1234", f"kernels-{204:020x}-copy", f"kernels-{'g' * 20}"):
        folder = parent / name
        folder.mkdir()
        for path in named.iterdir():
            (folder / path.name).write_bytes(path.read_bytes())
        made.append(folder)
    for path in named.iterdir():
        path.unlink()
    named.rmdir()
    (parent / f"kernels-{205:020x}").write_text("a file")
    (parent / "file").write_text("")
    return made


def test_strangers_stay(parent):
    strangers(parent)
    before = tree(parent)
    assert apart(parent).value == COMPILED
    assert before <= tree(parent)


@pytest.mark.skipif(not hasattr(os, "symlink") or os.name == "nt", reason="links")
def test_links_are_not_followed(parent, tmp_path):
    target = older(tmp_path, 300, 9 * DAY)
    (parent / target.name).symlink_to(target)
    within = older(parent, 301, 9 * DAY)
    (within / "elsewhere.nbc").symlink_to(target)
    before = tree(parent) | tree(tmp_path)
    apart(parent)
    gone = before - tree(parent) - tree(tmp_path)
    assert all(path.parent == within for path in gone)
    assert (within / "elsewhere.nbc").is_symlink()


def test_what_somebody_put_into_an_old_folder_stays(parent):
    folder = older(parent, 400, 9 * DAY)
    (folder / "notes.txt").write_text("mine")
    (folder / "sub").mkdir()
    (folder / "sub" / "a.nbc").write_text("mine")
    apart(parent)
    assert tree(folder) == {folder / "notes.txt", folder / "sub", folder / "sub" / "a.nbc", folder / MARK}


def test_a_folder_that_goes_while_it_is_used_is_made_again(tmp_path):
    outcome = apart(tmp_path / "kernels", use_of_what_goes)
    assert outcome.quiet, outcome
    assert outcome.value == list(COMPILED)
    assert kept(tmp_path / "kernels").parent.joinpath(MARK).read_bytes() == MARK_TEXT


def use_of_what_goes() -> object:
    import shutil

    from conicoid._jit import disk_cache as place

    from . import tiny

    declared = tiny.declared()
    tiny.declared = lambda: declared
    save = type(declared._cache).save_overload

    def after_it_has_gone(self, signature, data):
        shutil.rmtree(place.kernel_directory())
        save(self, signature, data)

    type(declared._cache).save_overload = after_it_has_gone
    return list(tiny.used())
