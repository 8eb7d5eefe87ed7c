"""Declarations of kernels for the door: the build refuses a kernel with an incomplete one."""

from __future__ import annotations

import re

import pytest

from conicoid._jit.decorators import DECLARED, kernel
from conicoid.kernels.tables import Floats, Geometry, Ints
from native.signature import declared, signature


def lengths(a: Floats, b: Floats, begin: int, end: int) -> None: ...


def of_tables(geometry: Geometry, bodies: Ints) -> int: ...


def without_tables(bodies: Ints) -> int: ...


def test_every_kernel_has_a_complete_signature():
    assert len(declared()) > 40


OF_ANY_LENGTH = {
    "integers": "the geometry's tables: `places`, whose length is tested, says where each begins and ends",
    "floats": "the same",
    "lights": "every row is one light, and all are read from the first to the last",
    "rows": "of spans: read as far as they go, or of materials: looked up by `row_of` and `face_row`, made with them; "
    "of surroundings: made with their `height`",
    "values": "of albedos: rows of materials, made with them",
    "means": "the same",
    "records": "of sources: all are read from the first to the last, or looked up by `source_of`, made with them",
    "source_of": "read where there is any: it is as long as there are bodies",
    "triangles": "of lamps: looked up by `records`, made with them",
    "columns": "of surroundings: made with their `width` and `height`, which are 0 where there are none",
    "face_row": "read only within its length; what is in it are rows of materials, made with it",
    "frames": "looked up by `body_frame`, made with it",
    "spheres": "what rounding took from records: of those beyond its end, nothing",
    "boxes": "of entries: looked up by `tree_order`, made with them",
    **dict.fromkeys(
        ("code", "numbers", "constants", "series", "inputs", "wide_in", "wide_out"),
        "of a tape: what its code looks up in them is tested before it is played (`tape.interpreter.fits`)",
    ),
    "quadrics": "what rounding took from quadrics: of those beyond its end, nothing",
    "textures": "rows of textures: looked up by materials and other textures, made with them",
    "texels": "of pictures: looked up by the textures that they belong to, made with them",
    "squares": "which squares of a film are wanted: read only within its length",
    "counts": "a table that is counted through, as large as it is",
    "weights": "of line integrals: looked up only within its length",
}
"""Tables whose length no other argument gives, and the reason why no row beyond their end is read."""


def test_a_table_of_any_length_has_a_reason():
    found = {
        leaf.name.rpartition(".")[2]
        for each in declared()
        for leaf in each.leaves
        if leaf.kind == "array" and None in leaf.lengths
    }
    assert found == OF_ANY_LENGTH.keys()


def test_foreign_kernels_are_ignored():
    kernel()(without_tables)  # its declaration is too short for a door
    assert without_tables.__name__ not in DECLARED


@pytest.mark.parametrize(
    ("function", "shapes"),
    [
        (lengths, dict(a="n 3", b="n|1", begin="0..end", end="0..n")),
        (lengths, dict(a="8*n", b="out 2*n+8", begin="0..end", end="0..n-1")),
        (lengths, dict(a="*", b="end-begin", begin="0..end")),
        (of_tables, dict(bodies="out body_face")),
    ],
)
def test_a_complete_signature_is_accepted(function, shapes):
    assert signature(function, shapes).name == function.__name__


@pytest.mark.parametrize(
    ("function", "shapes", "message"),
    [
        (lengths, dict(a="n 3"), "b: an array needs a shape"),
        (lengths, dict(a="n", b="m|1"), "lengths: no argument gives m"),
        (lengths, dict(a="n", b="n", end="0..count"), "lengths: no argument gives count"),
        (lengths, dict(a="n+1", b="*"), "lengths: no argument gives n"),
        (lengths, dict(a="n", b="n", last="0..n"), "lengths: there is no parameter last"),
        (lengths, dict(a="n", b="n+begin+end"), "a length is a sum of at most two names"),
        (lengths, dict(a="n", b="n?"), "no length: 'n?'"),
        (lengths, dict(a="n 1 1 1", b="n"), "lengths: arrays have at most 3 dimensions"),
        (without_tables, dict(bodies="body_face"), "without_tables: no argument gives body_face"),
    ],
)  # fmt: skip
def test_untestable_arguments_are_refused(function, shapes, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        signature(function, shapes)
