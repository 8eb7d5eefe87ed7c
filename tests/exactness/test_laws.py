"""Laws between queries and of set algebra, for bodies turned by angles whose sines are no sums of square roots."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co

from ..reference.intervals import Answers, ends
from ..reference.items import Item, combined
from ..reference.judge import FAR, LOOSE, rows_of
from ..reference.random_shapes import Random, generator, pick
from ..reference.whole_items import SCENES, axis, part
from ..reference.whole_rays import whole_rays

ANGLES = (1.0, 7.5, 22.5, 33.3, 89.999, 120.5, -0.001, 1e-9, 179.0, 37.0)
KINDS = (
    "Boolean",
    "Fan",
    "Siblings",
    "Abutting",
    "Mixed",
    "ClippedSheet",
    "Cylinder",
    "Cone",
    "Polyhedron",
    "Triangle",
)


def turned(r: Random, items: list[Item]) -> list[Item]:
    """All of a scene by one angle, some bodies in two parts of it."""
    about, degrees = axis(r), float(pick(r, ANGLES))
    half = degrees / 2
    return [
        item.moved(("rotate", about, half), ("rotate", about, half))
        if r.random() < 0.3
        else item.moved(("rotate", about, degrees))
        for item in items
        if item.kind != "Spheres"
    ]


def broken(answers: Answers, origins: np.ndarray) -> dict[str, list[int]]:
    """Law -> rays that break it."""
    listed, first, spans = answers.listed, answers.first, answers.spans
    ray = rows_of(listed.offsets)
    wrong = answers.laws()
    # As the judge has it: far out, along an asymptote, the bound is as large as the error of t, which no float avoids
    near = np.abs(listed.t) < FAR * (np.abs(origins[ray]).max(axis=1) + 1)
    wrong["bounds are small"] = ray[near & (listed.t_error > LOOSE * (np.abs(listed.t) + 32))]
    wrong["point_error is finite"] = np.flatnonzero(np.isfinite(first.t) & ~np.isfinite(first.point_error))
    order = np.lexsort((np.arange(len(ray)), listed.body, ray))
    follows = (np.diff(ray[order]) == 0) & (np.diff(listed.body[order]) == 0)
    solid = np.isin(listed.body, np.unique(spans.body))
    same = follows & (listed.entering[order][1:] == listed.entering[order][:-1]) & solid[order][1:]
    wrong["solids are entered and left in turn"] = ray[order][1:][same]
    for name, starts in (("enter", True), ("exit", False)):
        inner = rows_of(spans.offsets)[~getattr(spans, f"{name}_clipped")]
        counts = [np.bincount(x, minlength=len(first.t)) for x in (inner, ray[solid & (listed.entering == starts)])]
        wrong[f"spans {name} at crossings"] = np.flatnonzero(counts[0] != counts[1])
    return {law: np.unique(rays).tolist() for law, rays in wrong.items() if len(rays)}


def check(kind: str, number: int, count: int) -> int:
    r = generator(f"laws {kind}", number)
    items = turned(r, SCENES[kind](r))
    scene = co.Scene([item.shape(co) for item in items])
    origins, d = whole_rays(r, items_before(items), count)
    listed = scene.crossings(origins, d, t_min=-np.inf)
    every = np.full(len(d), np.inf)
    for low, high in ((-every, every), (np.zeros(len(d)), every), ends(r, listed.offsets, listed.t)):
        found = broken(Answers(scene, (origins, d), low, high), origins)
        places = {law: [(origins[i], d[i], low[i], high[i]) for i in rays[:2]] for law, rays in found.items()}
        assert not found, (items, places)
    flat, order = scene.first_hit(origins, d), r.permutation(len(d))
    other = scene.first_hit(origins[order], d[order])
    for name in ("t", "t_error", "body", "face", "entering", "doubtful", "point", "normal"):
        assert np.array_equal(getattr(flat, name)[order], getattr(other, name), equal_nan=True), (items, name)
    return len(listed.t)


def items_before(items: list[Item]) -> list[Item]:
    """Without their motions, so that rays run through places of the lattice."""
    return [Item(item.kind, item.parameters, (), tuple(items_before(list(item.operands)))) for item in items]


@pytest.mark.parametrize(
    "numbers", [range(2), pytest.param(range(100, 160), marks=pytest.mark.deep)], ids=["sample", "deep"]
)
@pytest.mark.parametrize("kind", KINDS)
def test_laws_under_any_turn(kind, numbers):
    assert sum(check(kind, number, 90 if len(numbers) < 10 else 400) for number in numbers)


@pytest.mark.parametrize(
    "numbers", [range(3), pytest.param(range(100, 200), marks=pytest.mark.deep)], ids=["sample", "deep"]
)
def test_set_algebra_under_any_turn(numbers):
    """A - A is empty, A | A, A & A and ~~A are A, ~A has its walls; A & B and A - B part A."""
    compared = 0
    for number in numbers:
        r = generator("algebra", number)
        a, b = part(r), part(r)
        about, degrees = axis(r), float(pick(r, ANGLES))
        a, b = (item.moved(("rotate", about, degrees)) for item in (a, b))
        origins, d = whole_rays(r, items_before([a, b]), 60 if len(numbers) < 10 else 300)

        def ends(item, origins=origins, d=d):
            listed = co.Scene([item.shape(co)]).crossings(origins, d, t_min=-np.inf)
            return listed, list(
                zip(rows_of(listed.offsets).tolist(), listed.t.tolist(), listed.entering.tolist(), strict=True)
            )

        assert not len(ends(combined("Difference", a, a))[0].t), a
        listed, expected = ends(a)
        for same in (
            combined("Union", a, a),
            combined("Intersection", a, a),
            combined("Complement", combined("Complement", a)),
        ):
            assert ends(same)[1] == expected, (a, same)
        around, turned_out = ends(combined("Complement", a))
        assert [i for i, _, _ in turned_out] == [i for i, _, _ in expected], a
        assert (np.abs(around.t - listed.t) <= around.t_error + listed.t_error).all(), a
        assert (around.entering != listed.entering).all(), a
        whole, parts = (
            co.Scene([item.shape(co)]).spans(origins, d, t_min=-np.inf)
            for item in (a, combined("Union", combined("Intersection", a, b), combined("Difference", a, b)))
        )
        assert np.array_equal(whole.offsets, parts.offsets), (a, b)
        compared += len(expected)
    assert compared
