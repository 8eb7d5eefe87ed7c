"""Files made to hurt: a clear error in seconds and bounded memory, without execution, without other files."""

import difflib
import os
import struct
import time
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid._util import files as errors
from conicoid.io import importers
from conicoid.io.molecules.atoms import bonds_by_distance
from conicoid.io.scene_file import yaml_parser
from conicoid.io.scene_file.scene_file import read_scene
from conicoid.io.scene_file.writer import dump_json
from conicoid.materials import image_file
from conicoid.materials.image_file import read_pixels
from conicoid.parallel.pictures import Checkpoint
from conicoid.viewer.playground import Playground

MB = 1 << 20
SECONDS = 20  # far more than any of them takes, for slow machines

HOSTILE = {
    "100 MB of brackets": (b"[" * (100 * MB), "is too large: 100 MB"),
    "3 MB of brackets": (b"[" * (3 * MB), "nested deeper than 250 levels"),
    "3 MB of braces": (b"{a: " * (3 * MB // 5), "nested deeper than 250 levels"),
    "3 MB of dashes": (b"- " * (3 * MB // 2), "nested deeper than 250 levels"),
    "a staircase": (b"".join(b" " * i + b"a:\n" for i in range(5000)), "nested deeper than 250 levels"),
    "3 MB of spaces": (b" " * (3 * MB), "is empty"),
    "3 MB of comments": (b"#\n" * (3 * MB // 2), "is empty"),
    "a long word": (b"a" * (3 * MB), "must be a mapping"),
    "a long number": (b"bodies: [{shape: {Sphere: {radius: " + b"1" * (2 * MB) + b"}}}]", "must be a number"),
    "a long name": (b"bodies: [{name: " + b"n" * (2 * MB) + b"}]", "shape must be given"),
    "a long alias": (b"*" + b"a" * (3 * MB), "has no anchor"),
    "many directives": (b"".join(b"%%TAG !a%d! x\n" % i for i in range(200_000)), "not allowed"),
    "many mistakes": (b"bodies:\n" + b"- {shape: {Spere: {}}}\n" * 50_000, "more problems"),
    "many unknown keys": (b"bodies: [{" + b",".join(b"k%d: 1" % i for i in range(100_000)) + b"}]", "more problems"),
    "many steps": (b"bodies: [{shape: {Sphere: {}}, move: [" + b"{scale: 2}," * 50_000 + b"]}]", "at most 1000 steps"),
    "random bytes": (np.random.default_rng(0).bytes(1 * MB), "UTF-8"),
    "zeros": (b"\0" * (3 * MB), "binary"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_refused_in_seconds(name, tmp_path):
    content, phrase = HOSTILE[name]
    path = tmp_path / "scene.yaml"
    path.write_bytes(content)
    started = time.process_time()
    with pytest.raises(co.SceneFileError) as caught:
        read_scene(path)
    assert phrase in str(caught.value)
    assert len(str(caught.value)) < 20_000
    assert time.process_time() - started < SECONDS


@pytest.mark.parametrize("most", [40_000, pytest.param(yaml_parser.MAX_NODES, marks=pytest.mark.deep)])
def test_too_many_values_are_refused(most, tmp_path, monkeypatch):
    monkeypatch.setattr(yaml_parser, "MAX_NODES", most)
    path = tmp_path / "scene.yaml"
    path.write_bytes(b"[" + b"[]," * (most + most // 6))
    with pytest.raises(co.SceneFileError, match=f"more than {most:,} values"):
        read_scene(path)


def test_memory_is_bounded(tmp_path):
    path = tmp_path / "scene.yaml"
    laughs = "".join(f"a{i}: &a{i} [{','.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 100))
    path.write_text("a0: &a0 [1,1,1,1,1,1,1,1,1,1]\n" + laughs)
    tracemalloc.start()
    with pytest.raises(co.SceneFileError, match="aliases expanded"):
        read_scene(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 5 * MB


def test_tags_execute_nothing(tmp_path):
    path, witness = tmp_path / "scene.yaml", tmp_path / "witness"
    for tag in (
        "!!python/object/apply:os.mkdir",
        "!!python/object/new:os.mkdir",
        "!<tag:yaml.org,2002:python/name:os.mkdir>",
        "!x",
    ):
        path.write_text(f"bodies: {tag} ['{witness}']\n")
        with pytest.raises(co.SceneFileError, match="tags"):
            read_scene(path)
    assert not witness.exists()


def test_pickled_balls_are_not_unpickled(tmp_path):
    class Trap:
        def __reduce__(self):
            return os.mkdir, (str(tmp_path / "witness"),)

    np.save(tmp_path / "balls.npy", np.array([Trap()], dtype=object), allow_pickle=True)
    (tmp_path / "scene.yaml").write_text("bodies: [{shape: {Spheres: {file: balls.npy}}}]\n")
    with pytest.raises(co.SceneFileError, match=r"balls.npy is not a .npy file of numbers"):
        read_scene(tmp_path / "scene.yaml")
    assert not (tmp_path / "witness").exists()


@pytest.mark.parametrize(
    ("name", "content", "phrase"),
    [
        ("balls.npy", b"", "is not a .npy file"),
        ("balls.npy", b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, 'shape': (10000000000, 4)}", "is not a .npy file"),
        ("balls.npy", b"hello", "is not a .npy file"),
        ("balls.csv", b"1,2,3\n", "balls.csv:1: must be 4 numbers (x, y, z, radius), got '1,2,3'"),
        ("balls.csv", b"x,y,z,r\n1,2,3,4\n1,2,3,1_0\n", "balls.csv:3: must be 4 numbers"),
        ("balls.csv", b"1,2,3,4\n1,2,three,4\n", "balls.csv:2: must be 4 numbers"),
        ("balls.csv", b"1,2,3,\xff\n", "is not a text in UTF-8"),
        ("balls.csv", b"1,2,3,nan\n", "radii[0] must be finite"),
        ("balls.csv", b"1,2,3,0\n", "radii[0] must be > 0"),
        ("balls.txt", b"1,2,3,4\n", "must be a .npy or .csv file"),
    ],
)  # fmt: skip
def test_bad_files_of_balls(name, content, phrase, tmp_path):
    (tmp_path / name).write_bytes(content)
    (tmp_path / "scene.yaml").write_text(f"bodies:\n  - shape: {{Spheres: {{file: {name}}}}}\n")
    with pytest.raises(co.SceneFileError) as caught:
        read_scene(tmp_path / "scene.yaml")
    assert phrase in str(caught.value)
    assert "scene.yaml:2:" in str(caught.value)


@pytest.mark.parametrize("shape", [(4,), (3, 3), (2, 4, 1)])
def test_arrays_of_balls_have_four_columns(shape, tmp_path):
    np.save(tmp_path / "balls.npy", np.ones(shape))
    (tmp_path / "scene.yaml").write_text("bodies: [{shape: {Spheres: {file: balls.npy}}}]\n")
    with pytest.raises(co.SceneFileError, match=r"shape \(N, 4\): x, y, z, radius"):
        read_scene(tmp_path / "scene.yaml")


def test_links_do_not_lead_out(tmp_path):
    inside = tmp_path / "scenes"
    inside.mkdir()
    np.save(tmp_path / "secret.npy", np.ones((1, 4)))
    (inside / "balls.npy").symlink_to(tmp_path / "secret.npy")
    (inside / "scene.yaml").write_text("bodies: [{shape: {Spheres: {file: balls.npy}}}]\n")
    with pytest.raises(co.SceneFileError, match="must stay inside the scene's folder"):
        read_scene(inside / "scene.yaml")


def test_no_file_no_text(tmp_path):
    for path, phrase in (
        (tmp_path / "none.yaml", "no such file"),
        (tmp_path, "is a directory"),
        (Path(os.devnull), "is not a regular file"),
        (tmp_path / ("x" * 5000), "cannot be read"),
        ("zero\0character.yaml", "cannot be read"),
    ):
        with pytest.raises(co.SceneFileError, match=phrase):
            read_scene(path)


@pytest.mark.parametrize("suffix", ["yaml", "json"])
@pytest.mark.parametrize("name", ["n" * 5000, "\U0001f600" * 1000, "\U0001f600" * 100])
def test_long_names_of_materials_are_saved_and_loaded(name, suffix, tmp_path):
    path = tmp_path / f"scene.{suffix}"  # YAML reads keys of at most 1,024 characters
    co.save(co.Scene([co.Body(co.Sphere(), co.matte("red", name=name))]), path)
    assert co.load(path).bodies[0].material.name == name


def test_errors_cannot_drive_a_terminal(tmp_path):
    (tmp_path / "scene.yaml").write_text('bodies: [{name: "a\\e[31m\\nb", "\\e]0;x\\a": 1}]\n')
    with pytest.raises(co.SceneFileError) as caught:
        read_scene(tmp_path / "scene.yaml")
    assert "\x1b" not in str(caught.value)
    assert "\x07" not in str(caught.value)
    assert len(str(caught.value).splitlines()) == 2


def test_several_mistakes_are_reported_together(tmp_path):
    (tmp_path / "scene.yaml").write_text(
        "bodies:\n  - {shape: {Sphere: {radius: big, center: [0]}}}\n  - {shap: 1}\nlights: [{PointLight: {}}]\ncamra: 1\n"
    )
    with pytest.raises(co.SceneFileError) as caught:
        read_scene(tmp_path / "scene.yaml")
    assert [problem.line for problem in caught.value.problems] == [2, 2, 3, 3, 4, 5]
    assert isinstance(caught.value, ValueError)


def doubled(levels: int, mark: str = "", use: str = "s") -> str:
    """Return a kilobyte of references, or aliases, that stand for 2^levels balls, each in a place of its own."""
    lines = [
        f"  s{k + 1}: {mark.format(k + 1)}{{Union: [{use}{k}, {{shape: {use}{k}, move: [{{translate: [{2**k}.5, 0, 0]}}]}}]}}\n"
        for k in range(levels)
    ]
    return f"shapes:\n  s0: {mark.format(0)}{{Sphere: {{}}}}\n" + "".join(lines)


SHIFTS = ", ".join(f"{{translate: [{k}, 0, 0]}}" for k in range(900))
GROWING = {
    "references that double": (doubled(16) + "bodies:\n  - shape: s16\n", 20),
    "aliases that double": (doubled(14, "&s{} ", "*s") + "bodies:\n  - shape: s14\n", 18),
    "many bodies of a few parts": (doubled(8) + "bodies:\n" + "  - shape: s8\n" * 100, 44),
    "many bodies, one of them large": (doubled(14) + "bodies:\n" + "  - shape: s0\n" * 100 + "  - shape: s14\n", 118),
    "one list of steps for many bodies": (
        f"shapes: {{s: {{Sphere: {{}}, move: &m [{SHIFTS}]}}}}\nbodies:\n" + "  - {shape: s, move: *m}\n" * 30, 1),
    "one list of steps many times over": (
        f"shapes:\n  s0: {{Sphere: {{}}, move: &m [{SHIFTS}]}}\n" + "".join(f"  s{k + 1}: {{shape: s{k}, move: *m}}\n" for k in range(40))
        + "bodies: []\n", 2),
}  # fmt: skip


@pytest.mark.parametrize("name", GROWING)
def test_files_that_grow_are_refused(name, tmp_path):
    """The error has the expanded size of all bodies together, and the place, before memory is taken."""
    content, line = GROWING[name]
    (tmp_path / "scene.yaml").write_text(content)
    with pytest.raises(
        co.SceneFileError, match=r"has grown to more than [\d,]+ parts and steps of motion, references written out"
    ) as caught:
        read_scene(tmp_path / "scene.yaml")
    (problem,) = caught.value.problems
    assert problem.line == line


def test_an_alias_stands_for_the_same_shape(tmp_path):
    (tmp_path / "scene.yaml").write_text(
        doubled(3, "&s{} ", "*s")
        + "bodies:\n  - &b {shape: s3}\n  - *b\n  - {shape: &c {Sphere: {}}}\n  - {shape: *c}\n"
    )
    bodies = co.load(tmp_path / "scene.yaml").bodies
    assert bodies[0] is bodies[1]
    assert bodies[2].shape is bodies[3].shape


def test_scenes_within_limits_can_be_saved_and_loaded(tmp_path):
    """2^12 balls in a kilobyte load. 2^16, with as many unions and steps that count twice, are not saved."""

    def balls(levels: int) -> co.Scene:
        shape = co.Sphere()
        for k in range(levels):
            shape = co.Union((shape, shape.translate((2.0**k, 0, 0))))
        return co.Scene([shape])

    co.save(balls(12), tmp_path / "scene.yaml")
    assert (tmp_path / "scene.yaml").stat().st_size < 2000
    assert co.load(tmp_path / "scene.yaml").bodies[0].shape.motion == balls(12).bodies[0].shape.motion
    with pytest.raises(
        ValueError, match=r"scene\.yaml: a scene file of this size may have 32,768 parts .* this scene has 262,142"
    ):
        co.save(balls(16), tmp_path / "scene.yaml")
    assert len(read_scene(tmp_path / "scene.yaml").bodies) == 1


def test_long_files_may_have_many_parts(tmp_path):
    """5,000 bodies of 17 parts each, with a step each, are 95,000 parts, within the limit for a file of that length."""
    rod = "shapes: {rod: {Union: [" + ", ".join("{Sphere: {}}" for _ in range(16)) + "]}}\nbodies:\n"
    (tmp_path / "scene.yaml").write_text(
        rod + "".join(f"  - {{shape: rod, move: [{{translate: [{k}, 0, 0]}}]}}\n" for k in range(5000))
    )
    assert len(read_scene(tmp_path / "scene.yaml").bodies) == 5000


def test_typos_cost_nothing(tmp_path, noted_calls):
    """There are a thousand unknown names and twenty thousand known ones. The test counts comparisons, not seconds."""
    compared = noted_calls(difflib, "get_close_matches", lambda word, names, **how: len(names))
    known = "".join(f"  shape number {k}: {{Sphere: {{}}}}\n" for k in range(5_000))
    (tmp_path / "scene.yaml").write_text(f"shapes:\n{known}bodies:\n" + "  - shape: shape nomber 7\n" * 1000)
    with pytest.raises(co.SceneFileError, match=r"did you mean 'shape number 7'\?") as caught:
        read_scene(tmp_path / "scene.yaml")
    assert len(caught.value.problems) >= 1000
    assert 0 < sum(compared) <= errors.MAX_COMPARISONS


# Files of other programs

UNITS = [
    "\n",
    "/**/",
    "<?",
    "<!--",
    "<!DOCTYPE[",
    "]",
    "1",
    "1.",
    " ",
    "a ",
    "# \n",
    "//\n",
    "data_",
    "SURF 0 ",
    "\t\n",
    '"',
    '\\"',
]
HEADS = ["", "title\n1 1 ", "1\n", "<a", "<!DOCTYPE a[", "/*", "1 0 ", "#", "SURF 0", "1\n\nH "]


def test_kinds_of_files_are_known_in_linear_time():
    """64 KiB of hostile text of each alphabet take a tenth of a second of processor time."""
    for head in HEADS:
        for unit in UNITS:
            text = head + unit * ((64 << 10) // len(unit))
            begin = time.process_time()
            for each in importers.IMPORT_FORMATS:
                each.recognises(text, "")
            assert time.process_time() - begin < 0.1, (head, unit)


@pytest.mark.parametrize(
    "suffix", ["yaml", "json", "gdml", "xml", "csg", "scad", "mcnp", "zmx", "xyz", "pdb", "cif", "none"]
)
def test_special_files_are_refused(suffix, tmp_path):
    os.mkfifo(tmp_path / f"pipe.{suffix}")
    (tmp_path / f"zeros.{suffix}").symlink_to("/dev/zero")
    for path in tmp_path.iterdir():
        for read in (co.load, Playground, lambda path: Checkpoint(path, b"")):
            with pytest.raises((OSError, ValueError), match="regular file"):
                read(path)


@pytest.mark.parametrize("head", ["", "1\n", "HEADER\nATOM      1  C   ALA A   1       0.000   0.000   0.000\n"])
def test_a_line_without_end_is_refused(head, tmp_path):
    path = tmp_path / ("a.xyz" if len(head) < 3 else "a.pdb")
    with path.open("w") as file:
        file.write(head)
        file.truncate(1 << 40)
    tracemalloc.start()
    try:
        with pytest.raises(co.SceneFileError, match="longer than|must stand here"):
            co.load(path)
        assert tracemalloc.get_traced_memory()[1] < 64 * MB
    finally:
        tracemalloc.stop()


def test_atoms_that_are_all_neighbours_are_refused():
    positions = np.random.default_rng(0).uniform(0, 1, (20_000, 3))
    with pytest.raises(ValueError, match="atoms lie closer than any do"):
        bonds_by_distance(positions, np.full(20_000, 6))


def test_numbers_and_names_that_no_file_can_hold(tmp_path):
    (tmp_path / "a.yaml").write_text("background: 1e999\n")
    with pytest.raises(co.SceneFileError, match="background"):
        co.load(tmp_path / "a.yaml")
    with pytest.raises(ValueError, match="is not Unicode"):
        dump_json({"name": "\ud800"})
    assert "\\ud83d" in dump_json({"name": "\U0001f600"})


@pytest.mark.parametrize("name", ["a\0b", "\ud800"])
@pytest.mark.parametrize("read", [co.molecule, co.optics.load_agf, co.optics.load_zmx])
def test_names_that_no_file_can_have(read, name):
    with pytest.raises(OSError, match="is no name that a file can have here"):
        read(name)


def _png(size: tuple[int, int], bits: int, color: int, data: bytes, more: bytes = b"") -> bytes:
    """Return a PNG file with a head, one chunk of data, and other chunks between them."""
    head = struct.pack(">IIBBBBB", *size, bits, color, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", head) + more + _chunk(b"IDAT", data) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (_png((1 << 12, 1 << 12), 8, 2, zlib.compress(b"")), "rows are missing"),
        (_png((10, 10), 8, 2, zlib.compress(b"\0" * 31 * 9)), "rows are missing"),  # nine of ten
        # All rows are there, as zeros take a thousandth of their bytes
        (_png((1 << 13, 1 << 12), 1, 0, zlib.compress(bytes((1 + (1 << 10)) << 12))), "8192 x 4096 pixels; .* one of so few"),
        (_png((9, 9), 8, 2, b"", _chunk(b"zTXt", b"a\0\0" + zlib.compress(bytes(1 << 22)))), "'a.png' cannot be read as PNG: .*large"),
        (_png((9, 9), 8, 2, b"", _chunk(b"tRNS", b"\0")), "'a.png' cannot be read as PNG: .*tRNS"),
    ],
)  # fmt: skip
def test_pictures_of_few_bytes(content, message, tmp_path):
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(ValueError, match=message):
        read_pixels(tmp_path / "a.png")


@pytest.mark.parametrize(
    ("name", "head", "size", "message"),
    [
        # Pillow and OpenEXR read such a chunk and such an attribute whole, of a sparse file too
        ("a.png", b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 0x7FFFFF00) + b"IHDR", 1 << 31, "is larger than 512 MiB"),
        ("a.exr", b"\x76\x2f\x31\x01\2\0\0\0a\0string\0" + struct.pack("<i", 0x7FFFFF00), 1 << 31, "is larger than 512"),
        # Pillow skips zeros between parts one by one
        ("a.jpg", b"\xff\xd8\xff\xe1\0\2", 1 << 26, "cannot be read as JPEG: takes more than"),
    ],
)  # fmt: skip
def test_pictures_of_large_sparse_files(name, head, size, message, tmp_path):
    (tmp_path / name).write_bytes(head)
    os.truncate(tmp_path / name, size)
    with pytest.raises(ValueError, match=message):
        read_pixels(tmp_path / name)


def test_a_smooth_photo_of_few_bytes_is_read(tmp_path, monkeypatch):
    """The photo has 131,072 pixels in 6 kB.

    Where colors hardly change, a block of 64 pixels takes a code for each of three colors.
    """
    image = pytest.importorskip("PIL.Image")
    monkeypatch.setattr(image_file, "_FREE_TEXELS", 1 << 10)
    rows = np.repeat(128 + 60 * np.sin(np.arange(256) / 30.0), 512).reshape(256, 512, 1).astype(np.uint8)
    image.fromarray(np.repeat(rows, 3, axis=2)).save(tmp_path / "a.jpg")
    assert read_pixels(tmp_path / "a.jpg").size == (512, 256)


def test_exr_files_of_few_bytes(tmp_path):
    openexr = pytest.importorskip("OpenEXR")
    kinds = dict(compression=openexr.ZIP_COMPRESSION, type=openexr.scanlineimage)
    zeros = np.zeros((1 << 12, 1 << 10), np.float16)
    layers = {f"layer {k}": zeros for k in range(17)}  # 2^22 numbers each, 2^26 are free
    samples = np.empty((1, 1), object)
    samples[0, 0] = np.zeros(3, np.float32)
    deep = dict(compression=openexr.ZIPS_COMPRESSION, type=openexr.deepscanline)
    for head, channels, message in (
        (
            dict(kinds),
            {"Y": zeros, **layers},
            r"has 75,497,472 numbers; .* one of so few bytes 16,777,216, with 4 numbers",
        ),
        (deep, {"Y": samples}, "is a deep image"),
        (dict(kinds), {"Z": zeros}, "must have the channels R, G, B or Y"),
    ):
        openexr.File([openexr.Part(head, channels)]).write(str(tmp_path / "a.exr"))
        with pytest.raises(ValueError, match=message):
            read_pixels(tmp_path / "a.exr")
