"""Compile every kernel ahead of time, by small scenes that reach each of them."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from .._jit.machine_code import SHIPPED
from ..apps.checks.check import check
from ..apps.measures.measure import FEWEST_RAYS, measure
from ..geometry.bulk import Spheres
from ..geometry.general_quadric import Quadric
from ..geometry.instances import InstanceBlock, InstanceList, Shift, ShiftTable
from ..geometry.polyhedron import MANY_FACES, Polyhedron
from ..geometry.primitives import Box, Cylinder, HalfSpace, Sphere
from ..geometry.shape import Intersection, Solid
from ..geometry.sheets import Polygon
from ..kernels.crossings import trace_rows_alone
from ..kernels.first_hits import HitBuffers, trace_first_alone
from ..prepare.bvh.sah_binning import ONE_THREAD
from ..prepare.tape.recordings import FEWEST
from ..queries.hit_fields import hit_alone, scan_lines
from ..queries.ray_queries import arrays_of
from ..queries.rays import Rays
from ..render.camera import EquirectangularCamera
from ..render.integrators import INTEGRATORS
from .scene import QUERIES, Scene


def warmup() -> None:
    """Compile all kernels for this process, in some two minutes.

    There is nothing to do if the package came with machine code.
    """
    if SHIPPED is not None:
        return
    for call in (
        _answers,
        _pictures,
        _coherent,
        _incoherent,
        _single_rays,
        _exact,
        _large_tree,
        _copies,
        _batches,
        _polyhedra,
        _explanations,
        _apps,
    ):
        call()


def _answers() -> None:
    """Compute every field of every result, for rays that certainly hit and for rays that only touch a ball."""
    scene = Scene([Sphere(1.0), Sphere(1.0, (0.0, 0.0, 1.0)) - Sphere(0.5)])
    along_rays = [name for name, first in QUERIES.items() if first == "origins"]
    at_points = [name for name, first in QUERIES.items() if first == "points"]
    # The second ray touches the ball, so exact arithmetic must decide it
    certain, touching = (0.0, 0.0, 5.0), (1.0, 0.0, 5.0)
    for origins in ([certain], [touching], [certain, touching]):
        hits = scene.first_hit(origins, (0.0, 0.0, -1.0))
        hits.before  # noqa: B018 (computed on access)
        for rays in (hits.rays, hits.spawn((0.0, 0.0, 1.0)), hits.spawn((1.0, 0.0, 0.0))):
            for name in along_rays:
                answer = getattr(scene, name)(rays)
                if hasattr(answer, "detached"):
                    answer.detached()
                    answer[:1].detached()
    for name in at_points:
        getattr(scene, name)([(0.0, 0.0, 0.0)])
    scene.first_hit([(0.0, 0.0, 1e9)], (0.0, 0.0, -1.0)).point  # noqa: B018 (far away)
    Scene([Sphere(1.0)]).spans([certain], (0.0, 0.0, -1.0)).line_integral([1.0], overlaps="error")
    for fractions in (None, "body"):
        scene.voxels(shape=1, fractions=fractions, samples=1)
    scene.distance([(0.0, 0.0, 0.0)], exact=True).detached()
    for answer in (scene.first_hit([certain], (0.0, 0.0, -1.0)), scene.spans([certain], (0.0, 0.0, -1.0))):
        answer.jvp(d_origins=(0.0, 0.0, 1.0))
        answer.vjp()


def _pictures() -> None:
    """Render with each integrator, and make rays of cameras and scans."""
    for integrator in INTEGRATORS:
        Scene([]).render(1, 1, samples=1, integrator=integrator)
    EquirectangularCamera((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)).rays(1, 1)
    origins, directions = np.zeros((2, 1, 3))
    scan_lines(np.zeros((1, 12)), 0, 1, 1, True, 0, 1, origins, directions, np.zeros(1, np.int8))


def _coherent() -> None:
    """Trace first hits of coherent rays in float32 and float64: enough of them for the test of coherence."""
    for kind in (np.float32, np.float64):
        origins = np.zeros((128, 64, 3), kind)
        Scene([]).first_hit(origins, np.ones_like(origins))


def _incoherent() -> None:
    """Trace first hits of many rays in no order, which begin before their origins."""
    every = np.random.default_rng(0).normal(size=(8192, 3))
    for _ in range(2):  # rays that are copied, and rays that are kept
        Scene([]).first_hit(every, every, t_min=-1.0)
        every.flags.writeable = False


def _single_rays() -> None:
    """Trace rays one by one, as exported pages do from machine code of their own."""
    scene = Scene([])._prepared
    arrays = arrays_of("warmup", scene, Rays((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), 0.0, math.inf)
    trace_first_alone(scene.geometry, arrays, 0, 1, HitBuffers.new(1))
    trace_rows_alone(scene.geometry, arrays, True, 0, 1, np.zeros(1, np.int32), np.zeros(1, np.int8))
    line, none, real = np.ones((1, 3)), np.full(1, -1, np.int32), np.ones(1)
    hits = line, line, line, real, none, none, none
    hit_alone(scene.geometry, *hits, none, none, none, real, real, real, real, real, real)


def _exact() -> None:
    """Decide rays that error bounds leave open: two equal irrational roots, and a point on an oblique wall."""
    two = Scene([Sphere(1.0), Sphere(1.0, (1.0, 0.0, 0.0))])
    edge = (0.5, 0.0, 5.0), (0.0, 0.0, -1.0)
    for query in (two.first_hit, two.spans, two.crossings):
        query(*edge).detached()
    Scene([Quadric(coefficients=dict(xx=1, xy=1, yy=1, zz=1, constant=-3))]).contains((1.0, 1.0, 0.0))


class CutCylinders(InstanceList):
    """Two blocks of copies of a cylinder without a ball."""

    def __init__(self) -> None:
        places, (x, y) = tuple(map(Fraction, range(64))), np.indices((64, 2), np.int32).reshape(2, -1, order="F")
        shifts = ShiftTable((places, places[:2], places[:1]), np.stack([x, y, 0 * x]))
        super().__init__(0 * x, shifts, [None])

    def shape_at(self, kind: int, shift: Shift) -> Solid:
        """Return the copy at a place."""
        x, y, z = map(float, shift)
        return (Cylinder((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5) - Sphere(0.2)).translate((x, y, z))

    def name(self, number: int) -> str:
        """Return the number as a name."""
        return str(number)

    def number(self, name: str) -> int:
        """Return the number of a name."""
        return int(name)

    def is_rigid(self, kind: int) -> bool:
        """Return True: no copy is thin."""
        return True

    def blocks(self) -> list[InstanceBlock]:
        """Return both blocks."""
        return [InstanceBlock(0, 64, 0), InstanceBlock(64, 64, 0)]


def _copies() -> None:
    """Lower translated copies, and edit one."""
    scene = Scene(CutCylinders())
    scene.prepare()
    scene.moved(5, (0.0, 0.0, 0.5)).prepare()


def _batches() -> None:
    """Lower bodies together: in lanes, with numbers halfway between floats, surfaces that may be one, no bounds."""
    for offset in (0.0, 2.0**-120):
        # As few as are lowered together, moved halfway between two floats, exactly and by a little more
        balls = [Sphere(1.0, (1.0, float(k), 0.0)) for k in range(FEWEST)]
        Scene([ball.translate((2.0**-53, 0.0, 0.0)).translate((offset, 0.0, 0.0)) for ball in balls]).prepare()
    Scene([Box().rotate((1, 2, 3), 30) & Sphere(1.0)]).prepare()  # parts that cut one another
    # Parts without bounds of their own
    endless = [*(HalfSpace((1, 2, k), 1.0) for k in range(3)), Quadric(coefficients={"xx": 1})]
    Scene([Intersection(tuple(endless))]).prepare()
    Scene([Cylinder((0, 0, 0), (1, 2, 3), 0.1 + tiny) for tiny in (0.0, 2.0**-56)]).prepare()  # nearly one surface
    slanted = [HalfSpace((1.0, 2.0, 3.0), float(k)) for k in range(2)]
    Scene(
        [*slanted, Sphere(1.0), Quadric(coefficients=dict(xx=2, yy=1, zz=1, constant=-1)), Spheres([(1, 2, 3)], 1)]
    ).prepare()


def _polyhedra() -> None:
    """Lower polyhedra of many faces, one of them turned."""
    angles = [2.0 * math.pi * k / MANY_FACES for k in range(MANY_FACES)]
    normals = tuple((math.cos(angle), math.sin(angle), 0.3 * (-1) ** k) for k, angle in enumerate(angles))
    solid = Polyhedron(normals, (1.0,) * MANY_FACES)
    Scene([solid, solid.rotate((1, 2, 3), 30)]).prepare()


def _explanations() -> None:
    """Explain rays through solids and clipped sheets."""
    corners = ((-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (0.0, 1.0, 0.0))
    Scene([Sphere(1.0) - Box(), Polygon(corners) & Sphere(1.0)]).explain((0.1, 0.2, 5.0), (0.0, 0.0, -1.0))


def _apps() -> None:
    """Measure a body by rays, and check a scene."""
    measure(Sphere(1.0) - Box(), FEWEST_RAYS)
    check(Scene([Sphere(1.0), Sphere(1.0, (1.0, 0.0, 0.0))]), 60)


def _large_tree() -> None:
    """Build the tree of a scene that all threads build together."""
    # One more than a single thread builds
    centers = np.random.default_rng(0).random((ONE_THREAD + 1, 3))
    Scene([Spheres(centers, 0.001)]).first_hit((0.0, 0.0, 5.0), (0.0, 0.0, -1.0))
