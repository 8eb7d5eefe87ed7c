"""The types that all kinds of surface share: the point to scatter at, a sampled direction, and a kind itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

from ..._jit.decorators import inline
from ...kernels.numbers.vectors import Vector
from ..sampling import Direction
from .albedo_tables import SMOOTH, AlbedoTables
from .material_table import MaterialTable

LOST, SPREAD, SHARP, STRAIGHT = -1, 0, 1, 2
"""Outcomes of sampling: absorbed; into a lobe with an extent; into a single direction (a mirror, smooth glass);
straight on, as if there were no surface."""


class LobeSurface(NamedTuple):
    """The properties of a surface point that its lobes depend on."""

    row: Any  # int64: its row in the table of materials
    r: float  # the diffuse reflectance
    g: float
    b: float
    refracts: bool  # the wall of a transparent solid
    outside: bool  # seen from outside of the body
    eta: float  # of a wall that refracts: the index on the side of o over the index beyond


class BsdfSample(NamedTuple):
    """A sampled direction, and the weight of light that comes from there: f |cos| / density."""

    how: Any  # int64: LOST, SPREAD, SHARP or STRAIGHT
    i: Direction
    r: float
    g: float
    b: float
    density: float  # per solid angle, if SPREAD


class LobeProbabilities(NamedTuple):
    """The probability of each lobe. They add up to at most 1; the rest is absorbed."""

    mirror: float
    matte: float
    through: float
    beyond: float  # scattered on the other side


Evaluate: TypeAlias = Callable[
    [MaterialTable, AlbedoTables, LobeSurface, Direction, Direction], tuple[float, float, float, float]
]
Sample: TypeAlias = Callable[[MaterialTable, AlbedoTables, LobeSurface, Direction, float, float, float], BsdfSample]
HasExtent: TypeAlias = Callable[[MaterialTable, LobeSurface], bool]
DiffuseCosine: TypeAlias = Callable[[Any, Vector, Vector, Vector], float]
Highlight: TypeAlias = Callable[[Any, Vector, Vector, Vector], float]
MirrorShare: TypeAlias = Callable[[Any, float], tuple[float, float, float]]


def no_albedos(row: Any, values: Any, means: Any) -> None:
    """Leave the tables of a row at 1: for kinds that read none."""


class SurfaceKind(NamedTuple):
    """One kind of surface: the functions that both integrators take from its module.

    All but `is_kind` and `fill_albedos` are compiled: the decorators are `@inline`, or `@helper` for a long one.
    Directions are in the frame of the point (z along the normal on the side of o) and point away from the surface.
    """

    is_kind: Callable[[Any], bool]
    """Return whether a filled row of the table of materials is of this kind. The first kind of the registry that says
    so has the row."""
    evaluate: Evaluate
    """Return (r, g, b, density): f |cos i_z| of light from i to o, and the density by which `sample` takes i.

    Called with o_z > 0 and i_z ≠ 0; lobes of a single direction count 0."""
    sample: Sample
    """Return a direction for light to o from three numbers in [0, 1).

    It is `spread_sample` of a direction of a lobe with an extent, which `evaluate` then weighs by all lobes; a SHARP or
    STRAIGHT sample with its own weight; or `lost_sample`.

    Called with o_z > 0."""
    has_extent: HasExtent
    """Return whether any lobe has an extent, so that light from a lamp may arrive through it."""
    fill_albedos: Callable[[Any, Any, Any], None] = no_albedos
    """Fill the row's tables, values (CHANNELS, STEPS) and means (MEANS,), which start at 1: see `AlbedoTables`."""
    diffuse_cosine: DiffuseCosine | None = None
    """Whitted's: return the factor of color · diffuse · I from (row, light, eye, normal), unit vectors with
    N·L > 0. None: N·L."""
    highlight: Highlight | None = None
    """Whitted's: return the factor of specular · I from (row, light, eye, normal). None: Phong's or the half-vector's,
    as the material says."""
    mirror_share: MirrorShare | None = None
    """Whitted's: return F for the mirrored ray from (row, cosine). None: the reflectivity, by Schlick if the material
    says so."""


@inline
def lost_sample() -> BsdfSample:
    """Return the sample of absorbed light."""
    return BsdfSample(LOST, (0.0, 0.0, 1.0), 0.0, 0.0, 0.0, 0.0)


@inline
def spread_sample(i: Direction) -> BsdfSample:
    """Return a direction of a lobe with an extent, not weighed yet."""
    return BsdfSample(SPREAD, i, 0.0, 0.0, 0.0, 0.0)


@inline
def mean_rgb(r: float, g: float, b: float) -> float:
    return (r + g + b) * (1.0 / 3.0)


@inline
def is_rough(row: Any) -> bool:
    """Return whether the facets of a material have an extent (roughness over SMOOTH)."""
    return bool(row.roughness > SMOOTH)
