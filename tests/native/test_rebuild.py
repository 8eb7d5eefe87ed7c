"""A build of the checkout after an edit makes the functions that it changes again, and the files that copy them."""

import os
import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.children import ROOT

pytest.importorskip("numba")
pytest.importorskip("llvmlite")

from native import build

PROGRAM = """
from typing import NamedTuple
from conicoid._jit import compiler

class Pair(NamedTuple):
    a: float
    b: float

LIMIT = 3.0
def other(x): return x
other = compiler.Inner(other)
plain = lambda x: x
def function(x, unused=1):
    "A docstring."
    return other(x) * LIMIT + Pair(x, 2.0).a
{edit}
from native.memory import content
print(content(function, {{"_nrt": False}}))
"""
EDITS = {
    "a comment": (
        "def function(x, unused=1):\n    'Words.'\n    return other(x) * LIMIT + Pair(x, 2.0).a  # more",
        True,
    ),
    "the code of a function that it calls": ("other.py_func.__code__ = plain.__code__", True),
    "a number in it": ("def function(x, unused=1):\n    'Words.'\n    return other(x) * LIMIT + Pair(x, 3.0).a", False),
    "what it calls": ("def function(x, unused=1):\n    'Words.'\n    return abs(x) * LIMIT + Pair(x, 2.0).a", False),
    "a constant of its module": ("LIMIT = 4.0", False),
    "a record": ("class Pair(NamedTuple):\n    b: float\n    a: float", False),
    "how a function that it calls is compiled": ("other = compiler.Inner(other.py_func, forceinline=True)", False),
    "a default": ("function.__defaults__ = (2,)", False),
}


def content_of(edit: str) -> str:
    process = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(edit=edit)], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return process.stdout


def test_dependencies_of_a_function() -> None:
    before = content_of("")
    for name, (edit, same) in EDITS.items():
        assert (content_of(edit) == before) == same, name


class Function(NamedTuple):
    """A function of a package of three files: its calls, and whether callers copy it."""

    calls: tuple[str, ...] = ()
    copied: bool = False
    code: bytes = b""


FUNCTIONS = {
    "top.kernel": Function(("middle.large", "middle.small")),
    "middle.large": Function(("low.small",)),
    "middle.small": Function(("low.large", "low.small"), copied=True),
    "low.small": Function(copied=True),
    "low.large": Function(("outside",)),
}


def groups_of(functions: dict[str, Function]) -> dict[str, object]:
    from native import groups

    parts = [
        groups.Part(each.code or name.encode(), (name,), each.calls, each.copied, name.partition(".")[0])
        for name, each in functions.items()
    ]
    return groups.groups(
        {"kernel": {"symbol": "top.kernel", "functions": [list(functions).index("top.kernel")]}}, parts
    )


@pytest.mark.parametrize(
    ("edited", "files"),
    [
        ("top.kernel", {"top"}),
        ("middle.large", {"middle"}),
        ("middle.small", {"middle", "top"}),
        ("low.small", {"low", "middle", "top"}),
        ("low.large", {"low"}),
    ],
)
def test_files_are_made_again_that_hold_a_function_or_a_copy_of_it(edited: str, files: set[str]) -> None:
    before = groups_of(FUNCTIONS)
    after = groups_of(FUNCTIONS | {edited: FUNCTIONS[edited]._replace(code=b"edited")})
    assert {name for name in before if before[name] != after[name]} == files


def test_the_order_of_functions_changes_nothing() -> None:
    assert groups_of(FUNCTIONS) == groups_of(dict(reversed(FUNCTIONS.items())))


def test_symbols_that_other_files_call_are_visible() -> None:
    found = groups_of(FUNCTIONS)
    assert {name: group.seen for name, group in found.items()} == {
        "top": [],
        "middle": ["middle.large"],
        "low": ["low.large"],
    }
    assert [name for name, group in found.items() if group.entries] == ["top"]


MODULE = """
from typing import NamedTuple
from conicoid._jit.compiler import Inner

class Pair(NamedTuple):
    a: float
    b: float

@Inner
def leaf(x):
    return x + 1.0

@Inner
def middle(x):
    return leaf(x) * 2.0

@Inner
def top(pair):
    return middle(pair.a) - pair.b
"""
BUILD = """
import sys, types
from pathlib import Path
from native import front, memory
front.bend()
kept = memory.Memory(Path(sys.argv[1]))
kept.bend()
sys.modules["conicoid.example"] = module = types.ModuleType("conicoid.example")
exec(compile(sys.stdin.read(), "example.py", "exec"), module.__dict__)
pair = front.types.NamedTuple([front.types.float64] * 2, module.Pair)
module.top.compile((pair,))
codes = {}
front._numbers([module.top.overloads[pair,].library], codes)
kept.keep([module.top], codes)
print(*kept.compiled)
"""


@pytest.mark.deep
@pytest.mark.parametrize(
    ("before", "after", "compiled"),
    [
        ("", "", ""),
        ("x + 1.0", "x + 2.0", "leaf"),
        ("return leaf(x) * 2.0", "return leaf(x)", "middle"),
        ("return x + 1.0", "return int(x)", "leaf middle"),  # it has the type of before
        ("a: float\n    b: float", "b: float\n    a: float", "top"),
    ],
)
def test_functions_are_lowered_again_that_an_edit_changes(before: str, after: str, compiled: str, tmp_path) -> None:
    """The build runs twice: after an edit, and after none. The linked code is that of a build from the beginning."""
    assert before in MODULE

    def built(text: str) -> list[str]:
        words = [sys.executable, "-c", BUILD, str(tmp_path / "functions.pickle")]
        process = subprocess.run(words, input=text, cwd=ROOT, capture_output=True, text=True, check=True)
        return sorted(process.stdout.split())

    assert built(MODULE) == ["leaf", "middle", "top"]
    edited = MODULE.replace(before, after)
    assert built(edited) == sorted(compiled.split())
    assert built(edited) == []


ASK = """
import conicoid as co
print(co.__file__, *co.Scene([co.Sphere(1)]).first_hit([(0, 0, -3), (0, 0, 3)], (0, 0, 1)).face)
"""
FACE = "= surface, face, side"


@pytest.mark.deep
def test_a_kernel_is_edited_and_built_again(tmp_path: Path) -> None:
    """The test edits a copy of the checkout, with the objects of its last incremental build, if there was one."""
    for folder in ("conicoid", "native", "out/edited_kernels"):
        if (ROOT / folder).exists():
            left_out = shutil.ignore_patterns("__pycache__", "_kernels.*")
            shutil.copytree(ROOT / folder, tmp_path / folder, ignore=left_out)
    source = tmp_path / "conicoid/queries/hit_fields.py"
    text = source.read_text(encoding="utf-8")
    assert text.count(FACE) == 1

    def run(*words: str) -> str:
        return subprocess.check_output(
            [sys.executable, "-W", "error", *words],
            cwd=tmp_path, text=True, env=os.environ | {"PYTHONPATH": str(tmp_path)},
        )  # fmt: skip

    def built(code: str) -> tuple[list[str], set[str]]:
        source.write_text(code, encoding="utf-8")
        run("-m", "native.build", "--incremental")
        place, *faces = run("-c", ASK).split()
        assert Path(place).is_relative_to(tmp_path)
        return faces, {file.name for file in (tmp_path / "out/edited_kernels/objects").iterdir()}

    faces, objects = built(text)
    extension = next((tmp_path / "conicoid").glob("_kernels.*")).read_bytes()
    assert faces == ["0", "-1"]
    faces, others = built(text.replace(FACE, "= surface, face + 7, side"))
    assert faces == ["7", "-1"]
    assert [name.partition("-")[0] for name in others - objects] == ["conicoid.queries.hit_fields"]
    assert built(text)[0] == ["0", "-1"]
    assert next((tmp_path / "conicoid").glob("_kernels.*")).read_bytes() == extension


def test_one_build_waits_for_another(monkeypatch, tmp_path, capsys) -> None:
    monkeypatch.setattr(build, "HERE", tmp_path / "native")
    monkeypatch.setattr(build, "_LONGEST", 0)
    with build.alone(), pytest.raises(sqlite3.OperationalError, match="locked"), build.alone():
        pass
    assert "Another build of this checkout is at work" in capsys.readouterr().out
    with build.alone():
        assert not capsys.readouterr().out
