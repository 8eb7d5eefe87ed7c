"""Small geometries in OpenMC's format, each for a part that an importer can get wrong."""

import functools
from pathlib import Path

import conicoid as co

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
