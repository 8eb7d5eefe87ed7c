"""Planes of a cell in pairs: slabs, worked out as the ray tracing notes do with a box."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

from . import sources
from .blocks import Block
from .blocks import Line as Words
from .line import Line
from .numbers import as_float, dot, rounded
from .steps import Board, FaceStep

_PARALLEL = 1e-12
Slab: TypeAlias = tuple[str, Fraction, Fraction, Fraction, Fraction]
"""A name, low <= n·p <= high, n·o and n·d."""


def slab_pairs(faces: Sequence[FaceStep]) -> list[tuple[int, int]]:
    """Which planes are two sides of a slab: (the one with the lower offset along the axis, the other)."""
    flat = [k for k, face in enumerate(faces) if face.surface.flat]
    pairs: list[tuple[int, int]] = []
    for k, i in enumerate(flat):
        for j in flat[k + 1 :]:
            used = {each for pair in pairs for each in pair}
            if i not in used and j not in used and _opposite(outward(faces[i]), outward(faces[j])):
                low, high = (i, j) if _leads(outward(faces[j])) else (j, i)
                pairs.append((low, high))
    return pairs


def outward(face: FaceStep) -> list[Fraction]:
    """The outward normal of a plane, of any length."""
    return [2 * face.inside * half for half in face.surface.polynomial.ten[6:9]]


def _leads(normal: Sequence[Fraction]) -> bool:
    """Is the first component that counts positive?"""
    largest = max(map(abs, normal))
    return next(c for c in normal if abs(c) > _PARALLEL * largest) > 0


def _opposite(m: Sequence[Fraction], n: Sequence[Fraction]) -> bool:
    along = as_float(dot(m, n))
    return along < 0 and as_float(dot(m, m)) * as_float(dot(n, n)) - along * along <= _PARALLEL * along * along


def slabs_board(pairs: Sequence[tuple[int, int]], faces: Sequence[FaceStep], line: Line) -> Board:
    """The slabs of a cell, one after the other."""
    return worked_out([_slab(faces[i], faces[j], line, k) for k, (i, j) in enumerate(pairs)], line)


def worked_out(slabs: Sequence[Slab], line: Line) -> Board:
    """t_near and t_far after each slab, until one of them says that there is no hit."""
    words: list[Block] = []
    numbers: dict[str, float] = {}
    near: Fraction | None = None
    far: Fraction | None = None
    for name, low, high, at, slope in slabs:
        source = sources.BOX if not words else ""
        limits = f"{name}: {rounded(low)} to {rounded(high)}, origin {rounded(at)}, direction {rounded(slope)}"
        if not slope:
            outside = at < low or at > high
            told_of = "outside: no hit" if outside else "between the planes for all t"
            words.append(Words(f"{limits}: parallel, {told_of}", source, 2))
            if outside:
                return Board(tuple(words), numbers)
            continue
        t1, t2 = (low - at) / slope, (high - at) / slope
        first, last = min(t1, t2), max(t1, t2)
        near = first if near is None else max(near, first)
        far = last if far is None else min(far, last)
        numbers |= {f"{name} t1": as_float(t1), f"{name} t2": as_float(t2)}
        numbers |= {"t_near": as_float(near), "t_far": as_float(far)}
        swapped = ", swapped" if t2 < t1 else ""
        words.append(Words(f"{limits}: t₁ = {rounded(t1)}, t₂ = {rounded(t2)}{swapped}", source, 2))
        words.append(Words(f"t_near = {rounded(near)}, t_far = {rounded(far)}", "", 3))
        if near > far:
            words.append(Words("t_near > t_far: no hit", "", 3))
            return Board(tuple(words), numbers)
        if far < 0 <= line.t_min:
            words.append(Words("t_far < 0: it lies behind the origin", "", 3))
            return Board(tuple(words), numbers)
    if near is not None:
        words.append(Words("all slabs have t_near ≤ t_far: a hit", "", 2))
    return Board(tuple(words), numbers)


def _slab(low: FaceStep, high: FaceStep, line: Line, k: int) -> Slab:
    """(name, low <= n·p <= high, n·o, n·d); along an axis n is the axis."""
    normal = outward(high)
    axes = [i for i in range(3) if normal[i]]
    scale = abs(normal[axes[0]]) if len(axes) == 1 else Fraction(1)
    normal = [value / scale for value in normal]
    name = "xyz"[axes[0]] if len(axes) == 1 else f"slab {k + 1}"
    top = -high.inside * high.surface.polynomial.ten[9] / scale
    other = outward(low)
    length = math.sqrt(as_float(dot(other, other)) / as_float(dot(normal, normal)))
    ratio = Fraction(length) if len(axes) != 1 else abs(other[axes[0]])
    bottom = low.inside * low.surface.polynomial.ten[9] / ratio
    return name, bottom, top, dot(normal, line.origin), dot(normal, line.direction)
