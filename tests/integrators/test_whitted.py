"""Whitted's method against closed forms: single pixels and whole pictures whose colour is known."""

import math

import numpy as np
import pytest

import conicoid as co

DOWN = co.OrthographicCamera((0, 0, 10), (0, 0, 0), up=(0, 1, 0), height=1e-3)
WHITE = (1.0, 1.0, 1.0)
FAINT = 2.0**-11  # the integrator drops rays that add less than 2⁻¹²


def color(items, lights=(), background=WHITE, camera=DOWN, **options):
    """Return the color of a single ray straight down the z axis."""
    lights = lights or [co.AmbientLight(1)]
    return co.Scene(items, lights=lights, camera=camera, background=background).render(1, 1, 1, **options).pixels[0, 0]


def floor(material):
    return co.Body(co.Box((-50, -50, -1), (50, 50, 0)), material)


# Local light


@pytest.mark.parametrize("tilt", [0, 30, 60, 89])
def test_lamberts_law(tilt):
    angle = math.radians(tilt)
    light = co.DirectionalLight((math.sin(angle), 0, -math.cos(angle)), (0.5, 1, 2))
    radiance = color([floor(co.matte((0.2, 0.4, 0.8)))], [light])
    assert radiance == pytest.approx(np.array((0.1, 0.4, 1.6)) * math.cos(angle), rel=1e-6)


def test_light_from_below_does_not_count():
    assert (color([floor(co.matte())], [co.DirectionalLight((0, 0, 1))]) == 0).all()


def test_ambient_light_adds_up():
    radiance = color(
        [floor(co.matte((0.5, 0.5, 1), ambient=0.5))], [co.AmbientLight(0.2), co.AmbientLight((0.1, 0, 0))]
    )
    assert radiance == pytest.approx((0.075, 0.05, 0.1), rel=1e-6)


def test_inverse_square():
    """The light is at height 3 over a point 4 to the side. The distance is 5 and the cosine 3/5, so 3/5 of I / 25."""
    far = color([floor(co.matte(WHITE))], [co.PointLight((4, 0, 3), 50, falloff="inverse_square")])
    same = color([floor(co.matte(WHITE))], [co.PointLight((4, 0, 3), 50)])
    assert far == pytest.approx([50 / 25 * 0.6] * 3, rel=1e-6)
    assert same == pytest.approx([50 * 0.6] * 3, rel=1e-6)


@pytest.mark.parametrize(("aim", "share"), [(10, 1), (19.9, 1), (25, 0.5), (30.1, 0), (60, 0)])
def test_spot_and_its_soft_edge(aim, share):
    """The light is full within 20°, and there is none beyond 30°. Halfway it is 3s² - 2s³ = 1/2."""
    angle = math.radians(aim)
    light = co.SpotLight((0, 0, 5), (math.sin(angle), 0, -math.cos(angle)), angle=30, soft_edge=10)
    assert color([floor(co.matte(WHITE))], [light]) == pytest.approx([share] * 3, rel=1e-6, abs=1e-9)


# Lamps


def test_glowing_bodies_are_visible():
    """The ray sees the body's emission under any light. The body lights nothing here."""
    lamp = co.Body(co.Box((-1, -1, 0), (1, 1, 1)), co.glow((3, 2, 0.5)))
    assert color([lamp]).tolist() == [3, 2, 0.5]
    assert color([lamp], [co.DirectionalLight((0, 0, -1), 9)]).tolist() == [3, 2, 0.5]


# Shadows


def test_opaque_bodies_cast_shadows_and_those_behind_the_light_do_not():
    lit, dark = co.PointLight((0, 3, 4)), co.PointLight((0, 3, 4))
    between, behind = co.Sphere(0.5, (0, 1.5, 2)), co.Sphere(0.5, (0, 4.5, 6))
    assert (color([floor(co.matte(WHITE)), between], [dark]) == 0).all()
    assert color([floor(co.matte(WHITE)), behind], [lit]) == pytest.approx([0.8] * 3, rel=1e-6)


def test_a_sheet_is_lit_on_its_visible_side():
    sheet = co.Body(co.Disc((0, 0, 0), (0, 0, -1), 5), co.matte(WHITE))
    assert color([sheet], [co.DirectionalLight((0, 0, -1))]) == pytest.approx([1] * 3, rel=1e-6)
    assert (color([sheet], [co.DirectionalLight((0, 0, 1))]) == 0).all()


def test_light_through_a_pane_of_glass():
    """The ray goes straight through two walls and 0.5 of glass: (1 - R)² exp(-0.5 a), R = ((n - 1) / (n + 1))²."""
    glass = co.Body(co.Box((-9, 2.5, -9), (9, 3, 9)), co.glass(1.5, absorption=(0, 1, 2), specular=0))
    wall = co.Body(co.Box((-9, -1, -9), (9, 0, 9)), co.matte(WHITE))
    camera = co.OrthographicCamera((0, 2, 0), (0, 0, 0), height=1e-3)
    radiance = color([wall, glass], [co.DirectionalLight((0, -1, 0))], camera=camera)
    assert radiance == pytest.approx(0.96**2 * np.exp([0, -0.5, -1]), rel=1e-6)


def test_light_at_an_angle_through_a_pane():
    """With θ = 60°, n = √3: r_s = -1/2, r_p = 0 (Brewster), so each wall keeps 1 - 1/8. The way is straight, 2 × 0.5."""
    glass = co.Body(co.Box((-99, -99, 2), (99, 99, 2.5)), co.glass(math.sqrt(3), absorption=0.7, specular=0))
    camera = co.OrthographicCamera((0, 0, 1), (0, 0, 0), up=(0, 1, 0), height=1e-3)
    light = co.DirectionalLight((math.sqrt(3), 0, -1))
    radiance = color([floor(co.matte(WHITE)), glass], [light], camera=camera)
    assert radiance == pytest.approx([0.5 * 0.875**2 * math.exp(-0.7)] * 3, rel=1e-6)


# Reflection and refraction


def test_mirrors_show_the_sky():
    sky = co.Sky((0.2, 0.4, 0.8), (1, 1, 1), (0, 0, 0))
    assert color([floor(co.mirror((0.9, 0.5, 1)))], background=sky) == pytest.approx((0.18, 0.2, 0.8), rel=1e-6)


def test_mirrors_facing_each_other_end_at_the_depth():
    """Floor and lid each mirror half of the light, and the lid glows with the other half."""
    box = co.Body(co.Box((-9, -9, -1), (9, 9, 0)), co.mirror(0.5))
    lid = co.Body(co.Box((-9, -9, 20), (9, 9, 21)), co.Material((1, 1, 1), ambient=1, reflectivity=0.5))
    camera = co.OrthographicCamera((0, 0, 10), (0, 0, 0), up=(0, 1, 0), height=1e-3)
    for depth in range(5):
        # floor 1/2, lid (1 - 1/2) visible, on with 1/4 and so forth
        expected = sum(0.5 * 0.5 * 0.25**k for k in range((depth + 1) // 2))
        assert color([box, lid], camera=camera, depth=depth) == pytest.approx([expected] * 3, rel=1e-6)


def test_schlick_on_lacquer():
    angle = math.radians(60)
    camera = co.OrthographicCamera((10 * math.sin(angle), 0, 10 * math.cos(angle)), (0, 0, 0), height=1e-3)
    shown = color([floor(co.lacquer((0, 0, 0), specular=0))], camera=camera)
    assert shown == pytest.approx([0.04 + 0.96 * 0.5**5] * 3, rel=1e-6)


@pytest.mark.parametrize("index", [1.0, 1.33, 1.52, 2.4])
def test_beers_law_through_a_slab(index):
    """The ray goes straight down, with all orders of reflection inside: T = (1 - R)² A / (1 - R² A²), A = exp(-a d)."""
    slab = co.Body(co.Box((-50, -50, 1), (50, 50, 3)), co.glass(index, absorption=(0, 0.3, 1), specular=0))
    black = floor(co.Material((0, 0, 0), diffuse=0, ambient=0))
    below = co.OrthographicCamera((0, 0, 0.5), (0, 0, 5), up=(0, 1, 0), height=1e-3)
    sky = co.Sky((1, 1, 1), (1, 1, 1), (0, 0, 0))
    r = ((index - 1) / (index + 1)) ** 2
    transmittance = np.exp(-2 * np.array((0, 0.3, 1)))
    expected = (1 - r) ** 2 * transmittance / (1 - r**2 * transmittance**2)
    assert color([slab, black], background=sky, camera=below) == pytest.approx(expected, abs=4 * FAINT)


def test_a_white_furnace_shows_no_glass():
    """In uniform light of 1 a clear body of any shape sends back 1, because every wall keeps the energy."""
    shapes = [
        co.Sphere(1),
        co.Box((-1.5, -0.4, -0.4), (-1.1, 0.4, 0.4)),
        co.Sphere(0.9, (2, 0, 0)) - co.Sphere(0.5, (2, 0, 0)),
    ]
    camera = co.Camera((0, -8, 2), (0, 0, 0), field_of_view=30)
    bodies = [co.Body(shape, co.glass(specular=0)) for shape in shapes]
    pixels = (
        co.Scene(bodies, lights=[co.AmbientLight()], camera=camera, background=WHITE).render(96, 64, 1, depth=60).pixels
    )
    assert pixels.max() <= 1 + 1e-6
    assert pixels.min() > 0.95
    assert pixels.mean() > 0.999


def test_glass_ball_turns_the_world_upside_down():
    camera = co.Camera((0, -6, 0), (0, 0, 0), field_of_view=30)
    sky = co.Sky((0, 0, 1), (0, 0, 0), (1, 0, 0))
    ball = co.Scene(
        [co.Body(co.Sphere(1), co.glass(specular=0))], lights=[co.AmbientLight()], camera=camera, background=sky
    )
    pixels = ball.render(61, 61, 1).pixels
    above, below = pixels[20, 30], pixels[40, 30]
    assert above[0] > 0.3 > above[2]
    assert below[2] > 0.3 > below[0]
    empty = pixels[2, 30]
    assert empty[2] > 0 == empty[0]


def test_total_reflection_in_a_prism():
    """A ray meets the long side of a right-angled prism of glass at 45° > asin(1 / 1.52) and turns by 90°."""
    prism = co.Polyhedron([(0, -1, 0), (0, 0, -1), (0, 1, 1), (1, 0, 0), (-1, 0, 0)], [0, 0, 1, 1, 1])
    camera = co.OrthographicCamera((0, -5, 0.5), (0, 0, 0.5), height=1e-3)
    sky = co.Sky((1, 1, 1), (1, 1, 1), (0, 0.5, 1))  # straight down is where it leaves
    radiance = color([co.Body(prism, co.glass(specular=0))], background=sky, camera=camera)
    r = (0.52 / 2.52) ** 2
    once = (1 - r) ** 2 * np.array((0, 0.5, 1))
    # a part is reflected at the exit, turned again, and leaves by the entry: horizon, white; so is R at the entry
    back = r + (1 - r) ** 2 * r
    assert radiance == pytest.approx(once + back, abs=0.01)


def test_a_transparent_sheet_is_a_thin_pane():
    pane = co.Body(co.Disc((0, 0, 5), (0, 0, 1), 3), co.Material((0, 0, 0), ambient=0, transparency=(1, 0.5, 0.25)))
    assert color([pane, floor(co.matte(WHITE))]) == pytest.approx((1, 0.5, 0.25), rel=1e-6)


# Nested and abutting dielectrics

CAMERA = co.Camera((2.5, -6, 2.5), (0, 0, 0.2), field_of_view=35)
GROUND = co.Body(co.Box((-20, -20, -2), (20, 20, -1)), co.matte(co.Checker(scale=0.5, space=True)))
LIGHTS = [co.AmbientLight(0.3), co.PointLight((3, -4, 6), 0.8), co.PointLight((-5, -2, 4), 0.3)]


def picture(items, camera=CAMERA, **options):
    return co.Scene([*items, GROUND], lights=LIGHTS, camera=camera).render(72, 54, 2, **options).pixels


GREEN = co.glass(absorption=(1, 0.2, 0.6))
WATER = co.glass(co.materials.WATER, absorption=(0.4, 0.1, 0.05))


def test_a_cut_through_glass_is_invisible():
    whole = picture([co.Body(co.Box((-1, -1, -1), (1, 1, 1)), GREEN)])
    halves = [co.Box((-1, -1, -1), (0.25, 1, 1)), co.Box((0.25, -1, -1), (1, 1, 1))]
    assert (picture([co.Body(half, GREEN) for half in halves]) == whole).all()
    assert (picture([co.Body(half, GREEN) for half in reversed(halves)]) == whole).all()
    quarter = [half.rotate((0, 0, 1), 90) for half in halves]
    assert (picture([co.Body(half, GREEN) for half in quarter]) == whole).all()


def test_a_cut_through_a_curved_solid_is_invisible():
    whole = picture([co.Body(co.Sphere(1), GREEN)])
    halves = [co.Sphere(1) & co.HalfSpace((1, 1, 0), 0.3), co.Sphere(1) - co.HalfSpace((1, 1, 0), 0.3)]
    assert (picture([co.Body(half, GREEN) for half in halves]) == whole).all()


def test_overlapping_media_act_like_abutting_ones():
    """The first body in the list has priority: the part of the water within the glass is glass."""
    glass = co.Body(co.Box((-1, -1, -1), (0, 1, 1)), GREEN)
    abutting = picture([glass, co.Body(co.Box((0, -1, -1), (1, 1, 1)), WATER)])
    overlapping = picture([glass, co.Body(co.Box((-0.5, -1, -1), (1, 1, 1)), WATER)])
    assert (abutting == overlapping).all()


def test_a_drink_needs_no_gap():
    """The water in a glass is an abutting body, or a later one in the list that overlaps the whole glass."""
    outer, inner = co.Cylinder((0, 0, -0.9), (0, 0, 1), 0.9), co.Cylinder((0, 0, -0.7), (0, 0, 1), 0.7)
    glass = co.Body(outer - inner, GREEN)
    fitted = picture([glass, co.Body(inner & co.HalfSpace((0, 0, 1), 0.5), WATER)])
    poured = picture([glass, co.Body(outer & co.HalfSpace((0, 0, 1), 0.5), WATER)])
    assert (fitted == poured).all()


def test_air_in_glass_and_glass_around_air():
    """A bubble is a body of index 1 that comes first in the list, or a hole: the same."""
    dull = co.glass(absorption=(1, 0.2, 0.6), specular=0)
    with_body = picture([co.Body(co.Sphere(0.6), co.glass(1, specular=0)), co.Body(co.Sphere(1), dull)])
    with_hole = picture([co.Body(co.Sphere(1) - co.Sphere(0.6), dull)])
    assert np.abs(with_body - with_hole).max() < 1e-6


def test_bodies_that_touch_glass_are_visible_through_it():
    """A wall of glass touches an opaque wall at one t. Either may come first in the list."""
    plate = co.Body(co.Box((-1, -1, -1), (1, 1, -0.5)), GREEN)
    first = co.Scene([plate, GROUND], lights=LIGHTS, camera=CAMERA).render(72, 54, 2).pixels
    last = co.Scene([GROUND, plate], lights=LIGHTS, camera=CAMERA).render(72, 54, 2).pixels
    assert (first == last).all()
    radiance = color(
        [co.Body(co.Box((-9, -9, 0), (9, 9, 2)), co.glass(1, absorption=0.5, specular=0)), floor(co.matte(WHITE))]
    )
    assert radiance == pytest.approx([math.exp(-1)] * 3, rel=1e-6)


def test_a_camera_may_stand_in_water():
    """The camera looks through 4 of water to the floor, and upwards total reflection shows bodies under water."""
    sea = co.Body(
        co.Box((-90, -90, 0), (90, 90, 12)), co.glass(co.materials.WATER, absorption=(0.5, 0.1, 0), specular=0)
    )
    camera = co.OrthographicCamera((0, 0, 4), (0, 0, 0), up=(0, 1, 0), height=1e-3)
    radiance = color([sea, floor(co.matte(WHITE))], camera=camera)
    assert radiance == pytest.approx(np.exp([-2, -0.4, 0]), rel=1e-6)
    endless = co.Body(co.HalfSpace((0, 0, 1), 12), co.glass(co.materials.WATER, absorption=(0.5, 0.1, 0), specular=0))
    assert color([endless], camera=camera) == pytest.approx((0, 0, 1), abs=1e-6)


# Textures


def test_checker_in_space_is_steady_on_the_boundary_of_its_cubes():
    """The floor's top is z = 0, where cubes meet. The color is that of the matter below, on every pixel."""
    checker = co.matte(co.Checker((1, 1, 1), (0, 0, 0), scale=1, space=True), ambient=1)
    camera = co.OrthographicCamera((0.5, 0.5, 10), (0.5, 0.5, 0), up=(0, 1, 0), height=3)
    pixels = co.Scene([floor(checker)], lights=[co.AmbientLight(1)], camera=camera).render(30, 30, 1).pixels[..., 0]
    # z just under 0: floor(z) = -1, odd; the square about (1/2, 1/2) is black
    squares = (np.add.outer(np.arange(3), np.arange(3)) + 1) % 2
    expected = np.kron(squares, np.ones((10, 10)))
    assert (pixels == 1 - expected).all()


def test_checker_on_uv():
    """u of a cylinder is angle / 360: eight sectors of alternating colors."""
    checker = co.matte(co.Checker((1, 1, 1), (0, 0, 0), scale=(1 / 8, 10)))
    tube = co.Body(co.Cylinder((0, 0, 0), (0, 0, 5), 1, 0, 360, (1, 0, 0)), checker)
    for k in range(8):
        angle = math.radians(45 * k + 20)
        eye = (5 * math.cos(angle), 5 * math.sin(angle), 2)
        camera = co.OrthographicCamera(eye, (0, 0, 2), height=1e-3)
        assert color([tube], camera=camera) == pytest.approx([(k + 1) % 2] * 3, abs=1e-6)
