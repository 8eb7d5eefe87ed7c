"""Every kind of surface, macrobody and facet against the formulas of MCNP's manual, at 10⁴ points each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from .decks import chosen, loaded, names_at
from .senses import BODIES, SIMPLE, Sense, beyond_any

POINTS = chosen(1, 10_000, 3.0)


def check(folder: Path, card: str, region: str, sense: Sense) -> None:
    """Cell 1 on the positive side of a region, cell 2 on its other side."""
    scene = loaded(folder, f"title\n1 0 {region}\n2 0 #1\n\n7 {card}\n")
    expected = np.where(sense(POINTS), "cell 1", "cell 2").tolist()
    assert 0 < expected.count("cell 1") < len(POINTS)
    assert names_at(scene, POINTS) == expected


@pytest.mark.parametrize(("card", "sense"), SIMPLE, ids=[card for card, _ in SIMPLE])
def test_surfaces(tmp_path: Path, card: str, sense: Sense) -> None:
    check(tmp_path, card, "7", sense)


@pytest.mark.parametrize(("card", "facets"), BODIES, ids=[card for card, _ in BODIES])
def test_macrobodies_and_facets(tmp_path: Path, card: str, facets: list[Sense]) -> None:
    check(tmp_path, card, "7", beyond_any(*facets))
    for number, sense in enumerate(facets, 1):
        check(tmp_path, card, f"7.{number}", sense)


def test_a_torus_is_refused_by_name_and_line(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"deck\.mcnp:4:1: surface 7: is a torus \(tz\)"):
        loaded(tmp_path, "title\n1 0 -7\n\n7 tz 0 0 0 5 1 1\n")


def test_facets_that_there_are_not(tmp_path: Path) -> None:
    for card, region in (("rcc 0 0 0 0 0 1 1", "-7.4"), ("so 1", "-7.1"), ("ell 0 0 0 0 0 2 -1", "7.1")):
        with pytest.raises(ValueError, match=r":2:1: cell 1: region: surface 7 has .*facets"):
            loaded(tmp_path, f"title\n1 0 {region}\n\n7 {card}\n")
