"""Rows of a picture are found in a flat list of rays; a list that has none, or a wrong guess, changes no hit."""

import numpy as np
import pytest

import conicoid as co
from conicoid.queries import ray_queries as queries
from conicoid.queries.ray_queries import row_length

from .test_routes import assert_same, camera, crowded_scene


@pytest.fixture(scope="module")
def scene():
    return crowded_scene()


def perspective(width, height):
    return co.Camera((0.1, -0.2, -4), (0, 0, 0), up=(0, 1, 0), field_of_view=42).rays(width, height)


def flat(rays, order=None):
    origins, directions = (part.reshape(-1, 3) for part in rays)
    return co.Rays(origins, directions) if order is None else co.Rays(origins[order], directions[order])


@pytest.mark.parametrize(("width", "height"), [(128, 128), (131, 127), (33, 500), (300, 60)])
def test_rows_of_a_camera_are_found(width, height):
    assert row_length(flat(perspective(width, height))) == width


@pytest.mark.parametrize(("width", "height"), [(150, 140), (2048, 8)])
def test_rows_of_parallel_rays_are_found_in_their_origins(width, height):
    y, x = np.meshgrid(np.arange(height), np.arange(width), indexing="ij")
    origins = np.stack([x, y, np.full_like(x, 5)], axis=-1).reshape(-1, 3)
    assert row_length(co.Rays(origins, (0, 0, -1))) == width


def test_rows_of_rays_that_are_not_in_the_middle_of_their_pixels_are_found():
    r = np.random.default_rng(0)
    y, x = np.meshgrid(np.arange(160), np.arange(200), indexing="ij")
    places = np.stack([x, y], axis=-1) + r.uniform(-0.5, 0.5, (160, 200, 2))
    directions = np.concatenate([places / 100 - 1, np.ones((160, 200, 1))], axis=-1).reshape(-1, 3)
    assert row_length(co.Rays((0, 0, 0), directions)) == 200


def serpentine(rays):
    """Every second row from right to left."""
    order = np.arange(rays.shape[0] * rays.shape[1]).reshape(rays.shape)
    order[1::2] = order[1::2, ::-1]
    return flat(rays, order.ravel())


def ragged(rays):
    """Rows of a picture and others of half their length, behind each other."""
    rows = [row if i % 2 else row[: len(row) // 2] for i, row in enumerate(np.arange(rays.shape[0] * rays.shape[1])
            .reshape(rays.shape))]  # fmt: skip
    return flat(rays, np.concatenate(rows))


PICTURE = perspective(256, 128)
OTHERS = {
    "none": lambda: co.Rays(np.zeros((0, 3)), np.zeros((0, 3))),
    "one": lambda: co.Rays((0, 0, -4), (0, 0, 1)),
    "few": lambda: flat(perspective(63, 64)),
    "one row": lambda: flat(perspective(1 << 14, 1)),
    "all the same": lambda: co.Rays(np.zeros((1 << 14, 3)), (0, 0, 1)),
    "in no order": lambda: flat(PICTURE, np.random.default_rng(0).permutation(256 * 128)),
    "rows in no order": lambda: flat(
        PICTURE, np.arange(256 * 128).reshape(128, 256)[np.random.default_rng(0).permutation(128)].ravel()
    ),
    "from the middle of a row": lambda: flat(PICTURE, np.arange(100, 256 * 100 + 100)),
    "an incomplete row": lambda: flat(PICTURE, np.arange(256 * 100 + 7)),
    "serpentine": lambda: serpentine(PICTURE),
    "ragged": lambda: ragged(PICTURE),
    "narrow": lambda: flat(perspective(16, 2048)),
}


@pytest.mark.parametrize("name", OTHERS)
def test_what_is_no_picture_in_scan_order_has_no_rows(name):
    assert row_length(OTHERS[name]()) == 0


@pytest.mark.parametrize("name", ["none", "one", "one row", "from the middle of a row", "serpentine", "ragged"])
def test_lists_without_rows_have_the_hits_of_their_rays(scene, name):
    rays = OTHERS[name]()
    hits = scene.first_hit(rays)
    some = np.arange(hits.t.size)[:: max(1, hits.t.size // 50)]
    assert_same(hits, scene.first_hit(*(part.reshape(-1, 3)[some] for part in rays)), some)
    assert np.array_equal(scene.occluded(rays), np.isfinite(hits.t))


@pytest.mark.parametrize(("width", "height"), [(131, 127), (129, 128)])
def test_a_flat_picture_has_the_hits_of_a_picture(scene, width, height):
    rays = perspective(width, height)
    hits, count = scene.first_hit(rays), width * height
    assert_same(hits, scene.first_hit(flat(rays)), np.arange(count))
    shuffled = np.random.default_rng(1).permutation(count)
    assert_same(hits, scene.first_hit(flat(rays, shuffled)), shuffled)
    assert np.array_equal(scene.occluded(flat(rays)), np.isfinite(hits.t).ravel())


@pytest.mark.parametrize("guess", [32, 64, 127, 12 * 127])
def test_a_wrong_guess_changes_nothing(scene, monkeypatch, guess):
    rays = flat(perspective(127, 192))
    hits, order = scene.first_hit(rays), np.arange(127 * 192)
    monkeypatch.setattr(queries, "row_length", lambda rays: guess)
    assert_same(hits, scene.first_hit(rays), order)
    assert np.array_equal(scene.occluded(rays), np.isfinite(hits.t))


@pytest.mark.parametrize("shape", [(3, 40, 24), (4, 10, 10), (4, 200, 3), (200, 2), (2, 200)])
def test_arrays_of_any_shape_have_the_hits_of_their_rays(scene, shape):
    """Several pictures behind each other, several rays for each pixel, several lines."""
    rays, count = camera(64), int(np.prod(shape))
    some = np.random.default_rng(2).choice(64 * 64, count, replace=False)
    hits, all_hits = scene.first_hit(*(x.reshape(-1, 3)[some].reshape(*shape, 3) for x in rays)), scene.first_hit(rays)
    assert hits.t.shape == shape
    for field in ("t", "body", "face", "surface"):
        assert np.array_equal(getattr(all_hits, field).ravel()[some], getattr(hits, field).ravel()), field
