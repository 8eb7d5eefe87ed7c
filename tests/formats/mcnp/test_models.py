"""Whole decks against an evaluator that shares no code, at 10⁴ points each; transformations by an asymmetric body."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from .decks import chosen, loaded, names_at
from .evaluator import carried
from .models import ASYMMETRIC, MODELS, TRANSFORMS

POINTS = chosen(2, 10_000, 3.0)


@pytest.mark.parametrize("name", MODELS)
def test_every_point_is_in_the_cell_that_mcnp_says(tmp_path: Path, name: str) -> None:
    model = MODELS[name]
    expected = model.names(POINTS)
    assert len(set(expected)) > 3
    assert names_at(loaded(tmp_path, model.text), POINTS) == expected


@pytest.mark.parametrize("name", TRANSFORMS)
def test_transformations_of_a_surface_a_cell_and_a_filling(tmp_path: Path, name: str) -> None:
    card, change = TRANSFORMS[name]
    body, sense = ASYMMETRIC[1]
    expected = [None if out else "cell 1" for out in sense(carried(POINTS, change))]
    assert expected.count("cell 1") > 100
    as_surface = f"title\n1 0 -1\n\n{body.replace(' ', ' 1 ', 1)}\n\n{card}\n"
    assert names_at(loaded(tmp_path, as_surface), POINTS) == expected
    as_cell = f"title\n1 0 -1 trcl=1\n\n{body}\n\n{card}\n"
    assert names_at(loaded(tmp_path, as_cell), POINTS) == expected
    as_filling = f"title\n1 0 -1 u=1\n2 0 -2 fill=1(1)\n\n{body}\n2 so 9\n\n{card}\n"
    inner = [None if each is None else "cell 1 @ cell 2" for each in expected]
    assert names_at(loaded(tmp_path, as_filling), POINTS) == inner


def test_a_row_and_a_column_give_a_rotation(tmp_path: Path) -> None:
    """Five cosines, those of a turn about (1, 2, 2)/3 by 60 degrees (Rodrigues' formula)."""
    axis = np.array([1, 2, 2]) / 3
    x, y, z = axis
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rows = np.eye(3) + np.sin(np.pi / 3) * skew + 0.5 * skew @ skew
    body, sense = ASYMMETRIC[1]
    expected = [None if out else "cell 1" for out in sense(carried(POINTS, ((0, 0, 0), rows)))]
    for row in range(3):
        for column in range(3):
            words = [repr(float(rows[i, j])) if row == i or column == j else "j" for i in range(3) for j in range(3)]
            card = f"tr1 0 0 0 {' '.join(words)}"
            scene = loaded(tmp_path, f"title\n1 0 -1 trcl=1\n\n{body}\n\n{card}\n")
            assert names_at(scene, POINTS) == expected


def test_surfaces_of_a_moved_cell_have_numbers(tmp_path: Path) -> None:
    """1000 c + s is surface s as TRCL moves it with cell c."""
    text = "title\n5 0 -1 trcl=(2 0 0)\n6 0 5001 -2\n\n1 so 1\n2 so 4\n"
    scene = loaded(tmp_path, text)
    assert names_at(scene, [(2, 0, 0), (0, 0, 0)]) == ["cell 5", "cell 6"]
