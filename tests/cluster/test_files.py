"""Files of rays and answers that are read and written part by part: every format has the same numbers."""

import os

import numpy as np
import pytest

import conicoid as co
from conicoid._util.files import refuse_devices

from ..command_line import run
from . import subject
from .test_commands import traced

COUNT = 500


@pytest.fixture(scope="module")
def rays():
    return subject.rays(COUNT)


def failure_of_trace(folder, rays, output, *options):
    result = run("trace", folder / "scene.yaml", folder / rays, "-o", folder / output, *options)
    assert result.exit_code == 2, result.stderr
    return result.stderr


def ends(count):
    return np.linspace(2, 9, count)


def with_ends(folder, rays):
    np.savez(folder / "ends.npz", origins=rays.origins, directions=rays.directions, t_min=np.float64(-1),
             t_max=ends(COUNT))  # fmt: skip
    return "ends.npz"


@pytest.mark.parametrize("name", ["stored.npz", "packed.npz", "ends.npz"])
def test_npz_in_and_out(folder, rays, name):
    with_ends(folder, rays)
    whole = co.Hits.load(traced(folder, name, "whole.npz"))
    assert co.Hits.load(traced(folder, name, "parts.npz", "--chunk", 37)) == whole
    spans = co.Spans.load(traced(folder, name, "whole.npz", "--spans"))
    parts = co.Spans.load(traced(folder, name, "parts.npz", "--spans", "--chunk", 37))
    assert parts == spans
    assert np.array_equal(parts.lengths("material", overlaps="both"), spans.lengths("material", overlaps="both"))


def test_spans_of_a_picture(folder, rays):
    np.savez(folder / "picture.npz", origins=rays.origins.reshape(20, 25, 3), directions=np.array([0.0, 0.0, -1.0]))
    whole = co.Spans.load(traced(folder, "picture.npz", "whole.npz", "--spans"))
    assert co.Spans.load(traced(folder, "picture.npz", "parts.npz", "--spans", "--chunk", 64)) == whole
    assert subject.scene().stream(folder / "picture.npz", "spans", out=folder / "shaped.npz") == COUNT
    shaped = co.Spans.load(folder / "shaped.npz")
    assert shaped.shape == (20, 25)
    assert np.array_equal(shaped.t_exit_error, whole.t_exit_error)


def test_spawned_rays_of_a_file(folder, rays):
    spawned = subject.scene().first_hit(rays).spawn((0.3, 0.2, 1.0))  # some start on surfaces, misses stay misses
    spawned.save(folder / "spawned.npz")
    whole = co.Hits.load(traced(folder, "spawned.npz", "whole.npz"))
    assert co.Hits.load(traced(folder, "spawned.npz", "parts.npz", "--chunk", 37)) == whole
    assert not np.array_equal(whole.t, subject.scene().first_hit(rays.origins, (0.3, 0.2, 1.0)).t)


def test_columns_that_come_first_in_pieces(folder, rays):
    table = np.load(folder / "rays.npy")
    np.save(folder / "columns.npy", np.asfortranarray(table))
    np.savez(folder / "columns.npz", origins=np.asfortranarray(table[:, :3]), directions=rays.directions)
    whole = traced(folder, "rays.npy", "whole.csv").read_bytes()
    for name in ("columns.npy", "columns.npz"):
        assert traced(folder, name, "parts.csv", "--chunk", 64).read_bytes() == whole


@pytest.mark.parametrize("spans", [(), ("--spans",)])
@pytest.mark.parametrize("options", [("--errors",), ("--t-min", -1, "--t-max", 6.5), ("--errors", "--t-max", 7)])
def test_options_of_chunks(folder, options, spans):
    whole = traced(folder, "rays.npy", "whole.csv", *spans, *options).read_bytes()
    assert traced(folder, "rays.npy", "parts.csv", *spans, *options, "--chunk", 64).read_bytes() == whole
    plain = traced(folder, "rays.npy", "plain.csv", *spans).read_bytes()
    assert plain != whole


def test_mistakes_in_streamed_files(folder, rays):
    with_ends(folder, rays)
    assert "holds t_max of each ray, so one t_max for all, 3, cannot be given" in failure_of_trace(
        folder, "ends.npz", "x.csv", "--chunk", 9, "--t-max", 3
    )
    directions = rays.directions.copy()
    directions[211] = 0
    np.savez_compressed(folder / "zero.npz", origins=rays.origins, directions=directions)
    assert "ray 211: direction must not be zero" in failure_of_trace(folder, "zero.npz", "x.csv", "--chunk", 50)
    np.savez(folder / "lacking.npz", origins=rays.origins)
    assert "must hold the arrays origins and directions" in failure_of_trace(
        folder, "lacking.npz", "y.csv", "--chunk", 50
    )
    data = bytearray((folder / "packed.npz").read_bytes())
    data[len(data) // 4] ^= 0xFF
    (folder / "damaged.npz").write_bytes(data)
    assert "damaged.npz: origins is not an array of numbers (" in failure_of_trace(
        folder, "damaged.npz", "z.csv", "--chunk", 50
    )
    assert "--errors goes with .csv" in failure_of_trace(folder, "rays.npy", "x.npz", "--chunk", 9, "--errors")


def test_streams_of_file_names(folder, rays):
    scene, expected = subject.scene(), subject.scene().first_hit(rays)
    for name in ("rays.npy", "packed.npz"):
        parts = list(scene.stream(folder / name, chunk=99))
        assert np.array_equal(np.concatenate([part.t for part in parts]), expected.t)
    assert scene.stream(folder / "rays.npy", out=folder / "hits.npz", chunk=99) == COUNT
    assert co.Hits.load(folder / "hits.npz") == expected
    camera = co.Rays.from_camera(co.Camera((5, 1, 2), (0, 0, 0)), 33, 20)
    assert scene.stream(camera, "spans", out=folder / "spans.npz", chunk=99) == 660
    assert co.Spans.load(folder / "spans.npz") == scene.spans(camera.to_rays())
    assert scene.stream(camera, "crossings", out=folder / "crossings.npz", chunk=99) == 660
    assert co.Crossings.load(folder / "crossings.npz") == scene.crossings(camera.to_rays())
    with pytest.raises(ValueError, match="direction must not be zero"):
        scene.stream(np.zeros((3, 6)), out=folder / "never.npz")
    assert not list(folder.glob("never*"))


@pytest.mark.parametrize("query", ["occluded", "lengths", "line_integral"])
def test_streams_of_numbers(folder, query):
    scene, camera = subject.scene(), co.Rays.from_camera(co.Camera((5, 1, 2), (0, 0, 0)), 33, 20)
    weights = np.linspace(0.5, 2, scene.body_count * 2).reshape(-1, 2)
    options = dict(values=weights, overlaps="both") if query == "line_integral" else {}
    options |= dict(by="material", overlaps="both") if query == "lengths" else {}
    positional = [options["values"]] if query == "line_integral" else []
    rest = {name: value for name, value in options.items() if name != "values"}
    expected = getattr(scene, query)(*positional, camera.to_rays(), **rest)
    for suffix in ("npy", "npz", "csv"):
        assert scene.stream(camera, query, out=folder / f"found.{suffix}", chunk=99, **options) == 660
    assert np.array_equal(np.load(folder / "found.npy", mmap_mode="r"), expected)
    assert np.array_equal(np.load(folder / "found.npz")[query], expected)
    heading, *lines = (folder / "found.csv").read_text().splitlines()
    assert np.array_equal(np.genfromtxt(lines, delimiter=",").reshape(expected.shape), expected.astype(float))
    assert scene.stream(np.zeros((0, 6)), query, out=folder / "none.csv", **options) == 0
    assert (folder / "none.csv").read_text() == heading + "\n"
    assert scene.stream(np.zeros((0, 6)), query, out=folder / "none.npy", **options) == 0
    assert np.load(folder / "none.npy").shape == (0, *expected.shape[2:])
    with pytest.raises(ValueError, match=r"x.txt: results are written as .npy, .npz, .csv, .parquet or .zarr"):
        scene.stream(camera, query, out=folder / "x.txt", **options)


def test_streams_of_numbers_by_libraries(folder, rays):
    parquet, zarr = pytest.importorskip("pyarrow.parquet"), pytest.importorskip("zarr")
    scene = subject.scene()
    expected = scene.lengths(rays, overlaps="both")
    for suffix in ("parquet", "zarr"):
        assert scene.stream(rays, "lengths", out=folder / f"found.{suffix}", chunk=99, overlaps="both") == COUNT
    table = parquet.read_table(folder / "found.parquet")
    assert np.array_equal(np.stack([column.to_numpy() for column in table.columns], axis=1), expected)
    assert np.array_equal(np.asarray(zarr.open_group(str(folder / "found.zarr"), mode="r")["lengths"]), expected)
    assert scene.stream(rays, "crossings", out=folder / "crossings.parquet", chunk=99) == COUNT
    assert np.array_equal(parquet.read_table(folder / "crossings.parquet")["t"].to_numpy(), scene.crossings(rays).t)


def test_crossings_in_lines(folder, rays):
    scene = subject.scene()
    scene.stream(rays, "crossings", out=folder / "crossings.csv", chunk=37)
    heading, *lines = (folder / "crossings.csv").read_text().splitlines()
    table = dict(zip(heading.split(","), np.genfromtxt(lines, delimiter=",").T, strict=True))
    expected = scene.crossings(rays)
    assert np.array_equal(np.bincount(table["ray"].astype(int), minlength=COUNT), np.diff(expected.offsets))
    for name in ("t", "body", "face", "surface", "entering", "before", "after", "t_error"):
        assert np.array_equal(table[name], getattr(expected, name).astype(float)), name
    assert np.array_equal(np.stack([table[name] for name in "xyz"], axis=1), expected.point)


def test_parquet(folder, rays):
    parquet = pytest.importorskip("pyarrow.parquet")
    arrow = pytest.importorskip("pyarrow")
    names, numbers = ("ox", "oy", "oz", "dx", "dy", "dz"), [*rays.origins.T, *rays.directions.T]
    columns = dict(zip(names, numbers, strict=True))
    # Columns in another order, with one more, and in groups of 90 rows
    table = arrow.table({"id": np.arange(COUNT)} | dict(reversed(columns.items())))
    parquet.write_table(table, folder / "rays.parquet", row_group_size=90)
    parquet.write_table(arrow.table(columns | {"t_max": ends(COUNT)}), folder / "ends.parquet")
    with_ends(folder, rays)
    for options in ((), ("--spans",), ("--spans", "--errors")):
        whole = np.genfromtxt(traced(folder, "rays.npy", "whole.csv", *options), delimiter=",", names=True)
        for chunk in (("--chunk", 37), ()):
            found = parquet.read_table(traced(folder, "rays.parquet", "parts.parquet", *options, *chunk))
            assert tuple(found.column_names) == whole.dtype.names
            for name in found.column_names:
                assert np.array_equal(found[name].to_numpy().astype(float), whole[name], equal_nan=True), name
    assert co.Rays.load(folder / "rays.parquet") == rays
    with pytest.raises(ValueError, match=r"ends.parquet: holds t_max, and rays have no intervals"):
        co.Rays.load(folder / "ends.parquet")
    limited = parquet.read_table(traced(folder, "ends.parquet", "limited.parquet"))
    assert np.array_equal(limited["t"].to_numpy(), subject.scene().first_hit(rays, None, 0, ends(COUNT)).t)
    parquet.write_table(arrow.table({"x": [1.0], "y": [2.0]}), folder / "other.parquet")
    assert "must have the columns ox, oy, oz, dx, dy, dz" in failure_of_trace(folder, "other.parquet", "x.csv")
    parquet.write_table(arrow.table(columns | {"dz": ["up"] * COUNT}), folder / "texts.parquet")
    assert "column 'dz' must hold numbers, got string" in failure_of_trace(folder, "texts.parquet", "x.csv")
    holes = [None, *rays.origins[1:, 0].tolist()]
    parquet.write_table(arrow.table(columns | {"ox": holes}), folder / "holes.parquet")
    assert "column 'ox' has 1 empty places" in failure_of_trace(folder, "holes.parquet", "h.csv")
    (folder / "damaged.parquet").write_bytes(b"PAR1" + bytes(100))
    assert "damaged.parquet: is not a Parquet file" in failure_of_trace(folder, "damaged.parquet", "x.csv")


def test_zarr(folder, rays):
    zarr = pytest.importorskip("zarr")
    table = np.concatenate([rays.origins, rays.directions], axis=1)
    zarr.save_array(str(folder / "rays.zarr"), table.reshape(20, 25, 6))
    group = zarr.open_group(str(folder / "ends.zarr"), mode="w")
    for name, values in (("origins", rays.origins), ("directions", rays.directions), ("t_max", ends(COUNT))):
        group.create_array(name, data=values, chunks=(64, *values.shape[1:]))
    scene = subject.scene()
    picture = co.Rays(rays.origins.reshape(20, 25, 3), rays.directions.reshape(20, 25, 3))
    assert co.Rays.load(folder / "rays.zarr") == picture
    group.create_array("wavelength", data=ends(COUNT))
    result = run("trace", folder / "scene.yaml", folder / "ends.zarr", "-o", folder / "noted.csv")
    assert "ends.zarr: not read: wavelength; arrays of rays are origins, directions, t_min, t_max" in result.stderr
    for options, expected in ((("--chunk", 37), scene.first_hit(picture)), (("--spans",), scene.spans(rays))):
        output = traced(folder, "rays.zarr", f"found{len(options)}.zarr", *options)
        expected.save(folder / "wanted.npz")
        found, arrays = zarr.open_group(str(output), mode="r"), np.load(folder / "wanted.npz")
        assert set(found.array_keys()) == set(arrays)
        for name, values in arrays.items():
            one = np.atleast_1d(values)
            own = np.asarray(found[name])
            if name == "starts":
                own = own[:1]
            assert np.array_equal(own, one, equal_nan=one.dtype.kind == "f"), name
    limited = list(scene.stream(folder / "ends.zarr", chunk=70))
    assert np.array_equal(np.concatenate([part.t for part in limited]), scene.first_hit(rays, None, 0, ends(COUNT)).t)
    opened = zarr.open_array(str(folder / "rays.zarr"), mode="r")
    assert "is a directory" in failure_of_trace(folder, "rays.npy", "found1.zarr")
    assert opened.shape == (20, 25, 6)
    (folder / "empty.zarr").mkdir()
    assert "empty.zarr: is not a folder of zarr" in failure_of_trace(folder, "empty.zarr", "x.csv")
    next(path for path in (folder / "ends.zarr" / "origins").rglob("0") if path.is_file()).write_bytes(b"\xff" * 30)
    assert "ends.zarr: array origins has a chunk that cannot be read" in failure_of_trace(folder, "ends.zarr", "y.csv")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes")
def test_pipes_and_devices_in_folders_are_refused(tmp_path):
    """A reader would wait for a pipe and never end with a device; cycles of links do no harm."""
    inner = tmp_path / "rays.zarr" / "c"
    inner.mkdir(parents=True)
    (inner / "again").symlink_to(tmp_path)
    (inner / "0").write_bytes(b"")
    refuse_devices(inner)
    for make in (os.mkfifo, lambda path: os.symlink("/dev/zero", path)):
        make(inner / "1")
        with pytest.raises(OSError, match="is not a regular file"):
            refuse_devices(tmp_path / "rays.zarr")
        (inner / "1").unlink()
    pytest.importorskip("zarr")
    os.mkfifo(tmp_path / "rays.zarr" / "zarr.json")
    with pytest.raises(OSError, match="is not a regular file"):
        co.Rays.load(tmp_path / "rays.zarr")


@pytest.mark.parametrize(("name", "module"), [("rays.parquet", "pyarrow"), ("rays.zarr", "zarr")])
def test_without_their_readers(folder, name, module, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, module, None)
    monkeypatch.setitem(__import__("sys").modules, f"{module}.parquet", None)
    (folder / name).touch()
    result = run("trace", folder / "scene.yaml", folder / name, "-o", folder / "x.csv")
    assert result.exit_code != 0
    assert f"pip install 'conicoid[{name.rpartition('.')[2]}]'" in result.stderr
