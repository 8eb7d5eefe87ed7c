"""Derivatives of hits by every number of every shape, of one face as an open surface, and of a user's own shapes."""

import zlib
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.cell import Cell, Face, cartesian_uv, cylindrical_uv
from conicoid.geometry.shape import REGISTERED, PrimitiveSolid
from conicoid.geometry.surface import PlaneSurface, QuadricSurface
from conicoid.numerics import bigfloat as ex

from ..contract.examples import MOTIONS, every_example
from ..samples import deeper, marked, sampled

# --- Derivatives of hits by every number of every shape, against differences of first hits of changed shapes


EXAMPLES = dict(every_example())
FIELDS = ("t", "point", "normal", "uv")
STEP = 2.0**-16
SMOOTH, KINK, SHARE, CLOSE = 1e-4, 1e-4, 0.05, 1e-8
"""Differences of both orders, and of both sides, agree so closely; derivatives agree with those of fourth order, by a
share.
"""
OPEN = {"Conic-4": ("",), "Lens-4": ("",), "SphereSection-6": ("",), "Revolution": ("[1]",), "Polycone": ("",),
        "Cylinder-4": ("angle",), "Cone-6": ("angle",), "Tube-4": ("angle",), "SphereSection-5": ("angle",),
        "SphereSection": ("range[0]", "range[1]")}  # fmt: skip
"""Ends of the names of numbers without a derivative: of walls that coincide for these numbers alone, of heights at
which a level wall becomes a cone, of a rim at an equator, of walls that are planes at half a turn or a right angle.
"""
TILTS = ("start", "end", "normal", "offsets", "coefficients", "outline", "scale_at_top", "z_range", "vertices")
"""Parts of the names of numbers by which `uv` may have no derivative, because they tilt an axis or bend a plane."""


def rays_at(shape: Any, count: int, seed: int) -> tuple[Any, Any]:
    """Return rays through the part of a shape near its middle, or near the middle of a complement's hole."""
    random = np.random.default_rng(seed)
    low, high = (np.clip(end, -4, 4) for end in shape.bounds)
    if isinstance(shape, co.Solid) and np.isinf(shape.bounds).all() and np.isfinite((~shape).bounds).all():
        low, high = (~shape).bounds
    inside = random.uniform(low - 0.1, high + 0.1, (count, 3))
    directions = random.normal(size=(count, 3)) * random.uniform(0.5, 2, (count, 1))
    return inside - directions * random.uniform(2, 6, (count, 1)), directions


def wrong(name: str, motion: str, numbers: int) -> tuple[list[str], int]:
    """Return (faults of derivatives by some numbers and by the rays, how many were compared)."""
    shape, seed = MOTIONS[motion](EXAMPLES[name]), zlib.crc32(f"{name} {motion}".encode())
    scene = co.Scene([co.Body(shape, name="it")])
    parameters, random = co.parameters(scene), np.random.default_rng(seed)
    hits = scene.first_hit(*rays_at(shape, 60, seed))
    hits = hits[hits.hit]
    ways = random.normal(size=(2, *hits.point.shape))
    values, found, compared = np.array(parameters.values), [], 0
    changes = list(np.eye(len(values))[random.permutation(len(values))[:numbers]])
    if isinstance(shape, co.Polygon):  # it stays flat where all corners move alike
        changes += [np.array([name.endswith(f"[{k}]") for name in parameters.names], float) for k in range(3)]
    changes.append(np.zeros(len(values)))  # the rays alone
    for change in changes:
        try:
            scenes = {side: parameters.scene(values + side * STEP * change) for side in (1, -1, 2, -2)}
        except ValueError:
            continue  # at the end of the domain: a full turn, a pole, a polygon that is no longer flat
        ends = {
            side: there.first_hit(
                hits.rays.origins + side * STEP * ways[0], hits.rays.directions + side * STEP * ways[1]
            )
            for side, there in scenes.items()
        }
        same = np.all([(end.face == hits.face) & (end.body == hits.body) for end in ends.values()], axis=0)
        own = hits.jvp(parameters, change, d_origins=ways[0], d_directions=ways[1])
        number = parameters.names[int(change.argmax())] if change.any() else "the rays"
        ends_open = [end for start, end in OPEN.items() if name.startswith(start)]
        is_open = any(number.endswith(end) for end in ends_open)
        for field in FIELDS:
            at = {side: getattr(end, field)[same] for side, end in ({0: hits} | ends).items()}
            one, two = ((at[k] - at[-k]) / (2 * k * STEP) for k in (1, 2))
            slope, derived = (4 * one - two) / 3, getattr(own, field)[same]
            size_of, apart = 1 + np.abs(slope), np.abs(slope - one)
            smooth = (apart < SMOOTH * size_of) & (np.abs(at[1] - 2 * at[0] + at[-1]) < KINK * STEP * size_of)
            undefined = np.isnan(derived) & (is_open or (field == "uv" and any(part in number for part in TILTS)))
            bad = smooth & ~undefined & ~(np.abs(derived - slope) <= SHARE * apart + CLOSE * size_of)
            compared += int((smooth & ~undefined).sum())
            if bad.any():
                found.append(f"{field} by {number}: {derived[bad][:2]}, by differences {slope[bad][:2]}")
    return found, compared


@pytest.mark.parametrize(
    ("name", "motion", "numbers"),
    [
        *marked(((name, sorted(MOTIONS)[len(name) % len(MOTIONS)], 2), k % 4 == 0) for k, name in enumerate(EXAMPLES)),
        *deeper((name, motion, 1000) for name in EXAMPLES for motion in MOTIONS),
    ],
)
def test_by_numbers(name, motion, numbers):
    found, compared = wrong(name, motion, numbers)
    assert not found
    assert compared or name.startswith(tuple(OPEN))


# --- One face of a solid as an open surface moves as the solid's does


SOLIDS = {name: shape for name, shape in every_example() if isinstance(shape, PrimitiveSolid) and name != "Lens-4"}
"""That lens is a whole ball. Its faces are one sphere, and tie."""


@pytest.mark.parametrize("name", sampled(SOLIDS, 7))
def test_a_wall_moves_as_its_solid_does(name):
    solid = MOTIONS["moved"](SOLIDS[name])
    random = np.random.default_rng(zlib.crc32(name.encode()))
    origins, directions = rays_at(solid, 300, 5)
    scene = co.Scene([co.Body(solid, name="it")])
    hits = scene.first_hit(origins, directions)
    numbers = co.parameters(scene)
    change = random.normal(size=len(numbers))
    known = dict(zip(numbers.names, change, strict=True))
    for face in np.unique(hits.face[hits.hit]).tolist():
        rays = np.flatnonzero(hits.hit & (hits.face == face))[:20]
        wall = co.Scene([co.Body(co.Wall(solid, face), name="it")])
        its = co.parameters(wall)
        alone = wall.first_hit(origins[rays], directions[rays])
        assert np.array_equal(alone.t, hits.t[rays])
        moved = alone.jvp(its, [known["it." + each.removeprefix("it.solid.")] for each in its.names])
        expected = hits[rays].jvp(numbers, change)
        tied = np.isnan(expected.t)  # one of several walls of the solid in one plane
        for field in ("t", "point", "normal", "uv"):
            own, its_solids = getattr(moved, field), getattr(expected, field)
            np.testing.assert_allclose(own[~tied], its_solids[~tied], rtol=1e-12, atol=1e-12)


# --- A user's own shape has derivatives without code for them; where its formulas depend on digits an error says so


def tower(square):
    """Return a class of hyperboloids x² + y² <= r² + m² z² between two planes, with a way to square its numbers."""

    @dataclass(frozen=True)
    class Tower(PrimitiveSolid):
        radius: float
        slope: float
        z_range: tuple[float, float] = (-1.0, 1.0)

        def tree(self):
            low, high = self.z_range
            wall = QuadricSurface((1.0, 1.0, -square(self.slope)), constant=square(self.radius))
            bottom = PlaneSurface((0.0, 0.0, -1.0), -low, anchor=(0.0, 0.0, low))
            top = PlaneSurface((0.0, 0.0, 1.0), high, anchor=(0.0, 0.0, high))
            ends = cartesian_uv((self.radius, 0, 0), (0, self.radius, 0))
            return Cell((Face(wall, 0, cylindrical_uv(low, high)), Face(bottom, 1, ends), Face(top, 2, ends)))

        def support(self, direction):
            return 99.0 * sum(map(abs, direction))

    REGISTERED.pop("Tower")
    return Tower


def test_by_its_own_formulas():
    # At the height z the wall is at x = -sqrt(r² + m² z²), so t changes by -r / 5 and -m z² / 5 for r = 3, m = 1, z = 4.
    scene = co.Scene([co.Body(tower(lambda x: ex.rational(x) ** 2)(3.0, 1.0, (-4.5, 5.0)), name="it")])
    parameters = co.parameters(scene)
    assert parameters.names == ("it.radius", "it.slope", "it.z_range[0]", "it.z_range[1]")
    hit = scene.first_hit((-10, 0, 4), (1, 0, 0))
    assert hit.t == 5
    assert hit.vjp(parameters, t=1).parameters == pytest.approx([-3 / 5, -16 / 5, 0, 0], rel=1e-15)
    # v is the height from low to high
    assert hit.vjp(parameters, uv=(0, 1)).parameters[3] == pytest.approx(-8.5 / 9.5**2, rel=1e-14)


def test_formulas_that_look_at_digits():
    scene = co.Scene([tower(lambda x: Fraction(x) ** 2)(3.0, 1.0, (-4.5, 5.0))])
    hit = scene.first_hit((-10, 0, 4), (1, 0, 0))
    assert hit.jvp(d_origins=(1, 0, 0)).t == -1
    with pytest.raises(TypeError, match=r"Tower: it has no derivatives, as its formulas look at the digits"):
        hit.vjp(co.parameters(scene), t=1)
