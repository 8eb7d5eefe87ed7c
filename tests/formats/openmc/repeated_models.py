"""Models in which most bodies are moved copies: lattices along the axes, turned, and cut."""

from benchmarks.comparison.scenes import core_xml

BALL = '<surface id="1" type="sphere" coeffs="0.1 0 0 0.3"/>'
CONE = '<surface id="2" type="z-cone" coeffs="0 0.05 -0.4 0.09"/>'
PIPE = '<surface id="3" type="x-cylinder" coeffs="0.1 -0.2 0.15"/>'
WALL = '<surface id="4" type="plane" coeffs="1 2 0.5 0.1"/>'
GENERAL = '<surface id="5" type="quadric" coeffs="1 2 3 0.2 0.1 0 0.1 0 0.2 -0.1"/>'
CELLS = (
    '<cell id="1" universe="1" material="1" region="-1"/>',
    '<cell id="2" universe="1" material="2" region="1 -2 -4"/>',
    '<cell id="3" universe="1" material="3" region="1 (2 | 4) (3 | -5)"/>',
    '<cell id="4" universe="1" material="4" region="1 (2 | 4) -3 5"/>',
)
INSIDE = BALL, CONE, PIPE, WALL, GENERAL, *CELLS
CORNER = -1, -1, -0.8
"""The center of spheres that cut the elements of a lattice at one corner, and no others."""


def within(x: float, y: float, z: float, radius: float) -> str:
    """Return the sphere around a model, and all of `INSIDE`."""
    return "".join((f'<surface id="9" type="sphere" coeffs="{x} {y} {z} {radius}" boundary="vacuum"/>', *INSIDE))


MODELS = {
    "core": core_xml(3, vessel=5.5, pins=3),
    "cubes": "<geometry>" + "".join((
        within(*CORNER, 3.5),
        '<lattice id="4" dimension="3 3 2" pitch="1 1.1 1.2" lower_left="-1.5 -1.65 -1.2" universes="' + "1 " * 18 + '"/>',
        '<cell id="20" fill="4" region="-9"/>',
    )) + "</geometry>",
    "turned": "<geometry>" + "".join((
        within(*CORNER, 3.3),
        '<lattice id="4" dimension="5 3 1" pitch="1 1.1 2" lower_left="-2.5 -1.65 -1" universes="' + "1 6 1 1 6 " * 3 + '"/>',
        '<cell id="21" universe="6" fill="1" rotation="90 0 90" translation="0.01 0 0"/>',
        '<cell id="20" fill="4" region="-9"/>',
    )) + "</geometry>",
    "hexagons": "<geometry>" + "".join((
        within(0.3, 0.2, 0.1, 1.4),
        '<hex_lattice id="4" n_rings="2" n_axial="3" center="0.1 0 0" pitch="1.1 1.2" universes="' + "1 " * 21 + '" outer="1"/>',
        '<cell id="20" fill="4" region="-9"/>',
    )) + "</geometry>",
    "slanted": "<geometry>" + "".join((
        within(0.3, 0.2, 0.1, 1.3),
        '<lattice id="4" dimension="3 3" pitch="1 1" lower_left="-1.5 -1.5" universes="' + "1 " * 9 + '" outer="1"/>',
        '<cell id="22" universe="7" fill="4"/>',
        '<cell id="20" fill="7" rotation="0 0 30" region="-9"/>',
    )) + "</geometry>",
    "core at an angle": core_xml(3, vessel=5.5, pins=3, turned='0 0 30" translation="0.1 0.2 0.3'),
    "cubes at an angle": "<geometry>" + "".join((
        within(*CORNER, 3.6),
        '<lattice id="4" dimension="3 3 2" pitch="1 1.1 1.2" lower_left="-1.5 -1.65 -1.2" universes="' + "1 " * 18 + '"/>',
        '<cell id="22" universe="7" fill="4" region="-9"/>',
        '<cell id="20" fill="7" rotation="10 -20 30" translation="0.02 0 0.1"/>',
    )) + "</geometry>",
    "hexagons at an angle": "<geometry>" + "".join((
        within(*CORNER, 3.4),
        '<hex_lattice id="4" n_rings="2" n_axial="3" center="0.1 0 0" pitch="1.1 1.2" universes="' + "1 " * 21 + '"/>',
        '<cell id="22" universe="7" fill="4" region="-9"/>',
        '<cell id="20" fill="7" rotation="0.8 0.6 0 -0.6 0.8 0 0 0 1"/>',
    )) + "</geometry>",
}  # fmt: skip
