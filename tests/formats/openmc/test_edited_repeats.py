"""Edits of imported models keep their lattices: only new bodies get shapes of their own."""

import dataclasses
import pickle

import numpy as np
import pytest

import conicoid as co
from benchmarks.comparison.scenes import core_xml
from conicoid._util.arrays import Vector
from conicoid.geometry import instance_edits as repeated_edited
from conicoid.geometry.cell import NOTHING, Tree
from conicoid.geometry.instance_edits import EditedInstances
from conicoid.geometry.instances import InstanceList
from conicoid.geometry.shape import PrimitiveSolid
from conicoid.prepare import prepared_scene

from ...samples import in_turn
from .models import MODELS, geometry_file
from .test_repeated import written_out


@dataclasses.dataclass(frozen=True)
class Nowhere(PrimitiveSolid):
    """A solid without a part, which is empty."""

    def tree(self) -> Tree:
        return NOTHING

    def support(self, direction: Vector) -> float:
        return 1.0


PROBE = co.Body(co.Cylinder((0.2, 0.1, -3), (0.4, 0.2, 3), 0.05), "red", "probe")


@pytest.fixture(scope="module")
def scene(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> co.Scene:
    return co.load_openmc(geometry_file(MODELS[request.param], tmp_path_factory.mktemp("model")))


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> co.Scene:
    return co.load_openmc(geometry_file(MODELS["core"], tmp_path_factory.mktemp("model")))


def answers_of(scene: co.Scene, low: np.ndarray, high: np.ndarray) -> list[np.ndarray]:
    """Return answers of every kind to the same rays and points."""
    random = np.random.default_rng(11)
    a, b = random.uniform(low, high, (2, 600, 3))
    rays = co.Rays(a, b - a)
    hits, spans, crossings = scene.first_hit(rays), scene.spans(rays), scene.crossings(rays)
    return [
        hits.t, hits.body, hits.face, hits.entering, hits.name, scene.occluded(rays, t_max=0.5), spans.offsets,
        spans.t_enter, spans.t_exit, spans.body, crossings.body, crossings.t, scene.body_at(a), scene.contains(a),
    ]  # fmt: skip


def same_answers(*edited: co.Scene) -> None:
    """Compare the answers with those of a scene whose bodies are each a shape of its own."""
    other = co.Scene(written_out(edited[0]))
    assert not isinstance(other.bodies, InstanceList)
    low, high = (np.nan_to_num(end, posinf=3, neginf=-3) for end in other.bounds)
    expected = answers_of(other, low, high)
    for scene in edited:
        for mine, its in zip(answers_of(scene, low, high), expected, strict=True):
            if mine.dtype == np.float64:
                assert np.allclose(mine, its, rtol=1e-12, atol=1e-12)
            else:
                assert (mine == its).all()


def inside(scene: co.Scene) -> int:
    """Return a body in the middle of the list."""
    return len(scene.bodies) // 2


EDITS = {
    "moved": lambda scene: scene.moved(inside(scene), (0.03, 0.02, 0.1)),
    "turned": lambda scene: scene.moved(inside(scene), lambda shape: shape.rotate("z", 20)),
    "replaced": lambda scene: scene.replace(inside(scene), co.Sphere(0.4, (0.2, 0.3, 0.1))),
    "added at the end": lambda scene: scene.added(PROBE),
    "added before": lambda scene: scene.added([PROBE, co.Sphere(0.3)], before=3),
    "taken out": lambda scene: scene.without([0, inside(scene), len(scene.bodies) - 1]),
    "of no part": lambda scene: scene.added([Nowhere(), PROBE], before=5),
    "a sheet": lambda scene: scene.added(co.Body(co.Disc((0.1, 0, 0.2), (0, 1, 3), 1.5), "blue"), before=0),
    "one after the other": lambda scene: (
        scene.added(PROBE, before=2).moved("probe", (0.1, 0, 0)).without(0).moved(1, (0, 0, 0.01)).without(5)
    ),
    "all of one material": lambda scene: scene.without(
        [number for number, body in enumerate(scene.bodies) if body.material == scene.bodies[0].material]
    ),
}


SCENES = "core", "cubes", "turned", "core at an angle", "cubes at an angle"


@pytest.mark.parametrize(("name", "scene"), in_turn(EDITS, SCENES), indirect=["scene"])
def test_edits_answer_as_bodies_written_out(name: str, scene: co.Scene) -> None:
    """Scenes are prepared or not before the edit. Their answers are those of one scene with all bodies written out."""
    edited = EDITS[name](co.Scene(scene.bodies, domain=scene.domain))
    scene.prepare()
    after = EDITS[name](scene)
    assert isinstance(edited.bodies, EditedInstances)
    assert isinstance(after.bodies, EditedInstances)
    same_answers(edited, after)


def test_a_reversed_edit_restores_the_list(core: co.Scene) -> None:
    assert core.added(PROBE, before=4).without("probe").bodies is core.bodies
    assert core.bodies != core.added(PROBE).bodies
    assert core.added(PROBE).bodies == core.added(PROBE).bodies


def test_names_and_materials_alone_prepare_nothing(core: co.Scene) -> None:
    core.prepare()
    number, red = inside(core), co.matte("red")
    edited = core.replace(number, material=red, name="this one")
    assert edited._prepared.geometry is core._prepared.geometry
    assert edited["this one"].material == red
    assert red in edited.materials
    assert edited.bodies[number].shape == core.bodies[number].shape
    assert edited.body(number).name == "this one"
    assert core.bodies[number].name not in edited
    low, high = core.bodies[number].shape.bounds
    middle = 0.5 * (low + high)
    for point in middle + np.random.default_rng(1).uniform(-0.3, 0.3, (20, 3)):
        hit, again = (one.first_hit(point, (0, 0.1, 1)) for one in (edited, core))
        assert (hit.t, hit.body) == (again.t, again.body)
        assert hit.name == ("this one" if hit.body == number else again.name)
        assert hit.material == (red if hit.body == number else again.material)
    old = core.bodies[number]
    assert edited.replace("this one", name=old.name, material=old.material) == core


def test_a_name_and_a_material_stay_where_other_bodies_change(core: co.Scene) -> None:
    red = co.matte("red")
    edited = core.replace(3, material=red, name="this one").moved(5, (0, 0, 0.01)).without(0)
    assert (edited["this one"].material, edited.bodies.index("this one")) == (red, 2)


def test_all_bodies_may_go(core: co.Scene) -> None:
    nothing = core.without(range(len(core.bodies)))
    assert len(nothing.bodies) == nothing.body_count == 0
    assert nothing.materials == ()
    assert not nothing.first_hit((0, 0, -99), (0, 0, 1)).hit
    probe = nothing.added(PROBE)
    assert probe.first_hit((0.2, 0.1, -20), (0.002, 0.001, 1)).name == "probe"
    assert probe.bodies == co.Scene([PROBE]).bodies


def test_bodies_that_were_changed_are_bodies_like_others(core: co.Scene) -> None:
    """Bodies are moved, or of another material: in scenes, beside others, and once more."""
    turned = [body.translate((100, 0, 0)) for body in core.bodies]
    assert co.Scene(turned).bodies[3].shape == core.bodies[3].shape.translate((100, 0, 0))
    assert co.Scene([dataclasses.replace(body, material="red") for body in core.bodies]).materials == (co.matte("red"),)
    another = dataclasses.replace(core.bodies[0].translate((100, 0, 0)), name="another")
    assert core.added(another)["another"] == another
    moved = core.moved(0, (0.1, 0, 0))
    assert co.Scene([body for body in moved.bodies if body.name]).bodies == moved.bodies
    assert isinstance(core.moved(0, (0.1, 0, 0)).moved(0, (0.1, 0, 0)).bodies, EditedInstances)


def test_names_stay_different(core: co.Scene) -> None:
    taken = core.bodies[7].name
    edited = core.added(PROBE, before=5)
    assert edited["probe"] == PROBE
    assert edited.bodies[5] == PROBE
    assert edited[taken].name == taken
    assert edited.bodies.index(taken) == 8
    for call, error, message in (
        (lambda: edited.added(PROBE, before=6), ValueError, r"bodies\[5\] and bodies\[6\] are both named 'probe'"),
        (
            lambda: core.added(co.Body(co.Sphere(), name=taken), before=0),
            ValueError,
            r"bodies\[0\] and bodies\[8\] are both named ",
        ),
        (lambda: core.replace(0, name=taken), ValueError, "are both named"),
        (lambda: edited.without("nobody"), KeyError, "no body named"),
    ):
        with pytest.raises(error, match=message):
            call()


def test_some_bodies_of_a_list_keep_their_common_tables(core: co.Scene) -> None:
    """The bodies are in any order, and others stand among them."""
    bodies = [body for body in core.bodies if body.material != core.bodies[0].material]
    some = co.Scene([PROBE, *bodies[::-1]])
    assert isinstance(some.bodies, EditedInstances)
    assert tuple(some.bodies) == (PROBE, *bodies[::-1])
    same_answers(some)
    assert co.Scene(list(core.bodies)).bodies is core.bodies
    assert not isinstance(co.Scene(bodies[:5]).bodies, InstanceList)
    with pytest.raises(ValueError, match="are both named"):
        co.Scene([*core.bodies, core.bodies[0]])


def test_many_bodies_in_one_entry_may_come_to_them(core: co.Scene) -> None:
    """An entry of many bodies has no number of its own, so such lists are written out."""
    edited = core.added(co.Spheres([(0, 0, 1), (0.2, 0.1, 0.5)], 0.1), before=2)
    assert edited.body_count == core.body_count + 2
    same_answers(edited)


def test_many_bodies_in_one_entry_are_refused_where_too_many_would_be_written_out(
    core: co.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(repeated_edited, "MAX_EXPANDED_BODIES", 100)
    many = co.Spheres([(0, 0, 1), (0.2, 0.1, 0.5)], 0.1)
    with pytest.raises(
        ValueError, match="a Spheres cannot come to 276 bodies .* over 100; add its bodies as single ones"
    ):
        core.added(many)
    with pytest.raises(ValueError, match="a Spheres cannot come to 276 bodies"):
        co.Scene([*core.bodies, many])
    edited = core.added([many.single(k) for k in range(len(many))])
    assert isinstance(edited.bodies, EditedInstances)
    assert edited.body_count == core.body_count + 2


def test_edited_scenes_are_pickled(core: co.Scene) -> None:
    edited = core.added(PROBE, before=2).without(0)
    again = pickle.loads(pickle.dumps(edited))
    assert isinstance(again.bodies, EditedInstances)
    assert again == edited
    assert again.materials == edited.materials


def bits_of_answers(scene: co.Scene) -> list[bytes]:
    """Return answers that show every number of a body, a face and a surface, to the bit."""
    low, high = (np.nan_to_num(end, posinf=3, neginf=-3) for end in scene.bounds)
    a, b = np.random.default_rng(7).uniform(low, high, (2, 600, 3))
    hits, crossings = scene.first_hit(co.Rays(a, b - a)), scene.crossings(co.Rays(a, b - a))
    found = [hits.t, hits.body, hits.face, hits.surface, hits.uv, hits.normal, hits.local_point, hits.t_error]
    spans = scene.spans(co.Rays(a, b - a))
    found += [crossings.offsets, crossings.t, crossings.surface, scene.body_at(b), spans.offsets, spans.t_exit]
    return [*(np.ascontiguousarray(each).tobytes() for each in found), scene._prepared.key]


def test_bodies_are_exchanged_in_the_tables_of_others(tmp_path, noted_calls) -> None:
    """Most edits prepare nothing anew. All have the numbers and the bits of a newly prepared scene."""
    scene = co.load_openmc(geometry_file(core_xml(1), tmp_path), void=False)
    fresh = noted_calls(prepared_scene.lowering, "lower")
    scene.prepare()
    scenes, random = [], np.random.default_rng(3)
    for step in range(14):
        number = inside(scene) if step % 2 else int(random.integers(len(scene.bodies)))
        middle = np.mean(scene.bodies[number].shape.bounds, axis=0)
        new = [
            lambda shape: shape.translate((0, 0, 0.01)), lambda shape: shape.translate((1.26, 0, 0)),
            lambda _, at=middle: co.Sphere(0.4, at), lambda shape: shape.rotate("z", 20),
        ][step % 4]  # fmt: skip
        scene = scene.moved(number, new)
        scenes += [scene] * (step % 3 == 0)
        same = co.Scene(scene.bodies)
        count = len(fresh)
        assert bits_of_answers(scene) == bits_of_answers(same)
        assert len(fresh) <= count + 2
    assert len(fresh) < 2 * step
    assert str(co.check(scene, rays=300)) == str(co.check(co.Scene(scene.bodies), rays=300))
    assert bits_of_answers(scene) == bits_of_answers(same)
    assert bits_of_answers(scenes[0]) == bits_of_answers(co.Scene(scenes[0].bodies))
