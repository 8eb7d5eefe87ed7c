"""What must hold on every ray whatever the angle: turns by which no number stays in the field that the oracle knows."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co

from .aims import lattice_rays
from .columns import Array
from .items import Item, complement, difference, intersection, union
from .judge import LOOSE, falls, rows_of
from .kinds import SCENES, Random, axis, generator, part, pick

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


def limits(r: Random, listed) -> tuple[Array, Array]:
    """Ends at told crossings or a float or two beside."""
    count = np.diff(listed.offsets)
    found = []
    for _ in range(2):
        value = r.choice([-np.inf, np.inf, 0.0, 1.0, -2.0], len(count))
        some = np.flatnonzero((count > 0) & (r.random(len(count)) < 0.7))
        t = listed.t[listed.offsets[:-1][some] + r.integers(0, 1 << 20, len(some)) % count[some]]
        for _ in range(2):
            t = np.where(r.random(len(t)) < 0.4, np.nextafter(t, r.choice([-np.inf, np.inf], len(t))), t)
        value[some] = t
        found.append(value)
    return np.minimum(*found), np.maximum(*found)


def broken(scene, origins: Array, d: Array, low, high) -> dict[str, list[int]]:
    """Law -> rays that break it."""
    first, hidden = scene.first_hit(origins, d, low, high), scene.occluded(origins, d, low, high)
    listed, spans = scene.crossings(origins, d, low, high), scene.spans(origins, d, low, high)
    ray, hit, some = rows_of(listed.offsets), np.isfinite(first.t), np.diff(listed.offsets) > 0
    rows = listed.offsets[:-1][some]
    wrong = {
        "occluded is a first hit": np.flatnonzero(hidden != hit),
        "crossings begin with the first hit": np.flatnonzero(some != hit),
        "t rises": falls(listed.t, ray),
        "spans are sorted": falls(spans.t_enter, rows_of(spans.offsets)),
        "bounds are small": ray[listed.t_error > LOOSE * (np.abs(listed.t) + 32)],
        "point_error is finite": np.flatnonzero(hit & ~np.isfinite(first.point_error)),
    }
    if (some == hit).all():
        for name in ("t", "t_error", "body", "face", "surface", "entering"):
            wrong[f"{name} of the first hit"] = np.flatnonzero(some)[
                getattr(listed, name)[rows] != getattr(first, name)[some]
            ]
    order = np.lexsort((np.arange(len(ray)), listed.body, ray))
    follows = (np.diff(ray[order]) == 0) & (np.diff(listed.body[order]) == 0)
    solid = np.isin(listed.body, np.unique(spans.body))
    same = follows & (listed.entering[order][1:] == listed.entering[order][:-1]) & solid[order][1:]
    wrong["solids are entered and left in turn"] = ray[order][1:][same]
    for name, starts in (("enter", True), ("exit", False)):
        ends = ~getattr(spans, f"{name}_clipped")
        counts = [
            np.bincount(x, minlength=len(d))
            for x in (rows_of(spans.offsets)[ends], ray[solid & (listed.entering == starts)])
        ]
        wrong[f"spans {name} at crossings"] = np.flatnonzero(counts[0] != counts[1])
    return {law: np.unique(rays).tolist() for law, rays in wrong.items() if len(rays)}


def check(kind: str, number: int, count: int) -> int:
    r = generator(f"laws {kind}", number)
    items = turned(r, SCENES[kind](r))
    scene = co.Scene([item.shape(co) for item in items])
    origins, d = lattice_rays(r, items_before(items), count)
    listed = scene.crossings(origins, d, t_min=-np.inf)
    every = np.full(len(d), np.inf)
    for low, high in ((-every, every), (np.zeros(len(d)), every), limits(r, listed)):
        found = broken(scene, origins, d, low, high)
        assert not found, (
            items,
            {law: [(origins[i], d[i], low[i], high[i]) for i in rays[:2]] for law, rays in found.items()},
        )
    flat, order = scene.first_hit(origins, d), r.permutation(len(d))
    other = scene.first_hit(origins[order], d[order])
    for name in ("t", "t_error", "body", "face", "entering", "doubtful", "point", "normal"):
        assert np.array_equal(getattr(flat, name)[order], getattr(other, name), equal_nan=True), (items, name)
    return len(listed.t)


def items_before(items: list[Item]) -> list[Item]:
    """Without their motions, for the oracle's field knows none of these angles: places of the lattice are aimed at."""
    return [Item(item.kind, item.parameters, (), tuple(items_before(list(item.operands)))) for item in items]


@pytest.mark.parametrize(
    "numbers", [range(3), pytest.param(range(100, 160), marks=pytest.mark.deep)], ids=["sample", "deep"]
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
        origins, d = lattice_rays(r, items_before([a, b]), 60 if len(numbers) < 10 else 300)

        def ends(item, origins=origins, d=d):
            listed = co.Scene([item.shape(co)]).crossings(origins, d, t_min=-np.inf)
            return listed, list(
                zip(rows_of(listed.offsets).tolist(), listed.t.tolist(), listed.entering.tolist(), strict=True)
            )

        assert not len(ends(difference(a, a))[0].t), a
        listed, expected = ends(a)
        for same in (union(a, a), intersection(a, a), complement(complement(a))):
            assert ends(same)[1] == expected, (a, same)
        around, turned_out = ends(complement(a))
        assert [i for i, _, _ in turned_out] == [i for i, _, _ in expected], a
        assert (np.abs(around.t - listed.t) <= around.t_error + listed.t_error).all(), a
        assert (around.entering != listed.entering).all(), a
        whole, parts = (
            co.Scene([item.shape(co)]).spans(origins, d, t_min=-np.inf)
            for item in (a, union(intersection(a, b), difference(a, b)))
        )
        assert np.array_equal(whole.offsets, parts.offsets), (a, b)
        compared += len(expected)
    assert compared
