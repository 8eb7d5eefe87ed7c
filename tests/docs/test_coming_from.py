"""The page "Coming from another program" names only what exists: functions, arguments, methods and fields."""

from __future__ import annotations

import ast
import inspect
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conicoid as co

PAGE = Path(__file__).resolve().parents[2] / "docs" / "coming-from.md"
ROW = re.compile(r"^\| (.+?) \| (.+?) \|$", re.MULTILINE)
CODE = re.compile(r"`([^`]+)`")


def snippets() -> list[str]:
    """Return the code in the right-hand column of every table."""
    rows = ROW.findall(PAGE.read_text(encoding="utf-8").replace("\\|", "∪"))
    return sorted({code.replace("∪", "|") for _, right in rows for code in CODE.findall(right)})


@pytest.fixture(scope="module")
def things() -> dict[str, Any]:
    """Return an example of every name that the tables use."""
    a, b = co.Sphere(1), co.Box((0, 0, 0), (2, 2, 2))
    material = co.Material(properties={"density": 1.0})
    body = co.Body(a, material, "ball")
    scene = co.Scene([body])
    rays = co.Rays([(-3, 0, 0), (-3, 0, 0.5)], (1, 0, 0))
    lens = co.optics.prescription([(50, 6, "N-BK7"), (-50, None)], aperture=10)
    return {
        "co": co, "np": np, "a": a, "b": b, "solid": a, "body": body, "material": material, "scene": scene, "rays": rays,
        "hits": scene.first_hit(rays), "spans": scene.spans(rays), "crossings": scene.crossings(rays), "lens": lens,
        "image": co.Image(np.zeros((2, 2, 3))),
    }  # fmt: skip


def test_tables_have_their_rows():
    """Every program has a table of 8 to 18 rows."""
    text = PAGE.read_text(encoding="utf-8")
    for section in text.split("\n## ")[1:]:
        rows = len(ROW.findall(section.replace("\\|", "∪"))) - 1
        assert 8 <= rows <= 18, section.partition("\n")[0]


def test_right_hand_sides_exist(things: dict[str, Any]):
    """Every attribute of the code exists, and every call has arguments that the function takes."""
    codes = [code for code in snippets() if re.match(r"(co|[a-z]+)\.|[~-]", code)]
    for node in (node for code in codes for node in ast.walk(ast.parse(code, mode="eval"))):
        if isinstance(node, ast.Attribute):
            found(node, things)
        if isinstance(node, ast.Call) and (function := found(node.func, things)) is not None:
            keywords = {keyword.arg: None for keyword in node.keywords if keyword.arg}
            inspect.signature(function).bind(*node.args, **keywords)


def found(node: ast.expr, things: dict[str, Any]) -> Any:
    """Return the object that a dotted name means; None for the results of calls, which are not computed."""
    if isinstance(node, ast.Name):
        return things.get(node.id)
    if isinstance(node, ast.Attribute):
        owner = found(node.value, things)
        return None if owner is None else getattr(owner, node.attr)
    return None
