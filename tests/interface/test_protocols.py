"""Protocols that users of Python try first: len, truth, indices, iteration, np.asarray."""

import types

import numpy as np
import PIL.Image
import pytest

import conicoid as co
from conicoid.kernels.threads import thread_count

SCENE = co.Scene([co.Sphere(1), co.Sphere(1, (0, 0, 3)), co.Disc((0, 0, 6), (0, 0, 1), 2)])
X = np.array([0.0, 0.25, 5.0, 0.5, 1.5, 0.75])
"""Rays along z: they go through both balls and the disc, or nothing, or the disc alone."""
HIT = [True, True, False, True, True, True]
ORIGINS = np.stack([X, 0 * X, 0 * X - 5], axis=-1)


def both(query):
    """Return the rays in one row, and in two rows of three."""
    method = getattr(SCENE, query)
    return method(ORIGINS, (0, 0, 2)), method(ORIGINS.reshape(2, 3, 3), (0, 0, 2))


def test_hits_are_a_sequence_of_hits():
    hits, table = both("first_hit")
    assert hits.hit.tolist() == HIT
    assert table.hit.shape == (2, 3) and table.hit.dtype == np.bool_  # noqa: PT018
    assert [bool(one) for one in hits] == HIT
    assert len(hits) == 6
    assert [row.hit.tolist() for row in table] == [HIT[:3], HIT[3:]]
    assert [one.t for one in hits] == hits.t.tolist()


@pytest.mark.parametrize(("query", "columns"), [
    ("spans", ("t_enter", "t_exit", "body", "enter_clipped", "exit_clipped", "t_enter_error", "t_exit_error")),
    ("crossings", ("t", "body", "face", "surface", "entering", "t_error", "point", "normal")),
])  # fmt: skip
def test_lists_are_indexed_by_ray(query, columns):
    for rows in both(query):
        assert len(rows) == 6
        parts = list(rows)
        assert len(parts) == 6
        for i, part in enumerate(parts):
            begin, end = rows.offsets[i], rows.offsets[i + 1]
            assert part.offsets.tolist() == [0, end - begin]
            assert bool(part) == (end > begin)
            for column in columns:
                assert np.array_equal(getattr(part, column), getattr(rows, column)[begin:end]), column
        some = rows[[4, 2, 0]]
        assert len(some) == 3
        assert np.diff(some.offsets).tolist() == [len(part.body) for part in (parts[4], parts[2], parts[0])]
        for column in columns:
            joined = np.concatenate([getattr(parts[i], column) for i in (4, 2, 0)])
            assert np.array_equal(getattr(some, column), joined)
        assert rows[1:3].body.tolist() == [*parts[1].body, *parts[2].body]
        assert rows[-1].body.tolist() == parts[5].body.tolist()
        mask = (np.arange(6) % 2 == 0).reshape(rows._rays.shape)
        assert rows[mask].body.tolist() == [*parts[0].body, *parts[2].body, *parts[4].body]
        with pytest.raises(IndexError):
            rows[6]
        with pytest.raises(ValueError, match="truth value of the rows of 6 rays is ambiguous"):
            bool(rows)
    alone = getattr(SCENE, query)((0, 0, -5), (0, 0, 1))
    assert alone
    assert len(alone) == 1
    assert alone[0].body.tolist() == alone.body.tolist()
    assert not getattr(SCENE, query)((0, 0, -5), (0, 0, -1))


def test_points_and_normals_of_crossings():
    """On the balls the normal is the point less the center, and the disc has its own."""
    crossings = both("crossings")[0]
    centers = np.array([(0, 0, 0), (0, 0, 3), (0, 0, 6)])[crossings.body]
    ray = np.repeat(np.arange(6), np.diff(crossings.offsets))
    assert crossings.point[:, 0] == pytest.approx(X[ray])
    assert crossings.point[:, 2] == pytest.approx(-5 + 2 * crossings.t)
    expected = np.where((crossings.body == 2)[:, None], (0, 0, 1), crossings.point - centers)
    assert crossings.normal == pytest.approx(expected, abs=1e-14)
    assert ((crossings.normal[:, 2] < 0) == crossings.entering).all()
    first = SCENE.first_hit(ORIGINS, (0, 0, 2))
    assert np.array_equal(crossings[0].point[0], first.point[0])
    assert np.array_equal(crossings[0].normal[0], first.normal[0])


def test_normals_of_crossings_of_a_hollow_point_out_of_the_body():
    shell = co.Scene(co.Sphere(2) - co.Sphere(1))
    assert shell.crossings((0, 0, -5), (0, 0, 1)).normal.tolist() == [[0, 0, -1], [0, 0, 1], [0, 0, -1], [0, 0, 1]]


def test_an_image_is_an_array_of_its_displayed_bytes(tmp_path):
    pixels = np.random.default_rng(0).random((4, 5, 3))
    image = co.Image(pixels)
    image.save(tmp_path / "x.png")
    seen = np.asarray(image)
    assert seen.dtype == np.uint8
    assert np.array_equal(seen, np.asarray(PIL.Image.open(tmp_path / "x.png")))
    assert np.array(image, dtype=float).dtype == float
    assert np.array_equal(co.Image(seen), seen)
    assert np.asarray(co.Image(np.eye(3))).shape == (3, 3, 3)
    with pytest.raises(ValueError, match="always made anew"):
        np.array(image, copy=False)


@pytest.mark.parametrize(("suffix", "most"), [(".jpg", 4), (".JPEG", 4), (".webp", 0)])
def test_photos(tmp_path, suffix, most):
    ramp = np.linspace(0, 1, 64)
    image = co.Image(np.stack([np.tile(ramp, (64, 1))] * 3, axis=-1))
    path = tmp_path / f"x{suffix}"
    image.save(path)
    with PIL.Image.open(path) as file:
        pixels = np.asarray(file.convert("RGB")).astype(int)
    assert np.abs(pixels - np.asarray(image)).max() <= most
    with pytest.raises(ValueError, match=r"Image: .*wide\.webp cannot be written as WEBP"):
        co.Image(np.zeros((1, 20_000))).save(tmp_path / "wide.webp")
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_show(monkeypatch):
    image, shown = co.Image(np.eye(2)), []
    monkeypatch.setattr(PIL.Image.Image, "show", lambda self: shown.append(np.asarray(self)))
    image.show()
    assert np.array_equal(shown.pop(), np.asarray(image))
    shell = types.SimpleNamespace(kernel=object())
    module = types.ModuleType("IPython")
    module.get_ipython = lambda: shell
    module.display = types.ModuleType("IPython.display")
    module.display.display = shown.append
    monkeypatch.setitem(__import__("sys").modules, "IPython", module)
    monkeypatch.setitem(__import__("sys").modules, "IPython.display", module.display)
    image.show()
    assert shown == [image]


@pytest.mark.parametrize(("name", "axis"), [
    ("x", (1, 0, 0)), ("y", (0, 1, 0)), ("z", (0, 0, 1)), ("+z", (0, 0, 1)), ("-y", (0, -1, 0)),
])  # fmt: skip
def test_axes_by_name(name, axis):
    assert co.Box().rotate(name, 30) == co.Box().rotate(axis, 30)


def test_dir_lists_public_names():
    packages = "checks ct derivatives explain io materials measures optics parallel scene section".split()
    assert dir(co) == sorted([*co.__all__, *packages])


@pytest.mark.parametrize("value", ["0", "-1", "many", "1.5", "9" * 5000, "²"])
def test_a_wrong_number_of_threads_is_an_error(monkeypatch, value):
    monkeypatch.setenv("CONICOID_THREADS", value)
    with pytest.raises(ValueError, match="CONICOID_THREADS must be an integer from 1 to 65536, got '") as message:
        thread_count()
    assert len(str(message.value)) < 200
    monkeypatch.setenv("CONICOID_THREADS", "3")
    assert thread_count() == 3


@pytest.mark.parametrize("kind", [co.Camera, co.OrthographicCamera])
@pytest.mark.parametrize(("position", "up", "right", "upwards"), [
    ((0, 0, 9), (0, 0, 1), (1, 0, 0), (0, 1, 0)),
    ((0, 0, -9), (0, 0, 2), (-1, 0, 0), (0, 1, 0)),
    ((0, 9, 0), (0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    ((0, 9, 0), (1e-13, 1, 0), (-1, 0, 0), (0, 0, 1)),
    ((0, 9, 0), (0, -1, 1e-13), (-1, 0, 0), (0, 0, 1)),
    ((9, 0, 0), (-1, 0, 0), (0, 0, -1), (0, 1, 0)),
])  # fmt: skip
def test_plan_views(kind, position, up, right, upwards):
    """Right is forward × up, by hand."""
    camera = kind(position, (0, 0, 0), up)
    o, d = camera.rays(3, 3)
    ends = o + d * 9
    assert (ends[1, 2] - ends[1, 0]) @ right > 0.5
    assert (ends[0, 1] - ends[2, 1]) @ upwards > 0.5
    assert camera.up == upwards


def test_rays_one_after_the_other():
    """Spawned rays do not hit the surface that they start on, before and after they are joined."""
    ball = co.Scene(co.Sphere())
    plain = co.Rays(ORIGINS, (0, 0, 1))
    spawned = ball.first_hit(plain).spawn((0, 0, 1))
    both_ = co.Rays.concatenate([spawned, plain, co.Rays((0, 0, -5), (0, 0, 1))])
    assert both_.shape == (13,)
    t = np.concatenate([ball.first_hit(spawned).t, ball.first_hit(plain).t, [4]])
    assert np.array_equal(ball.first_hit(both_).t, t)
    assert np.array_equal(ball.first_hit(both_[:6]).t, ball.first_hit(spawned).t)
    table = co.Rays(ORIGINS.reshape(2, 3, 3), (0, 0, 1))
    assert co.Rays.concatenate([table, table]).shape == (4, 3)
    for wrong, kind, message in (
        ([plain, table], ValueError, r"parts must have shapes .* got \(6,\), \(2, 3\)"),
        ([], ValueError, "parts must hold at least one Rays, got none"),
        ([plain, ORIGINS], TypeError, r"parts\[1\] must be Rays, got ndarray"),
        (plain, TypeError, "parts must be a list of Rays, got Rays"),
        (3, TypeError, "parts must be a list of Rays, got int"),
    ):
        with pytest.raises(kind, match=message):
            co.Rays.concatenate(wrong)


REFUSED = [
    # truth of a single hit
    (lambda: bool(both("first_hit")[0]), ValueError, r"truth value of 6 hits is ambiguous; use hits.hit.any"),
    (lambda: bool(SCENE.first_hit(np.zeros((0, 3)), (0, 0, 1))), ValueError, "truth value of 0 hits"),
    (lambda: list(SCENE.first_hit((0, 0, -5), (0, 0, 1))), TypeError, "single ray or point has no length"),
    # a scene saves itself
    (lambda: SCENE.save(3), TypeError, "save: path must be a text or a Path, got 3"),
    # render names its options
    (lambda: SCENE.render(8, 8, dept=3), TypeError, "dept"),
]


@pytest.mark.parametrize(("call", "error", "message"), REFUSED)
def test_invalid_conversions_are_refused(call, error, message):
    with pytest.raises(error, match=message):
        call()
