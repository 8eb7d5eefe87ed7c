"""Scenes of volumes that are placed again and again can be pickled, whatever solids they are."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.instances import InstanceList
from conicoid.io.gdml.solids import SOLID_READERS

from ...samples import sampled, size
from .files import placed, scene_of, text_of, volume
from .test_solids import DEFINE, SOLIDS as OLD
from .test_twisted import SOLIDS as TWISTED

SOLIDS = OLD | {f"twisted: {name}": solid for name, solid in TWISTED.items()}
PROTOCOLS = 2, pickle.HIGHEST_PROTOCOL
_ACROSS = size(2, 3)


def rows_of(folder: Path, solids: str) -> co.Scene:
    """A solid in rows and columns in a box, which is around all of them."""
    inside = "".join(
        placed("it", f'<position x="{40 * (k % _ACROSS)}" y="{40 * (k // _ACROSS)}" z="1"/>') for k in range(_ACROSS**2)
    )
    solids += '<box name="around" x="1000" y="1000" z="100"/>'
    return scene_of(
        folder, text_of(solids, volume("it", "s") + volume("world", "around", inside, "air"), DEFINE, world="world")
    )


def answers(scene: co.Scene) -> list[np.ndarray]:
    """What some rays meet between the first bodies."""
    rng = np.random.default_rng(4)
    origins, ends = rng.uniform(-20, 60, (2, 400, 3)) * (1, 1, 0.3)
    hits, points = scene.first_hit(origins, ends - origins), scene.body_at(origins)
    return [hits.t, hits.name, hits.face, hits.normal, points]


@pytest.mark.parametrize("name", sampled(SOLIDS, 16))
def test_scenes_of_each_solid(name: str, tmp_path: Path) -> None:
    scene = rows_of(tmp_path, SOLIDS[name][0])
    assert isinstance(scene.bodies, InstanceList)
    pickles, copies = [pickle.dumps(scene, protocol) for protocol in PROTOCOLS], [copy.deepcopy(scene)]
    expected = answers(scene)
    pickles += [pickle.dumps(scene, protocol) for protocol in PROTOCOLS]
    for other in (*map(pickle.loads, pickles), *copies, copy.deepcopy(scene)):
        assert isinstance(other.bodies, InstanceList)
        assert [body.name for body in other.bodies] == [body.name for body in scene.bodies]
        assert all(np.array_equal(a, b) for a, b in zip(other.bounds, scene.bounds, strict=True))
        for mine, its in zip(expected, answers(other), strict=True):
            assert np.array_equal(mine, its, equal_nan=mine.dtype.kind == "f")


def test_all_kinds_of_solids_are_among_them() -> None:
    texts = " ".join(text for text, *_ in SOLIDS.values())
    assert {kind for kind in SOLID_READERS if f"<{kind} " not in texts} == set()
