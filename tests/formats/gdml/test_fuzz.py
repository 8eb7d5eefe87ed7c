"""GDML files that chance has spoilt: a scene or an error with lines, no traceback of any other kind."""

from __future__ import annotations

import random
import re

import numpy as np
import pytest

import conicoid as co
from conicoid._util.files import SceneFileError

from ...samples import sampled
from ..fuzzing import words
from .files import placed, text_of, volume
from .test_solids import DEFINE, SOLIDS as PLAIN
from .test_twisted import SOLIDS as TWISTED

SOLIDS = {**PLAIN, **{f"twisted {name}": each for name, each in TWISTED.items()}}

WORDS = (
    "-1", "0", "1", "2", "1e300", "-1e-300", "1e999", "nan", "0.5", "x", "world", "pi", "deg", "(", ")", "^", "[1]", "m[9]", "&amp;", "",
    "/", "*", "i", "box", "ref", "cm", "9" * 30, "<box/>", '"', "file", "loop", "1e-320", "90", "-90", "1e15", "s1", "'",
)  # fmt: skip
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?")


def whole_text(chance):
    """Some solids, placed, in a loop as well."""
    solids, inside, structure = '<box name="w" x="200" y="200" z="200"/>', "", ""
    for k, name in enumerate(chance.sample(sorted(SOLIDS), 4)):
        solids += re.sub(r'(name|ref|solid)="([abs])"', rf'\g<1>="\g<2>{k}"', SOLIDS[name][0])
        slices = (
            '<divisionvol axis="kZAxis" number="3" width="0" offset="0" unit="mm"><volumeref ref="v0"/></divisionvol>'
        )
        structure += volume(f"v{k}", f"s{k}", slices if k == 3 else "")
        turn = '<rotation x="90" z="30" unit="deg"/>' if k % 2 else '<scale x="1" y="-1" z="1"/>'
        inside += placed(f"v{k}", f'<position x="{25 * k}" y="0" z="0"/>{turn}')
    inside += '<loop for="i" from="1" to="2">' + placed("v0", '<position x="0" y="25*i" z="m[i]"/>') + "</loop>"
    define = DEFINE + '<variable name="i" value="0"/><matrix name="m" coldim="1" values="1 2"/>'
    return text_of(solids, structure + volume("world", "w", inside, "air"), define)


def in_words(text, chance):
    return words.in_words(text, chance, WORDS)


def in_numbers(text, chance):
    found = list(NUMBER.finditer(text))
    for match in sorted(chance.sample(found, chance.choice([1, 1, 2, 4])), key=lambda each: -each.start()):
        text = text[: match.start()] + chance.choice(WORDS) + text[match.end() :]
    return text


def in_elements(text, chance):
    """One left out, doubled, or put elsewhere."""
    found = list(re.finditer(r"<(\w+)[^<>]*/>", text))
    one, other = chance.choice(found), chance.choice(found)
    piece = "" if chance.random() < 0.4 else other[0]
    return text[: one.start()] + piece + chance.choice(["", one[0]]) + text[one.end() :]


def in_letters(text, chance):
    at = chance.randrange(len(text))
    return text[:at] + chance.choice(["<", ">", '"', "\x00", "é", "\u2028", "&", ""]) + text[at + chance.randrange(3) :]


def check(path, chance):
    """Read a spoilt file. What is read can be asked, and says so again."""
    text = whole_text(chance)
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        text = chance.choice([in_words, in_numbers, in_numbers, in_elements, in_letters])(text, chance)
    path.write_text(text, encoding="utf-8")
    try:
        scene = co.load(path, max_bodies=2_000)
    except (SceneFileError, ValueError) as error:
        told = str(error)
        assert "a.gdml" in told
        assert len(told) < 3000
        return False
    except TypeError as error:  # its root is spoilt, and it is no GDML any more
        assert "files of other programs" in str(error)
        return False
    points = np.array([[0.0, 0.0, 0.0], [25.0, 1.0, 1.0], [199.0, 0.0, 0.0]])
    assert len(scene.body_at(points)) == 3
    return True


@pytest.mark.parametrize("part", sampled(range(4), 4))
def test_spoilt_files(tmp_path, part):
    read = [check(tmp_path / "a.gdml", random.Random(1000 * part + k)) for k in range(50)]
    assert 5 < sum(read) < 45


@pytest.mark.deep
@pytest.mark.parametrize("part", range(20))
def test_very_many_spoilt_files(tmp_path, part):
    for k in range(100):
        check(tmp_path / "a.gdml", random.Random(100_000 + 1000 * part + k))
