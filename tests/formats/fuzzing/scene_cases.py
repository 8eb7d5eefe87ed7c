"""Scene files: damaged ones, and ones from the published schema. They load, or errors name their lines."""

import functools
import json
import os
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import yaml

import conicoid as co
from conicoid.io.scene_file.schema import scene_schema
from conicoid.io.scene_file.writer import dump_yaml
from conicoid.prepare.lowering import lower

from .from_schema import Generator
from .mutations import bytes_damaged, subtrees, text_damaged, tree_damaged

ROOT = Path(__file__).resolve().parents[3]
BY_HAND = """%YAML 1.2
---
conicoid: 1
camera: {OrthographicCamera: {position: [4, -6, 3], look_at: [0, 0, 0], height: 4}}
background: [0.1, 0.2, 1.5]
lights:
  - PointLight: &lamp {position: [3, -5, 8], intensity: 1.0e-9}
  - SpotLight: {<<: 1}
  - AmbientLight:
materials:
  brass: {metal: {color: "#d9a64a"}}
  tiles: &tiles {matte: {color: {Checker: {a: white, scale: [2, 3], space: true}}}}
shapes:
  bore: {Cylinder: {start: [0, 0, -9], end: [0, 0, 9], radius: .5, start_angle: 10, end_angle: 200, reference: [1, 0, 0]}}
  wheel: {Difference: [{Sphere: {radius: 0x2}}, bore]}
  many: {Union: [wheel, {shape: wheel, move: &move [{translate: [3, 0, 0]}, {rotate: {axis: [0, 0, 1], degrees: 30}}]}]}
bodies:
  - {name: ball, shape: many, move: *move, material: brass}
  - {shape: {Painted: {operand: wheel, material: *tiles}}, move: [{transform: [[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 3, 0], [0, 0, 0, 1]]}]}
  - {shape: {ClippedSheet: {base: {Plane: {normal: [0, 0, 1], offset: 0}}, solid: bore, keep: outside}}}
  - {shape: {Spheres: {file: balls.npy}}, move: [{scale: [1, -2, 3]}]}
  - {shape: {Spheres: {centers: [[1, 2, 3], [4, 5, 6]], radii: [1, 2]}}}
  - {shape: {Difference: [wheel, {Box: {low: $low}}]}, move: [{scale: $k}], columns: {low: [[-1, -2, 0], [0, 0, 0]], k: [2, 3]}}
  - {shape: wheel, move: [{rotate: {axis: z, degrees: $turn}}, {translate: [$x, 0, 1]}], columns: {file: rows.npz}, material: red}
  - {shape: {Quadric: {coefficients: {xx: 1, yy: 1, zz: -1, xy: 0.5, x: 1, constant: -1}}}}
  - {shape: {Polygon: {vertices: [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]}}}
  - {shape: {Polyhedron: {normals: [[1, 0, 0], [-1, 0, 0], [0, 1, 1]], offsets: [1, 1, 2]}}}
  - {shape: {HyperbolicParaboloid: {A: 1, E: 2, within: {Box: {low: [-1, -1, -1], high: [1, 1, 1]}}}}}
  - {shape: {Intersection: [{EllipticParaboloid: {A: 2, E: .5}}, {Complement: {Box: {}}}]}, move: [{scale: [1, 2, .5]}]}
"""


@functools.cache
def sources() -> tuple[list[str], list[Any], list[Any]]:
    """Return texts of good scenes, their trees, and all values in them."""
    texts = [BY_HAND.replace("  - SpotLight: {<<: 1}\n", "")]
    texts += [path.read_text(encoding="utf-8") for path in sorted((ROOT / "examples").rglob("*.yaml"))]
    trees = [yaml.safe_load(text) for text in texts]
    return texts, trees, [value for tree in trees for value in subtrees(tree)]


def prepare(folder: Path) -> None:
    """Write the files that scene files may refer to."""
    if not (folder / "balls.npy").exists():
        np.save(folder / "balls.npy", np.arange(12.0).reshape(3, 4) + 1)
        np.savez(folder / "rows.npz", turn=np.arange(12.0), x=np.arange(12.0) / 7)
        (folder / "balls.csv").write_text("x,y,z,radius\n1,2,3,4\n")
        (folder / "zero.npy").symlink_to("/dev/zero")
        os.mkfifo(folder / "pipe.npy")
        (folder / "folder").mkdir()


def mutated_case(seed: int, folder: Path) -> bool:
    """Damage the bytes, the text or the tree of a good scene file; return whether it loads."""
    random = Random(seed)
    texts, trees, pool = sources()
    kind = random.choice([0, 0, 0, random.randrange(len(texts))])
    match random.randrange(3):
        case 0:
            data = bytes_damaged(random, texts[kind].encode())
        case 1:
            data = text_damaged(random, texts[kind]).encode("utf-8", "surrogatepass")
        case _:
            tree = trees[kind]
            bodies = random.sample(tree["bodies"], random.randint(1, len(tree["bodies"])))
            data = text_of(random, tree_damaged(random, {**tree, "bodies": bodies}, pool))
    return check(data, folder)


def schema_case(seed: int, folder: Path) -> bool:
    """Make a scene that the schema allows; return whether it loads."""
    random = Random(seed)
    schema = _schema()
    return check(text_of(random, Generator(random, schema).value(schema)), folder)


@functools.cache
def _schema() -> dict[str, Any]:
    return scene_schema()


def text_of(random: Random, tree: Any) -> bytes:
    """Return a tree as YAML or JSON."""
    if not isinstance(tree, dict) or random.random() < 0.3:
        return json.dumps(tree).replace("-Infinity", "-.inf").replace("Infinity", ".inf").encode()
    return dump_yaml({str(key): value for key, value in _plain(tree).items()}).encode()


def _plain(value: Any) -> Any:
    """Make texts of keys that are none, as YAML allows them."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, list) else value


def check(data: bytes, folder: Path) -> bool:
    """Load a file. The scene must have bounds and tables, and come back equal after a save."""
    prepare(folder)
    path = folder / "scene.yaml"
    path.write_bytes(data)
    try:
        scene = co.load(path)
    except co.SceneFileError as error:
        check_problems(error)
        return False
    for body in scene.bodies:
        low, high = body.shape.bounds
        assert not np.isnan([low, high]).any(), f"bounds {low} {high} of {body}"
    if len(data) < 20_000:
        lower(scene.bodies)
    co.save(scene, folder / "again.yaml")
    again = co.load(folder / "again.yaml")
    assert again == scene, "saved and loaded again it is another scene"
    assert repr(again.bodies) == repr(scene.bodies)
    for file in folder.glob("again-*.npy"):
        file.unlink()
    return True


def check_problems(error: co.SceneFileError) -> None:
    """Check that each mistake has a line of its own, with its place unless it is one of the file as a whole."""
    assert error.problems
    for problem in error.problems:
        assert problem.message.strip()
        assert problem.line > 0 or problem.where == "", f"no line: {problem}"
    text = str(error)
    assert "Traceback" not in text
    assert all(line.startswith(error.path) for line in text.splitlines()), text
    assert text.isprintable() or len(text.splitlines()) > 1
    assert len(text) < 20_000
