"""Templates: many bodies in one entry, with names in place of numbers and the columns of these numbers.

The oracle is the same file with each body written out, its numbers in their places.
"""

import itertools
import re
import warnings
from typing import Any

import jsonschema
import numpy as np
import pytest

import conicoid as co
from conicoid._util.records import pickle_state
from conicoid.io.scene_file import shape_reader, template
from conicoid.io.scene_file.scene_file import parse_scene
from conicoid.io.scene_file.schema import scene_schema
from conicoid.io.scene_file.writer import dump_json, format_number

from ..samples import quick, sampled
from .test_body_groups import SHAPES
from .test_broken_files import tree

COUNT = 12
BODIES = {
    "sphere": "shape: {Sphere: {radius: $a, center: [$b, $c, $d]}}, material: glossy",
    "vector": "shape: {Sphere: {radius: $a, center: $v}}, material: red",
    "ellipsoid": "shape: {Ellipsoid: {radii: [$a, $b, $c], z_range: [-0.5, $d]}}",
    "moved": "shape: block, move: [{scale: $a}, {translate: $v}]",
    "moved again": "shape: egg, move: [{scale: [$a, 2, $b]}, {rotate: {axis: z, degrees: $c}}]",
    "turned": "shape: {Box: {}}, move: [{rotate: {axis: [$a, $b, $c], degrees: $d}}]",
    "turned about": "shape: {Box: {}}, move: [{rotate: {axis: y, degrees: 30, about: [1, 2, 3]}}, {scale: $a}]",
    "turned about a point": "shape: {Box: {}}, move: [{rotate: {axis: y, degrees: 30, about: $v}}]",
    "carried": "shape: ball, move: [{transform: [[$a, 0, 0, $b], [0, $c, 0, $d], [0, 0, 1, 0], [0, 0, 0, 1]]}]",
    "matrix": "shape: ball, move: [{transform: $m}]",
    "operands": (
        "shape: {Difference: [{Sphere: {radius: $a}}, {Box: {}, move: [{translate: [$b, 0, $c]}]}]}, move: [{scale: $d}]"
    ),
    "moved operands": "shape: {Union: [{Sphere: {}, move: [{scale: $a}]}, egg]}, move: [{translate: [1, 2, 3]}]",
    "outside": "shape: {Complement: {Sphere: {radius: $a}, move: [{scale: $b}]}}, move: [{scale: $c}]",
    "nested": "shape: {shape: {shape: egg, move: [{scale: $a}]}, move: [{scale: 2}]}, move: [{scale: $b}]",
    "cut sheet": "shape: {Difference: [{Plane: {normal: [0, 0, 1], offset: $a}}, ball]}",
    "integers": "shape: {RegularPrism: {sides: $n, radius: $a, z_range: [0, $b]}}, material: '#ff0000'",
    "painted": "shape: {Painted: {operand: {Sphere: {radius: $a}}, material: {matte: {color: [$e, 0, 1]}}}}",
    "radians": "shape: ball, move: [{rotate: {axis: x, degrees: 1.5707963267948966}}, {scale: $a}]",
}  # fmt: skip
NUMBERS = [
    0.0, -0.0, -1.0, 1.0, 1e99, 1e-99, 1e-101, 1e100, 1e300, np.nan, np.inf, -np.inf, 1.5707963267948966, 1e50, 5e-324, 7.0,
]  # fmt: skip


def columns(seed: int = 7, count: int = COUNT) -> dict[str, np.ndarray]:
    random = np.random.default_rng(seed)
    matrices = np.tile(np.eye(4), (count, 1, 1))
    matrices[:, :3] += random.uniform(-0.2, 0.2, (count, 3, 4))
    single = {name: random.uniform(0.5, 3, count) for name in "abcd"}
    single["e"] = random.uniform(0, 1, count)
    single["n"] = np.arange(count) + 3
    return single | {"v": random.uniform(-3, 3, (count, 3)), "m": matrices}


def word(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(word, value))}]"
    return ".nan" if value != value else format_number(float(value))


def written_out(body: str, rows: dict[str, np.ndarray]) -> str:
    """Return each body with its numbers in place of the names."""
    count = len(rows["a"])
    lines = (re.sub(r"\$(\w+)", lambda name: word(rows[name[1]][k].tolist()), body) for k in range(count))  # noqa: B023
    return SHAPES + "".join(f"  - {{{line}}}\n" for line in lines)


def outcome(text: str, folder) -> Any:
    """Return the content of a file, or its messages without places; and the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            found: Any = parse_scene(text, folder / "scene.yaml")
        except co.SceneFileError as error:
            listed = [f"{one.where}: {one.message}" for one in error.problems]
            return sorted(re.sub(r"^bodies\[\d+\](, row \d+)?: ", "", one) for one in listed)
    fields = [
        (vars(body), type(body.shape), pickle_state(body.shape), body.shape.motion.reach) for body in found.bodies
    ]
    return found, repr(fields), {str(one.message) for one in caught}


def check(body: str, rows: dict[str, np.ndarray], folder) -> Any:
    """Compare a template with the bodies written out; return the outcome of both."""
    np.savez(folder / "rows.npz", **rows)
    found = outcome(f"{SHAPES}  - {{{body}, columns: {{file: rows.npz}}}}\n", folder)
    assert found == outcome(written_out(body, rows), folder)
    return found


@pytest.mark.parametrize("form", BODIES)
def test_bodies_are_those_written_out(form, tmp_path):
    found = check(BODIES[form], columns(), tmp_path)
    assert len(found[0].bodies) == COUNT


@pytest.mark.parametrize("form", BODIES)
def test_most_bodies_are_built_together(form, tmp_path, noted_calls):
    """The reader with reports reads single rows: the first, and those whose types the columns omit."""
    rows = noted_calls(template, "read_row", lambda *arguments: arguments[2])
    check(BODIES[form], columns(), tmp_path)
    slow = form in ("turned about a point", "integers", "painted", "radians")
    assert rows == (list(range(COUNT)) if slow else [0])


def check_number(form: str, name: str, number: float, folder) -> None:
    """Put a number in some rows, or in the first one. Both files have the same bodies, or the same mistakes."""
    for those in ([5, 11], [0])[: 2 if name == "a" else 1]:
        rows = columns()
        rows[name][those] = number
        check(BODIES[form], rows, folder)


@pytest.mark.parametrize(("form", "number"), sampled(itertools.product(BODIES, NUMBERS), 3))
def test_any_number_in_any_place(form, number, tmp_path):
    """A fast run tries one place."""
    names = [name for name in "abcd" if f"${name}" in BODIES[form]]
    for name in names[NUMBERS.index(number) % len(names) :][:1] if quick() and names else names:
        check_number(form, name, number, tmp_path)


def test_vectors_and_matrices_that_vanish(tmp_path):
    rows = columns()
    rows["v"][3], rows["m"][4, :3, :3], rows["m"][5, 3, 3], rows["m"][6, 1, 1] = 0, 0, 2, np.nan
    for form in ("vector", "moved", "matrix", "turned about a point"):
        check(BODIES[form], rows, tmp_path)


def load(text: str, folder) -> co.Scene:
    (folder / "scene.yaml").write_text(text)
    return co.load(folder / "scene.yaml")


def test_columns_in_the_file_itself(tmp_path):
    text = "bodies:\n- shape: {Sphere: {radius: $r, center: $c}}\n  columns: {r: [1, 2], c: [[0, 0, 0], [5, 0, 0]]}\n"
    assert load(text, tmp_path).bodies == co.Scene([co.Sphere(1), co.Sphere(2, (5, 0, 0))]).bodies
    data = tree(text)
    assert load(dump_json(data), tmp_path).body_count == 2
    jsonschema.Draft202012Validator(scene_schema()).validate(data)


def test_each_body_may_have_its_material(tmp_path):
    text = "bodies:\n- {shape: {Sphere: {radius: $r}}, columns: {r: [1, 2, 3]}, materials: [red, gray], material_index: %s}"
    np.save(tmp_path / "index.npy", [1, 0, 1])
    for index in ("[1, 0, 1]", "{file: index.npy}"):
        found = [body.material for body in load(text % index, tmp_path).bodies]
        assert found == [co.Body(co.Sphere(), color).material for color in ("gray", "red", "gray")]
    assert "material_index[2] must be at least 0 and below 2, got 7" in refusal(text % "[1, 0, 7]", tmp_path)
    assert "material_index must have shape (3,)" in refusal(text % "[1, 0]", tmp_path)


def test_no_rows_are_no_bodies(tmp_path):
    np.savez(tmp_path / "rows.npz", r=np.zeros(0))
    assert load("bodies: [{shape: {Sphere: {radius: $r}}, columns: {file: rows.npz}}]", tmp_path).body_count == 0


def test_bodies_of_templates_and_others_keep_their_order(tmp_path):
    text = "bodies:\n- {shape: {Box: {}}}\n- {shape: {Sphere: {radius: $r}}, columns: {r: [1, 2]}}\n- {shape: {Box: {}}, name: b}\n"
    kinds = [type(body.shape).__name__ for body in load(text, tmp_path).bodies]
    assert kinds == ["Box", "Sphere", "Sphere", "Box"]


def refusal(text: str, folder) -> str:
    with pytest.raises(co.SceneFileError) as caught:
        load(text, folder)
    return str(caught.value)


MISTAKES = {
    "{shape: {Sphere: {radius: $r}}, columns: {r: [1, 2, -3]}}": "1:36: bodies[0], row 2: Sphere: radius must be > 0, got -3.0",
    "{shape: {Sphere: {radius: $r}}, columns: {s: [1, 2]}}": "1:36: bodies[0]: columns: unknown column 'r' (known: s)",
    "{shape: {Sphere: {radius: $r}}, columns: {r: [1], s: [2]}}": "columns: column 's' is not used: no number is $s",
    "{shape: {Sphere: {radius: 1}}, columns: {r: [1]}}": "are for names such as $radius in place of numbers; the body has none",
    "{shape: {Sphere: {radius: $r, center: $c}}, columns: {r: [1], c: [[1, 2]]}}": "row 0: Sphere: center: must be 3 numbers, got 2: [1, 2]",
    "{shape: {Sphere: {radius: $r}}, columns: {r: 5}}": "columns: r: must be a list of items, each a number, or a list",
    "{shape: {Sphere: {radius: $r}}, columns: {r: [x]}}": "columns: r[0]: must be a number",
    "{shape: {Sphere: {radius: $r}}, columns: [1, 2]}": "columns: must be a mapping from names to lists of numbers, or {file: NAME.npz}",
    "{shape: {Sphere: {radius: $r, center: [$x, 0, 0]}}, columns: {r: [1, 2], x: [1]}}": "columns must be of equally many bodies, got r of 2, x of 1",
    "{shape: {Sphere: {radius: $r}}, columns: {r: [1, [2]]}}": "columns: r must be an array of numbers",
    "{shape: {Sphere: {radius: $r}}, columns: {r: [1]}, name: a}": "unknown key 'name' (known: material, material_index, materials, move)",
    "{shape: {Sphere: {radius: $r}}}": "Sphere: radius: must be a number, got '$r'",
    "{shape: {Spheres: {centers: [[0, 0, 0]], radii: [$r]}}, columns: {r: [1]}}": "must be the shape of one body, got Spheres, which has columns of its own",
    "{shape: {Spher: {radius: $r}}, columns: {r: [1, 2]}}": "bodies[0], row 0: unknown shape 'Spher' (did you mean 'Sphere'?)",
    "{shape: {Sphere: {radius: $r}}, material: nothing, columns: {r: [1]}}": "got 'nothing'",
    "{columns: {r: [1]}}": "bodies[0]: shape must be given",
    "{shape: {Sphere: {radius: $r}}, columns: {file: none.npz}}": "columns: file: is not an existing file: 'none.npz' beside the scene",
    "{shape: {Sphere: {radius: $r}}, columns: {file: rows.npy}}": "must be the name of a .npz file, got 'rows.npy'",
    "{shape: {Sphere: {radius: $r}}, columns: {file: ../rows.npz}}": "columns: file",
    "{shape: {Sphere: {radius: $q}}, columns: {file: rows.npz}}": "rows.npz must hold the arrays q; q is missing",
    "{shape: {Sphere: {radius: $t}}, columns: {file: rows.npz}}": "rows.npz: t",
    "{shape: {Sphere: {radius: $r}}, columns: {file: rows.npz}}": "row 3: Sphere: radius must be > 0, got -2.5",
    "{shape: {Sphere: {radius: $z}}, columns: {file: rows.npz}}": "z must have shape (N,), (N, 3) or (N, 4, 4), got ()",
}  # fmt: skip


@pytest.mark.parametrize("body", MISTAKES)
def test_mistakes_name_the_place_the_field_the_row_and_the_value(body, tmp_path):
    np.savez(tmp_path / "rows.npz", r=[1, 2, 3, -2.5], t=["a", "b"], z=np.float64(3))
    assert MISTAKES[body] in refusal(f"bodies: [{body}]", tmp_path)


def test_each_bad_row_is_reported(tmp_path):
    text = "bodies: [{shape: {Sphere: {radius: $r}}, columns: {r: [-1, 2, 0, 4]}}]"
    assert refusal(text, tmp_path).count("radius must be > 0") == 1  # without a good first row no other is read
    text = "bodies: [{shape: {Sphere: {radius: $r}}, columns: {r: [1, -2, 0, 4]}}]"
    assert refusal(text, tmp_path).count("radius must be > 0") == 2


def test_aliases_in_a_template_are_read_once(tmp_path):
    text = "bodies:\n- shape: {Union: [&a {Sphere: {radius: $r}, move: &m [{translate: [$r, 0, 0]}]}, *a, {Box: {}, move: *m}]}\n"
    (one, two) = load(text + "  columns: {r: [1, 2]}\n", tmp_path).bodies
    ball = co.Sphere(2).translate((2, 0, 0))
    assert two.shape == co.Union((ball, ball, co.Box().translate((2, 0, 0))))
    assert one.shape != two.shape


def test_rows_are_counted_before_they_are_made(tmp_path, monkeypatch):
    """Few rows of a large shape, and many rows of a template with many values."""
    many = ", ".join(["{Sphere: {}}"] * 400)
    shapes = f"shapes: {{many: {{Union: [{many}]}}}}\n"
    np.savez(tmp_path / "rows.npz", x=np.arange(3000.0), y=np.arange(1e6))
    monkeypatch.setattr(template, "build_batch", lambda *_: pytest.fail("made"))
    text = shapes + "bodies: [{shape: many, move: [{translate: [$x, 0, 0]}], columns: {file: rows.npz}}]"
    assert "which is too much for its length" in refusal(text, tmp_path)
    text = "bodies: [{shape: {Sphere: {radius: 1, center: [$y, 0, 0]}}, columns: {file: rows.npz}}]"
    assert "1,000,000 rows of 11 values are more than 8,000,000" in refusal(text, tmp_path)


def test_rows_in_doubt_count_once(tmp_path, monkeypatch):
    """Rows that the reader with reports reads a second time do not use up the budget of the file."""
    text = "bodies: [{shape: {Painted: {operand: {Sphere: {}}, material: red}}, move: [{rotate: {axis: z, degrees: $d}}], columns: {d: [%s]}}]"
    angles = ", ".join(["0.5"] * 12)  # which may be radians: each warns
    monkeypatch.setattr(shape_reader, "FREE_PARTS", 60)
    monkeypatch.setattr(shape_reader, "PARTS_PER_VALUE", 0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert load(text % angles, tmp_path).body_count == 12


def test_parts_that_rows_share_count_once_for_each_row(tmp_path, monkeypatch):
    """Building all rows together reads the parts once more, which counts nothing."""
    moves = ", ".join(["{translate: [1, 0, 0]}"] * 5)
    text = f"bodies: [{{shape: {{Union: [{{Sphere: {{}}, move: [{moves}]}}, {{Sphere: {{radius: $r}}}}]}}, columns: {{r: %s}}}}]"
    monkeypatch.setattr(shape_reader, "PARTS_PER_VALUE", 0)
    monkeypatch.setattr(shape_reader, "FREE_PARTS", 12 * 5 * shape_reader.STEP_COMPOSED)
    assert load(text % list(range(1, 13)), tmp_path).body_count == 12
    assert "too much for its length" in refusal(text % list(range(1, 14)), tmp_path)


def test_a_row_is_bounded_however_wide_its_columns_are(tmp_path):
    """A column of one row may be wide, and a body may use it in many places: the product counts."""
    wide, places = ", ".join(["1"] * 3000), ", ".join(["$v"] * 100)
    text = f"bodies:\n  - shape: {{Sphere: {{radius: [{places}]}}}}\n    columns: {{v: [[{wide}]]}}\n"
    assert "are more than 100,000" in refusal(text, tmp_path)


def test_a_template_that_aliases_nest_deeply_is_refused(tmp_path):
    links = "".join(f"  - &a{k} {{Complement: *a{k - 1}}}\n" for k in range(1, 900))
    text = f"x:\n  - &a0 {{Sphere: {{radius: $r}}}}\n{links}bodies:\n  - shape: *a899\n    columns: {{r: [1, 2]}}\n"
    assert "nested too deeply" in refusal(text, tmp_path)
