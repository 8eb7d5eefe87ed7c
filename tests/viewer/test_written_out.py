"""The tables of pages, where every body has rows of its own: each body's tree holds the leaves of that body."""

from __future__ import annotations

from pathlib import Path

import pytest

import conicoid as co
from conicoid.kernels.tables import Tables
from conicoid.viewer.scene_data import expand_tables

_BOXES = 16
"""Boxes in a module: what is around them has more leaves than bodies without trees."""


def modules(folder: Path) -> co.Scene:
    """Thirty-six boxes with sixteen boxes in each, as GDML."""
    solids = "".join(f'<box name="b{k}" x="{2 + 0.1 * k}" y="2" z="2" lunit="mm"/>' for k in range(_BOXES))
    volumes = "".join(
        f'<volume name="v{k}"><materialref ref="m"/><solidref ref="b{k}"/></volume>' for k in range(_BOXES)
    )
    placed = "".join(
        f'<physvol><volumeref ref="v{k}"/><position x="{-30 + 20 * (k % 4)}" y="{-30 + 20 * (k // 4)}" z="0"/></physvol>'
        for k in range(_BOXES)
    )
    around = "".join(
        f'<physvol><volumeref ref="module"/><position x="{110 * (k % 6)}" y="{110 * (k // 6)}" z="0"/></physvol>'
        for k in range(36)
    )
    path = folder / "modules.gdml"
    path.write_text(
        f"""<gdml><define/><materials><material name="m" Z="1"><D value="1"/><atom value="1"/></material></materials>
        <solids><box name="w" x="2000" y="2000" z="500" lunit="mm"/><box name="s" x="100" y="100" z="100" lunit="mm"/>
        {solids}</solids><structure>{volumes}
        <volume name="module"><materialref ref="m"/><solidref ref="s"/>{placed}</volume>
        <volume name="world"><materialref ref="m"/><solidref ref="w"/>{around}</volume></structure>
        <setup name="d" version="1"><world ref="world"/></setup></gdml>""",
        encoding="utf-8",
    )
    scene = co.load(path)
    assert isinstance(scene, co.Scene)
    return scene


def leaves_below(tables: Tables, roots: list[int]) -> list[int]:
    """What the leaves of a tree hold, in order of their numbers."""
    found, codes = [], list(roots)
    while codes:
        code = codes.pop()
        if code < 0:
            first, count = (-code - 1) >> 4, (-code - 1) & 15
            found += tables.tree_order[first : first + count].tolist()
        else:
            codes += [child for child in tables.node_children[code].tolist() if child != 0]
    return sorted(found)


@pytest.mark.parametrize("edit", ["none", "before", "instead", "behind"])
def test_trees_hold_the_leaves_of_their_bodies(edit: str, tmp_path: Path) -> None:
    scene, box = modules(tmp_path), co.Box((-1, -1, 100), (1, 1, 101))
    if edit == "before":
        scene = scene.added(box, before=0)
    elif edit == "instead":
        scene = scene.replace(0, box)
    elif edit == "behind":
        scene = scene.added(box)
    tables = scene._prepared.lowered.tables
    assert len(tables.program_shifts) > 0  # else leaves are numbered by themselves as it is
    out = tables._replace(**expand_tables(tables))
    sizes = []
    for program in range(len(out.program_leaf) - 1):
        roots = out.roots[out.tree_root[program] : out.tree_root[program + 1]].tolist()
        first, end = out.program_leaf[program : program + 2].tolist()
        assert leaves_below(out, roots) == list(range(first, end))
        sizes.append(end - first)
    assert max(sizes) > _BOXES
    assert min(sizes) > 0
