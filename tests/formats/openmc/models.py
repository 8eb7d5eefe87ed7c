"""Small geometries in OpenMC's format, each for a part that an importer can get wrong."""

import functools
from pathlib import Path

import conicoid as co
from benchmarks.comparison.scenes import core_xml

EXAMPLES = Path(__file__).resolve().parents[3] / "examples" / "openmc"
EXAMPLE_FILES = {"assembly": EXAMPLES / "assembly" / "geometry.xml", "pin": EXAMPLES / "pin" / "model.xml"}

# Every kind of surface, in one universe; regions with all operators and the documented precedence
KINDS = """
<geometry>
  <surface id="1" type="x-plane" coeffs="0.7"/>
  <surface id="2" type="y-plane" coeffs="-0.35"/>
  <surface id="3" type="z-plane" coeffs="0.15"/>
  <surface id="4" name="slope" type="plane" coeffs="1 -2 0.5 1.3"/>
  <surface id="5" type="x-cylinder" coeffs="0.2 -0.4 1.1"/>
  <surface id="6" type="y-cylinder" coeffs="-0.3 0.6 0.9"/>
  <surface id="7" type="z-cylinder" coeffs="0.5 0.25 1.3"/>
  <surface id="8" type="sphere" coeffs="-0.5 0.5 0.1 1.4"/>
  <surface id="9" type="x-cone" coeffs="-1 0.3 0.2 0.3"/>
  <surface id="10" type="y-cone" coeffs="0.4 1 -0.2 0.45"/>
  <surface id="11" type="z-cone" coeffs="0.1 -0.6 0.5 0.7"/>
  <surface id="12" type="quadric" coeffs="1 1.5 0.5 0.4 -0.3 0.2 0.1 -0.2 0.3 -1.7"/>
  <surface id="13" type="quadric" coeffs="0 0 0 0 0 0 0 1 0 -1.2"/>
  <surface id="14" type="sphere" coeffs="0 0 0 3" boundary="vacuum"/>
  <cell id="1" material="1" region="-14 -5 | -6 8 -14"/>
  <cell id="2" material="2" region="-14 ~(-5 | -6 8) ~(7 | 9 -10) (-1 | 2)"/>
  <cell id="3" material="3" region="-14 ~(-14 -5 | -6 8 -14) ~(~(-5 | -6 8) ~(7 | 9 -10) (-1 | 2)) &amp; (-12|-11 4|(3 -13))"/>
  <cell id="4" material="void" region="-14 5 (6 | -8) (7 | (9 -10) | (1 -2)) ~(-12 | -11 4 | 3 -13)"/>
  <cell id="5" material="4" region="14"/>
</geometry>
"""

# A rectangular lattice in three dimensions; its elements hold turned copies of a universe without symmetry
TURNS = """
<geometry>
  <surface id="1" type="sphere" coeffs="0.2 0.1 0 0.35"/>
  <surface id="2" type="x-cylinder" coeffs="-0.1 0.15 0.2"/>
  <surface id="3" type="z-cone" coeffs="0 0.1 -0.3 0.2"/>
  <surface id="4" type="plane" coeffs="1 0.5 -0.25 0.1"/>
  <surface id="5" type="quadric" coeffs="4 9 1 1 -2 3 0.5 0 1 -1"/>
  <cell id="1" universe="1" material="1" region="-1"/>
  <cell id="2" universe="1" material="2" region="1 -2"/>
  <cell id="3" universe="1" material="3" region="1 2 -3 4"/>
  <cell id="4" universe="1" material="4" region="1 2 (3 | -4) -5"/>
  <cell id="5" universe="1" material="void" region="1 2 (3 | -4) 5"/>
  <cell id="11" universe="11" fill="1"/>
  <cell id="12" universe="12" fill="1" rotation="90 0 0"/>
  <cell id="13" universe="13" fill="1" rotation="0 -90 180" translation="0.1 0 -0.05"/>
  <cell id="14" universe="14" fill="1" rotation="0 270 90"/>
  <cell id="15" universe="15" fill="1" rotation="0 1 0 0 0 -1 -1 0 0"/>
  <cell id="16" universe="16" fill="1" rotation="20 -35 50" translation="-0.1 0.05 0.1"/>
  <cell id="17" universe="17" fill="1" rotation="0.8 0.6 0 -0.6 0.8 0 0 0 1"/>
  <cell id="18" universe="18" fill="16" rotation="0 90 0" translation="0 0.1 0"/>
  <lattice id="9">
    <dimension>2 3 2</dimension> <lower_left>-1.3 -1.2 -0.9</lower_left> <pitch>1.3 0.8 0.9</pitch>
    <universes> 11 12  13 14  15 16   17 18  12 11  14 16 </universes>
  </lattice>
  <surface id="21" type="sphere" coeffs="0 0 0 1.4" boundary="vacuum"/>
  <cell id="21" fill="9" region="-21" rotation="0 0 25"/>
</geometry>
"""

# A lattice whose outer universe has structure of its own, so that it repeats element by element
OUTER = """
<geometry>
  <surface id="1" type="z-cylinder" coeffs="0 0 0.4"/>
  <surface id="2" type="z-cylinder" coeffs="0.1 0 0.3"/>
  <surface id="3" type="z-plane" coeffs="0.2"/>
  <cell id="1" universe="1" material="1" region="-1"/>
  <cell id="2" universe="1" material="2" region="1"/>
  <cell id="3" universe="2" material="3" region="-2 -3"/>
  <cell id="4" universe="2" material="4" region="-2 3"/>
  <cell id="5" universe="2" material="void" region="2"/>
  <lattice id="3" dimension="2 2" lower_left="-1 -0.9" pitch="1 0.9" outer="2" universes="1 1 1 2"/>
  <surface id="11" type="z-cylinder" coeffs="0.3 0 2.6"/>
  <surface id="12" type="z-plane" coeffs="-1"/>
  <surface id="13" type="z-plane" coeffs="1"/>
  <surface id="14" type="z-cylinder" coeffs="0.3 0 2.8" boundary="vacuum"/>
  <cell id="11" fill="3" region="-11 12 -13" translation="0.15 0.2 0.3" rotation="0 0 12"/>
  <cell id="12" material="5" region="-14 11 12 -13"/>
</geometry>
"""

PINS = """
  <surface id="1" type="z-cylinder" coeffs="0 0 0.3"/>
  <surface id="2" type="z-cylinder" coeffs="0.05 -0.1 0.4"/>
  <surface id="3" type="x-plane" coeffs="0.1"/>
  <cell id="1" universe="1" material="1" region="-1"/>
  <cell id="2" universe="1" material="2" region="1"/>
  <cell id="3" universe="2" material="3" region="-2 -3"/>
  <cell id="4" universe="2" material="4" region="-2 3"/>
  <cell id="5" universe="2" material="2" region="2"/>
  <cell id="6" universe="3" material="5"/>
"""

# The two kinds of hexagonal lattice: flat with structure outside, and in levels with the same outside everywhere
HEXAGONS_Y = f"""
<geometry>{PINS}
  <hex_lattice id="7" name="flat" n_rings="3" outer="2">
    <center>0.2 -0.1</center> <pitch>1.1</pitch>
    <universes>
          1
       2     1
    1     2     2
       1     1
    2     3     1
       1     2
    2     1     1
       1     2
          2
    </universes>
  </hex_lattice>
  <surface id="11" type="sphere" coeffs="0 0 0 3.6" boundary="vacuum"/>
  <cell id="11" fill="7" region="-11"/>
</geometry>
"""
HEXAGONS_X = f"""
<geometry>{PINS}
  <hex_lattice id="7" n_rings="3" n_axial="2" orientation="x" outer="3">
    <center>0.1 0.2 0.3</center> <pitch>0.9 1.2</pitch>
    <universes>
        1  2  1
      2  1  1  2
    1  2  3  1  2
      1  1  2  1
        2  2  1
        2  1  2
      1  2  2  1
    2  2  1  1  3
      2  1  2  2
        1  1  3
    </universes>
  </hex_lattice>
  <surface id="11" type="z-cylinder" coeffs="0 0 3" boundary="vacuum"/>
  <surface id="12" type="z-plane" coeffs="-1.7"/>
  <surface id="13" type="z-plane" coeffs="2"/>
  <cell id="11" fill="7" region="-11 12 -13" rotation="0 0 -17"/>
  <cell id="12" universe="0" material="void" region="-11 13"/>
</geometry>
"""
# Its planes are all along one line, which no rotation of floats keeps
ONE_HEXAGON = """
<geometry>
  <surface id="4" type="x-cylinder" coeffs="0.05 -0.1 0.35"/>
  <cell id="7" universe="4" material="3" region="-4"/>
  <cell id="8" universe="4" material="4" region="4"/>
  <cell id="6" universe="3" material="5"/>
  <hex_lattice id="7" orientation="x" n_rings="1" center="0 0" pitch="1.1" outer="3" universes="4"/>
  <surface id="11" type="sphere" coeffs="0 0 0 2"/>
  <cell id="11" fill="7" region="-11" rotation="119 -6 170"/>
  <cell id="12" material="1" region="11"/>
</geometry>
"""

# A lattice in a lattice, cut off by a cylinder that some elements lie outside of, and open beyond its last elements
NESTED = f"""
<model><geometry>{PINS}
  <lattice id="5" dimension="3 3" lower_left="-1.5 -1.5" pitch="1 1" universes="1 2 1  2 3 2  1 2 2"/>
  <cell id="31" universe="31" fill="5"/>
  <cell id="32" universe="32" material="5"/>
  <lattice id="6" dimension="4 4" lower_left="-6 -6" pitch="3 3" universes="32 31 31 31  31 32 31 31  31 31 31 31  31 31 31 32"/>
  <surface id="11" type="z-cylinder" coeffs="0 0 7"/>
  <surface id="12" type="z-plane" coeffs="-1"/>
  <surface id="13" type="z-plane" coeffs="1"/>
  <cell id="11" fill="6" region="-11 12 -13"/>
</geometry></model>
"""

TEXTS = {
    "kinds": KINDS, "turns": TURNS, "outer": OUTER, "hexagons y": HEXAGONS_Y, "hexagons x": HEXAGONS_X,
    "one hexagon": ONE_HEXAGON, "nested": NESTED,
}  # fmt: skip
NAMES = [*TEXTS, *EXAMPLE_FILES]


def endless(side: int, radius: float) -> str:
    """Return side x side endless elements of pitch 1 from the origin, each of a pin of a radius and water."""
    return f"""
<geometry>
  <surface id="1" type="z-cylinder" coeffs="0 0 {radius}"/>
  <surface id="2" type="x-plane" coeffs="0"/>
  <surface id="3" type="x-plane" coeffs="{side}"/>
  <surface id="4" type="y-plane" coeffs="0"/>
  <surface id="5" type="y-plane" coeffs="{side}"/>
  <cell id="1" universe="1" material="1" region="-1"/>
  <cell id="2" universe="1" material="2" region="1"/>
  <lattice id="9" dimension="{side} {side}" lower_left="0 0" pitch="1 1" universes="{" 1" * side**2}"/>
  <cell id="3" fill="9" region="2 -3 4 -5"/>
</geometry>
"""


def model_file(name: str, folder: Path) -> Path:
    """Return the file of a model, which is made in `folder` unless it is one of the examples."""
    if name in EXAMPLE_FILES:
        return EXAMPLE_FILES[name]
    return geometry_file(TEXTS[name], folder)


def geometry_file(text: str, folder: Path) -> Path:
    """Write a text as the file of a geometry."""
    path = folder / "geometry.xml"
    path.write_text(text.strip(), encoding="utf-8")
    return path


@functools.lru_cache(maxsize=4)
def _example(path: Path) -> co.Scene:
    return co.load_openmc(path)


def load_model(path: Path) -> co.Scene:
    """Return the scene of a file. Those of the examples are prepared only once."""
    return _example(path) if path in EXAMPLE_FILES.values() else co.load_openmc(path)


# --- Models in which most bodies are moved copies: lattices along the axes, turned, and cut


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


# --- Geometries with mistakes: name -> (content, line, phrases that the message must hold). Line 0 is no line


PLANES = '<surface id="1" type="x-plane" coeffs="0"/><surface id="2" type="sphere" coeffs="0 0 0 1"/>'


def geometry(*lines: str) -> str:
    """Return a geometry of some lines. The first is line 3 of the file."""
    return "\n".join(["<geometry>", PLANES, *lines, "</geometry>"])


def surface(attributes: str) -> str:
    return geometry(f"<surface id='9' name='odd' {attributes}/>", '<cell id="1" material="1" region="-2"/>')


def cell(attributes: str, *more: str) -> str:
    return geometry(f"<cell id='5' name='odd' {attributes}/>", *more)


def lattice(attributes: str, tag: str = "lattice") -> str:
    filled = '<cell id="1" universe="1" material="1"/><cell id="2" fill="4"/>'
    return geometry(f"<{tag} id='4' name='odd' {attributes}/>", filled)


RECT = "lower_left='0 0' pitch='1 1'"
HEX = "center='0 0' pitch='1'"

CASES: dict[str, tuple[str, int, tuple[str, ...]]] = {
    # The file
    "no XML": ("cell 1 -3", 1, ("is not XML",)),
    "cut short": ("<geometry>\n<surface id='1'", 2, ("is not XML",)),
    "crossed tags": ("<geometry>\n<a><b></a></b></geometry>", 2, ("is not XML", "mismatched tag")),
    "empty": ("", 1, ("is not XML", "no element found")),
    "another root": ("<settings/>", 1, ("is <settings>, not <geometry> or <model>",)),
    "a model without geometry": ("<model>\n<materials/></model>", 1, ("holds 0 <geometry> elements",)),
    "no cells": (geometry(), 1, ("geometry: holds no cells",)),
    "unknown encoding": ("<?xml version='1.0' encoding='klingon'?><geometry/>", 0, ("is not XML", "klingon")),
    # Surfaces
    "torus": (geometry("<surface id='x' type='z-torus' coeffs='0 0 0 5 1 1'/>", "<cell id='1' material='1'/>"), 3, ("surface: id must be an integer, got 'x'",)),
    "unknown type": (surface("type='w-plane' coeffs='0'"), 3, ("surface 9 'odd': type must be one of x-plane,", "got 'w-plane'")),
    "no type": (surface("coeffs='0'"), 3, ("needs the attribute or element 'type'",)),
    "no coefficients": (surface("type='plane'"), 3, ("needs the attribute or element 'coeffs'",)),
    "too few numbers": (surface("type='plane' coeffs='1 2 3'"), 3, ("coeffs must be 4 numbers, got 3",)),
    "too many numbers": (surface("type='x-plane' coeffs='1 2'"), 3, ("coeffs must be 1 number, got 2",)),
    "no number": (surface("type='x-plane' coeffs='1,5'"), 3, ("coeffs must be a number, got '1,5'",)),
    "NaN": (surface("type='x-plane' coeffs='nan'"), 3, ("coeffs must be a number, got 'nan'",)),
    "infinity": (surface("type='x-plane' coeffs='inf'"), 3, ("coeffs must be a number, got 'inf'",)),
    "overflow": (surface("type='x-plane' coeffs='1e999'"), 3, ("in the range of double precision, got '1e999'",)),
    "absurd exponent": (surface("type='x-plane' coeffs='1e-999999999'"), 3, ("in the range of double precision",)),
    "radius": (surface("type='sphere' coeffs='0 0 0 -2'"), 3, ("coeffs: the radius must be >= 0, got -2",)),
    "cone": (surface("type='x-cone' coeffs='0 0 0 0'"), 3, ("coeffs: the R² must be > 0, got 0",)),
    "no normal": (surface("type='plane' coeffs='0 0 0 1'"), 3, ("a normal (A, B, C) that is not zero",)),
    "constant quadric": (surface("type='quadric' coeffs='0 0 0 0 0 0 0 0 0 1'"), 3, ("more than the constant K",)),
    "boundary": (surface("type='x-plane' coeffs='0' boundary='sticky'"), 3, ("boundary must be one of", "got 'sticky'")),
    "a number taken twice": (geometry("<surface id='2' type='x-plane' coeffs='0'/>", "<cell id='1' material='1'/>"), 3, ("surface 2: id 2 is taken by another surface",)),
    "no id": (geometry("<surface type='x-plane' coeffs='0'/>"), 3, ("surface: needs the attribute or element 'id'",)),
    "id": (geometry("<surface id='one' type='x-plane' coeffs='0'/>"), 3, ("surface: id must be an integer, got 'one'",)),
    # Cells
    "unknown surface": (cell("material='1' region='-1 77'"), 3, ("cell 5 'odd': region refers to unknown surface 77",)),
    "unknown surfaces": (cell("material='1' region='-1 77 | 78'"), 3, ("region refers to unknown surfaces 77, 78",)),
    "open parenthesis": (cell("material='1' region='(-1 2'"), 3, ("cell 5 'odd': region: a ')' is missing",)),
    "region": (cell("material='1' region='-1 x'"), 3, ("cell 5 'odd': region: 'x' is no half-space",)),
    "neither material nor fill": (cell("region='-1'"), 3, ("needs either a material or a fill, got neither",)),
    "both": (cell("material='1' fill='2'"), 3, ("needs either a material or a fill, got both",)),
    "no materials": (cell("material=''"), 3, ("material must be an integer, 'void', or several of these, got nothing",)),
    "material": (cell("material='fuel'"), 3, ("material must be an integer, got 'fuel'",)),
    "unknown fill": (cell("fill='7'"), 3, ("cell 5 'odd': fill 7 is neither a universe nor a lattice",)),
    "filled with itself": (cell("universe='3' fill='3'"), 3, ("is filled with the universe 3 that it is in",)),
    "moved material": (cell("material='1' translation='1 0 0'"), 3, ("is translated, but not filled",)),
    "turned material": (cell("material='1' rotation='1 0 0'"), 3, ("is rotated, but not filled",)),
    "translation": (cell("fill='2' translation='1 0'", "<cell id='1' universe='2' material='1'/>"), 3, ("translation must be 3 numbers, got 2",)),
    "rotation": (cell("fill='2' rotation='1 0'", "<cell id='1' universe='2' material='1'/>"), 3, ("rotation must be 3 or 9 numbers, got 2",)),
    "singular rotation": (cell("fill='2' rotation='1 0 0 1 0 0 0 0 1'", "<cell id='1' universe='2' material='1'/>"), 3, ("can be inverted",)),
    "old form": (cell("material='1' surfaces='-1 2'"), 3, ("has `surfaces`, an old form",)),
    "cell twice": (cell("material='1'", "<cell id='5' material='1'/>"), 4, ("cell 5: id 5 is taken by another cell",)),
    "mesh": (geometry("<dagmc_universe id='x' filename='a.h5m'/>", "<cell id='1' material='1'/>"), 3, ("universe: id must be an integer, got 'x'",)),
    # Lattices
    "shape": (lattice(f"dimension='3' {RECT} universes='1 1 1'"), 3, ("lattice 4 'odd': dimension must be two or three integers > 0, got '3'",)),
    "no elements": (lattice(f"dimension='0 3' {RECT} universes=''"), 3, ("dimension must be two or three integers > 0",)),
    "too few universes": (lattice(f"dimension='2 2' {RECT} universes='1 1 1'"), 3, ("a lattice of 2 x 2 needs 4, got 3",)),
    "a huge lattice": (lattice(f"dimension='100000 100000' {RECT} universes='1'"), 3, ("needs 10000000000, got 1",)),
    "pitch": (lattice("dimension='1 1' lower_left='0 0' pitch='1 0' universes='1'"), 3, ("pitch must be > 0, got 0",)),
    "lower left": (lattice("dimension='1 1' lower_left='0 0 0' pitch='1 1' universes='1'"), 3, ("lower_left must be 2 numbers, got 3",)),
    "unknown universe": (lattice(f"dimension='1 2' {RECT} universes='1 8'"), 3, ("lattice 4 'odd': refers to unknown universe 8",)),
    "unknown outer": (lattice(f"dimension='1 1' {RECT} universes='1' outer='8'"), 3, ("refers to unknown universe 8",)),
    "rings": (lattice(f"n_rings='2' {HEX} universes='1 1 1'", "hex_lattice"), 3, ("a hexagonal lattice of 2 rings needs 7, got 3",)),
    "no rings": (lattice(f"n_rings='0' {HEX} universes='1'", "hex_lattice"), 3, ("n_rings and n_axial must be > 0, got 0",)),
    "absurd rings": (lattice(f"n_rings='99999999999' {HEX} universes='1'", "hex_lattice"), 3, ("got 1",)),
    "orientation": (lattice(f"n_rings='1' {HEX} orientation='z' universes='1'", "hex_lattice"), 3, ("orientation must be x or y, got 'z'",)),
    "levels": (lattice("n_rings='1' n_axial='1' center='0 0' pitch='1 1' universes='1'", "hex_lattice"), 3, ("center must be 3 numbers, got 2",)),
    # Together
    "a circle": (geometry("<cell id='1' universe='1' fill='2'/>", "<cell id='2' universe='2' fill='3'/>", "<cell id='3' universe='3' fill='1'/>", "<cell id='4' fill='1'/>"), 1, ("universe 1 → universe 2 → universe 3 → universe 1",)),
    "two roots": (geometry("<cell id='1' universe='1' material='1'/>", "<cell id='2' universe='2' material='1'/>"), 1, ("no single root universe: universes 1, 2 fill nothing",)),
    "no root": (geometry("<cell id='1' universe='1' fill='2'/>", "<cell id='2' universe='2' fill='1'/>"), 1, ("universes that contain themselves",)),
    "endless outer universe": (geometry("<cell id='1' universe='1' material='1' region='-2'/>", "<lattice id='4' dimension='1 1' lower_left='0 0' pitch='1 1' outer='1' universes='1'/>", "<cell id='7' fill='4' region='-1'/>"), 5, ("cell 7: must be bounded on all sides", "outer universe 1 of lattice 4")),
}  # fmt: skip
