"""Decks that chance has spoilt are read, or refused with a line; nothing else happens."""

from __future__ import annotations

from pathlib import Path

import pytest

from conicoid._util.files import SceneFileError
from conicoid.io.importers import ImportOptions
from conicoid.io.mcnp.importer import import_file

from .mutations import mutated


def spoilt(folder: Path, seeds: range) -> tuple[int, int]:
    """How many of some decks are read, and how many refused."""
    read = refused = 0
    path = folder / "deck.mcnp"
    for seed in seeds:
        path.write_text(mutated(seed), encoding="utf-8")
        try:
            import_file(path, ImportOptions(max_bodies=2000))
            read += 1
        except SceneFileError as error:
            assert str(error).startswith(str(path)), seed
            assert error.problems, seed
            refused += 1
        except Exception as error:
            raise AssertionError(f"seed {seed}: {error!r}") from error
    return read, refused


def test_spoilt_decks_are_read_or_refused(tmp_path: Path) -> None:
    read, refused = spoilt(tmp_path, range(80))
    assert read > 8
    assert refused > 24


@pytest.mark.deep
@pytest.mark.parametrize("first", range(1000, 3000, 500))
def test_many_spoilt_decks_are_read_or_refused(first: int, tmp_path: Path) -> None:
    """2,000 in all."""
    spoilt(tmp_path, range(first, first + 500))
