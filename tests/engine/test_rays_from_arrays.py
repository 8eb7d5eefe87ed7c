"""Many rays from arrays of users: threads check and copy them as they do few rays, and their owner cannot change them."""

import numpy as np
import pytest

import conicoid as co
from conicoid._jit.machine_code import SHIPPED, empty_array
from conicoid.queries.ray_queries import first_hit_of_arrays

from .test_routes import crowded_scene

MANY, FEW = 40_000, 50
RNG = np.random.default_rng(0)
ORIGINS, DIRECTIONS = RNG.normal(size=(MANY, 3)), RNG.normal(size=(MANY, 3))


@pytest.fixture(params=[1, 3], autouse=True)
def some_threads(request):
    co.set_threads(request.param)
    yield
    co.set_threads(None)


def frozen(array):
    array = array.copy()
    array.flags.writeable = False
    return array


FORMS = {
    "as they are": lambda a: a,
    "frozen": frozen,
    "halves of rows": lambda a: np.concatenate([a, a], axis=1)[:, 3:],
    "backwards": lambda a: a[::-1].copy()[::-1],
    "columns": lambda a: np.asfortranarray(a),
    "float32": lambda a: a.astype(np.float32),
    "every second of float32": lambda a: np.repeat(a.astype(np.float32), 2, axis=0)[::2],
    "the other order of bytes": lambda a: a.astype(a.dtype.newbyteorder()),
    "misaligned float32": lambda a: np.frombuffer(b"0" + a.astype(np.float32).tobytes(), np.float32, offset=1).reshape(-1, 3),
    "lists": lambda a: a.tolist(),
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("other", ["as they are", "float32"])
def test_every_form_of_array_gives_the_same_rays(form, other):
    origins, directions = FORMS[form](ORIGINS), FORMS[other](DIRECTIONS)
    rays = co.Rays(origins, directions)
    for mine, array in zip(rays, (origins, directions), strict=True):
        assert mine.tobytes() == np.array(array, np.float64).tobytes()
        assert not mine.flags.writeable
        assert mine.flags.c_contiguous
    parts = [co.Rays(origins[k : k + 1000], directions[k : k + 1000]) for k in range(0, MANY, 1000)]
    assert co.Rays.concatenate(parts) == rays


@pytest.mark.parametrize("query", ["first_hit", "occluded"])
@pytest.mark.parametrize("form", ["picture", "list", "in no order"])
@pytest.mark.parametrize("own", [frozen, np.copy])
def test_rays_are_checked_before_the_answer(query, form, own):
    """The kernel reads the rays first. It ends whatever they are, and the error is that of other arrays."""
    scene, shape = crowded_scene(), (120, 120, 3)
    origins, directions = (part.copy() for part in scene.rays(120, 120))
    if form == "in no order":
        origins, directions = RNG.normal(size=shape), RNG.normal(size=shape)
    if form == "list":
        origins, directions = origins.reshape(-1, 3), directions.reshape(-1, 3)
    method = getattr(scene, query)
    assert np.array_equal(read(method(own(origins), own(directions))), read(method(co.Rays(origins, directions))))
    for many in (1, 500, len(directions.reshape(-1, 3))):
        for field, values in VALUES.items():
            for value in values:
                arrays = {"origins": origins.copy(), "directions": directions.copy()}
                rows = RNG.choice(origins.size // 3, many, replace=False)
                arrays[field].reshape(-1, 3)[rows, :: 1 + (value != 0.0)] = value
                with pytest.raises(ValueError, match="^Rays: ") as expected:
                    co.Rays(**arrays)
                for limits in ({}, dict(t_min=-1.0, t_max=3.0), dict(t_min=np.zeros(3))):
                    with pytest.raises(ValueError, match="^Rays: ") as found:
                        method(*map(own, arrays.values()), **limits)
                    assert str(found.value) == str(expected.value)


@pytest.mark.parametrize("shape", [(120, 120), (91, 101), (365, 367)])
@pytest.mark.parametrize("flat", [False, True])
def test_rays_that_are_copied_as_they_are_traced(shape, flat):
    """Copies and hits equal those of rays copied before. The largest picture is written past the caches."""
    scene = crowded_scene()
    whole = [np.array(part).reshape((-1, 3) if flat else (*shape, 3)) for part in scene.rays(*shape[::-1])]
    t_min = np.linspace(-1.0, 2.0, whole[0].size // 3).reshape(whole[0].shape[:-1])
    for limits in ({}, dict(t_min=t_min)):
        copies = [part.copy() for part in whole]
        hits, expected = scene.first_hit(*copies, **limits), scene.first_hit(co.Rays(*whole), **limits)
        assert first_hit_of_arrays(scene._prepared, *copies, 0.0, np.inf) is not None
        for part in copies:
            part[:] = np.nan
        assert hits.rays == co.Rays(*whole)
        for field in ("t", "body", "face", "normal", "uv", "point", "doubtful"):
            assert getattr(hits, field).tobytes() == getattr(expected, field).tobytes()


def read(answer):
    """Return the numbers of an answer."""
    return getattr(answer, "t", answer)


def test_one_origin_for_a_picture():
    directions = DIRECTIONS.reshape(200, 200, 3)
    rays = co.Rays((1.0, 2.0, 3.0), directions)
    assert rays.shape == (200, 200)
    assert (rays.origins == (1.0, 2.0, 3.0)).all()
    assert np.array_equal(rays.directions, directions)
    assert np.array_equal(co.Rays(directions[:, ::2], (0, 0, 1)).origins, directions[:, ::2])


VALUES = {
    "origins": [np.nan, np.inf, -np.inf, 1e-101, -1e101, 5e-324],
    "directions": [np.nan, np.inf, 1e-101, 1e101, 0.0],
}


@pytest.mark.parametrize(("at", "freeze"), [(MANY - 1, False), (23_456, True)])
@pytest.mark.parametrize(("field", "value"), [(field, value) for field in VALUES for value in VALUES[field]])
def test_an_invalid_ray_is_named_as_among_few(field, value, at, freeze):
    arrays = {"origins": ORIGINS.copy(), "directions": DIRECTIONS.copy()}
    arrays[field][at] = value
    for later in range(at + 1, MANY):
        arrays["directions"][later] = 0.0
    if freeze:
        arrays = {name: frozen(array) for name, array in arrays.items()}
    with pytest.raises(ValueError, match="^Rays: ") as many:
        co.Rays(**arrays)
    with pytest.raises(ValueError, match="^Rays: ") as few:
        co.Rays(arrays["origins"][at - FEW : at + 1], arrays["directions"][at - FEW : at + 1])
    assert str(many.value) == str(few.value).replace(f"ray[{FEW}]", f"ray[{at}]")


@pytest.mark.parametrize("value", [0.0, -0.0, 1e-100, -1e100])
def test_the_ends_of_the_domain_are_valid(value):
    origins, directions = ORIGINS.copy(), DIRECTIONS.copy()
    origins[7], directions[8] = value, value or 1e-100
    directions[9, :2] = 0.0
    assert co.Rays(origins, directions).size == MANY


def test_answers_do_not_change_with_the_arrays_of_their_rays():
    scene = co.Scene([co.Sphere(1.0)])
    origins, directions = ORIGINS.copy(), DIRECTIONS.copy()
    hits, again = scene.first_hit(origins, directions), scene.first_hit(origins.copy(), directions.copy())
    origins[:], directions[:] = 7.0, 0.0
    assert hits == again
    fixed = frozen(ORIGINS)
    assert co.Rays(fixed, DIRECTIONS).origins is not fixed  # of two arrays both or none are kept


def test_frozen_arrays_are_kept_and_others_copied():
    owned, directions = frozen(ORIGINS), frozen(DIRECTIONS)
    shape = (200, 200, 3)
    rays = co.Rays(owned, directions)
    assert rays.origins is owned
    assert rays.directions is directions
    picture = co.Rays(owned.reshape(shape), directions.reshape(shape))
    assert np.shares_memory(picture.origins, owned)
    assert np.shares_memory(co.Rays(rays.origins, picture.directions.reshape(-1, 3)).origins, owned)
    writable = ORIGINS.copy()
    view = writable[:]
    view.flags.writeable = False  # a write through its owner is possible
    assert not np.shares_memory(co.Rays(view, directions).origins, writable)


@pytest.mark.skipif(SHIPPED is None, reason="the extension keeps memory")
def test_memory_that_was_left_is_taken_again():
    def address(count):
        return empty_array(count, np.float64).ctypes.data

    for count in (1 << 16, 1 << 20, 1 << 22):
        assert address(count) == address(count)
    arrays = [empty_array(3 << 20, np.float64) for _ in range(12)]  # 288 MiB
    assert len({array.ctypes.data for array in arrays}) == 12
    for array in arrays:
        array[...] = 1.0
    del array, arrays
    assert empty_array((3, 1 << 20), np.float64).shape == (3, 1 << 20)
    with pytest.raises(MemoryError):
        empty_array(1 << 58, np.float64)
