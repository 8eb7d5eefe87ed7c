"""Numbers that others print in the tests of their solids, with the solid as GDML and, if there is one, as a shape.

Source: the unit tests of VecGeom (test/unit_tests/Test*.cpp, many of them from Geant4's testG4*.cc), which give half
lengths and radians. Distances are those of DistanceToIn and DistanceToOut. Numbers that the source computes (constants,
square roots) are computed here.

Left out: rays that lie in a wall; edges, where a normal is a choice; and the capacity and area that TestPolyhedra
prints, which are not the solid's: n tan(δ / 2) ∫ (R² - r²) dz stands for the first.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import conicoid as co

Vector = tuple[float, float, float]
NEVER = math.inf
ROOT, DEG, PI = math.sqrt(2), math.pi / 180, math.pi
O = (0, 0, 0)  # noqa: E741
X, Y, Z, MX, MY, MZ = (1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)
XY, MXY, XMY, MXMY = (1, 1, 0), (-1, 1, 0), (1, -1, 0), (-1, -1, 0)
FAR = (100, 0, 0), (0, 100, 0), (0, 0, 100), (-100, 0, 0), (0, -100, 0), (0, 0, -100)


@dataclass
class Published:
    """A solid and its printed numbers; points in mm, angles in GDML in degrees."""

    source: str
    gdml: str
    shape: Callable[[], Any] | None = None
    inside: list[Vector] = field(default_factory=list)
    outside: list[Vector] = field(default_factory=list)
    into: list[tuple[Vector, Vector, float]] = field(default_factory=list)  # from, direction, distance to the solid
    out: list[tuple[Vector, Vector, float]] = field(default_factory=list)  # from, direction, distance out of it
    normals: list[tuple[Vector, Vector]] = field(default_factory=list)  # at a place on the surface
    volume: float | None = None
    area: float | None = None
    extent: tuple[Vector, Vector] | None = None
    digits: float = 1e-8  # as a share of the number, or of 1
    define: str = ""


def from_far(x: float, y: float, z: float) -> list[tuple[Vector, Vector, float]]:
    """Return rays along the axes from 100 mm, and past the solid."""
    straight = list(zip(FAR, (MX, MY, MZ, X, Y, Z), (x, y, z, x, y, z), strict=True))
    return [*straight, ((100, 0, 0), XY, NEVER), ((-100, 0, 0), MXY, NEVER)]


def from_middle(x: float, y: float, z: float) -> list[tuple[Vector, Vector, float]]:
    return list(zip((O,) * 6, (X, Y, Z, MX, MY, MZ), (x, y, z, x, y, z), strict=True))


def sphere(inner: float, outer: float, phi: tuple[float, float], theta: tuple[float, float]) -> dict[str, Any]:
    """Return GDML's sphere and the shape; ranges as (start, delta) in degrees."""
    (a, b), (c, d) = phi, theta
    return {
        "gdml": f'<sphere name="s" rmin="{inner}" rmax="{outer}" startphi="{a}" deltaphi="{b}" starttheta="{c}" '
        f'deltatheta="{d}" aunit="deg"/>',
        "shape": lambda: co.SphereSection(outer, inner, (c, min(c + d, 180)), a, a + b),
    }


def tube(inner: float, outer: float, half: float, start: float = 0, delta: float = 360) -> dict[str, Any]:
    return {
        "gdml": f'<tube name="s" rmin="{inner}" rmax="{outer}" z="{2 * half}" startphi="{start}" deltaphi="{delta}" '
        'aunit="deg"/>',
        "shape": lambda: co.Tube((0, 0, -half), (0, 0, half), inner, outer, start, start + delta, (1, 0, -half)),
    }


def cone(a: float, b: float, c: float, d: float, half: float, start: float = 0, delta: float = 360) -> dict[str, Any]:
    return {
        "gdml": f'<cone name="s" rmin1="{a}" rmax1="{b}" rmin2="{c}" rmax2="{d}" z="{2 * half}" startphi="{start}" '
        f'deltaphi="{delta}" aunit="deg"/>',
        "shape": lambda: co.Polycone([(-half, a, b), (half, c, d)], start, start + delta),
    }


def trd(x1: float, x2: float, y1: float, y2: float, half: float) -> dict[str, Any]:
    """Return a trd from half lengths."""
    return {
        "gdml": f'<trd name="s" x1="{2 * x1}" x2="{2 * x2}" y1="{2 * y1}" y2="{2 * y2}" z="{2 * half}"/>',
        "shape": lambda: co.Trapezoid((2 * x1, 2 * y1), (2 * x2, 2 * y2), (-half, half)),
    }


def trap(dz: float, dy: float, dx: float, alpha: float) -> dict[str, Any]:
    """Return a trap with equal sections, sheared by alpha."""
    shear = dy * math.tan(alpha * DEG)
    return {
        "gdml": f'<trap name="s" z="{2 * dz}" theta="0" phi="0" y1="{2 * dy}" x1="{2 * dx}" x2="{2 * dx}" '
        f'alpha1="{alpha}" y2="{2 * dy}" x3="{2 * dx}" x4="{2 * dx}" alpha2="{alpha}" aunit="deg"/>',
        "shape": lambda: co.Parallelepiped(
            (-dx - shear, -dy, -dz), (2 * dx, 0, 0), (2 * shear, 2 * dy, 0), (0, 0, 2 * dz)
        ),
    }


def planes(rows: list[tuple[float, float, float]]) -> str:
    return "".join(f'<zplane z="{z}" rmin="{a}" rmax="{b}"/>' for z, a, b in rows)


COS, SIN = 4 / math.sqrt(17), 1 / math.sqrt(17)
SIMPLE = [(-10.0, 0.0, 70.0), (0.0, 0.0, 70.0), (10.0, 0.0, 80.0)]
GON = [(-30, 30, 70), (-20, 30, 70), (-10, 0, 70), (0, 0, 40), (10, 0, 40), (20, 0, 80), (30, 40, 80), (40, 40, 60)]
ON_BOX = [((20, 0, 0), X), ((-20, 0, 0), MX), ((0, 30, 0), Y), ((0, -30, 0), MY), ((0, 0, 40), Z), ((0, 25, -40), MZ)]
ON_TRD = [
    ((20, 0, 0), (COS, 0, -SIN)), ((-20, 0, 0), (-COS, 0, -SIN)), ((0, 30, 0), (0, COS, -SIN)),
    ((0, -30, 0), (0, -COS, -SIN)), ((0, 0, 40), Z), ((0, 0, -40), MZ),
]  # fmt: skip
PARR, BACK = (0, 1, 2), (0, -1, -2)
HALF = 100 * math.sqrt(5) / 2
TET = [(0, 0, 0), (10, 0, 0), (5, 10, 0), (5, 5, 10)], [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
THIRD = 1 / math.sqrt(3)
PHI10 = [(60 * math.cos(a * DEG), 60 * math.sin(a * DEG), 0) for a in (10, -50)]


def tet(index: int) -> dict[str, str]:
    corners = TET[index]
    return {
        "gdml": '<tet name="s" vertex1="p0" vertex2="p1" vertex3="p2" vertex4="p3"/>',
        "define": "".join(
            f'<position name="p{k}" x="{x}" y="{y}" z="{z}" unit="mm"/>' for k, (x, y, z) in enumerate(corners)
        ),
    }


ARB8 = " ".join(
    f'v{k}x="{x}" v{k}y="{y}"'
    for k, (x, y) in enumerate([(-3, -3), (-3, 3), (3, 3), (3, -3), (-2, -2), (-2, 2), (2, 2), (2, -2)], 1)
)
SLANT, RISE = math.cos(math.atan2(1, 10)), math.sin(math.atan2(1, 10))
LEAN = math.tan(30 * DEG) * math.cos(45 * DEG)

FLAT = [
    Published("TestBox, b1", '<box name="s" x="40" y="60" z="80"/>', lambda: co.Box((-20, -30, -40), (20, 30, 40)),
              into=from_far(80, 70, 60), out=[*from_middle(20, 30, 40), (O, XY, math.sqrt(800)), ((20, 0, 0), MX, 40)],
              normals=ON_BOX, volume=192000, extent=((-20, -30, -40), (20, 30, 40))),
    Published("TestTrd, trd1", **trd(20, 20, 30, 30, 40), inside=[O], outside=[(0, 0, 100)], volume=8 * 20 * 30 * 40,
              area=20800, into=from_far(80, 70, 60), out=[*from_middle(20, 30, 40), (O, XY, math.sqrt(800))], normals=ON_BOX),
    Published("TestTrd, trd2", **trd(10, 30, 20, 40, 40), inside=[O], outside=[(0, 0, 100)], into=from_far(80, 70, 60),
              out=[*from_middle(20, 30, 40), (O, XY, math.sqrt(800)), ((20, 0, 0), X, 0), ((0, -30, 0), MY, 0)],
              normals=ON_TRD),
    Published("TestTrap, trap1", '<trap name="s" z="80" theta="0" phi="0" y1="60" x1="40" x2="40" alpha1="0" y2="60" '
              'x3="40" x4="40" alpha2="0" aunit="deg"/>', lambda: co.Trapezoid((40, 60), (40, 60), (-40, 40)),
              volume=8 * 20 * 30 * 40, area=2 * (40 * 60 + 80 * 60 + 80 * 40),
              into=[*from_far(80, 70, 60), ((0, 60, 0), XMY, NEVER), ((0, 40, 0), XMY, 10 * ROOT), ((0, 40, 50), XMY, NEVER),
                    ((40, 60, 0), MX, NEVER), ((40, 60, 0), MY, NEVER), ((40, 60, 50), MZ, NEVER),
                    ((0, 0, 50), (0, 1, -1), 10 * ROOT), ((0, 0, 80), (0, 1, -1), NEVER)],
              out=[*from_middle(20, 30, 40), ((-20, 0, 0), X, 40), ((0, 30, 0), MY, 60), ((0, 0, -40), Z, 80)], normals=ON_BOX),
    Published("TestTrap, trap2, by its corners", '<trap name="s" z="80" theta="0" phi="0" y1="40" x1="20" x2="20" alpha1="0" '
              'y2="80" x3="60" x4="60" alpha2="0" aunit="deg"/>', trd(10, 30, 20, 40, 40)["shape"],
              volume=80 * (60 * 40 + 20 * 20 / 3), into=from_far(80, 70, 60), normals=ON_TRD,
              area=4 * (200 + 1200) + 2 * (60 * math.sqrt(4 * 1600 + 400) + 40 * math.sqrt(4 * 1600 + 400))),
    Published("TestTrap, trap3", **trap(50, 50, 50, 45), volume=8 * 50**3, digits=1e-7,
              into=[((50, -50, 0), Y, 50), ((50, -50, 0), MY, NEVER)]),
    Published("TestTrap, trap4", **trap(50, 50, 50, -45), volume=8 * 50**3, digits=1e-7,
              into=[((50, 50, 0), Y, NEVER), ((50, 50, 0), MY, 50)]),
    Published("TestParallelepiped", '<para name="s" x="40" y="60" z="80" alpha="30" theta="30" phi="45" aunit="deg"/>',
              lambda: co.Parallelepiped((-20 - 30 * math.tan(30 * DEG) - 40 * LEAN, -30 - 40 * LEAN, -40), (40, 0, 0),
                                        (60 * math.tan(30 * DEG), 60, 0), (80 * LEAN, 80 * LEAN, 80)),
              inside=[O], outside=[(0, 0, 100)], into=from_far(80, 70, 60),
              out=[*from_middle(20, 30, 40), ((20, 0, 0), X, 0), ((0, -30, 0), MY, 0)], normals=[((0, 0, 40), Z), ((0, 0, -40), MZ)]),
    Published("TestTet, t1", **tet(0), inside=[(1, 1, 1)], outside=[(0, 5, 1.5)], normals=[((5, 5, 0), MZ)],
              out=[((1.5, 0.5, 1), MY, 0), ((0.1, 0.2, 1), X, NEVER)][:1]),
    Published("TestTet, t2", **tet(1), shape=lambda: co.Mesh(TET[1], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]),
              volume=1 / 6, area=1.5 + 0.5 * math.sqrt(3), extent=(O, (1, 1, 1)), into=[((0.1, 0.1, -20), Z, 20),
              ((0.1, 0.1, -20), X, NEVER), ((0.1, 0.1, -20), Y, NEVER)],
              normals=[((0.1, 0.1, 0), MZ), ((0.1, 0, 0.1), MY), ((0, 0.1, 0.1), MX), ((1 / 3, 1 / 3, 1 / 3), (THIRD,) * 3)]),
    Published("TestGenTrap, trap1", f'<arb8 name="s" {ARB8} dz="5"/>', lambda: co.Trapezoid((6, 6), (4, 4), (-5, 5)),
              inside=[O], outside=[(0, 0, 100)], volume=(36 + 24 + 16) * 10 / 3, area=36 + 16 + 20 * math.sqrt(101),
              out=[(O, MX, 2.5), (O, Z, 5), ((-2.5, 0, 0), X, 5), ((0, 2.5, 0), MY, 5)], into=from_far(97.5, 97.5, 95)[:6],
              normals=[((-2.5, 0, 0), (-SLANT, 0, RISE)), ((2.5, 0, 0), (SLANT, 0, RISE)), ((0, -2.5, 0), (0, -SLANT, RISE)),
                       ((0, 2.5, 0), (0, SLANT, RISE)), ((0, 0, 5), Z), ((0, 0, -5), MZ)]),
    Published("TestPolyhedra, MyPGon", '<polyhedra name="s" startphi="0" deltaphi="45" numsides="5" aunit="deg">'
              f'{planes(GON)}</polyhedra>', volume=5 * math.tan(4.5 * DEG) * 787000 / 3, inside=[(5, 1, 20), (45, 5, 30)], outside=[(0, 0, 30)],
              out=[((5, 1, 20), MY, 1), ((5, 1, 20), Z, 1.27382374146), ((45, 5, 30), Z, 10), ((45, 5, 30), X, 34.8538673445),
                   ((45, 5, 30), Y, 40)], digits=1e-10),
]  # fmt: skip

ROUND = [
    Published("TestOrb, b1", '<orb name="s" r="9"/>', lambda: co.Sphere(9), volume=4 * PI / 3 * 729, extent=((-9,) * 3, (9,) * 3),
              out=[*from_middle(9, 9, 9), ((9, 0, 0), MX, 18), ((0, 0, -9), Z, 18)], into=from_far(91, 91, 91)[:6]),
    Published("TestTube, t1", **tube(0, 50, 50), inside=[O], outside=[(0, 0, 100), (100, 0, 0)], volume=50 * 2 * PI * 2500,
              into=from_far(50, 50, 50), out=[*from_middle(50, 50, 50), (O, XY, 50)], extent=((-50,) * 3, (50,) * 3)),
    Published("TestTube, t1a", **tube(0, 50, 50, 0, 90), outside=[(0, 0, 100)], out=[((0, 5, 20), X, math.sqrt(2475))]),
    Published("TestTube, t2", **tube(45, 50, 50), outside=[O, (0, 0, 100)], area=2 * PI * 95 * (5 + 100),
              normals=[((50, 0, 0), X)]),
    Published("TestTube, t3", **tube(0, 50, 50, 90, 90), digits=1e-7,
              out=[((0, 10, 0), X, 0), ((-0.5, 9, 0), X, 0.5), ((-5, 9.5, 0), X, 5), ((-5, 9.5, 0), MY, 9.5),
                   ((-5, 9, 0), XMY, 7.0710678)]),
    Published("TestTube, t5", **tube(50, 100, 50, 0, 270), digits=1e-7,
              into=[((30, -20, 0), XY, 28.284271), ((30, -70, 0), XY, NEVER), ((30, -20, 0), MXMY, 42.426407),
                    ((30, -70, 0), MXMY, NEVER), ((50, -20, 0), Y, 20), ((100, -20, 0), Y, NEVER), ((30, -50, 0), MX, 30),
                    ((30, -100, 0), MX, NEVER)]),
    Published("TestTube, tube6 (bug 76)", **tube(750, 760, 350, 18, 324), digits=1e-7,
              out=[((-388.20504321896431, -641.71398957741451, 332.85995254027955),
                    (-0.47312863350457468, -0.782046391443315, 0.40565100491504164), 10.940583)]),
    Published("TestCons, c1", **cone(50, 100, 50, 100, 50), outside=[O, (120, 0, 0)], volume=2 * PI * 50 * 7500,
              area=2 * PI * (5000 + 10000 + 7500),
              into=[((120, 0, 0), MX, 20), ((120, 0, 0), X, NEVER), ((0, 0, 120), X, NEVER), ((0, 0, 120), MZ, NEVER),
                    ((60, 150, 0), MY, 70), ((50 / ROOT, 50 / ROOT, 0), MX, 100 / ROOT)],
              normals=[((0, 75, 50), Z), ((0, 75, -50), MZ), ((50 / ROOT, 50 / ROOT, 0), (-1 / ROOT, -1 / ROOT, 0)),
                       ((100 / ROOT, 100 / ROOT, 0), (1 / ROOT, 1 / ROOT, 0))]),
    Published("TestCons, c2", **cone(50, 100, 50, 200, 50), inside=[(120, 0, 0)], into=[((0, 0, 120), MZ, NEVER)],
              out=[((120, 0, 0), X, 30), ((120, 0, 0), MX, 70)]),
    Published("TestCons, c3", **cone(50, 100, 50, 100, 50, -30, 60), outside=[(120, 0, 0)],
              into=[((60, 150, 0), MY, 150 - 60 * math.tan(PI / 6)), ((0, 0, 120), MZ, NEVER)],
              out=[((60 * math.cos(PI / 6), -30, 0), Y, 60), ((60 * math.cos(PI / 6), 30, 0), MY, 60)],
              normals=[((60 * math.cos(PI / 6), -30, 0), (-0.5, -math.cos(PI / 6), 0)),
                       ((60 * math.cos(PI / 6), 30, 0), (-0.5, math.cos(PI / 6), 0))]),
    Published("TestCons, c4", **cone(50, 100, 50, 200, 50, -30, 60), inside=[(120, 0, 0)],
              into=[((0, 120, 0), MY, NEVER), ((500, 0, 0), MX, 350), (O, X, 50)], out=[((120, 0, 0), X, 30), ((120, 0, 0), MX, 70)],
              normals=[((150, 0, 0), (1 / ROOT, 0, -1 / ROOT))]),
    Published("TestCons, c5", **cone(25, 50, 75, 150, 50, 0, 270), inside=[(70, 1, 0)], outside=[(50, -50, 0)],
              into=[((0, 0, 120), MZ, NEVER), ((0, 0, -120), Z, NEVER)]),
    Published("TestCons, c6", **cone(0, 150, 0, 150, 50), inside=[O], volume=2 * PI * 50 * 22500,
              into=[((0, 0, 120), MZ, 70), ((0, 0, -120), Z, 70)], out=[((0, 75, 50), MZ, 100), ((0, 75, -50), Z, 100)],
              normals=[((0, 0, 50), Z)]),
    Published("TestCons, c7", **cone(95, 100, 95, 100, 50),
              out=[((100 / ROOT, 100 / ROOT, 0), MX, 100 / ROOT - math.sqrt(95 * 95 - 5000))]),
    Published("TestCons, c8a", **cone(0, 100, 0, 150, 50),
              into=[((0, 0, 120), MZ, 70), ((0, 0, -120), Z, 70), ((0, 125, -1000), Z, 1000)],
              out=[((0, 75, -50), PARR, HALF), ((0, 75, -50), Z, 100), ((0, 125, 50), BACK, HALF), ((0, 125, 50), MZ, 50)]),
    Published("TestCons, c8b", **cone(50, 100, 100, 150, 50), into=[((0, 0, 120), MZ, NEVER), ((0, 25, -150), PARR, HALF)],
              out=[((0, 75, -50), PARR, HALF), ((0, 75, -50), Z, 50), ((0, 125, 50), BACK, HALF), ((0, 125, 50), MZ, 50)]),
    Published("TestCons, c8c", **cone(100, 150, 50, 100, 50), into=[((0, 75, -1000), Z, 1000), ((0, 0, 120), MZ, NEVER)]),
    Published("TestCons, c9", **cone(50, 60, 0, 10, 50), into=[((0, 0, 120), MZ, NEVER), ((0, 0, -120), Z, NEVER)], digits=1e-9,
              out=[((5, 0, 50), (1, 0, -2), 111.8033988749895)]),
    Published("TestCons, cms", **cone(0, 70, 0, 157.8, 2949), digits=1e-7,
              out=[((0.28628920024909, -0.43438111004815, -2949.0),
                    (6.0886686196674e-05, -9.2382200635766e-05, 0.99999999387917), 5898.0)]),
    Published("TestCons, ctest10", **cone(20, 60, 80, 140, 100, 10, 300), digits=1e-5,
              inside=[(-100, 20.9, 5.89), (-44, 13, -14.7)], outside=[(-1191, 174, 404), (37, 1.67, -44.1), (537, 1.67, -44.1),
              (1000, -63.5, -213), (51.28206938732319, -32.10510677306267, 35.00932544708616)],
              into=[((60, 0, 0), X, NEVER), ((60, 0, 0), MX, 110), ((60, 0, 0), Y, 10.57961), ((60, 0, 0), MY, 71.5052),
                    ((60, 0, 0), Z, NEVER), (PHI10[0], X, NEVER), (PHI10[0], Y, 0), (PHI10[0], MY, 80.83778), (PHI10[1], X, NEVER),
                    (PHI10[1], Y, 77.78352), (PHI10[1], MY, 0)]),
    Published("TestPolycone, Simple", f'<polycone name="s">{planes(SIMPLE)}</polycone>', lambda: co.Polycone(SIMPLE),
              volume=PI * (49000 + 10 * (4900 + 6400 + 5600) / 3), area=PI * (4900 + 6400 + 150 * math.sqrt(200) + 1400),
              inside=[O, (0, 25, 0), (4, 25, 0)], outside=[(0, 0, 100), (100, 0, 0), (0, 100, 0)], extent=((-80, -80, -10), (80, 80, 10)),
              out=[(O, X, 70), (O, MX, 70), (O, Y, 70), (O, MY, 70), (O, Z, 10)],
              into=[((100, 0, -1), MX, 30), ((-100, 0, -1), X, 30), ((0, 100, -5), MY, 30), ((0, -100, -5), Y, 30),
                    ((0, 0, 100), MZ, 90), ((0, 0, -100), Z, 90), ((100, 0, 0), XY, NEVER), ((-100, 0, 0), MXY, NEVER)],
              normals=[((70, 0, -5), X), ((-70, 0, -3), MX), ((0, 70, -5), Y), ((0, 0, 10), Z), ((0, 0, -10), MZ)]),
    Published("TestParaboloid, p1", '<paraboloid name="s" rlo="6" rhi="9" dz="10"/>', inside=[O], outside=list(FAR),
              out=[(O, Z, 10), (O, MZ, 10)], into=[((0, 0, 100), MZ, 90), ((0, 0, -100), Z, 90)],
              normals=[((0, 0, 10), Z), ((0, 0, -10), MZ), ((3, 4, 10), Z), ((3, 4, -10), MZ)]),
    Published("TestParaboloid, p2", '<paraboloid name="s" rlo="0" rhi="8" dz="10"/>', out=[((0, 0, -10), Z, 20)]),
    Published("TestHype, b1", '<hype name="s" rmin="10" rmax="20" inst="45" outst="60" z="100" aunit="deg"/>', outside=[O, *FAR[:3]],
              inside=[(15, 0, 0), (-15, 0, 0), (0, 15, 0), (0, -15, 0)], into=[*from_far(80, 80, NEVER), ((10, 0, 0), MX, 20)],
              out=[((15, 0, 0), X, 5), ((-15, 0, 0), MX, 5), ((0, 15, 0), Y, 5), ((0, -15, 0), MY, 5),
                   *(((x, y, 0), v, math.sqrt(125)) for x, y in ((15, 0), (-15, 0), (0, 15), (0, -15)) for v in (Z, MZ)),
                   ((20, 0, 0), MX, 10), ((10, 0, 0), X, 10)],
              extent=((-math.sqrt(7900), -math.sqrt(7900), -50), (math.sqrt(7900), math.sqrt(7900), 50))),
    Published("TestEllipticalTube", '<eltube name="s" dx="4" dy="3" dz="5"/>', lambda: co.EllipticCylinder(1 / 16, 1 / 9, (-5, 5)),
              volume=2 * PI * 60, extent=((-4, -3, -5), (4, 3, 5)),
              out=[((x, y, 0), X, 4 * math.sqrt(1 - y * y / 9) - x) for x in (-1, 0, 1) for y in (-1, 0, 1)],
              into=[((5, y, 1), MX, 5 - 4 * math.sqrt(1 - y * y / 9)) for y in (-1, 0, 1)],
              normals=[((4 * math.cos(a), 3 * math.sin(a), 0),
                        (math.cos(a) * 3 / math.hypot(3 * math.cos(a), 4 * math.sin(a)),
                         math.sin(a) * 4 / math.hypot(3 * math.cos(a), 4 * math.sin(a)), 0)) for a in range(7)]),
    Published("TestEllipticalCone", '<elcone name="s" dx="0.5" dy="0.4" zmax="10" zcut="5"/>', extent=((-7.5, -6, -5), (7.5, 6, 5)),
              volume=PI * 0.2 * (15**3 - 5**3) / 3, into=[((0, 20, z), MY, 20 - 0.4 * (10 - z)) for z in (-4, 0, 3)],
              out=[((0, 0.5, z), X, 0.5 * math.sqrt((10 - z) ** 2 - 0.25 / 0.16)) for z in (-4, 0, 3)]),
    Published("TestEllipsoid", '<ellipsoid name="s" ax="3" by="4" cz="5" zcut1="-4.5" zcut2="3.5"/>',
              lambda: co.Ellipsoid((3, 4, 5), z_range=(-4.5, 3.5)), inside=[O], outside=[(0, 0, -5), (0, 0, 5)],
              normals=[((0, 0, -4.5), MZ), ((-0.6, -0.6, -4.5), MZ), ((0.5, 0, 3.5), Z), ((-0.5, 0.5, 3.5), Z)]),
]  # fmt: skip

S13 = 34.641016151377549, 11.547005383792508, 58.452994616207498, 35.358983848622451
RAND = (-10.276604989981144911, -4.7072500741022338389, 1), (-0.28873162920537848164, 0.51647890054938394577, -0.80615357816219324061)  # fmt: skip
SPHERES = [
    Published("TestSphere, b2", **sphere(0, 3, (30, 90), (0, 180)), volume=PI * 9, area=9 * PI + 9 * PI),
    Published("TestSphere, b3", **sphere(1, 3, (30, 90), (0, 180)), volume=27.22713633111, digits=1e-11),
    Published("TestSphere, b4", **sphere(6, 8, (0, 360), (0, 180)), outside=[(0.162722224118177, -8.624868144449298, -2.566158796458579)],
              inside=[(0.337317535387103, 6.265557026812151, 3.103064940359008), (5.644948390009752, -5.435958227995553, 1.607767309536356),
                      (0.101529841379922, -5.993375366532538, 0.262951431162379)], normals=[((8, 0, 0), X), ((0, -8, 0), MY)]),
    Published("TestSphere, b5", **sphere(6, 8, (0, 180), (0, 180)), inside=[(-6.354024677915919, 2.724956501738179, -1.095893451057325)],
              outside=[(-2.523183636323228, -3.188902592924771, -5.697757856405303)]),
    Published("TestSphere, b6", **sphere(6, 8, (30, 60), (0, 180)), inside=[(5.343263338886987, 3.536603816131425, -2.818150162612158)],
              outside=[(6.043467293054153, 0.461937628581358, 3.501873313683026)]),
    Published("TestSphere, b7", **sphere(6, 8, (30, 30), (0, 30)), inside=[(2.051950506806283, 1.301790637821730, 6.564666042754737)],
              outside=[(3.038887886090341, 3.240358815458723, 5.409735221140894)]),
    Published("TestSphere, s1", **sphere(0, 50, (0, 360), (0, 180)), inside=[O], out=[((0, 0, 30), Z, 20)],
              into=[((0, 100, 0), Y, NEVER), ((0, 100, 0), MY, 50)], normals=[((50, 0, 0), X)]),
    Published("TestSphere, s2", **sphere(45, 50, (0, 360), (0, 180)), outside=[O], out=[((45, 0, 0), X, 5)],
              into=[(O, Y, 45), (O, MY, 45), ((45, 0, 0), X, 0), ((45, 0, 0), MX, 90), ((45 / ROOT, 45 / ROOT, 0), MX, 90 / ROOT)]),
    Published("TestSphere, s3", **sphere(45, 50, (0, 360), (45, 90)),
              into=[((0, 48 / ROOT, 100), MZ, 100 - 48 / ROOT), (O, X, 45)]),
    Published("TestSphere, s4", **sphere(45, 50, (-45, 90), (0, 180)), outside=[(-48 / ROOT, 48 / ROOT, 0)], inside=[(48 * 0.866, -24, 0)],
              into=[((0, 100, 0), MY, NEVER), (O, Y, NEVER), (O, X, 45), ((-100, -45 / ROOT, 0), X, 100 + 45 / ROOT),
                    ((-100, 45 / ROOT, 0), X, 100 + 45 / ROOT)]),
    Published("TestSphere, s5", **sphere(45, 50, (-45, 90), (45, 90)), outside=[(0, 0, 100)]),
    Published("TestSphere, s13", **sphere(5, 50, (0, 360), (30, 90)), digits=1e-9,
              out=[((20, 0, 0), Z, S13[0]), ((20, 0, 0), MZ, S13[1])], into=[((20, 0, -70), Z, S13[2]), ((20, 0, 70), MZ, S13[3])]),
    Published("TestSphere, s14", **sphere(5, 50, (0, 360), (60, 90)), digits=1e-9,
              out=[((20, 0, 0), Z, S13[1]), ((20, 0, 0), MZ, S13[0])], into=[((20, 0, -70), Z, S13[3]), ((20, 0, 70), MZ, S13[2])]),
    Published("TestSphere, sn11", **sphere(0, 50, (0, 360), (0, 90)), out=[((0, 0, 20), MZ, 20), (O, Z, 50), ((10, 0, 0), MZ, 0)]),
    Published("TestSphere, sn12", **sphere(0, 50, (0, 360), (0, 45)), inside=[(0, 0, 30)], outside=[(30, 0, 0)],
              out=[((0, 0, 20), (1, 0, -1), 20 / ROOT), ((10, 0, 10), Z, 38.989794855663561179), ((10, 0, 10), MZ, 0)]),
    Published("TestSphere, sn13", **sphere(0, 50, (0, 360), (135, 45)), inside=[(0, 0, -30)]),
    Published("TestSphere, sn14", **sphere(0, 50, (0, 360), (45, 135)),
              out=[((10, 0, 10), Z, 0), ((10, 0, 5), Z, 5), ((10, 0, 5), (-1, 0, 1), 3.5355339059327381968)]),
    Published("TestSphere, sn17", **sphere(0, 50, (0, 360), (91, 89)), into=[(*RAND, 1.4874615083453075481)],
              out=[((16.20075504802145, -22.42917454903122, -41.6469406430184),
                    (-0.280469198715188, 0.4463870649961534, 0.8497503261406731), 48.95871780757848768)]),
    Published("TestSphere, sn22", **sphere(0, 50, (90, 90), (0, 180)), out=[((-1e-9, 49, 0), MY, 49), ((-45, 1e-9, 0), X, 45)], digits=1e-7),
    Published("TestSphere, b658", **sphere(209.6, 211.2658, (0, 360), (0, 90)), into=[(O, Z, 209.6)],
              outside=[(-35.69953348982516, 198.3183279249958, 56.30959457033987)]),
]  # fmt: skip
EVERY = [*FLAT, *ROUND, *SPHERES]
