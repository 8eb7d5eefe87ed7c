"""Divisions of each kind along each axis: every point of the mother is in the slice of its coordinate."""

import numpy as np
import pytest

from .files import placed, scene_of, text_of, volume
from .test_solids import (
    DEG,
    STEPS,
    in_box,
    in_cone,
    in_para,
    in_phi,
    in_polyhedra,
    in_stack,
    in_trd,
    planes,
    radius,
)

CONE = '<cone name="m" rmin1="1" rmax1="4" rmin2="3" rmax2="8" z="12" startphi="30" deltaphi="240" aunit="deg"/>'
TRD = '<trd name="m" x1="4" x2="12" y1="10" y2="5" z="14"/>'
BOX = '<box name="m" x="12" y="4" z="4"/>'
TUBE = '<tube name="m" rmin="2" rmax="8" z="4" deltaphi="2*pi"/>'
PARA = '<para name="m" x="6" y="8" z="12" alpha="15" theta="20" phi="30" aunit="deg"/>'
POLYCONE = f'<polycone name="m" startphi="0" deltaphi="360" aunit="deg">{planes(STEPS)}</polycone>'
POLYHEDRA = f'<polyhedra name="m" startphi="20" deltaphi="250" numsides="4" aunit="deg">{planes(STEPS)}</polyhedra>'


def in_cone_of_240(p):
    return in_cone(p, 1, 4, 3, 8, 6) & in_phi(p, 30, 240)


def in_box_of_12(p):
    return in_box(p, 12, 4, 4)


def in_tube(p):
    return (radius(p) >= 2) & (radius(p) <= 8) & (abs(p[:, 2]) <= 2)


def from_to(x, low, high):
    """Return x in slices of width 1 from the first one, or -1 outside of all."""
    return np.where((x >= low) & (x <= high), x - low, -1)


def phi(p, start):
    return (np.arctan2(p[:, 1], p[:, 0]) / DEG - start) % 360


def across_cone(p):
    """Return the share of the way from the inner wall to the outer."""
    t = (p[:, 2] + 6) / 12
    return (radius(p) - (1 + 2 * t)) / (3 + 2 * t)


def across_stack(p):
    z, inner, outer = (np.array(column, float) for column in zip(*STEPS, strict=True))
    a, b = np.interp(p[:, 2], z, inner), np.interp(p[:, 2], z, outer)
    return (radius(p) - a) / (b - a)


def across_trd(p, axis):
    t = (p[:, 2] + 7) / 14
    size = 4 + 8 * t if axis == 0 else 10 - 5 * t
    return p[:, axis] / size + 0.5


def across_para(p):
    z = p[:, 2]
    y = p[:, 1] - z * np.tan(20 * DEG) * np.sin(30 * DEG)
    return p[:, 0] - z * np.tan(20 * DEG) * np.cos(30 * DEG) - y * np.tan(15 * DEG), y


CASES = {
    "box, x": (BOX, "kXAxis", 'number="4" width="0" offset="0"', in_box_of_12, lambda p: (p[:, 0] + 6) / 3, 4),
    "box, y": (BOX, "kYAxis", 'number="0" width="1" offset="1"', in_box_of_12, lambda p: from_to(p[:, 1], -1, 2), 3),
    "box, z": (BOX, "kZAxis", 'number="2" width="1" offset="0.5"', in_box_of_12, lambda p: from_to(p[:, 2], -1.5, 0.5), 2),
    "tube, phi": (TUBE, "kPhi", 'number="4" width="0" offset="0"', in_tube, lambda p: phi(p, 0) / 90, 4),
    "tube, phi from -90": (TUBE, "kPhi", 'number="4" width="90" offset="-90"', in_tube, lambda p: phi(p, -90) / 90, 4),
    "tube, rho": (TUBE, "kRho", 'number="3" width="2" offset="0"', in_tube, lambda p: (radius(p) - 2) / 2, 3),
    "tube, z": (TUBE, "kZAxis", 'number="2" width="0" offset="0"', in_tube, lambda p: (p[:, 2] + 2) / 2, 2),
    "cone, z": (CONE, "kZAxis", 'number="4"', in_cone_of_240, lambda p: (p[:, 2] + 6) / 3, 4),
    "cone, phi": (CONE, "kPhi", 'number="3"', in_cone_of_240, lambda p: phi(p, 30) / 80, 3),
    "cone, rho": (CONE, "kRho", 'number="3"', in_cone_of_240, lambda p: across_cone(p) * 3, 3),
    "cone, by width": (CONE, "kRho", 'width="0.75"', in_cone_of_240, lambda p: across_cone(p) * 4, 4),
    "trd, z": (TRD, "kZAxis", 'width="2"', lambda p: in_trd(p, 4, 12, 10, 5, 7), lambda p: (p[:, 2] + 7) / 2, 7),
    "trd, x": (TRD, "kXAxis", 'number="4"', lambda p: in_trd(p, 4, 12, 10, 5, 7), lambda p: across_trd(p, 0) * 4, 4),
    "trd, y": (TRD, "kYAxis", 'number="5"', lambda p: in_trd(p, 4, 12, 10, 5, 7), lambda p: across_trd(p, 1) * 5, 5),
    "para, x": (PARA, "kXAxis", 'number="3"', in_para, lambda p: across_para(p)[0] / 2 + 1.5, 3),
    "para, y": (PARA, "kYAxis", 'number="4"', in_para, lambda p: across_para(p)[1] / 2 + 2, 4),
    "para, z": (PARA, "kZAxis", 'number="4"', in_para, lambda p: (p[:, 2] + 6) / 3, 4),
    "polycone, phi": (
        POLYCONE, "kPhi", 'number="6"', lambda p: in_stack(p, STEPS), lambda p: phi(p, 0) / 60, 6,
    ),
    "polycone, rho": (
        POLYCONE, "kRho", 'number="2"', lambda p: in_stack(p, STEPS), lambda p: across_stack(p) * 2, 2,
    ),
    "polycone, z": (
        POLYCONE, "kZAxis", 'number="3"', lambda p: in_stack(p, STEPS),
        lambda p: np.searchsorted([-2, 3], p[:, 2]), 3,
    ),
    "polyhedra, phi": (
        POLYHEDRA, "kPhi", 'number="4"', lambda p: in_polyhedra(p, 4, 20, 250, STEPS), lambda p: phi(p, 20) / 62.5, 4,
    ),
    "a box within": (
        '<box name="m" x="10" y="8" z="6"/>', "kXAxis", 'number="2" width="3" offset="1"',
        lambda p: in_box(p, 10, 8, 6), lambda p: np.where((p[:, 0] >= -4) & (p[:, 0] <= 2), (p[:, 0] + 4) / 3, -1), 2,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_points_are_in_their_slices(tmp_path, name):
    solid, axis, rule, inside, coordinate, count = CASES[name]
    unit = 'unit="deg"' if axis == "kPhi" else 'unit="mm"'
    division = f'<divisionvol axis="{axis}" {rule} {unit}><volumeref ref="part"/></divisionvol>'
    solids = f'{solid}<box name="any" x="1" y="1" z="1"/><box name="w" x="40" y="40" z="40"/>'
    structure = volume("part", "any") + volume("m", "m", division) + volume("world", "w", placed("m"))
    scene = scene_of(tmp_path, text_of(solids, structure))
    names = [body.name for body in scene.bodies]
    slices = [names.index(f"world/m/part[{k}]") for k in range(count)]
    p = np.random.default_rng(8).uniform(-9, 9, (20_000, 3))
    within = inside(p)
    at = np.floor(coordinate(p)).astype(int)
    other = names.index("world/m") if "world/m" in names else -1
    expected = np.where(within, np.where(at >= 0, np.array(slices)[np.clip(at, 0, count - 1)], other), 0)
    assert within.sum() > 300
    assert np.array_equal(np.asarray(scene.body_at(p)), expected)


@pytest.mark.parametrize(
    ("solid", "axis", "rule", "message"),
    [
        (CONE, "kXAxis", 'number="2"', "divides a cone along x, which Geant4 does not either"),
        (POLYHEDRA, "kPhi", 'number="3"', "across its sides"),
        (POLYCONE, "kZAxis", 'number="2"', "has 2 slices of 3 sections"),
        ('<orb name="m" r="3"/>', "kZAxis", 'number="2"', "divides what is no box, tube, cone"),
    ],
)
def test_undivided_volumes_are_reported(tmp_path, solid, axis, rule, message):
    division = f'<divisionvol axis="{axis}" {rule} unit="mm"><volumeref ref="part"/></divisionvol>'
    solids = f'{solid}<box name="any" x="1" y="1" z="1"/>'
    structure = volume("part", "any") + volume("m", "m", division)
    scene = scene_of(tmp_path, text_of(solids, structure, world="m"))
    assert any(message in note for note in scene.notes)


DIMENSIONS = {
    "trap": (
        '<trap_dimensions z="12" theta="10" phi="40" y1="8" x1="4" x2="6" alpha1="10" y2="10" x3="5" x4="7.5" alpha2="10"'
        ' aunit="deg" lunit="mm"/>',
        None,
    ),
    "para": ('<para_dimensions x="6" y="8" z="12" alpha="15" theta="20" phi="30" aunit="deg" lunit="mm"/>', in_para),
    "ellipsoid": (
        '<ellipsoid_dimensions ax="4" by="6" cz="9" zcut1="-3" zcut2="7" lunit="mm"/>',
        lambda p: (((p / [4, 6, 9]) ** 2).sum(axis=1) <= 1) & (p[:, 2] >= -3) & (p[:, 2] <= 7),
    ),
    "hype": ('<hype_dimensions rmin="2" rmax="4" inst="20" outst="40" z="12" aunit="deg" lunit="mm"/>', None),
    "polycone": (
        f'<polycone_dimensions numRZ="4" startPhi="10" openPhi="200" aunit="deg" lunit="mm">{planes(STEPS)}'
        "</polycone_dimensions>",
        lambda p: in_stack(p, STEPS) & in_phi(p, 10, 200),
    ),
    "polyhedra": (
        f'<polyhedra_dimensions numRZ="4" numSide="4" startPhi="20" openPhi="250" aunit="deg" lunit="mm">{planes(STEPS)}'
        "</polyhedra_dimensions>",
        lambda p: in_polyhedra(p, 4, 20, 250, STEPS),
    ),
}


@pytest.mark.parametrize("name", DIMENSIONS)
def test_parameters_of_other_solids(tmp_path, name):
    from .test_solids import hyperbolic, in_trap

    dimensions, inside = DIMENSIONS[name]
    inside = inside or {"trap": in_trap, "hype": hyperbolic}[name]
    rule = (
        '<paramvol ncopies="1"><volumeref ref="part"/><parameterised_position_size><parameters number="1">'
        f'<position x="0" y="0" z="0"/>{dimensions}</parameters></parameterised_position_size></paramvol>'
    )
    solids = '<box name="any" x="1" y="1" z="1"/><box name="w" x="40" y="40" z="40"/>'
    scene = scene_of(tmp_path, text_of(solids, volume("part", "any") + volume("world", "w", rule)))
    p = np.random.default_rng(9).uniform(-9, 9, (10_000, 3))
    assert np.array_equal(np.asarray(scene.body_at(p)), np.where(inside(p), 1, 0))
