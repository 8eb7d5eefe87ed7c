"""Strange arguments for every parameter: an error by name or an answer, and no warning, for every `np.errstate`."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.registry import REGISTRY

from ..samples import deep, quick
from .examples import examples_of
from .strange import faults, good_arguments

KINDS = sorted(name for name, kind in REGISTRY.items() if kind.__name__ in co.__all__)
OTHER_FIELDS = dict(
    start_angle="angle",
    end_angle="angle",
    start="start|reference",
    end="end|reference",
    coefficients="coefficients|A|E|H",
)
"""Fields whose errors may name another one, which then does not fit."""
COMBINED = {"Union", "Intersection", "Difference", "Complement", "Painted"}


@pytest.fixture(params=["raise", deep("warn")], autouse=True)
def settings(request: Any) -> Any:
    """Let NumPy raise or warn, as a user may; pytest turns its warnings into errors."""
    with np.errstate(all=request.param):
        yield


def report(found: Any) -> None:
    lines = list(found)
    assert not lines, f"{len(lines)} faults:\n" + "\n".join(lines[:40])


@pytest.mark.parametrize("name", [name for name in KINDS if name not in COMBINED])
def test_shapes(name: str) -> None:
    kind = REGISTRY[name]
    for instance in examples_of(name)[: 1 if quick() else 99]:
        report(faults(kind, good_arguments(kind, instance), **OTHER_FIELDS))


def test_motions() -> None:
    ball = co.Sphere()
    rows = np.eye(4).tolist()
    report(faults(ball.translate, {"offset": (1.0, 2.0, 3.0)}))
    report(faults(ball.rotate, {"axis": (1.0, 2.0, 3.0), "degrees": 30.0}))
    report(faults(ball.scale, {"factors": (1.0, 2.0, 3.0)}, names=""))
    report(faults(ball.scale, {"factors": 2.0}, names=""))
    report(faults(ball.transform, {"matrix": rows}, names=""))


LOOKS: list[tuple[Any, dict[str, Any]]] = [
    (co.Camera, dict(position=(5.0, 0.0, 0.0), look_at=(0.0, 1.0, 0.0), up=(0.0, 0.0, 1.0), field_of_view=40.0)),
    (co.OrthographicCamera, dict(position=(5.0, 0.0, 0.0), look_at=(0.0, 1.0, 0.0), up=(0.0, 0.0, 1.0), height=2.0)),
    (co.AmbientLight, dict(intensity=0.5)),
    (co.DirectionalLight, dict(direction=(1.0, 0.0, 0.0), intensity=(0.5, 0.5, 0.5))),
    (co.PointLight, dict(position=(1.0, 0.0, 0.0), intensity=0.5)),
    (co.SpotLight, dict(position=(1.0, 0.0, 0.0), direction=(1.0, 0.0, 0.0), angle=30.0, soft_edge=5.0)),
    (co.Material, dict(ambient=1.0, diffuse=1.0, specular=0.1, shininess=50.0, reflectivity=0.1, refractive_index=1.5, absorption=0.1)),
    (co.Checker, dict(scale=2.0)),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "good"), LOOKS, ids=lambda item: getattr(item, "__name__", ""))
def test_looks(kind: Any, good: dict[str, Any]) -> None:
    report(faults(kind, good))


def test_optics() -> None:
    good = dict(directions=(1.0, 0.5, -1.0), normals=(0.0, 0.0, 1.0))
    # A NaN of a miss gives NaN
    misses = ("nan", "decimal nan")
    report(line for line in faults(co.reflect, good) if not any(miss in line for miss in misses))
    report(line for line in faults(co.refract, {**good, "eta": 0.7}) if not any(miss in line for miss in misses))


SCENE = co.Scene([co.Sphere(), co.Box((2, 2, 2), (3, 3, 3)) - co.Sphere(0.5, (2, 2, 2))])
RAY: dict[str, Any] = dict(origins=(0.5, 0.0, 5.0), directions=(0.0, 0.1, -1.0))


def answers(found: Any) -> tuple[Any, ...]:
    names = ("t", "t_error", "t_enter", "t_exit", "t_enter_error", "t_exit_error")
    return tuple(getattr(found, name) for name in names if hasattr(found, name))


@pytest.mark.parametrize("query", ["first_hit", "occluded", "spans", "crossings"])
def test_queries(query: str) -> None:
    def ask(**arguments: Any) -> Any:
        found = getattr(SCENE, query)(**arguments)
        return found if query == "occluded" else answers(found)

    fields = dict(origins="origin", directions="direction")
    report(faults(ask, RAY | dict(t_min=0.0, t_max=9.0), names=" ", **fields))
    report(faults(co.Rays, RAY, names="Rays", **fields))


def test_points_and_values() -> None:
    report(faults(SCENE.body_at, dict(points=(0.5, 0.0, 0.1))))
    report(faults(SCENE.contains, dict(points=(0.5, 0.0, 0.1))))
    spans = SCENE.spans(**RAY)
    found = faults(spans.line_integral, dict(values=[1.0, 2.0]))
    # An integral of NaN is NaN, and numbers beyond float64 are inf
    report(line for line in found if "gives" not in line)
    hits = SCENE.first_hit(**RAY)
    report(faults(hits.spawn, dict(directions=(1.0, 0.0, 0.5)), directions="direction"))


def test_pictures_and_counts() -> None:
    report(faults(co.Image, dict(array=[[1.0, 2.0], [3.0, 4.0]])))
    report(faults(co.Image, dict(array=[[1.0, 2.0]], vmin=0.0, vmax=1.0, colormap="grey")))
    report(faults(co.measure, dict(shape=co.Sphere(), rays=60, seed=0), names="measure"))
    report(faults(co.check, dict(scene=SCENE, rays=60, seed=0), names="check"))
    report(faults(co.Body, dict(shape=co.Sphere(), name="ball")))
    for value in ("x", None, 1.5, np.nan, 10**400, -1, 0, 1j, np.array([2])):
        if value is not None and value != 10**400:
            with pytest.raises((ValueError, TypeError), match="set_threads"):
                co.set_threads(value)
        with pytest.raises((ValueError, TypeError), match=r"width"):
            SCENE.render(value, 8, samples=1)


@pytest.mark.parametrize("origin", [(-5, 3e-1, 7e-1), (-5, 1e-30, 2e-20), (-5, 1e-90, 1e-90), (5, 1e-100, 0)])
def test_numbers_of_the_library_are_of_the_domain(origin: Any) -> None:
    """Normals, and directions that they mirror or refract, start rays."""
    flat = co.Scene([co.Ellipsoid((1, 1e60, 1e80)), co.Sphere(1, (9, 0, 0))])
    hits = flat.first_hit(origin, (1, 0, 0))
    normal = hits.normal
    assert ((normal == 0) | (abs(normal) >= 1e-100)).all()
    assert np.linalg.norm(normal) == pytest.approx(1, rel=1e-15)
    hits.spawn(normal)
    hits.spawn(co.reflect((1, 1e-90, 0), normal))
    hits.spawn(co.refract((1, 1e-90, 0), normal, 0.7)[0])


def test_errors_of_t_at_the_end_of_the_domain() -> None:
    """Roots of x² + y² <= z² from (1, 1/2, 1) along (-1, -3/10, -1/5) are exact in rational arithmetic at any scale."""
    o, d = (1.0, 0.5, 1.0), (-1.0, -0.3, -0.2)
    hits = co.Scene([co.DoubleCone().scale(1e-100)]).first_hit(o, d)
    exact_o, exact_d, t = [*map(Fraction, o)], [*map(Fraction, d)], Fraction(float(hits.t))

    def value(s: Fraction) -> Fraction:
        x, y, z = (a + s * b for a, b in zip(exact_o, exact_d, strict=True))
        return x * x + y * y - z * z

    error = float(hits.t_error)
    assert 0 < error < 1e-15
    assert value(t - Fraction(error)) * value(t + Fraction(error)) <= 0


@pytest.mark.parametrize("size", [1e-100, 1e-60, 1e60, 1e99])
def test_a_camera_fits_or_is_refused_by_name(size: float) -> None:
    assert np.isfinite(co.Scene([co.Sphere(size)]).render(8, 8, samples=1).pixels).all()


def test_no_camera_beyond_the_domain() -> None:
    with pytest.raises(ValueError, match="Scene: bounds must leave room for a camera"):
        co.Scene([co.Sphere(1e100)]).render(8, 8, samples=1)


@pytest.mark.parametrize("size", [1e-100, 1e-70, 1e70, 1e100])
def test_measures_keep_their_scale(size: float) -> None:
    """Volume 4/3 π r³ and 2/3 π r³, centroid 0 and 3/8 r, area 4 π r² and 3 π r²."""
    ball, half = co.Sphere(size), co.Sphere(size) & co.HalfSpace((-1, 0, 0), 0)
    found = co.measure(ball, rays=60)
    assert found.volume / size / size / size == pytest.approx(4 / 3 * np.pi, rel=1e-12)
    assert found.area / size / size == pytest.approx(4 * np.pi, rel=1e-12)
    assert found.centroid.tolist() == [0, 0, 0]
    assert not np.isnan(found.inertia).any()
    sampled = co.measure(half, rays=3000)
    assert sampled.volume / size / size / size == pytest.approx(2 / 3 * np.pi, rel=0.05)
    assert sampled.area / size / size == pytest.approx(3 * np.pi, rel=0.2)
    assert sampled.centroid[0] / size == pytest.approx(3 / 8, rel=0.05)
    assert np.isfinite(sampled.centroid_error).all()
