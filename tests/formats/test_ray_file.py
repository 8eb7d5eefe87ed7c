"""Files of rays and results: formats as documented in docs/files.md."""

from __future__ import annotations

import contextlib
from types import SimpleNamespace

import numpy as np
import pytest

from conicoid._util.files import replace_file
from conicoid.io.array_file import check_output, write_arrays, write_columns
from conicoid.io.ray_file import read_rays
from conicoid.io.result_file import table_columns

RNG = np.random.default_rng(3)
RAYS = RNG.normal(size=(5, 6))


def test_npy(tmp_path):
    np.save(tmp_path / "rays.npy", RAYS)
    table = read_rays(tmp_path / "rays.npy")
    assert (table.rays.origins == RAYS[:, :3]).all()
    assert (table.rays.directions == RAYS[:, 3:]).all()
    assert (table.t_min, table.t_max) == (None, None)


def test_npy_keeps_the_leading_shape_and_takes_other_numbers(tmp_path):
    np.save(tmp_path / "rays.npy", np.arange(24, dtype=np.float32).reshape(2, 2, 6))
    table = read_rays(tmp_path / "rays.npy")
    assert table.rays.origins.shape == (2, 2, 3)
    assert table.rays.directions.dtype == np.float64
    assert table.rays.directions[1, 1].tolist() == [21, 22, 23]


def test_npz(tmp_path):
    np.savez(tmp_path / "rays.npz", origins=RAYS[:, :3], directions=RAYS[0, 3:], t_min=np.full(5, -1.0), other=["x"])
    table = read_rays(tmp_path / "rays.npz")
    assert (table.rays.directions == RAYS[0, 3:]).all()
    assert table.t_min.tolist() == [-1] * 5
    assert table.t_max is None


@pytest.mark.parametrize("header", ["", "ox,oy,oz,dx,dy,dz\n", "# rays\n\n"])
def test_csv(tmp_path, header):
    lines = "".join(",".join(map(repr, row)) + "\n" for row in RAYS.tolist())
    (tmp_path / "rays.csv").write_text("\ufeff" + header + lines, encoding="utf-8")
    table = read_rays(tmp_path / "rays.csv")
    assert (table.rays.origins == RAYS[:, :3]).all()
    assert (table.rays.directions == RAYS[:, 3:]).all()


def test_csv_of_nothing(tmp_path):
    (tmp_path / "rays.csv").write_text("ox,oy,oz,dx,dy,dz\n")
    assert read_rays(tmp_path / "rays.csv").rays.origins.shape == (0, 3)


@pytest.mark.parametrize(
    ("name", "content", "phrase"),
    [
        ("rays.txt", b"1 2 3 4 5 6\n", "are read from .npy, .npz, .csv, .parquet or .zarr files"),
        ("rays.csv", b"1,2,3,4,5\n", "rays.csv: 1: must be 6 numbers"),
        ("rays.csv", b"\x00\xff", "not a text in UTF-8"),
        ("rays.npy", b"no", "is not a .npy file"),
        ("rays.npz", b"no", "is not a .npz file"),
        ("rays.npz", b"PK\x03\x04", "is not a .npz file"),
    ],
)
def test_bad_files(tmp_path, name, content, phrase):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ValueError, match=phrase.replace(".", r"\.")):
        read_rays(tmp_path / name)


@pytest.mark.parametrize(
    ("array", "phrase"),
    [(np.ones((3, 5)), r"shape \(\.\.\., 6\)"), (np.array("x"), "is not|must be"), (np.array(1.0), r"shape \(\.\.\., 6\)"),
     (np.ones((2, 6), complex), "must be numbers")],
)  # fmt: skip
def test_bad_arrays(tmp_path, array, phrase):
    np.save(tmp_path / "rays.npy", array)
    with pytest.raises(ValueError, match=phrase):
        read_rays(tmp_path / "rays.npy")


def test_bad_npz(tmp_path):
    np.savez(tmp_path / "rays.npz", origin=RAYS[:, :3])
    with pytest.raises(ValueError, match=r"must hold the arrays origins and directions.*got origin"):
        read_rays(tmp_path / "rays.npz")
    np.savez(tmp_path / "rays.npz", origins=np.array(["a"]), directions=RAYS[:, 3:])
    with pytest.raises(ValueError, match="origins must hold numbers"):
        read_rays(tmp_path / "rays.npz")


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_rays(tmp_path / "rays.npy")
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(IsADirectoryError):
        read_rays(tmp_path / "folder.csv")


HITS = {
    "t": np.array([[1.5, np.inf]]),
    "point": np.array([[[1, 2, 3], [np.nan] * 3]]),
    "normal": np.array([[[0, 0, 1.0], [np.nan] * 3]]),
    "uv": np.array([[[0.25, 0.1], [np.nan] * 2]]),
    "body": np.array([[0, -1]], np.int32),
    "face": np.array([[2, -1]], np.int32),
    "surface": np.array([[7, -1]], np.int32),
    "entering": np.array([[True, False]]),
}
SPANS = {
    "offsets": np.array([0, 2, 2, 3]),
    "t_enter": np.array([0.1, 0.2, -np.inf]),
    "t_exit": np.array([1.0, 2.0, 3.0]),
    "body": np.array([0, 1, 0], np.int32),
    "enter_clipped": np.array([False, False, True]),
    "exit_clipped": np.array([False, True, False]),
}


def test_hits_as_csv(tmp_path):
    write_columns(tmp_path / "hits.csv", table_columns("first_hit", SimpleNamespace(**HITS), False))
    assert (tmp_path / "hits.csv").read_text() == (
        "t,x,y,z,normal_x,normal_y,normal_z,u,v,body,face,surface,entering\n"
        "1.5,1.0,2.0,3.0,0.0,0.0,1.0,0.25,0.1,0,2,7,1\n"
        "inf,nan,nan,nan,nan,nan,nan,nan,nan,-1,-1,-1,0\n"
    )


def test_spans_as_csv(tmp_path):
    write_columns(tmp_path / "spans.csv", table_columns("spans", SimpleNamespace(**SPANS), False))
    assert (tmp_path / "spans.csv").read_text() == (
        "ray,body,t_enter,t_exit,enter_clipped,exit_clipped\n0,0,0.1,1.0,0,0\n0,1,0.2,2.0,0,1\n2,0,-inf,3.0,1,0\n"
    )


@pytest.mark.parametrize("arrays", [HITS, SPANS])
def test_npz_keeps_everything(tmp_path, arrays):
    write_arrays(tmp_path / "out.npz", arrays)
    with np.load(tmp_path / "out.npz", allow_pickle=False) as found:
        assert set(found.files) == set(arrays)
        for name, array in arrays.items():
            assert np.array_equal(found[name], array, equal_nan=array.dtype.kind == "f")
            assert found[name].dtype == array.dtype


def test_results_of_other_kinds_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"written as \.npz or \.csv"):
        check_output(tmp_path / "hits.txt")


def test_a_failed_output_leaves_the_old_one(tmp_path):
    path = tmp_path / "out.txt"
    path.write_text("old")
    path.chmod(0o640)
    with contextlib.suppress(RuntimeError), replace_file(path) as partial:
        partial.write_text("half")
        raise RuntimeError
    assert path.read_text() == "old"
    with replace_file(path) as partial:
        partial.write_text("new")
    assert path.read_text() == "new"
    assert path.stat().st_mode & 0o777 == 0o640
    assert [p.name for p in tmp_path.iterdir()] == ["out.txt"]


def test_outputs_that_cannot_be(tmp_path):
    for path, error in (
        (tmp_path, IsADirectoryError),
        (tmp_path / "no" / "x", FileNotFoundError),
        ("/dev/null", OSError),
    ):
        with pytest.raises(error), replace_file(path):
            pass


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "real.txt").write_text("old")
    (tmp_path / "link.txt").symlink_to("real.txt")
    with replace_file(tmp_path / "link.txt") as partial:
        partial.write_text("new")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "real.txt").read_text() == "new"
