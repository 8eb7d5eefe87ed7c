"""Files of numbers made to hurt: refusals in one line that names them, before memory is taken, and without waiting."""

import io
import os
import resource
import struct
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.io import npz
from conicoid.io.ray_file import RayFile

RAYS = np.arange(30.0).reshape(5, 6) + 1
MB = 1 << 20


def npy(header: str, data: bytes = b"", version: int = 1) -> bytes:
    length = len(header).to_bytes(2 if version == 1 else 4, "little")
    return b"\x93NUMPY" + bytes([version, 0]) + length + header.encode() + data


def plain(kind: str = "<f8", shape: str = "(5, 6)", data: bytes = b"") -> bytes:
    return npy(f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n", data)


def archive_of(compression: int = zipfile.ZIP_DEFLATED, **members: bytes) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", compression) as archive:
        for name, data in members.items():
            archive.writestr(f"{name}.npy", data)
    return file.getvalue()


def archive_with(data: bytes, **fields: int) -> bytes:
    """Return an archive with fields of its first member changed, in the directory and before the member itself."""
    result = bytearray(data)
    places = {
        "flags": (8, 6, "<H"),
        "kind": (10, 8, "<H"),
        "crc": (16, 14, "<I"),
        "stored": (20, 18, "<I"),
        "size": (24, 22, "<I"),
    }
    central, local = data.index(b"PK\x01\x02"), data.index(b"PK\x03\x04")
    for name, value in fields.items():
        in_directory, before, form = places[name]
        struct.pack_into(form, result, central + in_directory, value)
        struct.pack_into(form, result, local + before, value)
    return bytes(result)


def refusal(path: Path, content: bytes) -> str:
    """Return the refusal of a file of rays, one line that names it."""
    path.write_bytes(content)
    with pytest.raises(ValueError) as caught:  # noqa: PT011  its text is what the caller looks at
        RayFile(path, whole=True).read()
    text = str(caught.value)
    assert text.startswith(f"{path}: ")
    assert len(text.splitlines()) == 1
    return text


GOOD = plain(shape="(5, 3)", data=RAYS[:, :3].tobytes())
ZIP = archive_of(origins=GOOD, directions=GOOD)

ARRAYS = {
    "nothing": (b"", "ends too early"),
    "something else": (b"\x93NUMPZ\x01\x00\x10\x00" + b" " * 16, "does not begin like one"),
    "another version": (npy("{}", version=4), "version 4.0"),
    "a header without end": (b"\x93NUMPY\x02\x00\xff\xff\xff\xff", "header is 4,294,967,295 bytes long"),
    "half a header": (b"\x93NUMPY\x01\x00\x50\x00{'descr'", "ends too early"),
    "a header of code": (npy("{'descr': __import__('os').getcwd(), 'fortran_order': False, 'shape': (5, 6)}"), "header is not"),
    "a header of escapes": (npy("{'descr': '\\\\d', 'fortran_order': False, 'shape': (5, 6)}"), "rays must be numbers"),
    "a deep header": (npy("(" * 5000), "header is not"),
    "too few entries": (npy("{'descr': '<f8', 'shape': (5, 6)}"), "must say descr, fortran_order and shape"),
    "one too many": (npy("{'descr': '<f8', 'fortran_order': False, 'shape': (5, 6), 'x': 'y'}"), "nothing else"),
    "an entry twice": (npy("{'descr': '<f8', 'descr': '<f4', 'fortran_order': False, 'shape': (5, 6)}"), "header is not"),
    "objects": (plain("|O", data=bytes(240)), "Python objects"),
    "records": (npy("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (5, 6)}", bytes(240)), "header is not"),
    "texts": (plain("<U9", data=bytes(1080)), "rays must be numbers of shape (..., 6)"),
    "dates": (plain("<M8[s]", data=bytes(240)), "rays must be numbers of shape (..., 6)"),
    "a negative shape": (plain(shape="(-5, 6)", data=bytes(240)), "header is not"),
    "a huge shape": (plain(shape="(99999999999999999999999, 6)"), "not that of an array"),
    "an impossible shape": (plain(shape="(100000000000000000, 6)"), "that of no array"),
    "an empty shape of astronomical size": (plain(shape="(0, 100000000000000000, 6)"), "that of no array"),
    "a shape of too many axes": (plain(shape="(" + "1, " * 60 + "6)"), "not that of an array"),
    "a shape that the file cannot hold": (plain(shape="(1000000000, 6)"), "announces 48,000,000,0"),
    "too few numbers": (plain(data=bytes(239)), "announces"),
    "something after the numbers": (plain(data=bytes(241)), "announces"),
    "numbers beyond float64": (plain("<f16", "(1, 6)", np.full(6, np.longdouble("1e4000")).tobytes()), "beyond the range of float64"),
}  # fmt: skip

ARCHIVES = {
    "encrypted": (archive_with(ZIP, flags=1), "origins is not an array of numbers (it is encrypted)"),
    "compressed in an unknown way": (archive_with(ZIP, kind=97), "compressed in a way"),
    "bzip2": (archive_of(zipfile.ZIP_BZIP2, origins=GOOD, directions=GOOD), "compressed in a way"),
    "lzma": (archive_of(zipfile.ZIP_LZMA, origins=GOOD, directions=GOOD), "compressed in a way"),
    "a wrong checksum": (archive_with(ZIP, crc=1), "origins is not an array of numbers (Bad CRC-32"),
    "a wrong size": (archive_with(ZIP, size=200), "announces"),
    "no such compressed data": (archive_with(archive_of(zipfile.ZIP_STORED, origins=GOOD, directions=GOOD), kind=8), "origins is not an array of numbers"),
    "objects": (archive_of(origins=plain("|O", "(5, 3)"), directions=GOOD), "Python objects"),
    "more numbers than declared": (archive_of(origins=GOOD + b"x", directions=GOOD), "announces"),
    "fewer numbers than declared": (archive_of(origins=GOOD[:-1], directions=GOOD), "announces"),
    "no arrays": (archive_of(other=GOOD), "must hold the arrays origins and directions"),
    "names that drive a terminal": (archive_of(**{"\x1b[31m": GOOD}), "got \\x1b[31m"),
    "rays that do not fit together": (archive_of(origins=GOOD, directions=plain(shape="(4, 3)", data=bytes(96))), "do not broadcast"),
    "points of two": (archive_of(origins=plain(shape="(5, 2)", data=bytes(80)), directions=GOOD), "origins must have shape (..., 3)"),
    "intervals of too many": (archive_of(origins=GOOD, directions=GOOD, t_max=plain(shape="(4,)", data=bytes(32))), "t_min and t_max must broadcast"),
    "an interval to nowhere": (archive_of(origins=GOOD, directions=GOOD, t_max=plain(shape="()", data=struct.pack("<d", np.nan))), "t_max must not be NaN"),
}  # fmt: skip


@pytest.mark.parametrize("name", ARRAYS)
def test_arrays(name, tmp_path):
    content, phrase = ARRAYS[name]
    assert phrase in refusal(tmp_path / "rays.npy", content)


@pytest.mark.parametrize("name", [name for name, (_, phrase) in ARRAYS.items() if "rays must" not in phrase])
def test_balls(name, tmp_path):
    """A scene refers to the same files; the error stands at the place in the scene."""
    (tmp_path / "balls.npy").write_bytes(ARRAYS[name][0])
    (tmp_path / "scene.yaml").write_text("bodies:\n  - shape: {Spheres: {file: balls.npy}}\n")
    with pytest.raises(co.SceneFileError) as caught:
        co.load(tmp_path / "scene.yaml")
    assert "scene.yaml:2:29: bodies[0]: Spheres: file: balls.npy " in str(caught.value)
    assert ARRAYS[name][1] in str(caught.value)


@pytest.mark.parametrize("name", ARCHIVES)
def test_archives(name, tmp_path):
    content, phrase = ARCHIVES[name]
    assert phrase in refusal(tmp_path / "rays.npz", content)


@pytest.mark.parametrize("name", ARRAYS)
def test_arrays_in_archives(name, tmp_path):
    assert "origins" in refusal(tmp_path / "rays.npz", archive_of(origins=ARRAYS[name][0], directions=GOOD))


def test_arrays_of_numpy_are_read(tmp_path):
    for kind in ("<f8", ">f8", "<f4", "<i8", "|u1", "<f2", ">i2"):
        for version in ((1, 0), (2, 0), (3, 0)):
            for values in (RAYS, np.asfortranarray(RAYS), RAYS[:0], RAYS[0], RAYS.reshape(5, 1, 6)):
                with (tmp_path / "rays.npy").open("wb") as file:
                    np.lib.format.write_array(file, values.astype(kind), version, allow_pickle=False)
                table = RayFile(tmp_path / "rays.npy", whole=True).read()
                assert np.array_equal(table.rays.origins, values[..., :3])
                assert np.array_equal(table.rays.directions, values[..., 3:])
    for save in (np.savez, np.savez_compressed):
        save(tmp_path / "rays.npz", origins=RAYS[:, :3], directions=np.asfortranarray(RAYS[:, 3:]), t_min=np.int8(-3))
        table = RayFile(tmp_path / "rays.npz", whole=True).read()
        assert np.array_equal(table.rays.directions, RAYS[:, 3:])
        assert (table.t_min == -3).all()
        hits = co.Scene([co.HalfSpace((1, 0, 0), 1e3)]).first_hit(table.rays)  # a kernel reads rows
        assert np.array_equal(hits.t, co.Scene([co.HalfSpace((1, 0, 0), 1e3)]).first_hit(RAYS[:, :3], RAYS[:, 3:]).t)


def test_small_files_do_not_unpack_to_large_ones(tmp_path, monkeypatch):
    """An honest archive of equal numbers has a thousandth of its unpacked size. The test makes the limits small for it."""
    zeros = plain(shape="(100000, 3)", data=bytes(2_400_000))
    ones = plain(shape="(100000, 3)", data=np.ones(300_000).tobytes())
    (tmp_path / "rays.npz").write_bytes(archive_of(origins=zeros, directions=ones))
    assert len(RayFile(tmp_path / "rays.npz", whole=True).read().rays) == 100_000
    monkeypatch.setattr(npz, "FREE_BYTES", 3 * MB)
    monkeypatch.setattr(npz, "MAX_COMPRESSION", 10)
    assert "unpacks to" in refusal(tmp_path / "rays.npz", archive_of(origins=zeros, directions=ones))


def test_announced_sizes_are_refused_before_memory_is_taken(tmp_path):
    """The archive, the header and the sizes of the member all announce 24 GB."""
    claim = plain(shape="(1000000000, 3)")
    tracemalloc.start()
    content = archive_with(archive_of(origins=claim + bytes(3 * MB), directions=GOOD), size=0xFFFFFFFF)
    assert "unpacks to 22.4 GiB" in refusal(tmp_path / "rays.npz", content)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 20 * MB


def test_rays_that_multiply_are_refused(tmp_path):
    """A megabyte of origins times a megabyte of directions is two billion rays."""
    column = plain(shape="(50000, 1, 3)", data=bytes(1_200_000))
    row = plain(shape="(1, 50000, 3)", data=np.ones(150_000).tobytes())
    assert "2,500,000,000 rays" in refusal(tmp_path / "rays.npz", archive_of(origins=column, directions=row))


def test_sparse_files_take_no_memory(tmp_path):
    """A file of 100 GB holds no data at all."""
    with (tmp_path / "rays.npy").open("wb") as file:
        header = plain(shape="(2000000000, 6)")
        file.write(header)
        try:
            file.truncate(len(header) + 2_000_000_000 * 48)
        except OSError:
            pytest.skip("this disk has no such files")
    with pytest.raises(ValueError, match=r"rays\.npy: takes 89\.4 GiB of memory"):
        RayFile(tmp_path / "rays.npy", whole=True).read()


def test_a_directory_without_end_is_not_read(tmp_path):
    content = bytearray(archive_of(origins=GOOD, directions=GOOD) + bytes(6 * MB))
    end = content.index(b"PK\x05\x06")
    content[-22:] = content[end : end + 22]
    struct.pack_into("<I", content, len(content) - 10, 5 * MB)
    assert "is not a .npz file (its directory is too long)" in refusal(tmp_path / "rays.npz", bytes(content))


@pytest.mark.parametrize("suffix", [".npy", ".npz", ".csv"])
def test_pipes_and_devices_are_not_read(suffix, tmp_path):
    os.mkfifo(tmp_path / f"pipe{suffix}")
    (tmp_path / f"zero{suffix}").symlink_to("/dev/zero")
    for name in ("pipe", "zero"):
        with pytest.raises(OSError, match="is not a regular file") as caught:
            RayFile(tmp_path / f"{name}{suffix}", whole=True).read()
        assert caught.value.filename == str(tmp_path / f"{name}{suffix}")
        (tmp_path / "scene.yaml").write_text(f"bodies: [{{shape: {{Spheres: {{file: {name}{suffix}}}}}}}]\n")
        with pytest.raises(co.SceneFileError, match=r"is not an existing file|must stay inside"):
            co.load(tmp_path / "scene.yaml")


def test_links_to_files_are_read(tmp_path):
    np.save(tmp_path / "real.npy", RAYS)
    (tmp_path / "link.npy").symlink_to("real.npy")
    assert np.array_equal(RayFile(tmp_path / "link.npy", whole=True).read().rays.origins, RAYS[:, :3])


@pytest.mark.parametrize(
    ("content", "phrase"),
    [
        (b"1," * 100_000, "rays.csv: 1: is longer than 10,000 characters"),
        (b"1,2,3,4,5,1e999\n", "1: must be 6 numbers"),
        (b"1,2,3,4,5,6\n1,2,3,4,5,1e-999\n", "2: must be 6 numbers"),
        (b"1,2,3,4,5,6\n1,2,3,4,5,\x1b[31m\n", "'1,2,3,4,5,\\x1b[31m'"),
    ],
)
def test_texts(content, phrase, tmp_path):
    assert phrase in refusal(tmp_path / "rays.csv", content)


@pytest.mark.parametrize("name", ["x" * 300 + ".npy", "round.npy", "secret.npy"])
def test_files_of_balls_that_cannot_be_read(name, tmp_path):
    """There are names that no disk takes, cycles of links, and files without permission."""
    (tmp_path / "round.npy").symlink_to("round.npy")
    np.save(tmp_path / "secret.npy", np.ones((1, 4)))
    (tmp_path / "secret.npy").chmod(0)
    (tmp_path / "scene.yaml").write_text(f"bodies:\n  - shape: {{Spheres: {{file: {name}}}}}\n")
    if name == "secret.npy" and os.access(tmp_path / name, os.R_OK):
        pytest.skip("an administrator reads everything")
    with pytest.raises(co.SceneFileError, match=r"scene\.yaml:2:29: "):
        co.load(tmp_path / "scene.yaml")


def test_little_memory_is_reported(tmp_path):
    """The error names the file whose array does not fit. The test limits the memory of a process of its own."""
    np.save(tmp_path / "rays.npy", np.ones((5_000_000, 6)))
    child = os.fork()
    if child == 0:
        try:
            taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (taken + 100 * MB, taken + 100 * MB))
            RayFile(tmp_path / "rays.npy", whole=True).read()
        except ValueError as error:
            os._exit(0 if "rays.npy: takes 0.2 GiB, more memory than there is left" in str(error) else 1)
        except BaseException:
            os._exit(2)
        os._exit(3)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
