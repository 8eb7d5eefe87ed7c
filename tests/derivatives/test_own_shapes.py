"""A shape of a user's own has derivatives without code for them; where its formulas look at digits it says so."""

from dataclasses import dataclass
from fractions import Fraction

import pytest

import conicoid as co
from conicoid.geometry.cell import Cell, Face, cartesian_uv, cylindrical_uv
from conicoid.geometry.shape import REGISTERED, PrimitiveSolid
from conicoid.geometry.surface import PlaneSurface, QuadricSurface
from conicoid.numerics import bigfloat as ex


def tower(square):
    """A hyperboloid x² + y² <= r² + m² z² between two planes, with a way to square its numbers."""

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
