"""The table of what mirrors what is complete, in the tests and in the documentation."""

from __future__ import annotations

import re
from pathlib import Path

from conicoid.viewer import html

from .mirrors import bodies, cells, looks, surfaces
from .mirrors.markdown import PAGE, tables, written
from .mirrors.table import MIRRORS, NO_MIRROR, OTHER_NAMES, python_name

SHADERS = Path(html.__file__).parent / "shaders"
FUNCTION = re.compile(r"^\w+ (\w+)\([^;{]*\) \{", re.MULTILINE)
CASES = surfaces.CASES | cells.CASES | bodies.CASES | bodies.DEAR_CASES | looks.CASES


def functions():
    return {name for path in SHADERS.glob("*.glsl") for name in FUNCTION.findall(path.read_text(encoding="utf-8"))}


def test_every_function_is_in_the_table():
    """Either with what it mirrors or with why it mirrors nothing; and nothing else is there."""
    assert functions() == MIRRORS.keys() | NO_MIRROR.keys()
    assert not MIRRORS.keys() & NO_MIRROR.keys()
    assert all(NO_MIRROR.values())


def test_every_file_is_a_piece_of_a_shader():
    assert {path.stem for path in SHADERS.glob("*.glsl")} == html.shaders()["pieces"].keys()


def test_every_mirror_is_tried():
    """By a case of its own name, or by the one that the table names, which calls it."""
    for name, mirror in MIRRORS.items():
        assert (mirror.case or name) in CASES, name
    assert {name.partition(",")[0] for name in CASES} <= MIRRORS.keys()


def test_the_names_are_pythons():
    """Where a function has its own case, so is all of a function of Python; other names have a reason."""
    for name, mirror in MIRRORS.items():
        names = {python_name(function).rpartition(".")[2] for function in mirror.python}
        if not mirror.case and name not in OTHER_NAMES:
            assert name in names, f"{name} mirrors {names}"
    assert MIRRORS.keys() >= OTHER_NAMES.keys()


def test_the_documentation_has_the_table():
    """`python -m tests.viewer.mirrors.markdown` writes it anew."""
    text = PAGE.read_text(encoding="utf-8")
    assert text == written(text)
    assert tables() in text
