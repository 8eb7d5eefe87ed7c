"""The public face of the package: small, explicit, documented, and light to import."""

import importlib
import inspect
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

import conicoid as co

ROOT = Path(__file__).resolve().parent.parent

PROMISED = """
Sphere Ellipsoid Box Cylinder Cone DoubleCone EllipticParaboloid HyperbolicParaboloid OneSheetHyperboloid
TwoSheetHyperboloid EllipticCone EllipticCylinder HyperbolicCylinder ParabolicCylinder Quadric HalfSpace Polyhedron
Spheres Plane Disc Triangle Polygon CylinderPatch Scene Body Rays reflect refract Camera Image load save warmup measure
""".split()


def test_every_promised_name_is_public():
    assert set(PROMISED) <= set(co.__all__)
    for name in co.__all__:
        assert getattr(co, name) is not None


def test_the_root_stays_small():
    assert len(co.__all__) <= 110


@pytest.mark.parametrize(
    "package", "checks ct derivatives explain materials measures optics parallel scene section".split()
)
def test_every_name_of_a_public_package_is_there(package: str):
    names = getattr(co, package).__all__
    assert importlib.import_module(f"conicoid.{package}") is getattr(co, package)
    assert names
    for name in names:
        assert getattr(getattr(co, package), name) is not None


@pytest.mark.parametrize("name", PROMISED)
def test_public_names_are_documented(name: str):
    item = getattr(co, name)
    assert inspect.getdoc(item)
    if inspect.isclass(item):
        methods = [m for k, m in inspect.getmembers(item, inspect.isfunction) if not k.startswith("_")]
        for method in methods:
            assert inspect.getdoc(method), f"{name}.{method.__name__} has no docstring"


def test_version_is_that_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert co.__version__ == project["version"]
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == project["version"]
    assert citation["license"] == project["license"]


def test_import_and_scenes_need_no_compiler():
    code = "import sys, conicoid as co; co.Scene([co.Sphere()]).bounds; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_nothing_is_printed_or_written_at_import(tmp_path: Path):
    ran = subprocess.run(
        [sys.executable, "-B", "-W", "error", "-c", "import conicoid"],
        cwd=tmp_path,
        env={"PYTHONPATH": str(ROOT), "HOME": str(tmp_path), "PATH": "/usr/bin:/bin"},
        capture_output=True,
        check=True,
    )
    assert ran.stdout == ran.stderr == b""
    assert list(tmp_path.iterdir()) == []


def test_package_is_typed():
    assert (Path(co.__file__).parent / "py.typed").exists()
