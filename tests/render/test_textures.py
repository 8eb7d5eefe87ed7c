"""Textures: their colors by formulas in NumPy; pictures of the Earth without seams."""

import pickle
import struct

import numpy as np
import PIL.Image
import pytest

import conicoid as co

RNG = np.random.default_rng(19)


def colors(body, camera=None, width=48, height=36, samples=1):
    """Return the colors of pixels without light, and the hits of the pixel centers."""
    camera = camera or co.Camera((4, -6, 3), (0, 0, 0), field_of_view=25)
    scene = co.Scene([body], camera=camera)
    hits = scene.first_hit(camera.rays(width, height))
    return scene.render(width, height, samples, integrator="albedo").pixels, hits


def sampled(pixels, u, v, wraps=("repeat", "clamp")):
    """Interpolate linear pixels bilinearly; v = 0 is their lower edge."""
    height, width, _ = pixels.shape
    x, y = u * width - 0.5, (1 - v) * height - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)

    def index(k, count, wrap):
        if wrap == "repeat":
            return np.mod(k, count)
        if wrap == "clamp":
            return np.clip(k, 0, count - 1)
        return np.where(np.mod(k, 2 * count) < count, np.mod(k, 2 * count), 2 * count - 1 - np.mod(k, 2 * count))

    total = 0
    for di, wx in ((0, 1 - (x - i)), (1, x - i)):
        for dj, wy in ((0, 1 - (y - j)), (1, y - j)):
            corner = pixels[index(j + dj, height, wraps[1]), index(i + di, width, wraps[0])]
            total = total + corner * (wx * wy)[..., None]
    return total


def compare(found, hits, expected, most=2e-6):
    hit = np.asarray(hits.hit)
    assert hit.sum() > 200
    assert np.abs(found - expected)[hit].max() < most


@pytest.mark.parametrize("wrap", ["repeat", "clamp", "mirror"])
def test_a_picture_on_a_drum(wrap):
    pixels = RNG.random((5, 7, 3)).astype(np.float32)  # few and large: none is smaller than a pixel of the view
    texture = co.materials.ImageTexture(pixels, scale=(0.4, 0.6), offset=(0.1, 0.2), wrap=wrap)
    found, hits = colors(co.Body(co.Cylinder((0, 0, -1), (0, 0, 1), 1), co.matte(texture)))
    u, v = np.moveaxis(np.nan_to_num(np.asarray(hits.uv)), -1, 0)
    expected = sampled(pixels.astype(float), (u - 0.1) / 0.4, (v - 0.2) / 0.6, (wrap, wrap))
    on_wall = np.asarray(hits.face) == 0
    assert np.abs(found - expected)[on_wall].max() < 2e-6


def test_bytes_are_srgb_and_data_are_not(tmp_path):
    PIL.Image.fromarray(np.full((4, 4, 3), (188, 55, 0), np.uint8)).save(tmp_path / "flat.png")
    ball = co.Sphere(2)
    for data, expected in (
        (False, [((188 / 255 + 0.055) / 1.055) ** 2.4, ((55 / 255 + 0.055) / 1.055) ** 2.4, 0]),
        (True, [188 / 255, 55 / 255, 0]),
    ):
        texture = co.materials.ImageTexture(tmp_path / "flat.png", data=data)
        found, hits = colors(co.Body(ball, co.matte(texture)))
        compare(found, hits, np.broadcast_to(expected, found.shape), 1e-6)


def test_a_map_of_the_earth_is_laid_by_longitude_and_latitude():
    """Each texel of the map holds its own longitude and latitude, as a smooth function."""
    rows, columns = 90, 180
    longitude = (np.arange(columns) + 0.5) / columns * 2 * np.pi
    latitude = np.pi / 2 - (np.arange(rows) + 0.5) / rows * np.pi
    x = np.cos(latitude)[:, None] * np.cos(longitude)
    y = np.cos(latitude)[:, None] * np.sin(longitude)
    z = np.broadcast_to(np.sin(latitude)[:, None], x.shape)
    world = ((1 + np.stack([x, y, z], axis=-1)) / 2).astype(np.float32)
    body = co.Body(co.Sphere(2), co.matte(co.materials.ImageTexture(world, mapping="latitude")))
    for position in ((6, 0, 0.5), (-6, 0.3, 1), (0.1, 0.2, 6), (0.3, 0, -6)):  # the seam, the other side, both poles
        found, hits = colors(body, co.Camera(position, (0, 0, 0)))
        expected = (1 + np.asarray(hits.normal)) / 2
        at_pole = np.abs(np.nan_to_num(np.asarray(hits.normal)[..., 2])) > np.cos(np.radians(3))
        # texels are 2 degrees: 1 - cos 1° of interpolation; a pixel over a pole is a mean over sin 2° and more of (1 + x) / 2
        compare(np.where(at_pole[..., None], expected, found), hits, expected, 2.5e-3)
        compare(found, hits, expected, 0.0175)


def test_a_seam_is_no_line():
    """A picture that is periodic in u is smooth across u = 0."""
    pixels = np.zeros((8, 64, 3), np.float32)
    pixels[..., 0] = 0.5 + 0.4 * np.cos(2 * np.pi * (np.arange(64) + 0.5) / 64)
    body = co.Body(co.Cylinder((0, 0, -2), (0, 0, 2), 1), co.matte(co.materials.ImageTexture(pixels)))
    found, hits = colors(body, co.Camera((5, 0, 0), (0, 0, 0), field_of_view=15), 200, 100)
    u = np.asarray(hits.uv)[..., 0]
    assert np.nanmin(u[50]) < 0.05
    assert np.nanmax(u[50]) > 0.95  # the seam is in view
    expected = 0.5 + 0.4 * np.cos(2 * np.pi * u)
    assert np.abs(found[..., 0] - expected)[np.asarray(hits.hit)].max() < 3e-3


def test_far_textures_are_read_from_smaller_levels():
    """A checkerboard with texels far below a pixel's size is grey, and the mean of the picture stays."""
    board = np.indices((256, 256)).sum(axis=0) % 2 * np.ones((3, 1, 1))
    texture = co.materials.ImageTexture(np.moveaxis(board, 0, -1), mapping="box", scale=1.0, wrap="repeat")
    floor = co.Body(co.Box((-500, -500, -1), (500, 500, 0)), co.matte(texture))
    found, hits = colors(floor, co.Camera((0.1, 0.2, 60), (0, 0, 0)), samples=1)
    assert np.abs(found[np.asarray(hits.hit)] - 0.5).max() < 0.02
    near, _ = colors(floor, co.Camera((0.1, 0.2, 0.02), (0.1, 0.2, 0)), samples=1)
    assert near.min() < 0.1  # near by each texel is seen
    assert near.max() > 0.9


# ---- Textures by formulas ----


@pytest.mark.parametrize(
    ("along", "field", "axis", "length", "offset"),
    [
        *((along, "point", axis, 1.5, -0.5) for axis, along in enumerate("xyz")),
        *((along, "uv", axis, 0.25, 0.5) for axis, along in enumerate("uv")),
    ],
)
def test_a_gradient_in_the_world_or_on_the_surface(along, field, axis, length, offset):
    texture = co.materials.Gradient((0.1, 0.2, 0.3), (0.9, 0.8, 0.1), along, length=length, offset=offset)
    found, hits = colors(co.Body(co.Sphere(2), co.matte(texture)))
    share = np.clip((np.asarray(getattr(hits, field))[..., axis] - offset) / length, 0, 1)[..., None]
    compare(found, hits, (1 - share) * (0.1, 0.2, 0.3) + share * (0.9, 0.8, 0.1))


def lattice(x, y, z):
    """Return SplitMix64's output function over three numbers."""
    h = 0
    for part in (x, y, z):
        h = int(mixed_by_hand(h ^ (int(part) % 2**64)))
    return h


def mixed_by_hand(value):
    z = (value + 0x9E3779B97F4A7C15) % 2**64
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) % 2**64
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) % 2**64
    return z ^ (z >> 31)


EDGES = [(1, 1, 0), (-1, 1, 0), (1, -1, 0), (-1, -1, 0), (1, 0, 1), (-1, 0, 1), (1, 0, -1), (-1, 0, -1),
         (0, 1, 1), (0, -1, 1), (0, 1, -1), (0, -1, -1), (1, 1, 0), (0, -1, 1), (-1, 1, 0), (0, -1, -1)]  # fmt: skip
"""Perlin's table of directions, of 2002."""


def perlin(point):
    base = np.floor(point)
    f = point - base
    weights = f**3 * (f * (f * 6 - 15) + 10)
    total = 0.0
    for corner in np.ndindex(2, 2, 2):
        weight = np.prod(np.where(corner, weights, 1 - weights))
        direction = np.array(EDGES[lattice(*(base + corner)) & 15])
        total += weight * direction @ (f - corner)
    return total


def octaves(point, count):
    total = weights = 0.0
    for k in range(count):
        total, weights = total + 0.5**k * perlin(point), weights + 0.5**k
        point = 2 * point + (17, 31, 47)
    return total / weights


def test_noise_is_perlins():
    texture = co.materials.Noise((0, 0, 0), (1, 1, 1), scale=0.7, octaves=3, contrast=1.2)
    found, hits = colors(co.Body(co.Sphere(2), co.matte(texture)), width=16, height=12)
    for index in zip(*np.nonzero(np.asarray(hits.hit)), strict=True):
        n = octaves(np.asarray(hits.point)[index] / 0.7, 3)
        assert found[index] == pytest.approx(np.full(3, np.clip(0.5 + 0.6 * n, 0, 1)), abs=1e-6)


@pytest.mark.parametrize("position", [(0.3, -9, 2), (9, 0.2, 2), (0.1, 0.2, 9)])
def test_bricks_in_running_bond(position):
    texture = co.materials.Brick((0.5, 0.2, 0.1), (0.9, 0.9, 0.9), size=(0.8, 0.3), joint=0.05, variation=0)
    wall = co.Body(co.Box((-2, -2, -2), (2, 2, 2)), co.matte(texture))
    found, hits = colors(wall, co.Camera(position, (0, 0, 0)))
    across = np.argmax(np.abs(np.nan_to_num(np.asarray(hits.normal))), axis=-1)
    point = np.nan_to_num(np.asarray(hits.point))
    u = np.where(across == 0, point[..., 1], point[..., 0])
    v = np.where(across == 2, point[..., 1], point[..., 2])
    course = np.floor(v / 0.3)
    along = u / 0.8 + 0.5 * np.mod(course, 2)
    is_brick = (np.mod(along, 1) * 0.8 >= 0.05) & (np.mod(v / 0.3, 1) * 0.3 >= 0.05)
    assert 0.2 < is_brick.mean() < 1
    compare(found, hits, np.where(is_brick[..., None], (0.5, 0.2, 0.1), (0.9, 0.9, 0.9)))


def test_bricks_may_be_of_wood_and_differ():
    plain = co.materials.Brick((0.4, 0.4, 0.4), (0.9, 0.9, 0.9), size=(0.8, 0.3), joint=0.05, variation=0.5)
    found, hits = colors(co.Body(co.Box((-2, -2, -2), (2, 2, 2)), co.matte(plain)))
    bricks = found[np.asarray(hits.hit)]
    shades = np.unique(bricks[np.abs(bricks[:, 0] - 0.9) > 1e-6][:, 0])
    assert len(shades) > 10
    assert 0.2 - 1e-6 <= shades.min() < shades.max() <= 0.6 + 1e-6
    wooden = co.materials.Brick(co.materials.Wood(), co.materials.Noise(), variation=0)
    rings, hits = colors(co.Body(co.Box((-2, -2, -2), (2, 2, 2)), co.matte(wooden)))
    assert len(np.unique(rings[np.asarray(hits.hit)], axis=0)) > 100


def test_wood_lies_between_its_colours():
    early, late = np.array([0.6, 0.4, 0.2]), np.array([0.2, 0.1, 0.05])
    found, hits = colors(co.Body(co.Sphere(2), co.matte(co.materials.Wood(early, late, ring=0.3, roughness=0))))
    share = (found - early) / (late - early)
    hit = np.asarray(hits.hit)
    assert np.ptp(share[hit], axis=-1).max() < 1e-5
    assert share[hit].min() > -1e-6
    assert share[hit].max() < 1 + 1e-6
    radius = np.linalg.norm(np.asarray(hits.point)[..., :2], axis=-1)
    year = np.mod(radius / 0.3, 1)
    assert share[..., 0][hit & (year > 0.8) & (year < 0.9)].min() > share[..., 0][hit & (year < 0.3)].max()


# ---- Files ----


@pytest.fixture
def folder(tmp_path):
    PIL.Image.fromarray(RNG.integers(0, 255, (6, 8, 3), dtype=np.uint8)).save(tmp_path / "tiles.png")
    return tmp_path


PATTERNS = [
    co.materials.Gradient("red", "blue", "x", 2, 0.5), co.materials.Noise("white", octaves=2), co.materials.Wood(ring=0.2, offset=(1, 2)),
    co.materials.Brick(co.materials.Noise("brown"), "white", (1, 0.5), 0.1), co.Checker("red"),
]  # fmt: skip


@pytest.mark.parametrize("texture", PATTERNS, ids=lambda each: type(each).__name__)
def test_textures_survive_repr_pickles_and_files(texture, tmp_path):
    assert eval(repr(texture), vars(co) | vars(co.materials)) == texture
    assert pickle.loads(pickle.dumps(texture)) == texture
    scene = co.Scene([co.Body(co.Sphere(), co.matte(texture))])
    co.save(scene, tmp_path / "scene.yaml")
    again = co.load(tmp_path / "scene.yaml")
    assert again.bodies[0].material.color == texture
    assert again.bodies == scene.bodies


def test_pictures_are_named_by_the_scene_file(folder):
    texture = co.materials.ImageTexture(folder / "tiles.png", "latitude", (2, 1), (0.5, 0), ("mirror", "clamp"))
    scene = co.Scene([co.Body(co.Sphere(), co.lacquer(texture))])
    co.save(scene, folder / "scene.yaml")
    assert "image: tiles.png" in (folder / "scene.yaml").read_text()
    again = co.load(folder / "scene.yaml")
    assert again.bodies == scene.bodies
    assert pickle.loads(pickle.dumps(again)).bodies == scene.bodies
    assert eval(repr(texture), vars(co) | vars(co.materials)) == texture


TEXT = "bodies: [{{shape: {{Sphere: {{}}}}, material: {{matte: {{color: {{ImageTexture: {{image: {}}}}}}}}}}}]"


def test_pictures_outside_of_the_folder_must_be_allowed(folder):
    inner = folder / "inner"
    inner.mkdir()
    for name, message in (
        ("../tiles.png", "must stay inside the scene's folder"), (str(folder / "tiles.png"), "must be a relative path"),
    ):  # fmt: skip
        (inner / "scene.yaml").write_text(TEXT.format(name))
        with pytest.raises(co.SceneFileError, match=f"1: .*ImageTexture: image: {message}"):
            co.load(inner / "scene.yaml")
        assert co.load(inner / "scene.yaml", outside=True).bodies[0].material.color.pixels.size == (8, 6)
    outside = co.Scene([co.Body(co.Sphere(), co.matte(co.materials.ImageTexture(folder / "tiles.png")))])
    with pytest.raises(ValueError, match="image must lie in the folder of the scene file"):
        co.save(outside, inner / "other.yaml")


def test_pictures_that_are_none(folder):
    pytest.importorskip("OpenEXR")
    (folder / "cut.png").write_bytes((folder / "tiles.png").read_bytes()[:80])
    (folder / "words.png").write_text("no picture")
    (folder / "words.exr").write_text("no picture")
    (folder / "words.txt").write_text("no picture")
    for name, message in (
        ("missing.png", "is not an existing file: 'missing.png'"), ("cut.png", "'cut.png' cannot be read as PNG"),
        ("words.png", "'words.png' cannot be read as PNG"), ("words.exr", "'words.exr' cannot be read as OpenEXR"),
        ("words.txt", "must be a picture"),
    ):  # fmt: skip
        (folder / "scene.yaml").write_text(TEXT.format(name))
        with pytest.raises(co.SceneFileError, match=message):
            co.load(folder / "scene.yaml")
        with pytest.raises(ValueError, match="ImageTexture: image "):
            co.materials.ImageTexture(folder / name)


@pytest.mark.parametrize("side", [1 << 13, 1 << 20, (1 << 31) - 1])
def test_an_exr_whose_size_is_far_beyond_its_bytes(side, tmp_path):
    pytest.importorskip("OpenEXR")
    resource = pytest.importorskip("resource")
    co.Image(np.ones((4, 4, 3))).save(tmp_path / "x.exr")
    head, rest = (tmp_path / "x.exr").read_bytes().split(window := b"dataWindow\0box2i\0" + struct.pack("<I", 16))
    (tmp_path / "x.exr").write_bytes(head + window + struct.pack("<4i", 0, 0, side - 1, side - 1) + rest[16:])
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(
        ValueError, match=r"'x.exr' cannot be read as OpenEXR: (has \d+ x \d+ pixels; a texture has at most)?"
    ):
        co.materials.ImageTexture(tmp_path / "x.exr")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100 << 10, "KiB"


def test_floats_come_from_exr(tmp_path):
    pytest.importorskip("OpenEXR")
    light = RNG.random((4, 6, 3)).astype(np.float32) * 5
    co.Image(light).save(tmp_path / "light.exr")
    assert (co.materials.ImageTexture(tmp_path / "light.exr").pixels.array == light).all()


def test_arrays_cannot_stand_in_a_scene_file(tmp_path):
    scene = co.Scene([co.Body(co.Sphere(), co.matte(co.materials.ImageTexture(np.zeros((2, 2, 3), np.uint8))))])
    with pytest.raises(ValueError, match="image must be a file to stand in a scene file"):
        co.save(scene, tmp_path / "scene.yaml")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: co.materials.ImageTexture(np.zeros((2, 2))),
            r"image must be a file or have shape \(height, width, 3\)",
        ),
        (lambda: co.materials.ImageTexture(np.full((2, 2, 3), np.nan)), "image must hold finite numbers"),
        (lambda: co.materials.ImageTexture(np.zeros((2, 2, 3), np.uint8), "round"), "mapping must be one of uv"),
        (lambda: co.materials.ImageTexture(np.zeros((2, 2, 3), np.uint8), wrap="twice"), "wrap must be one of repeat"),
        (lambda: co.materials.ImageTexture(np.zeros((2, 2, 3), np.uint8), scale=0), "scale must be > 0"),
        (lambda: co.materials.Gradient(along="w"), "Gradient: along must be one of u"),
        (lambda: co.materials.Noise(octaves=0), "Noise: octaves must be a whole number from 1 to 16"),
        (lambda: co.materials.Wood(ring=-1), "Wood: ring must be > 0"),
        (lambda: co.materials.Brick(joint=0.1), "Brick: joint must be less than both of size"),
        (lambda: co.materials.Brick(variation=2), r"Brick: variation must be in \[0, 1\]"),
    ],
)
def test_bad_textures_name_the_field(make, message):
    with pytest.raises(ValueError, match=message):
        make()
