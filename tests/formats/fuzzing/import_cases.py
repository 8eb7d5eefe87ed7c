"""Files of other programs, damaged in words, numbers, lines, elements and bytes: readers take them, or refuse by name."""

import importlib
import re
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from random import Random

from conicoid._util.files import SceneFileError
from conicoid.io.importers import ImportOptions, ImportResult
from conicoid.io.scene_file import scene_file

from ..gdml import files as gdml, test_solids
from ..mcnp import models as mcnp
from ..mcnp.test_reading import PIN
from ..molecules.test_molecules import CIF, PDB, SALT, XYZ
from ..openmc import models as openmc
from ..scad.test_scad import CASES
from .mutations import NUMBERS, bytes_damaged, text_damaged

MOST_BODIES = 500
SOLIDS = {**test_solids.SOLIDS, **{f"twisted {name}": each for name, each in test_solids.TWISTED.items()}}
NAMES = (
    "a\nb",
    "x\rfake  material 9",
    "\x9b31m",
    "\u202eevil",
    "\u2028",
    "🙂",
    "'",
    '"',
    "\\",
    "x" * 5000,
    "a' @ cell 9",
    "\t",
)
MATERIALS = '<materials><material id="1" name="{}"/><material id="2"/><material id="3" name="water"/></materials>'
WORDS = {
    "openmc": (
        "-1", "0", "7", "99", "nan", "x", "void", "|", "~", "(", ")", "&amp;", "-3 4", "", "z-plane", "sphere", "quadric", "z-torus", "y",
        "fill", "region", "universe", "9" * 30, "\u2029", "<cell/>", "dimension", "pitch", "lower_left", "universes", "outer", "n_rings",
        "n_axial", "center", "translation", "rotation", "coeffs", "material", "id", "name", "type", "boundary", "lattice", "hex_lattice",
    ),
    "mcnp": (
        "0", "-1", "7", "99", "nan", "x", "(", ")", ":", "#", "#1", "&", "$", "3r", "r", "2i", "5j", "1e9r", "999999999r", "lat=1", "lat=2",
        "u=1", "u=2", "fill=1", "fill=2", "fill=0:1 0:1 0:0", "trcl=1", "*trcl=(1 2 3 4 5 6)", "like 1 but", "imp:n=0", "mat=1", "rho=-1",
        "tz", "so", "gq", "rpp", "hex", "arb", "k/z", "1.1", "-10.3", "1" * 500, "\u2029", "message:", "read", "-999999:999999", "tr1",
        "*tr2", "m1", "c", "=", "\x00", "é",
    ),
    "gdml": (
        "-1", "0", "2", "nan", "x", "world", "pi", "deg", "(", ")", "^", "[1]", "m[9]", "&amp;", "", "/", "*", "i", "box", "ref", "cm",
        "9" * 30, "<box/>", '"', "file", "loop", "1e-320", "s1", "'", "\x00", "é", "\u2028", "&",
    ),
    "molecules": ("0", "9", "-", ".", "e", "E", "\n", "\t", "x", '"', "'", "#", "_", "\0", "é"),
    "openscad": ("0", "9", "-", ".", "e", "[", "]", "(", ")", "{", "}", ";", ",", "=", "\n", '"', "'", "#", "%", "!", "*", "_", "\0", "é"),
}  # fmt: skip


def openmc_text(random: Random) -> str:
    text = random.choice([*openmc.TEXTS.values(), openmc.EXAMPLE_FILES["pin"].read_text(encoding="utf-8")])
    if "<model" in text or random.random() < 0.6:
        return text
    name = re.sub(r"\s", lambda found: f"&#{ord(found[0])};", random.choice(NAMES).replace('"', ""))
    return f"<model>{MATERIALS.format(name)}{text.strip()}</model>"


def gdml_text(random: Random) -> str:
    """Return some solids, placed, and in a loop."""
    solids, inside, structure = '<box name="w" x="200" y="200" z="200"/>', "", ""
    slices = '<divisionvol axis="kZAxis" number="3" width="0" offset="0" unit="mm"><volumeref ref="v0"/></divisionvol>'
    for k, name in enumerate(random.sample(sorted(SOLIDS), 4)):
        solids += re.sub(r'(name|ref|solid)="([abs])"', rf'\g<1>="\g<2>{k}"', SOLIDS[name][0])
        structure += gdml.volume(f"v{k}", f"s{k}", slices if k == 3 else "")
        turn = '<rotation x="90" z="30" unit="deg"/>' if k % 2 else '<scale x="1" y="-1" z="1"/>'
        inside += gdml.placed(f"v{k}", f'<position x="{25 * k}" y="0" z="0"/>{turn}')
    inside += '<loop for="i" from="1" to="2">' + gdml.placed("v0", '<position x="0" y="25*i" z="m[i]"/>') + "</loop>"
    define = test_solids.DEFINE + '<variable name="i" value="0"/><matrix name="m" coldim="1" values="1 2"/>'
    return gdml.text_of(solids, structure + gdml.volume("world", "w", inside, "air"), define)


SOURCES = {
    "openmc": (openmc_text, "geometry.xml"),
    "mcnp": (lambda random: random.choice([PIN, *(model.text for model in mcnp.MODELS.values())]), "deck.mcnp"),
    "gdml": (gdml_text, "a.gdml"),
    "molecules": (lambda random: random.choice([XYZ, PDB, CIF, SALT]), "a.xyz"),
    "openscad": (lambda random: random.choice(list(CASES)), "a.csg"),
}
"""The function that makes a text, and the name of its file."""


def elements_damaged(random: Random, text: str) -> str:
    """Leave out, repeat or exchange an element or an attribute; repeat a value, or change a name."""
    pattern = random.choice([r"<(\w+)[^<>]*/>", r'\s\w+="[^"]*"', r'(?<=")[^"<>]+(?=")'])
    found = list(re.finditer(pattern, text))
    if not found:
        return text
    one, other = random.choice(found), random.choice(found)
    numbers = " ".join(random.choices(NUMBERS[:-2], k=random.choice([1, 2, 3, 9])))
    new = random.choice(["", other[0], f"{one[0]} " * random.choice([2, 3, 50]), numbers, random.choice(NAMES)])
    return text[: one.start()] + new + text[one.end() :]


def letters_damaged(random: Random, text: str, letters: Sequence[str]) -> str:
    """Leave out, double or replace a few letters."""
    changed = list(text)
    for _ in range(random.randint(1, 6)):
        at = random.randrange(len(changed))
        changed[at] = random.choice(["", changed[at] * 2, random.choice(letters), ""])
    return "".join(changed)


def import_case(kind: str, seed: int, folder: Path) -> bool:
    """Damage a good file of a format; return whether it can be read."""
    random = Random(seed)
    make, name = SOURCES[kind]
    text = make(random)
    if "</" in text and random.random() < 0.6:
        for _ in range(random.choice([1, 1, 1, 2, 3])):
            text = elements_damaged(random, text)
    else:
        text = random.choice([text_damaged, letters_damaged])(random, text, WORDS[kind])
    data = text.encode("utf-8", "surrogatepass")
    path = folder / name
    path.write_bytes(bytes_damaged(random, data) if random.random() < 0.15 else data)
    try:
        imported = importlib.import_module(f"conicoid.io.{kind}.importer").import_file(
            path, ImportOptions(max_bodies=MOST_BODIES)
        )
    except (SceneFileError, ValueError, ImportError) as error:  # the last two concern the file as a whole
        message = str(error)
        assert all(line.isprintable() for line in message.splitlines()), ascii(message)
        assert not isinstance(error, SceneFileError) or error.problems
        assert 0 < len(message) < 20_000
        return False
    check(imported, path.with_suffix(".yaml"))
    return True


def check(imported: ImportResult, output: Path) -> None:
    """Check the scene: a scene file that gives the same scene, bounds, and printable lines."""
    for line in (*imported.notes, *map(str, imported.legend), *(body.name or "" for body in imported.bodies)):
        assert line.isprintable(), ascii(line)
    for body in imported.bodies[:20]:
        assert body.shape.bounds is not None
    try:
        scene_file.write_scene(imported, output, imported.material_names)
    except ValueError as error:
        assert "a scene file holds at most" in str(error), error
        return
    assert list(scene_file.read_scene(output).bodies) == list(imported.bodies)


IMPORTS = {kind: partial(import_case, kind) for kind in SOURCES}
