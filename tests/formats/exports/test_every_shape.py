"""Every solid of Conicoid, moved and combined: a format says it so that it answers as before, or refuses it by name."""

from __future__ import annotations

import re
from pathlib import Path

import hypothesis
import pytest
from hypothesis import strategies as st

import conicoid as co
from conicoid.io.export.exporters import EXPORT_FORMATS

from ...samples import in_turn
from ..strategies import SOLIDS, moved, primitive
from .comparison import assert_close_answers

SUFFIXES = [each.suffixes[0] for each in EXPORT_FORMATS]
FEW = hypothesis.settings(
    max_examples=5,
    deadline=None,
    derandomize=True,
    phases=[hypothesis.Phase.generate],
    suppress_health_check=list(hypothesis.HealthCheck),
)
_NUMBER = re.compile(r"-?\d+\.?\d*(?:e[-+]?\d+)?")
CUT = co.Box((-3, -3, -3), (3, 3, 3))


def said_or_refused(scene: co.Scene, path: Path) -> None:
    """What comes back answers alike but for the rounding of numbers; a refusal names the body."""
    try:
        notes = co.export(scene, path)
    except ValueError as error:
        assert "\nthing: " in str(error)
        return
    try:
        back = co.load(path)
    except ValueError:  # of numbers that are out of bounds once they are written in the format's own way
        assert not _is_moderate(scene)
        return
    is_empty = any(note.startswith("with nothing in it") for note in notes)
    if _is_moderate(scene) and not is_empty:
        assert len(back) == 1
        assert_close_answers(scene, back, 1e-7)


def _is_moderate(scene: co.Scene) -> bool:
    """Do no numbers of the shape differ by so much that rounding one in OpenSCAD or GDML moves others out of sight?"""
    numbers = [abs(float(word)) for word in _NUMBER.findall(repr(scene.bodies[0].shape))]
    low, high = scene.bounds
    return (
        max(numbers, default=1) < 1e3 and min((n for n in numbers if n), default=1) > 1e-3 and (high - low).min() > 0.01
    )


@pytest.mark.parametrize(("name", "suffix"), in_turn(SOLIDS, SUFFIXES))
@FEW
@hypothesis.given(st.data())
def test_every_kind(name: str, suffix: str, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    """As it is, cut by a box, and cut from one."""
    shape = data.draw(moved(primitive(name)))
    kind = data.draw(st.sampled_from(["alone", "within", "without"]))
    shape = {"alone": shape, "within": CUT & shape, "without": CUT - shape}[kind]
    said_or_refused(co.Scene([co.Body(shape, name="thing")]), tmp_path_factory.mktemp("x") / f"out{suffix}")
