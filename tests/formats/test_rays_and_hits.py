"""Files of rays, hits and tables."""

import contextlib
import io
import pickle
from types import SimpleNamespace

import numpy as np
import pytest

import conicoid as co
from conicoid._util.files import replace_file
from conicoid.cli import app
from conicoid.io.array_file import check_output, write_columns
from conicoid.io.ray_file import RayFile
from conicoid.io.result_file import table_columns

from ..answers import assert_same_fields
from ..command_line import execute, run

# --- Files of rays and results: formats as documented in docs/files.md

RNG = np.random.default_rng(3)
ROWS = RNG.normal(size=(5, 6))


def test_npz(tmp_path):
    np.savez(tmp_path / "rays.npz", origins=ROWS[:, :3], directions=ROWS[0, 3:], t_min=np.full(5, -1.0), other=["x"])
    table = RayFile(tmp_path / "rays.npz", whole=True).read()
    assert (table.rays.directions == ROWS[0, 3:]).all()
    assert table.t_min.tolist() == [-1] * 5
    assert table.t_max is None


@pytest.mark.parametrize(
    "header",
    [
        "", "ox,oy,oz,dx,dy,dz\n", "# rays\n\n", "x,y,z,dx,dy,dz\n", "x y z u v w\n", "any words\n",
        "Origin X, Origin Y, Origin Z, Direction X, Direction Y, Direction Z\n",
        "origin_x origin_y origin_z direction_x direction_y direction_z\n",
    ],
)  # fmt: skip
def test_csv(tmp_path, header):
    lines = "".join(",".join(map(repr, row)) + "\n" for row in ROWS.tolist())
    (tmp_path / "rays.csv").write_text("\ufeff" + header + lines, encoding="utf-8")
    table = RayFile(tmp_path / "rays.csv", whole=True).read()
    assert (table.rays.origins == ROWS[:, :3]).all()
    assert (table.rays.directions == ROWS[:, 3:]).all()


def test_csv_of_nothing(tmp_path):
    (tmp_path / "rays.csv").write_text("ox,oy,oz,dx,dy,dz\n")
    assert RayFile(tmp_path / "rays.csv", whole=True).read().rays.origins.shape == (0, 3)


NO_ORDER = "rays.csv: 1: columns are read as origin x, .* is none of these"


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("rays.txt", b"1 2 3 4 5 6\n", "are read from .npy, .npz, .csv, .parquet or .zarr files"),
        ("rays.npy", b"no", "is not a .npy file"),
        ("rays.npz", b"no", "is not a .npz file"),
        ("rays.npz", b"PK\x03\x04", "is not a .npz file"),
        ("rays.csv", b"1,2,3,4,5\n", "rays.csv: 1: must be 6 numbers"),
        ("rays.csv", b"\x00\xff", "not a text in UTF-8"),
        ("rays.csv", b"0;0;5;0;0;-1\n", "must have 6 numbers .* with commas or spaces between, got only '0;0;5;0;0;-1'"),
        ("rays.csv", b"0;0;5;0;0;-1\n0;0;4;0;0;-1\n", "rays.csv: 2: must be 6 numbers .*, got '0;0;4;0;0;-1'"),
        ("rays.csv", b"abc\n", "got only 'abc'"),
        ("rays.csv", b"", "got nothing"),
        ("rays.csv", b"# nothing\n\n", "got nothing"),
        ("rays.csv", b"title\nx,y,z,dx,dy,dz\n0,0,5,0,0,-1\n", "rays.csv: 2: must be 6 numbers"),
        ("rays.csv", b"dx,dy,dz,x,y,z\n0,0,-1,0,0,5\n", "rays.csv: 1: columns must be in the order origin x,"),
        ("rays.csv", b"ox dx oy dy oz dz\n0,0,-1,0,0,5\n", "columns must be in the order"),
        ("rays.csv", b"u,v,w,x,y,z\n0,0,-1,0,0,5\n", "columns must be in the order"),
        ("rays.csv", b"t,x,y,z,u,v\n0,0,-1,0,0,5\n", "columns must be in the order"),
        ("rays.csv", b"x,y,z,theta,phi,r\n20,0,0,-1,0,0\n", NO_ORDER),
        ("rays.csv", b"x1,y1,z1,x2,y2,z2\n20,0,0,-1,0,0\n", NO_ORDER),
        ("rays.csv", b"x,y,z,to,azimuth,elevation\n20,0,0,-1,0,0\n", NO_ORDER),
        ("rays.csv", b"x_start,y_start,z_start,x_end,y_end,z_end\n20,0,0,-1,0,0\n", NO_ORDER),
    ],
)  # fmt: skip
def test_bad_files(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ValueError, match=message):
        RayFile(tmp_path / name, whole=True).read()


@pytest.mark.parametrize(("name", "suggestion"), [("tmin", "t_min"), ("T_MAX", "t_max"), ("origin", "origins")])
def test_misspelt_arrays(tmp_path, name, suggestion):
    arrays = {"origins": np.zeros((2, 3)), "directions": np.ones((2, 3)), name: np.ones(2)}
    np.savez(tmp_path / "rays.npz", **arrays)
    with pytest.raises(ValueError, match=rf"unknown array '{name}' \(did you mean '{suggestion}'\?\)"):
        RayFile(tmp_path / "rays.npz", whole=True).read()


def test_ray_notes_name_ignored_arrays(tmp_path):
    np.savez(tmp_path / "rays.npz", origins=np.zeros((2, 3)), directions=np.ones((2, 3)), wavelength=np.ones(2))
    assert list(RayFile(tmp_path / "rays.npz").notes()) == [
        f"{tmp_path / 'rays.npz'}: not read: wavelength; arrays of rays are origins, directions, t_min, t_max"
    ]


def test_ray_notes_of_a_header_alone(tmp_path):
    (tmp_path / "rays.csv").write_text("x,y,z,dx,dy,dz\n")
    assert list(RayFile(tmp_path / "rays.csv").notes()) == [f"{tmp_path / 'rays.csv'}: holds no rays"]
    (tmp_path / "rays.csv").write_text("x,y,z,dx,dy,dz\n1,2,3,4,5,6\n")
    assert list(RayFile(tmp_path / "rays.csv").notes()) == []


def test_rays_load_names_other_arrays(tmp_path):
    np.savez(tmp_path / "rays.npz", o=np.zeros((2, 3)), d=np.ones((2, 3)))
    with pytest.raises(ValueError, match="it lacks origins, directions and holds o, d"):
        co.Rays.load(tmp_path / "rays.npz")


@pytest.mark.parametrize(
    ("array", "phrase"),
    [(np.ones((3, 5)), r"shape \(\.\.\., 6\)"), (np.array("x"), "is not|must be"), (np.array(1.0), r"shape \(\.\.\., 6\)"),
     (np.ones((2, 6), complex), "must be numbers")],
)  # fmt: skip
def test_bad_arrays(tmp_path, array, phrase):
    np.save(tmp_path / "rays.npy", array)
    with pytest.raises(ValueError, match=phrase):
        RayFile(tmp_path / "rays.npy", whole=True).read()


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(FileNotFoundError):
        RayFile(tmp_path / "rays.npy", whole=True).read()
    (tmp_path / "folder.csv").mkdir()
    with pytest.raises(IsADirectoryError):
        RayFile(tmp_path / "folder.csv", whole=True).read()


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


@pytest.mark.parametrize(
    ("query", "columns", "text"),
    [
        (
            "first_hit", HITS,
            "t,x,y,z,normal_x,normal_y,normal_z,u,v,body,face,surface,entering\n"
            "1.5,1.0,2.0,3.0,0.0,0.0,1.0,0.25,0.1,0,2,7,1\n"
            "inf,nan,nan,nan,nan,nan,nan,nan,nan,-1,-1,-1,0\n",
        ),
        (
            "spans", SPANS,
            "ray,body,t_enter,t_exit,enter_clipped,exit_clipped\n0,0,0.1,1.0,0,0\n0,1,0.2,2.0,0,1\n2,0,-inf,3.0,1,0\n",
        ),
    ],
)  # fmt: skip
def test_answers_as_csv(tmp_path, query, columns, text):
    write_columns(tmp_path / "out.csv", table_columns(query, SimpleNamespace(**columns), False))
    assert (tmp_path / "out.csv").read_text() == text


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


# --- Hits in files: all fields come back to the bit, and readers refuse other files

BALLS = co.Spheres([(0, 0, 3), (0, 3, 0)], 0.5)
SCENE = co.Scene([
    co.Body(co.Sphere(1) - co.Box((0, 0, 0), (2, 2, 2)), co.phong("tomato", 0.3), "bitten \x1b ü"),
    co.Body(BALLS, (0.1, 0.2, 1 / 3), "balls"), co.Disc((0, 0, -3), (0, 0, 1), 2),
    co.Body(co.Sphere(0.5, (5, 0, 0)), co.matte(co.Checker("red", "blue", 3)), "never hit"),
])  # fmt: skip
CHANCE = np.random.default_rng(7)
RAYS = co.Rays(CHANCE.normal(size=(6, 50, 3)) * 4, CHANCE.normal(size=(6, 50, 3)))
RAY_SETS = {
    "many": RAYS,
    "one": co.Rays((0.1, 0.2, 9), (0, 0, -1)),
    "a miss": co.Rays((9, 9, 9), (0, 0, 1)),
    "none": RAYS[:0],
    "some": RAYS[2:4, ::3],
    "spawned": SCENE.first_hit(RAYS).spawn((0, 0, 1)),
}


@pytest.mark.parametrize("query", ["first_hit", "spans", "crossings"])
@pytest.mark.parametrize("name", RAY_SETS)
@pytest.mark.parametrize("detached", [False, True])
def test_round_trip(query, name, detached, tmp_path):
    answer, path = getattr(SCENE, query)(RAY_SETS[name]), tmp_path / "answer.npz"
    (answer.detached() if detached else answer).save(path)
    again = type(answer).load(path)
    assert again == answer == pickle.loads(pickle.dumps(again))
    assert_same_fields(again, answer)
    assert np.array_equal(again.rays.origins, answer.rays.origins, equal_nan=True)
    assert np.array_equal(SCENE.first_hit(again.rays).t, SCENE.first_hit(answer.rays).t)
    if query == "first_hit":
        assert np.array_equal(SCENE.first_hit(again.spawn((0, 0, 1))).t, SCENE.first_hit(answer.spawn((0, 0, 1))).t)
    else:
        assert not again.offsets.flags.writeable
    if query == "spans":
        assert again.materials == answer.materials
        assert np.array_equal(again.lengths("material"), answer.lengths("material"))
    assert [entry.name for entry in tmp_path.iterdir()] == ["answer.npz"]
    with np.load(path, allow_pickle=False) as arrays:
        assert all(arrays[each].dtype != object for each in arrays.files)


@pytest.mark.parametrize("name", RAY_SETS)
def test_rays_come_back_from_files(name, tmp_path):
    RAY_SETS[name].save(tmp_path / "rays.npz")
    again = co.Rays.load(tmp_path / "rays.npz")
    assert again == RAY_SETS[name]
    assert np.array_equal(SCENE.first_hit(again).t, SCENE.first_hit(RAY_SETS[name]).t)


def _with(path, **changes):
    """Return the bytes of a file with some arrays changed, or without them where they are None."""
    with np.load(path) as arrays:
        content = {name: arrays[name] for name in arrays.files} | changes
    stream = io.BytesIO()
    np.savez(stream, **{name: array for name, array in content.items() if array is not None})
    return stream.getvalue()


DAMAGE = {
    "first_hit": [
        (dict(t=None), "is not a file of hits.save: it lacks t"),
        (dict(t=np.zeros((3, 3))), r"t_error must have shape \(3, 3\), got \(6, 50\)"),
        (dict(normal=np.zeros((6, 50))), r"normal must have shape \(6, 50, 3\)"),
        (dict(body=np.full((6, 50), 0.5)), "body must hold integers from -1"),
        (dict(body=np.full((6, 50), np.nan)), "body must hold integers"),
        (dict(body=np.full((6, 50), 2**40)), "body must hold integers"),
        (dict(hit=np.full((6, 50), 7)), "hit must hold integers from 0 to 1"),
        (dict(starts=np.zeros(7)), r"starts must have shape \(1,\) or \(300,\)"),
        (dict(labels=np.frombuffer(b"bodies: 3", np.uint8)), "labels are damaged: "),
        (dict(labels=np.frombuffer(b"\xff\xfe", np.uint8)), "utf-8"),
        (dict(directions=np.zeros((6, 50, 3))), "Rays: direction must not be zero"),
        (dict(labels=np.array([1000.0])), "labels must hold integers from 0 to 255"),
        (dict(first_bodies=np.array([3, 2])), "first_bodies must be 2 rising numbers"),
        (dict(first_bodies=np.array([2, 3])), "first_bodies must not be above"),
        (dict(home=np.array([object()])), "home is not an array of numbers"),
    ],
    "spans": [
        (dict(t_enter=None), "is not a file of spans.save: it lacks t_enter"),
        (dict(more=np.zeros(2)), "is not a file of spans.save: it also holds more"),
        (dict(offsets=np.zeros(7)), "offsets must rise from 0, one for each ray and one more"),
        (dict(offsets=np.arange(301)[::-1]), "offsets must rise from 0"),
        (dict(t_exit=np.zeros(3)), r"t_exit must have shape \(\d+,\), got \(3,\)"),
        (dict(ends=np.zeros(3)), r"ends must have shape \(2, \d+\)"),
        (dict(body_count=np.array(1)), "body must be below body_count, 1"),
        (dict(enter_clipped=np.array([7.0])), "enter_clipped must have shape"),
        (dict(directions=np.zeros((6, 50, 3))), "Rays: direction must not be zero"),
        (dict(origins=np.zeros((6, 50))), "origins must have shape"),
        (dict(materials=np.frombuffer(b"bodies: 3", np.uint8)), "labels are damaged: "),
    ],
}  # fmt: skip


@pytest.mark.parametrize(
    ("query", "change", "message"), [(query, *row) for query, rows in DAMAGE.items() for row in rows]
)
def test_damaged_files(query, change, message, tmp_path):
    path, answer = tmp_path / "x.npz", getattr(SCENE, query)(RAYS)
    answer.save(path)
    path.write_bytes(_with(path, **change))
    with pytest.raises(ValueError, match=f"x.npz: .*{message}") as error:
        type(answer).load(path)
    assert len(str(error.value)) < 500


# --- Python loads the files of `conicoid trace`, which reads those of Python; errors name the reader of other files

SHELLS = co.Scene([
    co.Body(co.Sphere(1) - co.Sphere(0.5), co.matte("red", name="shell"), "ball"), co.Disc((0, 0, -3), (0, 0, 1), 2),
    co.Body(co.Spheres([(0, 3, 0), (3, 0, 0)], 0.5), "blue", "two"),
])  # fmt: skip
RANDOM = np.random.default_rng(3)
FEW_RAYS = co.Rays(RANDOM.normal(size=(6, 5, 3)) * 4, RANDOM.normal(size=(6, 5, 3)))


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.setattr(app, "PIECE", 7)
    SHELLS.save(tmp_path / "scene.yaml")
    return tmp_path / "scene.yaml"


@pytest.mark.parametrize("spawned", [False, True])
def test_hits_of_trace_are_hits(spawned, scene, tmp_path):
    rays = SHELLS.first_hit(FEW_RAYS).spawn((0, 0.1, 1)) if spawned else FEW_RAYS
    rays.save(tmp_path / "rays.npz")
    execute("trace", scene, tmp_path / "rays.npz", "-o", tmp_path / "hits.npz")
    hits, expected = co.Hits.load(tmp_path / "hits.npz"), SHELLS.first_hit(rays).detached()
    assert hits == expected
    assert hits.rays == rays
    assert hits.name.tolist() == expected.name.tolist()
    assert SHELLS.first_hit(hits.spawn((0, 0, 1))) == SHELLS.first_hit(expected.spawn((0, 0, 1)))
    with np.load(tmp_path / "hits.npz") as arrays:
        assert arrays["entering"].dtype == bool  # as docs/files.md says: it selects
        assert np.array_equal(arrays["t"][arrays["entering"]], expected.t[expected.entering])


def test_spans_of_trace_are_spans(scene, tmp_path):
    FEW_RAYS.save(tmp_path / "rays.npz")
    assert run("trace", scene, tmp_path / "rays.npz", "-o", tmp_path / "spans.npz", "--spans").exit_code == 0
    spans = co.Spans.load(tmp_path / "spans.npz")
    expected = SHELLS.spans(FEW_RAYS.origins.reshape(-1, 3), FEW_RAYS.directions.reshape(-1, 3))
    assert spans == expected.detached()
    assert np.array_equal(spans.lengths(by="material"), expected.lengths(by="material"))


@pytest.mark.parametrize("rays", [np.zeros((0, 6)), np.array([9, 9, 9, 0, 0, 1.0])])
def test_hits_of_no_rays_and_of_one(rays, scene, tmp_path):
    np.save(tmp_path / "rays.npy", rays)
    assert run("trace", scene, tmp_path / "rays.npy", "-o", tmp_path / "hits.npz").exit_code == 0
    assert co.Hits.load(tmp_path / "hits.npz") == SHELLS.first_hit(rays[..., :3], rays[..., 3:]).detached()
    assert run("trace", scene, tmp_path / "rays.npy", "-o", tmp_path / "spans.npz", "--spans").exit_code == 0
    assert len(co.Spans.load(tmp_path / "spans.npz").body) == 0


def test_rays_load_the_files_of_trace(tmp_path):
    table = np.concatenate([FEW_RAYS.origins, FEW_RAYS.directions], axis=-1)
    np.save(tmp_path / "rays.npy", table)
    (tmp_path / "rays.csv").write_text("\n".join(",".join(map(repr, row)) for row in table.reshape(-1, 6).tolist()))
    np.savez(tmp_path / "rays.npz", origins=FEW_RAYS.origins, directions=FEW_RAYS.directions)
    assert co.Rays.load(tmp_path / "rays.npy") == co.Rays.load(tmp_path / "rays.npz") == FEW_RAYS
    assert co.Rays.load(tmp_path / "rays.csv") == co.Rays(table.reshape(-1, 6)[:, :3], table.reshape(-1, 6)[:, 3:])
    np.savez(tmp_path / "rays.npz", origins=FEW_RAYS.origins, directions=FEW_RAYS.directions, t_min=0.5)
    with pytest.raises(ValueError, match=r"rays.npz: .* also holds t_min$"):
        co.Rays.load(tmp_path / "rays.npz")
    np.save(tmp_path / "rays.npy", [[0, 0, 0, 0, 0, 0.0]])
    with pytest.raises(ValueError, match=r"rays.npy: ray 0: direction must not be zero"):
        co.Rays.load(tmp_path / "rays.npy")


def test_files_of_other_results_are_refused(tmp_path):
    answers = {
        "hits": SHELLS.first_hit(FEW_RAYS),
        "spans": SHELLS.spans(FEW_RAYS),
        "crossings": SHELLS.crossings(FEW_RAYS),
        "rays": FEW_RAYS,
    }
    for kind, answer in answers.items():
        answer.save(tmp_path / f"{kind}.npz")
    np.savez(tmp_path / "lengths.npz", lengths=SHELLS.lengths(FEW_RAYS))
    for kind in answers:
        load = getattr(co, kind.capitalize()).load
        for other in answers:
            if other != kind:
                with pytest.raises(ValueError, match=rf"{other}.npz: is not a file of {kind}.save: it "):
                    load(tmp_path / f"{other}.npz")
        with pytest.raises(ValueError, match=rf"is not a file of {kind}.save: it lacks .* and holds lengths$"):
            load(tmp_path / "lengths.npz")
