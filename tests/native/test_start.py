"""Imports of a process before its first answer, where the package has machine code: only necessary ones."""

import pytest

from ..children import ROOT, child
from ..machine_code import needs_machine_code

pytestmark = needs_machine_code

BARREL = ROOT / "examples" / "scenes" / "barrel.yaml"

COMPILING = "numba llvmlite conicoid._jit.compiler conicoid.scene.warmup"
PROCESSES = "subprocess multiprocessing socket selectors asyncio concurrent.futures"
TERMINAL = "rich typer click argparse"
FILES = "yaml PIL OpenEXR defusedxml conicoid.io.scene_file conicoid.io.npz tempfile pathlib logging"
NUMBERS = "mpmath numpy.ma numpy.random"
WORDS = "difflib string secrets"
OTHER_ANSWERS = "conicoid.queries.spans conicoid.queries.exact.doubtful_rays conicoid.queries.exact.hit_sides"
OTHER_FORMATS = "conicoid.io.molecules.importer conicoid.io.molecules.atoms conicoid.io.openmc.importer"
OTHER_SHAPES = "conicoid.geometry.polyhedron conicoid.geometry.general_quadric conicoid.geometry.revolution"

FIRST_HIT = "co.Scene([co.Sphere()]).first_hit((0, 0, -3), (0, 0, 1)).t"
MOVED = "co.Scene([co.Cylinder((0, 0, 0), (0, 0, 1), 1).rotate((0, 0, 1), 90) - co.Box()]).spans((0, 0, -3), (0, 0, 1)).lengths()"
EDITED = (
    "s = co.Scene([co.Sphere(1, (3.0 * k, 0, 0)) - co.Box() for k in range(20)]); s.prepare(); "
    "s.moved(7, (0, 0, 0.1)).first_hit((0.3, 0.1, -3), (0, 0, 1)).t"
)
PICTURE = "co.Scene([co.Sphere()]).render(16, 16).pixels"
COMMAND = (
    "from conicoid.cli import terminal, resources; terminal.PATIENCE = resources.PATIENCE = float('inf'); "
    "from conicoid.cli.app import app; app(sys.argv[1:], standalone_mode=False)"
)
"""A command with infinite patience, because a slow machine takes longer than a second."""
RENDER = "render", BARREL, "-o", "o.png", "--width", "16", "--height", "16"

PROGRAM = """
import sys
import numpy
before = set(sys.modules)
import conicoid as co
{work}
print(*sorted(set(sys.modules) - before))
"""


def imports_of(work: str, folder, *words: object) -> set[str]:
    """Return the modules that some work imports, besides NumPy and its own imports."""
    with child(PROGRAM.format(work=work), *words, cwd=folder) as running:
        code, out, errors = running.end(60)
    assert code == 0, errors
    return set(out.splitlines()[-1].split())


@pytest.mark.parametrize(
    ("work", "without"),
    [
        (FIRST_HIT, (COMPILING, PROCESSES, TERMINAL, FILES, NUMBERS, WORDS, OTHER_SHAPES, OTHER_ANSWERS)),
        (EDITED, (COMPILING, PROCESSES, TERMINAL, FILES, NUMBERS, WORDS, OTHER_ANSWERS)),
        (MOVED, (COMPILING, PROCESSES, TERMINAL, FILES, NUMBERS, WORDS)),
        (PICTURE, (COMPILING, PROCESSES, TERMINAL, FILES, NUMBERS, WORDS)),
        (f"{PICTURE}; co.Image(numpy.zeros((2, 2, 3))).save('o.png')", (COMPILING, TERMINAL, "yaml PIL OpenEXR multiprocessing", NUMBERS)),
    ],
)  # fmt: skip
def test_unneeded_modules_are_not_imported(tmp_path, work, without):
    found = imports_of(work, tmp_path)
    assert found & set(" ".join(without).split()) == set()


def test_a_command_draws_no_bar_before_a_second_is_over(tmp_path):
    found = imports_of(COMMAND, tmp_path, *RENDER)
    assert found & set(f"{COMPILING} {NUMBERS} {OTHER_ANSWERS} {OTHER_FORMATS} rich multiprocessing".split()) == set()
    assert (tmp_path / "o.png").exists()


def test_odd_angles_import_no_mpmath(tmp_path):
    there = imports_of(MOVED.replace("90", "10"), tmp_path)
    assert "conicoid.numerics.bigfloat" in there
    assert "mpmath" not in there


def test_scene_files_know_all_shapes(tmp_path):
    assert set(OTHER_SHAPES.split()) <= imports_of(
        "from conicoid.geometry.registry import REGISTRY; list(REGISTRY)", tmp_path
    )


def test_a_scene_file_imports_the_shapes_that_it_has(tmp_path):
    found = imports_of("co.load(sys.argv[1])", tmp_path, BARREL)
    assert "conicoid.geometry.quadrics" in found
    others = {"conicoid.geometry.general_quadric", "conicoid.geometry.revolution", "conicoid.geometry.polyhedron"}
    assert found & {"logging", "secrets", "PIL", *others} == set()
