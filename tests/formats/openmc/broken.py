"""Geometries with mistakes: name -> (content, line, phrases that the message must hold). Line 0 is no line."""

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
