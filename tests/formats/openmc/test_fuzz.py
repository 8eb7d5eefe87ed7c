"""Geometries that chance has spoilt: they are read, or refused with a message; nothing else happens."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

import conicoid as co

from .models import TEXTS

WORDS = (
    "-1", "0", "1", "2", "5", "7", "11", "99", "1e300", "-1e-300", "1e999", "nan", "0.5", "x", "void", "|", "~", "(", ")", "&amp;",
    "-3 4", "", "z-plane", "sphere", "quadric", "z-torus", "y", "fill", "region", "universe", "9" * 30, "\u2029", "<cell/>",
)  # fmt: skip


def spoilt(text: str, chance: random.Random) -> str:
    """Some words replaced, doubled, exchanged or left out; now and then a piece of the file."""
    words = re.split(r"(\W+)", text)
    for _ in range(chance.choice([1, 1, 2, 5])):
        i, j = (chance.randrange(len(words)) for _ in range(2))
        match chance.randrange(5):
            case 0:
                words[i] = chance.choice(WORDS)
            case 1:
                words[i] += words[j]
            case 2:
                words[i], words[j] = words[j], words[i]
            case 3:
                words[i] = ""
            case _:
                del words[i : i + chance.randrange(1, 30)]
                words.append("")
    return "".join(words)


def tried(seeds: range, folder: Path) -> tuple[int, int]:
    """How many were read and how many refused."""
    read = refused = 0
    path = folder / "geometry.xml"
    for seed in seeds:
        chance = random.Random(seed)
        text = spoilt(chance.choice(list(TEXTS.values())), chance)
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
        try:
            scene = co.load_openmc(path, max_bodies=500)
        except co.SceneFileError as error:
            assert str(error)
            refused += 1
        else:
            assert all(body.shape.bounds is not None for body in scene.bodies)
            read += 1
    return read, refused


def test_spoilt_files_are_read_or_refused(tmp_path: Path) -> None:
    read, refused = tried(range(150), tmp_path)
    assert read > 10
    assert refused > 50


@pytest.mark.deep
def test_many_spoilt_files_are_read_or_refused(tmp_path: Path) -> None:
    tried(range(1000, 3000), tmp_path)
