"""OpenMC's cell elements."""

from __future__ import annotations

from fractions import Fraction

from .geometry import Cell
from .placement import ORIGIN, STRAIGHT, Point, Rotation, departure, rotation_by_angles, rotation_by_matrix
from .region import MAX_HALF_SPACES, Region, parse_region
from .values import Values
from .xml_tree import Element


def read_cell(element: Element, most: int = MAX_HALF_SPACES) -> Cell:
    """A cell whose region has at most so many half-spaces. Raises Mistake."""
    values = Values(element, "cell")
    number, name = values.title()
    materials = values.attempt(lambda: _materials(values), ())
    fill = values.attempt(lambda: values.optional_integer("fill"), None)
    is_filled = values.text("fill") is not None
    if is_filled == (values.text("material") is not None):
        values.tell(f"needs either a material or a fill, got {'both' if is_filled else 'neither'}")
    universe = values.attempt(lambda: values.optional_integer("universe"), None) or 0
    if fill is not None and fill == universe:
        values.tell(f"is filled with the universe {fill} that it is in")
    region = values.attempt(lambda: _region(values, most), None)
    rotation, skew = values.attempt(lambda: _rotation(values), (STRAIGHT, 0.0))
    translation = values.attempt(lambda: _translation(values), ORIGIN)
    if values.text("material") is not None and not is_filled:
        for what, attribute in (("rotated", "rotation"), ("translated", "translation")):
            if values.text(attribute) is not None:
                values.tell(f"is {what}, but not filled with a universe or lattice")
    values.finish()
    return Cell(number, name, universe, region, fill, materials, translation, rotation, skew, element)


def _region(values: Values, most: int) -> Region | None:
    if values.text("surfaces") is not None:
        raise values.mistake("has `surfaces`, an old form: write `region`")
    region = values.text("region")
    try:
        return parse_region(region, most) if region else None
    except ValueError as error:
        raise values.mistake(str(error)) from None


def _materials(values: Values) -> tuple[int | None, ...]:
    words = values.words("material")
    if words is None:
        return ()
    if not words:
        raise values.mistake("material must be an integer, 'void', or several of these, got nothing")
    integer = values.integer_word
    return tuple(None if word.lower() == "void" else integer("material", word) for word in words)


def _translation(values: Values) -> Point:
    if values.text("translation") is None:
        return ORIGIN
    x, y, z = values.numbers("translation", 3)
    return x, y, z


def _rotation(values: Values) -> tuple[Rotation, float]:
    """By three angles or nine entries, row by row; and how far those are from a rotation."""
    if values.text("rotation") is None:
        return STRAIGHT, 0.0
    numbers: tuple[Fraction, ...] = values.numbers("rotation", 3, 9)
    try:
        if len(numbers) == 3:
            x, y, z = numbers
            return rotation_by_angles((x, y, z)), 0.0
        a, b, c, d, e, f, g, h, i = numbers
        rows = ((a, b, c), (d, e, f), (g, h, i))
        rotation = rotation_by_matrix(rows)
        if rotation is None:
            raise values.mistake("rotation must be a matrix that can be inverted, its determinant is 0")
        return rotation, departure(rows)
    except OverflowError:
        raise values.mistake("rotation must be in the range of double precision, and so its inverse") from None
    except ValueError as error:
        raise values.mistake(f"rotation cannot be expressed in double precision: {error}") from None
