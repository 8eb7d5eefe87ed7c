"""What is reached for and is not there, or means something else: told with what to write instead."""

from __future__ import annotations

import inspect
import math

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.registry import REGISTRY
from conicoid.io.scene_file.scene_file import parse_scene

from .contract.examples import examples_of

BALL, BOX = co.Sphere(), co.Box((2, 2, 2), (3, 3, 3))
SCENE = co.Scene([co.Body(BALL, co.matte("red", name="steel"), "ball"), BOX])
RAYS = co.Rays([(0, 0, 5), (0.1, 0, 5)], (0, 0, -1))
HITS = SCENE.first_hit(RAYS)
CAMERA = co.Camera((0, 0, 5), (0, 0, 0))
DISC = co.Disc((0, 0, 0), (0, 0, 1), 1)


@pytest.mark.parametrize("radii", [(1, 2, 3), (1.0, 2.0, 3.0), [1, 2, 3], np.array([1.0, 2.0, 3.0])])
def test_radii_beside_coefficients_are_refused_whatever_they_are(radii):
    with pytest.raises(ValueError, match="radii must be left out where coefficients are given"):
        co.Ellipsoid(radii=radii, coefficients=(1, 1, 1))


def test_coefficients_alone_stay_and_move():
    ball = co.Ellipsoid(coefficients=(1, 1, 1)).translate((1, 0, 0))
    assert ball.coefficients == (1, 1, 1)
    assert ball.radii == (1, 1, 1)


@pytest.mark.parametrize("call", [
    lambda: co.Box((0.5, 0.5, 0.5)), lambda: co.Box((-1, -1, -1)), lambda: co.Box([2, 2, 2]),
    lambda: co.Box(np.ones(3)), lambda: co.Box(size=(1, 1, 1)), lambda: co.Box((0, 0, 0), size=(1, 1, 1)),
    lambda: co.Box(half_extents=(1, 1, 1)),
])  # fmt: skip
def test_a_box_by_its_size_is_told_of_corners(call):
    with pytest.raises(TypeError, match=r"^Box: a box is given by two corners, Box\(low, high\), got .* Box\(\(-x/2, "):
        call()


def test_a_box_by_corners_that_are_named_is_one():
    assert co.Box() == co.Box((-1, -1, -1), (1, 1, 1)) == co.Box(low=(-1, -1, -1))
    assert co.Box(high=(3, 3, 3)).high == (3, 3, 3)
    assert parse_scene("bodies: [{shape: {Box: {low: [0, 0, 0]}}}]", "x.yaml").bodies[0].shape == co.Box(low=(0, 0, 0))


@pytest.mark.parametrize("name", sorted(REGISTRY))
@pytest.mark.parametrize("motion", ["x", None, 3, np.eye(4), ()])
def test_motions_of_shapes_are_motions(name, motion):
    shape = examples_of(name)[0]
    fields = {field: getattr(shape, field) for field in inspect.signature(type(shape)).parameters if field != "motion"}
    with pytest.raises(TypeError, match=rf"^{name}: motion must be left out: .*translate.*; got "):
        type(shape)(**fields, motion=motion)
    assert type(shape)(**fields, motion=shape.motion) == shape


@pytest.mark.parametrize(("call", "told"), [
    (lambda: co.measure(SCENE, samples=3), r"has no argument 'samples' \(did you mean rays\?\)"),
    (lambda: co.check(SCENE, samples=3), r"has no argument 'samples' \(did you mean rays\?\)"),
    (lambda: co.Scene([], name="x"), r"has no argument 'name': a body has that, Body\(shape, material, name\); call"),
    (lambda: co.Sphere(1, material="red"), r"has no argument 'material': a body has that, Body\(shape, material, name\)"),
    (lambda: co.Scene([], cameras=3), r"\(did you mean camera\?\)"),
    (lambda: CAMERA.rays(64), r"^Camera.rays\(\) missing height; call it as rays\(width, height\)$"),
    (lambda: SCENE.rays(10), r"^Scene.rays\(\) missing height; call it as rays\(width, height\)$"),
    (lambda: co.Image(np.eye(3)).save(), r"^Image.save\(\) missing path; call it as save\(path, \*, bits\)$"),
    (lambda: HITS.save(), r"^Hits.save\(\) missing path"), (lambda: RAYS.save(), r"^Rays.save\(\) missing path"),
    (lambda: HITS.detached(1), r"^Hits.detached\(\) takes no arguments, got 1"),
    (lambda: co.Hits.concatenate(HITS, HITS), r"^Hits.concatenate\(\) takes 1 argument, got 2 \(put parts in a list\)"),
    (lambda: co.Spans.concatenate(1, 2), r"^Spans.concatenate\(\) takes 1 argument, got 2 \(put parts in a list\)"),
    (lambda: co.Union(BALL, BOX), r"\(put operands in a list\)"),
    (lambda: SCENE.replace("ball", colour="red"), r"has no argument 'colour' \(did you mean material\?\); call it as replace"),
    (lambda: co.Camera((0, 0, 1), look_from=(1, 1, 1)), r"has no argument 'look_from' \(did you mean position\?\)"),
    (lambda: co.PointLight((0, 0, 1), color="red"), r"has no argument 'color' \(did you mean intensity\?\)"),
    (lambda: co.Cylinder(radius=1, height=2), r"has no argument 'height' \(did you mean start and end\?\)"),
    (lambda: SCENE.line_integral(RAYS, [1, 2]), r"values come first, and then the rays: line_integral\(values, rays\).*Rays"),
    (lambda: SCENE.line_integral(HITS, RAYS), r"values come first, and then the rays: line_integral\(values, rays\).*Hits"),
    (lambda: co.render(SCENE), r"^conicoid.render is a module, not a function: .* scene.render\(width, height\)$"),
    (lambda: co.explain(SCENE), r"^conicoid.explain is a module, not a function: .* scene.explain\(origin, direction\)$"),
    (lambda: co.section(SCENE), r"^conicoid.section is a module, not a function: .* scene.section\(plane\)$"),
    (lambda: BALL + BOX, r"^Sphere: \+ is no operation of shapes; a \| b is the union"),
    (lambda: BALL * BOX, r"^Sphere: \* is no operation of shapes; .* a & b what both have in common$"),
    (lambda: DISC + BALL, r"^Disc: \+ is no operation of shapes"),
    (lambda: BALL + (1, 2, 3), r"^Sphere: \+ \(1, 2, 3\) is no operation, sphere.translate\(offset\) moves it$"),
    (lambda: BALL * 2, r"^Sphere: \* 2 is no operation, sphere.scale\(2\) changes its size$"),
    (lambda: 2 * BALL, r"sphere.scale\(2\) changes its size$"),
    (lambda: BALL - co.Body(BOX), r"^Body: bodies do not combine, shapes do: co.Body\(a.shape - b.shape, material\)$"),
    (lambda: co.Body(BALL) - BOX, r"^Body: bodies do not combine, shapes do: co.Body\(a.shape - b.shape, material\)$"),
    (lambda: co.Body(BALL) | co.Body(BOX), r"^Body: bodies do not combine, shapes do: co.Body\(a.shape \| b.shape"),
])  # fmt: skip
def test_calls(call, told):
    with pytest.raises(TypeError, match=told) as error:
        call()
    assert "positional" not in str(error.value)


@pytest.mark.parametrize(("call", "told"), [
    (lambda: sum([BALL, BOX]), r"^Sphere: sum\(\) adds nothing up here, co.Union\(\[...\]\) unites many$"),
    (lambda: -co.HalfSpace((0, 0, 1), 0), "^HalfSpace: signs mean nothing here: a shape is its inside, ~shape the outside$"),
    (lambda: +BALL, "^Sphere: signs mean nothing here"),
    (lambda: co.Scene(BALL, BOX), r"^Scene: items must be in one list, Scene\(\[first, second\]\), got Box as lights$"),
    (lambda: co.Scene([(BALL, "red")]), r"items\[0\] must be .* got tuple; Body\(shape, material, name\) is one$"),
    (lambda: co.Scene([[BALL, BOX]]), r"got list; \[\*a, \*b\] is one list of two$"),
    (lambda: co.Scene([SCENE, BOX]), r"got Scene; a scene has these in .bodies: \[\*a, \*b\] is one list of two$"),
    (lambda: SCENE.first_hit([RAYS[0], RAYS[1]]), r"^first_hit: rays of a list are joined by co.Rays.concatenate\(rays\)"),
])  # fmt: skip
def test_combinations(call, told):
    with pytest.raises(TypeError, match=told):
        call()


def test_a_section_by_an_equation_is_told_how():
    with pytest.raises(ValueError, match=r"got 'z=0'; where it lies is the second, section\('z', 0.5\)$"):
        SCENE.section("z=0")


@pytest.mark.parametrize("compared", [
    lambda body: HITS.body == body, lambda body: body == HITS.body, lambda body: HITS.name == body,
    lambda body: HITS.body[0] == body, lambda body: HITS.body != body,
])  # fmt: skip
def test_numbers_of_bodies_are_not_compared_with_bodies(compared):
    with pytest.raises(TypeError, match=r"^Body: numbers and names are no bodies: compare hits.name == body.name"):
        compared(SCENE["ball"])


def test_bodies_are_equal_as_before():
    body = SCENE["ball"]
    assert body == co.Body(co.Sphere(), co.matte("red", name="steel"), "ball")
    assert hash(body) == hash(co.Body(co.Sphere(), co.matte("red", name="steel"), "ball"))
    assert body not in (None, 3, "ball", co.Sphere(), co.Body(co.Sphere(), "red", "ball"))
    assert (HITS.name == body.name).all()


def test_values_after_rays_are_told_of_their_order():
    with pytest.raises(
        ValueError, match=r"got \(2,\); values come first: line_integral\(values, origins, directions\)$"
    ):
        SCENE.line_integral((0, 0, 5), (0, 0, -1), [1, 2])
    with pytest.raises(ValueError, match=r"directions must not be zero|direction must not be zero") as error:
        SCENE.line_integral([1, 2], (0, 0, 5), (0, 0, 0))
    assert "values come first" not in str(error.value)


@pytest.mark.parametrize("name", ["ball", "detector", "steel"])
def test_a_name_in_place_of_a_material_is_told_of(name):
    with pytest.raises(ValueError, match=rf"; a name is the third, Body\(shape, name='{name}'\)$"):
        co.Body(BALL, name)


@pytest.mark.parametrize(("ask", "told"), [
    (lambda: SCENE.check(), r"'Scene' object has no attribute 'check': it is a function, co.check\(scene\)$"),
    (lambda: SCENE.measure, r"co.measure\(scene\)$"), (lambda: SCENE.volume, r"co.measure\(scene\).by_material"),
    (lambda: SCENE.intersect, "first_hit"), (lambda: SCENE.add, r"co.Scene\(\[\*scene.bodies, another\], scene.lights, scene.camera, scene.background, scene.domain\)"),
    (lambda: SCENE.rotate, r"body.translate\(offset\) for body in scene.bodies"),
    (lambda: SCENE.ball, r"a body is called so, scene\['ball'\]$"), (lambda: SCENE.objects, r"scene.bodies are"),
    (lambda: SCENE.nonsense, r"^'Scene' object has no attribute 'nonsense'$"),
    (lambda: BALL.rotate_z, r'axes are named, sphere.rotate\("z", degrees\)$'), (lambda: BALL.move, "called translate$"),
    (lambda: BALL.union, r"operators, sphere \| other$"), (lambda: BALL.subtract, r"operators, sphere - other$"),
    (lambda: BALL.bbox, "called bounds$"), (lambda: BALL.material, r"a body has that, co.Body\(sphere, material, name\)$"),
    (lambda: BALL.check, r"co.check\(sphere\)$"), (lambda: co.Body(BALL).radius, r"body.shape.radius is that$"),
    (lambda: co.Body(BALL).bounds, r"body.shape.bounds is that$"), (lambda: co.Body(BALL, "red").color, "body.material.color"),
    (lambda: co.first_hit, r"'conicoid' has no attribute 'first_hit': a scene has it, scene.first_hit$"),
    (lambda: co.Ball, r"\(did you mean Sphere\?\)$"), (lambda: co.Halfspace, r"\(did you mean HalfSpace\?\)$"),
    (lambda: co.Torus, "planes and quadrics"), (lambda: co.Translate, r"shape.translate\(...\)$"),
    (lambda: co.nonsense, "^module 'conicoid' has no attribute 'nonsense'$"),
])  # fmt: skip
def test_attributes(ask, told):
    with pytest.raises(AttributeError, match=told):
        ask()


def test_hints_name_what_there_is():
    from conicoid._util import foreign_names as elsewhere

    assert all(hasattr(co, name) for name in elsewhere.PACKAGE_FUNCTIONS)
    assert all(hasattr(co, name) for name in elsewhere.CLASS_SYNONYMS.values())
    assert all(hasattr(BALL, name) for name in elsewhere.SHAPE_SYNONYMS.values())
    assert not any(hasattr(co.Sphere, name) or hasattr(co.Body, name) for name in elsewhere.SHAPE_SYNONYMS)


def test_every_public_method_tells_calls_that_do_not_fit():
    for kind in (
        co.Scene,
        co.Hits,
        co.Rays,
        co.Spans,
        co.Crossings,
        co.Camera,
        co.OrthographicCamera,
        co.Image,
        co.Body,
    ):
        for name in dir(kind):
            found = inspect.getattr_static(kind, name)
            if not name.startswith("_") and inspect.isfunction(getattr(found, "__func__", found)):
                with pytest.raises(TypeError, match=r"\(\) .*call it as|^[a-z_]+: ") as error:
                    getattr(kind, name)(*[None] * 20)
                assert "positional" not in str(error.value), name


@pytest.mark.parametrize(("answer", "told"), [
    (SCENE.first_hit((0, 0, 5), (0, 0, -1)),
     "Hits(body 0 'ball', t=4.0, point=(0.0, 0.0, 1.0), normal=(0.0, 0.0, 1.0), face=0, entering=True)"),
    (HITS[0].detached(),
     "Hits(body 0 'ball', t=4.0, point=(0.0, 0.0, 1.0), normal=(0.0, 0.0, 1.0), face=0, entering=True)"),
    (SCENE.first_hit((9, 9, 9), (0, 0, 1)), "Hits(a miss, t=inf)"),
    (RAYS[0], "Rays((0.0, 0.0, 5.0), (0.0, 0.0, -1.0))"),
    (SCENE.spans((0, 0, 5), (0, 0, -1)), "Spans(shape=(), 1 span: body 0 'ball' [4.0, 6.0])"),
    (SCENE.spans((2.5, 2.5, 0), (0, 0, 2)), "Spans(shape=(), 1 span: body 1 [1.0, 1.5])"),
    (SCENE.crossings((0, 0, 5), (0, 0, -1)), "Crossings(shape=(), 2 crossings: body 0 'ball' t=4.0, body 0 'ball' t=6.0)"),
    (SCENE.spans((9, 9, 9), (0, 0, 1)), "Spans(shape=(), 0 spans)"),
    (HITS, "Hits(shape=(2,), 2 of 2 rays hit)"),
])  # fmt: skip
def test_answers_to_one_ray_show_their_digits(answer, told):
    assert repr(answer) == told


@pytest.mark.parametrize(("material", "told"), [
    (co.Material(), "Material()"), (co.matte("red"), "matte(color='red')"), (co.Material("red"), "Material(color='red')"),
    (co.glass(1.5, name="crown"), "glass(refractive_index=1.5, name='crown')"),
    (co.metal("gold", reflectivity=0.7), "metal(color='gold', reflectivity=0.7)"), (co.mirror(), "mirror()"),
    (co.lacquer(properties={"mu": 2}), "lacquer(properties={'mu': 2})"), (co.phong(specular=0.25), "phong(specular=0.25)"),
    (co.materials.gold(), "gold()"), (co.materials.conductor(roughness=0.2), "conductor(roughness=0.2)"),
])  # fmt: skip
def test_materials_show_the_call_that_makes_them(material, told):
    assert repr(material) == told
    names = {name: getattr(co, name) for name in ("matte", "glass", "metal", "Material")}
    assert eval(told, vars(co) | vars(co.materials) | names) == material


def test_motions_about_a_point():
    turned = BOX.rotate("z", 90, about=(2, 2, 0))
    assert turned == BOX.translate((-2, -2, 0)).rotate("z", 90).translate((2, 2, 0))
    # (x, y) goes to (2 - (y - 2), 2 + (x - 2)): x from 1 to 2, y from 2 to 3, to the bit
    assert [end.tolist() for end in turned.bounds] == [[1, 2, 2], [2, 3, 3]]
    assert [end.tolist() for end in BOX.scale(2, about=(3, 3, 3)).bounds] == [[1, 1, 1], [3, 3, 3]]
    point = np.array((0.1, 0.2, 0.3))
    assert co.Sphere(0.5, tuple(point)).rotate((1, 1, 1), 77, about=point).bounds[0] == pytest.approx(point - 0.5)
    body = co.Body(BOX, "red", "box")
    assert body.rotate("z", 90, about=(2, 2, 0)) == co.Body(turned, "red", "box")
    assert body.translate((1, 0, 0)).scale(2).transform(np.eye(4)).name == "box"
    for wrong in ((1, 2), "x", (math.nan, 0, 0)):
        with pytest.raises(ValueError, match=r"^rotate: about(\[0\])? must be"):
            BALL.rotate("z", 1, about=wrong)


def test_a_turn_about_a_point_in_a_scene_file(tmp_path):
    text = "bodies: [{shape: {Box: {low: [2, 2, 2], high: [3, 3, 3]}}, move: [{rotate: {axis: z, degrees: 90, about: %s}}]}]"
    scene = co.Scene(parse_scene(text % "[2, 2, 0]", "x.yaml").bodies)
    assert scene.bodies[0].shape == BOX.rotate("z", 90, about=(2, 2, 0))
    scene.save(tmp_path / "scene.yaml")
    assert co.load(tmp_path / "scene.yaml") == scene
    with pytest.raises(co.SceneFileError, match=r"move\[0\]: rotate: about: must be 3 numbers, got 2"):
        parse_scene(text % "[2, 2]", "x.yaml")


@pytest.mark.parametrize(("shape", "told"), [
    ("{Ball: {}}", r"unknown shape 'Ball' \(did you mean 'Sphere'\?\)$"),
    ("{Rotate: {}}", r"unknown shape 'Rotate': motions stand beside a shape, move: \[\{rotate: ...\}\]$"),
    ("{Box: {size: [1, 1, 1]}}", r"Box: a box is given by two corners, Box\(low, high\), got size alone; of size"),
])  # fmt: skip
def test_scene_files_tell_what_is_meant(shape, told):
    with pytest.raises(co.SceneFileError, match=told):
        parse_scene(f"bodies: [{{shape: {shape}}}]", "x.yaml")


@pytest.mark.parametrize(("body", "told"), [
    ("{shape: {Sphere: {material: red}}}", r"Sphere: unknown key 'material' \(a body has it, beside its shape\)$"),
    ("{shape: {Sphere: {name: ball}}}", r"Sphere: unknown key 'name' \(a body has it, beside its shape\)$"),
    ("{shape: {Box: {colour: red}}}", r"Box: unknown key 'colour' \(a body has a material, beside its shape\)$"),
    ("{shape: {Sphere: {}}, colour: red}", r"unknown key 'colour' \(its material may be a colour\)$"),
    ("{shape: {Sphere: {radios: 1}}}", r"Sphere: unknown key 'radios' \(did you mean 'radius'\?\)$"),
])  # fmt: skip
def test_keys_of_a_body_have_their_place(body, told):
    with pytest.raises(co.SceneFileError, match=told):
        parse_scene(f"bodies: [{body}]", "x.yaml")
