"""Files of rays and of balls, damaged: readers accept them, or refuse them in one line that names the file."""

import functools
import io
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

import conicoid as co
from conicoid.io.ray_file import RayFile

from .mutations import NUMBERS, bytes_damaged

SHAPES = ["(5, 6)", "(6,)", "(0, 6)", "(6, 5)", "(-1, 6)", "(1e3, 6)", "(5, 6L)", "(99999999999, 6)", "(9999999999999999999, 6)", "(0, 9999999999999999, 6)",
          "()", "(,)", "(5, 6", "5, 6", "[5, 6]", "(5.0, 6)", "(True, 6)", "(5, 6,)", "(" + "1, " * 40 + "5, 6)", "(5, 6) * 9", "('5', 6)", "(0x5, 6)", "(5_0, 6)",
          "(536870912, 6)", "(4611686018427387904, 4, 6)", "None", "(" * 500 + "5" + ")" * 500]  # fmt: skip
TYPES = ["'<f8'", "'>f8'", "'<f4'", "'<f2'", "'<f16'", "'<i8'", "'|u1'", "'|b1'", "'|O'", "'<U9'", "'<c16'", "'<M8[s]'", "'|V8'", "[('a', '<f8')]", "'f8,f8'",
         "'<f99'", "'<f8", "8", "'|S0'", "'<f8' and 1", "'\\x41'", "'\\d'", "'O8'", "('<f8', (2,))", "{}", "'<m8'", "''", "'<f8,'", "'(2,)f8'"]  # fmt: skip


def ray_case(seed: int, folder: Path) -> bool:
    """Damage a file of rays, or of balls in a scene; return whether it can be read."""
    random = Random(seed)
    balls = random.random() < 0.25
    suffix = random.choice([".npy", ".npy", ".csv"] if balls else [".npy", ".npz", ".npz", ".csv"])
    data = damaged(random, suffix, 4 if balls else 6)
    path = folder / f"file{suffix}"
    path.write_bytes(data)
    return balls_read(folder, path) if balls else rays_read(path)


def rays_read(path: Path) -> bool:
    """Read rays, whole and in pieces. A refusal is one line that begins with the file."""
    whole = refused_or(path, lambda: RayFile(path, whole=True).read())
    pieces = refused_or(path, lambda: list(RayFile(path).pieces(2)))
    if whole is None:
        return False
    assert pieces is not None
    rays = whole.rays
    assert rays.origins.dtype == rays.directions.dtype == np.float64
    for name in ("origins", "directions"):
        found = [getattr(piece.rays, name) for piece in pieces]
        assert np.array_equal(np.concatenate([np.zeros((0, 3)), *found]), getattr(rays, name).reshape(-1, 3))
    for end in (whole.t_min, whole.t_max):
        assert end is None or end.shape == rays.shape
    return True


def refused_or(path: Path, read: Callable[[], Any]) -> Any:
    """Return the result of a call, or None after a refusal with a good text."""
    try:
        return read()
    except ValueError as error:
        text = str(error)
        assert text.startswith(f"{path}: "), text
        assert len(text.splitlines()) == 1, text
        assert len(text) < 1000, text
        return None


def balls_read(folder: Path, path: Path) -> bool:
    """Load a scene of the balls. A refusal stands at its place in the scene, and names the file or its values."""
    scene = folder / "balls.yaml"
    scene.write_text(f"bodies:\n  - shape: {{Spheres: {{file: {path.name}}}}}\n")
    try:
        loaded = co.load(scene)
    except co.SceneFileError as error:
        (problem,) = error.problems
        assert problem.line == 2
        assert path.name in problem.message or problem.message.startswith(("centers[", "radii[")), problem.message
        return False
    low, high = loaded.bodies[0].shape.bounds
    assert not np.isnan([low, high]).any()
    return True


def damaged(random: Random, suffix: str, columns: int) -> bytes:
    """Return the bytes of a file, wrong in one way or another, sometimes in none."""
    if suffix == ".csv":
        return csv(random, columns)
    if suffix == ".npy":
        if random.random() < 0.4:
            return npy_by_hand(random, columns)
        good = good_npy(random, columns)
        return bytes_damaged(random, good) if random.random() < 0.9 else good
    match random.randrange(4):
        case 0:
            return bytes_damaged(random, good_npz(random))
        case 1:
            return directory_damaged(random, good_npz(random))
        case 2:
            return npz_of(random, {name: npy_by_hand(random, 3) for name in ("origins", "directions")})
        case _:
            arrays = {name: good_npy(random, 3) for name in ("origins", "directions")}
            name = random.choice(["origins", "directions", "t_min", "t_max"])
            arrays[name] = bytes_damaged(random, arrays.get(name, good_npy(random, 3)))
            return npz_of(random, arrays)


@functools.cache
def _values(columns: int) -> Any:
    return np.random.default_rng(columns).normal(size=(5, columns)) * 3 + 4


def good_npy(random: Random, columns: int) -> bytes:
    file = io.BytesIO()
    values = _values(columns).astype(random.choice(["<f8", "<f8", ">f8", "<f4", "<i8", "|i1", "<f2", "<f16", "<u4"]))
    version = random.choice([(1, 0), (1, 0), (2, 0), (3, 0)])
    np.lib.format.write_array(
        file, np.asfortranarray(values) if random.random() < 0.3 else values, version, allow_pickle=False
    )
    return file.getvalue()


def npy_by_hand(random: Random, columns: int) -> bytes:
    """Return a header with any content, and some bytes after it."""
    kind, shape = random.choice(TYPES[:3] if random.random() < 0.5 else TYPES), random.choice(SHAPES)
    order = random.choice(["False", "True", "False", "0", "None", "'False'"])
    entries = [f"'descr': {kind}", f"'fortran_order': {order}", f"'shape': {shape.replace('6', str(columns))}"]
    if random.random() < 0.2:
        random.shuffle(entries)
    if random.random() < 0.1:
        entries.append(random.choice([entries[0], "'x': 1", "**{}", "'\\u0041': 1"]))
    if random.random() < 0.1:
        entries.pop(random.randrange(3))
    text = (
        random.choice(["{", "{", "{", "", "dict("])
        + ", ".join(entries)
        + random.choice(["}", ", }", "", "}}", "} + {}"])
    )
    text += " " * random.choice([0, 1, 63]) + random.choice(["\n", "\n", ""])
    header = text.encode("latin-1", "replace")
    version = random.choice([1, 1, 2, 3, 0, 9])
    length = random.choice([len(header)] * 6 + [0, 65535, len(header) + 1, 2**31])
    packed = length.to_bytes(2 if version == 1 else 4, "little") if length < 65536 or version != 1 else b"\xff\xff"
    size = random.choice([5 * columns * 8] * 4 + [0, 1, 5 * columns * 8 - 1, 5 * columns * 8 + 1, 1000])
    return b"\x93NUMPY" + bytes([version, 0]) + packed + header + (_values(columns).tobytes() + bytes(1000))[:size]


def good_npz(random: Random) -> bytes:
    return npz_of(
        random,
        {
            "origins": good_npy(random, 3),
            "directions": good_npy(random, 3),
            "t_max": good_npy(random, 1)[:0] or scalar(),
        },
    )


def scalar() -> bytes:
    file = io.BytesIO()
    np.save(file, np.array(9.0))
    return file.getvalue()


def npz_of(random: Random, members: dict[str, bytes]) -> bytes:
    file = io.BytesIO()
    kinds = [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA]
    with zipfile.ZipFile(file, "w", random.choice(kinds[:3] if random.random() < 0.8 else kinds)) as archive:
        for name, data in members.items():
            archive.writestr(f"{name}.npy", data)
        if random.random() < 0.05:
            archive.writestr("other\x1b[31m.npy", b"")
    return file.getvalue()


def directory_damaged(random: Random, data: bytes) -> bytes:
    """Exchange one field of the archive's directory, or of the headers of its members, for another value."""
    result = bytearray(data)
    signature, fields = random.choice([
        (b"PK\x01\x02", {4: 2, 6: 2, 8: 2, 10: 2, 16: 4, 20: 4, 24: 4, 28: 2, 30: 2, 32: 2, 34: 2, 42: 4}),
        (b"PK\x03\x04", {4: 2, 6: 2, 8: 2, 14: 4, 18: 4, 22: 4, 26: 2, 28: 2}),
        (b"PK\x05\x06", {4: 2, 6: 2, 8: 2, 10: 2, 12: 4, 16: 4, 20: 2}),
    ])  # fmt: skip
    places = [at for at in range(len(data)) if data[at : at + 4] == signature]
    place, (offset, width) = random.choice(places), random.choice(list(fields.items()))
    value = random.choice(
        [0, 1, 8, 9, 12, 14, 93, 99, 255, 0x7FFF, 0xFFFF, 1 << 30, 0xFFFFFFFF, random.getrandbits(32)]
    )
    result[place + offset : place + offset + width] = struct.pack("<I", value)[:width]
    return bytes(result)


def csv(random: Random, columns: int) -> bytes:
    rows = [[repr(float(value)) for value in row] for row in _values(columns)]
    for _ in range(random.choice([0, 1, 1, 2, 4])):
        row = random.choice(rows)
        match random.randrange(4):
            case 0 if row:
                row[random.randrange(len(row))] = random.choice(
                    [*NUMBERS, "nan", "inf", "-inf", "x", "", "0x1p3", "١", '"1"', "1e-400"]
                )
            case 1:
                row.append("1")
            case 2:
                row.clear()
            case 3:
                rows.insert(0, ["x"] * random.choice([1, columns]))
    text = "\n".join(random.choice([",", ";", " ", ", ", ","]).join(row) for row in rows)
    data = text.encode() + random.choice([b"\n", b"", b"\r\n", b"\0"])
    return bytes_damaged(random, data) if random.random() < 0.5 else data
