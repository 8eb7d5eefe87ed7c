"""Mistakes are errors at once, by object and field, or warnings; values with a plain meaning pass."""

import math
import re
import warnings

import numpy as np
import pytest

import conicoid as co
from conicoid._util.validation import looks_like_radians
from conicoid.io.scene_file.scene_file import parse_scene

from ..command_line import failure, run
from ..public_names import PUBLIC
from .arguments import CALLS, JUNK, TAKEN

# --- Mistakes that gave an answer: each is an error or a warning now, and right calls go on as before


BALL = co.Sphere()
BALLS = co.Spheres([(0, 0, 9), (0, 0, 12)], 1)
SCENE = co.Scene([co.Body(BALL, "red", "ball"), BALLS, co.Box((2, 2, 2), (3, 3, 3))])
RAYS = co.Rays([(0, 0, 5), (0.1, 0, 5), (9, 9, 0)], (0, 0, -1))
HITS = SCENE.first_hit(RAYS)


@pytest.mark.parametrize(
    "color", [(20, 30, 90), (20.0, 30.0, 90.0), np.array([20, 30, 90]), np.array([20, 30, 90], np.uint8)]
)
@pytest.mark.parametrize(
    "take",
    [
        lambda c: co.Scene(BALL, background=c),
        lambda c: co.Scene(BALL).replace(background=c),
        co.Sky,
        lambda c: co.Sky("white", c),
        lambda c: co.Sky("white", "white", c),
        co.matte,
        co.metal,
        lambda c: co.Material(specular=c),
        lambda c: co.Checker("white", c),
        lambda c: co.Body(BALL, c),
        BALL.painted,
    ],
)
def test_bytes_are_no_linear_light(color, take):
    with pytest.raises(ValueError, match=r"must be in \[0, 1\], got 20|must be linear light"):
        take(color)


def test_light_brighter_than_white_is_reported():
    """A sky of intensity 8 is eight times as bright in every direction, also when it comes back from files."""
    plain, bright = (
        co.Scene([], background=co.Sky("navy", "tomato", "gray", i), camera=co.Camera((0, 0, 0), (1, 0, z)))
        for i, z in ((1, 0.5), (8, 0.5))
    )
    one, eight = (scene.render(4, 3, samples=1).pixels for scene in (plain, bright))
    assert np.array_equal(eight, 8 * one)
    assert co.Scene([], background=(1.5, 2.25, 9.5)).background == (1.5, 2.25, 9.5)
    with pytest.warns(UserWarning, match=r"background \(20.5, 30.25, 90.5\) is linear light, 90.5 times white; co.Sky"):
        co.Scene([], background=(20.5, 30.25, 90.5))  # the mean of some bytes, say


@pytest.mark.parametrize(
    "make",
    [
        co.AmbientLight,
        lambda i: co.DirectionalLight((0, 0, 1), i),
        lambda i: co.PointLight((0, 0, 1), i),
        lambda i: co.SpotLight((0, 0, 1), (0, 0, -1), intensity=i),
    ],
)
def test_lights_in_bytes_are_doubted(make):
    with pytest.warns(
        UserWarning, match=r"intensity \(255.0, 240.0, 200.0\) is linear light, 255 times white"
    ) as message:
        make((255, 240, 200))
    assert message[0].filename == __file__
    for usual in ((3, 2, 2), (16, 12, 9), (40.5, 38, 36), 255, (1, 1, 1)):
        make(usual)
    co.PointLight((0, 0, 1), (255, 240, 200), "inverse_square")  # at a distance of 16 it is about 1


def test_numbers_of_answers_are_not_counted_as_entries():
    """Body 1 is the first ball of entry 1, body 2 the second, and body 3 the box, which is entry 2."""
    assert SCENE.bodies[np.int32(0)].name == "ball"
    assert SCENE.bodies[np.int32(1)].shape is BALLS
    for number in (np.int32(2), np.int32(3)):
        with pytest.raises(IndexError, match="bodies and entries are counted differently"):
            SCENE.bodies[number]


@pytest.mark.parametrize("vector", [(math.nan, 0, 1), (math.nan,) * 3])
def test_nan_is_nan_and_no_total_reflection(vector):
    for d, n in ((vector, (0, 0, 1)), ((0, 0, 1), vector)):
        assert np.isnan(co.reflect(d, n)).all()
        refracted, total = co.refract(d, n, 1.5)
        assert np.isnan(refracted).all()
        assert not total


_ANGLES = [
    math.pi,
    math.pi / 2,
    -math.pi / 6,
    2 * math.pi / 3,
    math.radians(47.3),
    2 * math.pi,
    np.deg2rad(30),
    np.float64(math.pi) / 4,
]


@pytest.mark.parametrize("angle", _ANGLES)
@pytest.mark.parametrize(
    "turn",
    [
        lambda a: BALL.rotate("z", a),
        lambda a: co.Body(BALL).rotate((0, 0, 1), a, about=(1, 1, 1)),
        lambda a: co.Camera((0, 0, 5), (0, 0, 0), field_of_view=abs(a)),
        lambda a: co.SpotLight((0, 0, 1), (0, 0, -1), abs(a), 0),
        lambda a: co.Cylinder((0, 0, 0), (0, 0, 1), 1, -9, a, (1, 0, 0)),
        lambda a: co.CylinderPatch((0, 0, 0), (0, 0, 1), 1, a, 20, (1, 0, 0)),
        lambda a: parse_scene(
            f"camera: {{position: [0, 0, 5], look_at: [0, 0, 0], field_of_view: {abs(float(a))!r}}}\nbodies: []", "x"
        ),
    ],
)
def test_radians_are_doubted(angle, turn):
    with pytest.warns(
        UserWarning,
        match=rf"must be in degrees, got .*: -?{abs(round(math.degrees(angle), 1)):g} degrees are that in radians",
    ) as message:
        turn(angle)
    assert len(message) == 1
    assert message[0].filename == __file__


def test_no_number_of_degrees_is_taken_for_radians():
    """There are all decimals of six digits after the point, to the end of radians, and a million sums and products."""
    some = np.arange(1, 12_600_000) / 1e6
    step = math.pi / 1800
    near = np.abs(some - np.round(some / step) * step) <= 4 * np.spacing(some)
    assert not near.any()
    rng = np.random.default_rng(5)
    for angle in [
        *(360 / rng.integers(29, 9999, 2000)),
        *(rng.integers(1, 99, 2000) / 7),
        *np.linspace(-12, 12, 1001),
        0.0,
        1e-9,
    ]:
        assert not looks_like_radians(float(angle))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        co.Camera((0, 0, 5), (0, 0, 0), field_of_view=0.7)  # a telescope


def test_radians_in_few_digits_are_doubted():
    for degrees in (15, 30, 45, 90, -90, 180, 360):
        with pytest.warns(UserWarning, match=rf": -?{abs(degrees)} degrees are that in radians"):
            BALL.rotate("z", np.float32(math.radians(degrees)))
    for angle in np.round(np.random.default_rng(1).uniform(-12, 12, 3000), 2):
        BALL.rotate("z", np.float32(angle))


STEEL, LEAD = (
    co.matte("gray", name="steel", properties={"mu": 2.0}),
    co.matte("blue", name="lead", properties={"mu": 3.0}),
)
BLOCKS = [co.Body(co.Box((0, 0, 0), (2, 1, 1)), STEEL, "one"), co.Body(co.Box((1, 0, 0), (3, 1, 1)), LEAD, "two"),
          co.Body(co.Box((2.5, 0, 0), (4, 1, 1)), LEAD)]  # fmt: skip
THROUGH = co.Rays([(-1, 0.5, 0.5), (-1, 0.4, 0.5), (-1, 9, 9)], (2, 0, 0))


def test_overlaps_are_reported_by_sums(caplog):
    """From 1 to 2 there are both steel and lead, from 2.5 to 3 lead twice: 2 + 2 + 1.5 where there are 4."""
    scene = co.Scene(BLOCKS)
    assert scene.line_integral([1, 1, 1], THROUGH).tolist() == [5.5, 5.5, 0]
    (record,) = caplog.records
    assert record.levelname == "WARNING"
    assert record.getMessage().startswith(
        "line_integral: 2 rays go through two bodies at once, and such a stretch counts for each: "
        "body 0 'one' and body 1 'two' overlap on the ray from (-1.0, 0.5, 0.5) along (2.0, 0.0, 0.0)"
    )
    scene.line_integral([1, 1, 1], THROUGH)
    assert len(caplog.records) == 1  # once for a scene
    co.Scene(BLOCKS).spans(THROUGH).lengths(by="material")
    assert "lengths: 2 rays" in caplog.records[1].getMessage()
    assert "body 1 'two' and body 2 overlap" in caplog.records[1].getMessage()


@pytest.mark.parametrize(
    "query",
    [
        lambda scene: scene.line_integral([1, 0, 1], THROUGH),
        lambda scene: scene.spans(THROUGH).line_integral({"steel": 1, "lead": 0}),
        lambda scene: scene.line_integral([1, -1, 1], THROUGH),
        lambda scene: scene.line_integral([1, 1, 1], THROUGH, overlaps="both"),
        lambda scene: scene.lengths(THROUGH),
        lambda scene: scene.lengths(THROUGH, by="material", overlaps="both"),
        lambda scene: scene.line_integral("mu", THROUGH, t_max=0.9),
        lambda scene: scene.line_integral("mu", (0, 5, 0), (0, 0, 1)),
    ],
)
def test_queries_that_count_nothing_twice_report_no_overlaps(query, caplog):
    query(co.Scene(BLOCKS))
    assert caplog.records == []


@pytest.mark.parametrize("shapes", [
    [co.Box((0, 0, 0), (1, 1, 1)), co.Box((1, 0, 0), (2, 1, 1))],  # flush
    [co.Box((0, 0, 0), (1, 1, 1)).rotate((1, 2, 3), 20), co.Box((1, 0, 0), (2, 1, 1)).rotate((1, 2, 3), 20)],
    [co.Box((0, 0, 0), (0.3333334, 1, 1)), co.Box((0.3333333, 0, 0), (2, 1, 1))],  # as decimals round
    [co.Sphere(2) - BALL, BALL], [co.Box((0, 0, 0), (1, 1, 1)), co.Box((0, 3, 0), (1, 4, 1))],
])  # fmt: skip
def test_neighbours_do_not_overlap(shapes):
    rng = np.random.default_rng(2)
    aims = rng.random((500, 3))
    origins = rng.normal(size=(500, 3)) * 6
    co.Scene(shapes).line_integral([1, 1], origins, aims - origins, overlaps="error")


def test_overlaps_are_refused_on_request():
    scene = co.Scene(BLOCKS)
    for integral in (scene.line_integral, scene.spans(THROUGH).line_integral):
        rest = (THROUGH,) if integral == scene.line_integral else ()
        with pytest.raises(
            ValueError, match=r"line_integral: 2 rays go .* overlap on the ray .*; co.check\(scene\) finds all$"
        ):
            integral("mu", *rest, overlaps="error")
        with pytest.raises(
            ValueError, match=r"overlaps must be 'both', 'error' or None, got 'eror' \(did you mean 'error'\?\)"
        ):
            integral("mu", *rest, overlaps="eror")
    with pytest.raises(ValueError, match="body 0 'one' and body 1 'two' overlap"):
        scene.lengths(THROUGH, overlaps="error")
    balls = co.Scene(co.Body(co.Spheres([(0, 0, 0), (1, 0, 0)], 1), LEAD))
    with pytest.raises(ValueError, match="body 0 and body 1 overlap"):
        balls.line_integral("mu", (-9, 0, 0), (1, 0, 0), overlaps="error")
    endless = co.Scene([co.HalfSpace((0, 0, 1), 0), co.HalfSpace((0, 0, 1), 1)])
    with pytest.raises(ValueError, match="body 0 and body 1 overlap"):
        endless.line_integral([1, 1], (0, 0, 9), (0, 0, -1), t_min=-math.inf, overlaps="error")


def test_overlaps_on_the_command_line(tmp_path):
    co.Scene(BLOCKS).save(tmp_path / "s.yaml")
    np.save(tmp_path / "r.npy", [[-1, 0.5, 0.5, 1, 0, 0.0]])
    files = tmp_path / "s.yaml", tmp_path / "r.npy", "-o", tmp_path / "x.csv"
    assert "body 0 'one' and body 1 'two' overlap" in failure(
        "lengths", *files, "--property", "mu", "--overlaps", "error"
    )
    assert "--overlaps must be one of both, error, got 'no'" in failure("lengths", *files, "--overlaps", "no")
    assert run("lengths", *files, "--property", "mu", "--overlaps", "both").exit_code == 0
    assert (tmp_path / "x.csv").read_text() == "line_integral\n14.5\n"  # 2 * 2 + 3 * 2 + 3 * 1.5


@pytest.mark.parametrize("density", [-1, -0.5, True, np.bool_(False), [1.0, -2.0], -math.inf])
def test_densities_are_not_negative_nor_truth_values(density):
    with pytest.raises(ValueError, match=r"Material: properties\['density'\] must be >= 0, got "):
        co.matte("red", properties={"density": density})
    co.matte("red", properties={"density": 0, "mu": density, "Density": "heavy"})


@pytest.mark.parametrize(("rays", "eta"), [((4,), (4, 1)), ((2, 3), (2, 3, 1)), ((3,), (3, 3))])
def test_a_column_of_etas_is_refused(rays, eta):
    d = np.broadcast_to((0.0, 0.6, -0.8), (*rays, 3))
    with pytest.raises(ValueError, match=r"refract: eta must be a number or have the rays' shape"):
        co.refract(d, (0, 0, 1), np.full(eta, 1.2))
    assert co.refract(d[:, None], (0, 0, 1), np.full((1, 5, *rays[1:]), 1.2))[1].shape == (rays[0], 5, *rays[1:])
    assert co.refract((0, 0.6, -0.8), (0, 0, 1), np.full((5, 1), 1.2))[0].shape == (5, 1, 3)


def test_what_is_in_a_scene():
    assert BALL in SCENE
    assert co.Sphere(1.0) in SCENE
    assert co.Sphere(2) not in SCENE
    assert "ball" in SCENE
    assert SCENE["ball"] in SCENE
    assert "steel" not in SCENE
    for item in (0, None, co.matte("red"), HITS.body[0]):
        with pytest.raises(TypeError, match="Scene: `in` asks for a name, a shape or a Body, got "):
            item in SCENE  # noqa: B015


# --- Values without a meaning are errors at once, by object and field; values with a plain meaning pass


LAST_ENTRY = r"Scene: bodies\[...\] takes an integer >= 0 \(-1 is a miss\), got -\d$"
LONGEST = 400
"""Characters of a message: a few lines of a terminal."""


def refusal(call, arguments, argument, value):
    """Return the message that refuses a value, or None where a call takes it."""
    try:
        call(**(arguments | {argument: value}))
    except (TypeError, ValueError) as error:
        return str(error)
    return None


@pytest.mark.parametrize("name", CALLS)
def test_junk_is_refused_by_object_and_field(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, arguments = CALLS[name]
    for argument in arguments:
        for kind, junk in JUNK.items():
            if (name, argument, kind) in TAKEN:
                continue
            try:
                message = refusal(call, arguments, argument, junk)
            except OSError:
                assert (argument, type(junk)) == ("path", str)  # it may be a path
                continue
            assert message is not None, f"{name}: {argument} takes {kind}"
            assert argument == "path" or len(message) <= LONGEST, (name, argument, kind, message[:80], len(message))
            if argument == "path" and isinstance(junk, str):
                assert str(junk)[:20] in message
            else:
                assert re.match(r"\w+: ", message), (name, argument, kind, message)
                assert re.search(rf"\b{argument}", message), (name, argument, kind, message)


def test_every_public_function_is_in_the_table():
    called = {name.partition(".")[0].partition(" ")[0] for name in CALLS}
    answers = {"Hits", "Spans", "Crossings", "Finding", "Findings", "Measures", "SceneMeasures", "SceneFileError"}
    answers |= {"BodiesAt", "Explanation", "Molecule", "Outline", "SceneSurface", "Slice", "Voxels"}
    kinds = {"Shape", "Solid", "Sheet"}
    for name in set(PUBLIC) - called - answers - kinds - {"warmup"}:
        assert not callable(PUBLIC[name]), f"{name} is not in the table"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: co.Body(co.Sphere(), co.matte), "Body: material must be .* got the function matte$"),
        (lambda: co.Body(co.Sphere(), co.Material), "Body: material must be .* got the class Material$"),
        (lambda: co.Body(co.Sphere(), "rde"), "Body: material must be three linear numbers, .*colour name, got 'rde'"),
        (lambda: co.Body(co.Sphere(), (1, 2, 0)), r"Body: material\[1\] must be in \[0, 1\], got 2"),
        (lambda: co.Body(co.Sphere(), 3), "Body: material must be a Material .* got int"),
        (lambda: co.Body(co.Sphere), "Body: shape must be a shape such as .* got the class Sphere"),
        (lambda: co.Sphere().painted(co.glass), "Painted: material must be .* got the function glass$"),
        (lambda: co.Scene(3), "Scene: items must be a list of shapes and Bodies, or one of them, got int"),
        (lambda: co.Scene("ball"), "Scene: items must be .* got str"),
        (lambda: co.Scene({"ball": co.Sphere()}), "Scene: items must be .* got dict"),
        (lambda: co.Scene([co.Sphere, co.Box()]), r"Scene: items\[0\] must be a shape or a Body, got the class Sphere"),
        (lambda: co.Scene([], lights=co.PointLight), "Scene: lights must be a list of .* got the class PointLight"),
        (lambda: co.Scene([], lights=3), "Scene: lights must be a list of .* got int"),
        (lambda: co.Scene([], lights=["sun"]), r"Scene: lights\[0\] must be one of .* got str"),
        (lambda: co.Scene([], camera=dict(position=(1, 2, 3))), "Scene: camera must be a Camera, .* got dict"),
        (lambda: co.Scene([], camera=co.Camera), "Scene: camera must be a Camera, .* got the class Camera"),
        (lambda: co.check([co.Sphere()]), "check: scene must be a Scene, a shape or a Body, got list"),
        (lambda: co.save("scene.yaml", co.Scene([])), "save: scene must be .* got str"),
        (lambda: co.Sphere(center={1, 2, 3}), "Sphere: center must be 3 numbers"),
        # a miss does not index the last entry, and numbers of bodies are not those of entries
        (lambda: SCENE.bodies[HITS.body[2]], LAST_ENTRY),
        (lambda: SCENE.bodies[np.intp(-3)], LAST_ENTRY),
        (lambda: SCENE.bodies[-1], LAST_ENTRY),
        # light that is brighter than white
        (lambda: parse_scene("background: [20, 30, 90]\nbodies: []", "x.yaml"), r"x.yaml:1:13: .*background must be linear light.* got \(20.0, 30.0, 90.0\)$"),
        (lambda: co.Scene([], background=(1, 2, 3)), r"or a Sky with an intensity, got \(1.0, 2.0, 3.0\)$"),
        (lambda: co.Sky(intensity=-1), "Sky: intensity must be >= 0, got -1"),
    ],
)  # fmt: skip
def test_values_of_other_meanings_are_refused(call, message):
    with pytest.raises((TypeError, ValueError, IndexError), match=message):
        call()


@pytest.mark.parametrize("color", ["red", "#f80", (0.5, 0, 1), np.array([0.5, 0, 1]), co.Checker("red", "blue")])
def test_a_colour_is_a_matte_material(color):
    assert co.Body(BALL, color).material == co.matte(color)


def test_one_thing_is_a_scene_of_it(tmp_path):
    ball = co.Sphere()
    assert co.Scene(ball) == co.Scene([ball])
    assert co.Scene(co.Body(ball, "red", "ball"))["ball"].material == co.matte("red")
    light = co.PointLight((0, 0, 5))
    assert co.Scene(ball, light).lights == (light,)
    assert co.Scene(iter([ball, ball])).bodies == (co.Body(ball), co.Body(ball))
    overlapping = co.Spheres([(0, 0, 0), (1, 0, 0)], 1)
    assert [f.message for f in co.check(overlapping)] == [f.message for f in co.check(co.Scene([overlapping]))]
    assert co.check(overlapping)
    assert co.check(co.Body(ball)) == []
    co.save(ball, tmp_path / "ball.yaml")
    assert co.load(tmp_path / "ball.yaml") == co.Scene([ball])
