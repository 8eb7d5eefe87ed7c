"""GDML: published numbers, whole files, shared volumes, pickles, and colors."""

import copy
import importlib
import pickle
import tracemalloc

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.instances import InstanceList
from conicoid.io.gdml.solids import SOLID_READERS

from ...samples import sampled
from .evaluator import Evaluator
from .files import placed, scene_of, solid_scene, text_of, volume
from .published import EVERY
from .test_solids import DEFINE, SOLIDS as FLAT, TWISTED

# --- GDML's solids, and the shapes of the same names, against the numbers that VecGeom's and Geant4's tests print

NAMES = [one.source for one in EVERY]
READ = [(one, way) for one in EVERY for way in ("gdml", "shape") if way == "gdml" or one.shape]
ON = 1e-9
"""Points on a surface, as printed, are on it to their last digits."""


@pytest.fixture(scope="module", params=READ, ids=[f"{one.source} as {way}" for one, way in READ])
def solid(request, tmp_path_factory):
    """Return (the printed numbers, a scene of the solid alone)."""
    one, way = request.param
    if way == "shape":
        return one, co.Scene([one.shape()])
    scene = solid_scene(tmp_path_factory.mktemp("solid"), one.gdml, "s", one.define)
    assert not [note for note in scene.notes if "left out" in note]
    return one, scene


def intervals(scene, point, direction):
    """Return the intervals of the whole line through a point inside, (n, 2), in lengths from the point."""
    unit = np.array(direction, float) / np.linalg.norm(direction)
    spans = scene.spans(point, unit, t_min=-np.inf)
    return np.stack([spans.t_enter, spans.t_exit], axis=1)


def distance_in(scene, point, direction):
    """Return the distance to the solid; 0 on its surface if the line goes in there, inf if it never meets the solid."""
    scale = 1 + np.abs(point).max()
    found = [low for low, high in intervals(scene, point, direction) if high > ON * scale]
    return max(min(found), 0.0) if found else np.inf


def distance_out(scene, point, direction):
    """Return the distance out of the part that holds the point, inside or on the surface."""
    scale = 1 + np.abs(point).max()
    return max(high for low, high in intervals(scene, point, direction) if low <= ON * scale and high >= -ON * scale)


def close(found, expected, digits):
    if np.isinf(expected):
        return found == expected
    return abs(found - expected) <= digits * (1 + abs(expected))


def test_inside_and_outside(solid):
    one, scene = solid
    for points, expected in ((one.inside, True), (one.outside, False)):
        if points:
            assert (np.asarray(scene.contains(np.array(points, float))) == expected).all()


def test_distances(solid):
    one, scene = solid
    for wanted, distance in ((one.into, distance_in), (one.out, distance_out)):
        for point, direction, expected in wanted:
            found = distance(scene, point, direction)
            assert close(found, expected, one.digits), (distance.__name__, point, direction, found, expected)


def test_normals(solid):
    """The ray comes from a little way outside, straight on."""
    one, scene = solid
    for point, normal in one.normals:
        unit = np.array(normal, float) / np.linalg.norm(normal)
        hit = scene.first_hit(np.array(point) + 0.125 * unit, -unit)
        assert abs(hit.t - 0.125) <= 1e-12 * (1 + np.abs(point).max())
        assert np.allclose(hit.normal, unit, rtol=0, atol=1e-12)


def test_sizes(solid, monkeypatch):
    monkeypatch.setattr(importlib.import_module("conicoid.apps.measures.measure"), "RAYS", 60_000)
    one, scene = solid
    if one.extent is not None:
        low, high = scene.bounds
        rough = 1e-9 if hasattr(scene.bodies[0].shape, "operands") else 1e-14  # bounds of Booleans are not tight
        assert np.allclose(low, one.extent[0], rtol=rough, atol=1e-13)
        assert np.allclose(high, one.extent[1], rtol=rough, atol=1e-13)
    if one.volume is None and one.area is None:
        return
    found = co.measure(scene.bodies[0].shape, rays=None if isinstance(scene.bodies[0].shape, co.Polyhedron) else 3000)
    for value, error, expected in (
        (found.volume, found.volume_error, one.volume),
        (found.area, found.area_error, one.area),
    ):
        if expected is not None:
            assert abs(value - expected) <= 5 * error + 1e-11 * expected


def test_every_solid_of_gdml_that_others_print_numbers_of_is_here():
    """The list has all solids of formats/gdml; xtru, cutTube, twistedtubs and others have formulas in test_solids."""
    here = {one.gdml.split()[0].lstrip("<").rstrip(">") for one in EVERY}
    elsewhere = {"cutTube", "tessellated", "xtru", "genericPolycone", "genericPolyhedra", "twistedtubs"}
    assert set(SOLID_READERS) - here == elsewhere


# --- Whole files against an evaluator without common code

SOLIDS = """
<box name="w" x="200" y="200" z="200"/>
<tube name="t" rmin="2" rmax="9" z="20" startphi="15" deltaphi="300" aunit="deg"/>
<trap name="p" z="24" theta="10" phi="40" y1="16" x1="8" x2="12" alpha1="10" y2="20" x3="10" x4="15" alpha2="10" aunit="deg"/>
<trd name="d" x1="6" x2="20" y1="10" y2="5" z="30"/>
<cone name="c" rmin1="1" rmax1="4" rmin2="3" rmax2="8" z="12"/>
<union name="u"><first ref="d"/><second ref="t"/><position x="3" y="-2" z="5"/><rotation x="20" y="30" z="40" unit="deg"/></union>
<subtraction name="s"><first ref="u"/><second ref="c"/><rotation x="-70" y="10" z="5" unit="deg"/></subtraction>
<box name="b" x="60" y="60" z="60"/>
"""


@pytest.mark.parametrize("seed", range(3))
def test_the_deepest_volume(tmp_path, seed):
    chance = np.random.default_rng(seed)

    def motion(reach):
        x, y, z = chance.uniform(-reach, reach, 3)
        a, b, c = chance.uniform(-180, 180, 3)
        return f'<position x="{x}" y="{y}" z="{z}"/><rotation x="{a}" y="{b}" z="{c}" unit="deg"/>'

    structure = volume("vc", "c") + volume("vs", "s") + volume("vp", "p", placed("vc", '<position x="1" y="0" z="2"/>'))
    structure += volume("vb", "b", placed("vs", motion(5)))
    inside = "".join(
        placed(name, f'<position x="{x}" y="{y}" z="{z}"/>' + motion(1).partition("/>")[2])
        for name, x, y, z in [
            ("vb", -40, -40, 0),
            ("vb", 40, 40, 0),
            ("vp", 50, -50, 0),
            ("vp", -50, 50, 30),
            ("vs", 0, 0, 75),
        ]
    )
    text = text_of(SOLIDS, structure + volume("world", "w", inside))
    scene = scene_of(tmp_path, text)
    count = 10_000
    around = np.array([(-40, -40, 0), (40, 40, 0), (50, -50, 0), (0, 0, 75)])[chance.integers(0, 4, count)]
    p = np.concatenate([chance.uniform(-100, 100, (count, 3)), chance.uniform(-30, 30, (count, 3)) + around])
    names = np.array([body.name.rpartition("/")[2].partition("#")[0] for body in scene.bodies] + [""], object)
    found, expected = names[np.asarray(scene.body_at(p))], Evaluator(tmp_path / "a.gdml").deepest(p)
    assert set(expected) == {"", "world", "vb", "vs", "vp", "vc"} - ({""} if (abs(p) <= 100).all() else set())
    assert (found != expected).sum() == 0


# --- Scenes of volumes in many places can be pickled, whatever their solids are

EVERY_SOLID = FLAT | {f"twisted: {name}": solid for name, solid in TWISTED.items()}
PROTOCOLS = 2, pickle.HIGHEST_PROTOCOL
_ACROSS = 2


def rows_of(folder, solids: str) -> co.Scene:
    """Return a solid in rows and columns in a box around all of them."""
    inside = "".join(
        placed("it", f'<position x="{40 * (k % _ACROSS)}" y="{40 * (k // _ACROSS)}" z="1"/>') for k in range(_ACROSS**2)
    )
    solids += '<box name="around" x="1000" y="1000" z="100"/>'
    return scene_of(
        folder, text_of(solids, volume("it", "s") + volume("world", "around", inside, "air"), DEFINE, world="world")
    )


def answers(scene: co.Scene) -> list[np.ndarray]:
    """Return the first bodies that some rays meet."""
    rng = np.random.default_rng(4)
    origins, ends = rng.uniform(-20, 60, (2, 400, 3)) * (1, 1, 0.3)
    hits, points = scene.first_hit(origins, ends - origins), scene.body_at(origins)
    return [hits.t, hits.name, hits.face, hits.normal, points]


@pytest.mark.parametrize("name", sampled(EVERY_SOLID, 16))
def test_scenes_of_each_solid(name: str, tmp_path) -> None:
    scene = rows_of(tmp_path, EVERY_SOLID[name][0])
    assert isinstance(scene.bodies, InstanceList)
    pickles, copies = [pickle.dumps(scene, protocol) for protocol in PROTOCOLS], [copy.deepcopy(scene)]
    expected = answers(scene)
    pickles += [pickle.dumps(scene, protocol) for protocol in PROTOCOLS]
    for other in (*map(pickle.loads, pickles), *copies, copy.deepcopy(scene)):
        assert isinstance(other.bodies, InstanceList)
        assert [body.name for body in other.bodies] == [body.name for body in scene.bodies]
        assert all(np.array_equal(a, b) for a, b in zip(other.bounds, scene.bounds, strict=True))
        for mine, its in zip(expected, answers(other), strict=True):
            assert np.array_equal(mine, its, equal_nan=mine.dtype.kind == "f")


def test_all_kinds_of_solids_are_among_them() -> None:
    texts = " ".join(text for text, *_ in EVERY_SOLID.values())
    assert {kind for kind in SOLID_READERS if f"<{kind} " not in texts} == set()


# --- Volumes in many places are computed once: the same answers, in the memory of the text

HALL = """<box name="hall" x="2000" y="2000" z="2000" lunit="mm"/>
<box name="shelf" x="90" y="5.9" z="3.1"/><tube name="pin" rmin="0.3" rmax="0.7" z="2.9" deltaphi="360" aunit="deg"/>
<box name="chip" x="0.9" y="0.7" z="0.3"/><trd name="wedge" x1="0.5" x2="0.3" y1="0.4" y2="0.2" z="0.6"/>"""


def nested(rows: int, columns: int) -> str:
    """Return shelves of pins with two chips in each, some shelves turned by quarters and some by 30 degrees."""
    pin = volume(
        "pin", "pin", placed("chip", '<position x="0.5" z="0.1"/>') + placed("wedge", '<position y="0.5"/>'), "air"
    )
    shelf = "".join(placed("pin", f'<position x="{k * 1.7 - 0.85 * (columns - 1):.2f}"/>') for k in range(columns))
    turns = ("", '<rotation z="90" unit="deg"/>', '<rotation x="180" unit="deg"/>', '<rotation z="30" unit="deg"/>')
    hall = "".join(
        placed("shelf", f'<position y="{100.1 * (k // 9 - 2)}" x="{k % 3 * 100.3}" z="{k % 9 // 3 * 100.7}"/>' + turn)
        for k in range(rows)
        for turn in [turns[0 if rows > 40 else k % 4]]
    )
    parts = (
        volume("chip", "chip"), volume("wedge", "wedge"), pin, volume("shelf", "shelf", shelf),
        volume("world", "hall", hall, "air"),
    )  # fmt: skip
    return text_of(HALL, "".join(parts))


def test_shared_solids_answer_as_separate_ones(tmp_path):
    shared = scene_of(tmp_path, nested(4, 10))
    bodies = [co.Body(body.shape, body.material, body.name) for body in shared.bodies]
    alone = co.Scene(bodies)
    assert len(bodies) == 1 + 4 * (1 + 10 * 3)
    rng = np.random.default_rng(1)
    ends = rng.uniform(-130, 330, (2, 3000, 3))
    ends[:, :1500] = np.round(ends[:, :1500], 1)  # many along flush faces
    rays = co.Rays(ends[0], ends[1] - ends[0])
    a, b = shared.spans(rays), alone.spans(rays)
    assert len(a.t_enter) > 800
    for name in ("body", "t_enter", "t_exit"):
        assert getattr(a, name).tobytes() == getattr(b, name).tobytes()


def test_bodies_have_the_names_of_their_ways(tmp_path):
    scene = scene_of(tmp_path, nested(5, 3))
    names = [body.name for body in scene.bodies]
    assert len(set(names)) == len(names)
    assert names[:4] == ["world", "world/shelf", "world/shelf/pin", "world/shelf/pin/chip"]
    number = names.index("world/shelf#4/pin#2/wedge")
    assert scene[names[number]].shape == scene.bodies[number].shape


def test_memory_follows_the_size_of_the_file(tmp_path):
    def peak(rows: int) -> int:
        text = nested(rows, 50)
        scene_of(tmp_path, text)
        tracemalloc.start()
        assert len(scene_of(tmp_path, text).bodies) == 1 + rows * 151
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    few, many = peak(41), peak(161)
    assert many - few < 120 * 151 * 100  # bytes for one more body of a volume: less than its shape alone


# --- Colors as auxiliary information: read where they are understood, named in a warning where not, written again

BOX = '<box name="s" x="2" y="2" z="2"/>'


def load_colored_box(folder, value, kind="Color"):
    """Return a box of a color, and the warnings."""
    hint = f'<auxiliary auxtype="{kind}" auxvalue="{value}"/>'
    path = folder / "a.gdml"
    path.write_text(text_of(BOX, volume("world", "s", hint)), encoding="utf-8")
    return co.load(path)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("#12aB34", "#12ab34"), ("#12ab34ff", "#12ab34"), ("Red", "#ff0000"), ("grey", "#808080"),
        ("(1.0,0.0,0.2)", "#ff0033"), ("1 .4 0", "#ff6600"), ("(0,1,0,1)", "#00ff00"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("kind", ["Color", "color", "Colour"])
def test_colors_are_read_and_written(tmp_path, caplog, value, expected, kind):
    scene = load_colored_box(tmp_path, value, kind)
    assert scene.bodies[0].material.color == expected
    co.save(scene, tmp_path / "a.yaml")
    co.export(scene, tmp_path / "b.gdml")
    assert not caplog.records
    for again in (co.load(tmp_path / "b.gdml"), co.load(tmp_path / "a.yaml")):
        assert again.bodies[0].material == scene.bodies[0].material


@pytest.mark.parametrize(
    "value", ["mauve", "", "#12345", "300", "1 2 3", "nan 0 0", "0.1 0.2", "(0,0,0,0,0)", "1e0 0 0"]
)
def test_unknown_elements_are_reported(tmp_path, caplog, value):
    material = load_colored_box(tmp_path, value).bodies[0].material
    message = caplog.text
    assert material.color == load_colored_box(tmp_path, "0", "SensDet").bodies[0].material.color
    assert f"has the colour {value!r}, which is not understood" in message


def test_opacity_is_reported(tmp_path, caplog):
    assert load_colored_box(tmp_path, "#ff000080").bodies[0].material.color == "#ff0000"
    assert "has a colour of opacity 0.502, which is not read" in caplog.text


def test_one_material_in_several_colors(tmp_path):
    """It is one material in the exported file, and two in a scene file, where names belong to looks."""
    solids, inside = BOX + '<box name="w" x="99" y="99" z="99"/>', ""
    structure = ""
    for k, hint in enumerate(
        ("", '<auxiliary auxtype="Color" auxvalue="red"/>', '<auxiliary auxtype="Color" auxvalue="blue"/>')
    ):
        structure += volume(f"v{k}", "s", hint)
        inside += f'<physvol name="v{k}"><volumeref ref="v{k}"/><position x="{9 * k}" y="0" z="0"/></physvol>'
    (tmp_path / "a.gdml").write_text(text_of(solids, structure + volume("world", "w", inside, "air")), encoding="utf-8")
    scene = co.load(tmp_path / "a.gdml")
    assert len({body.material for body in scene.bodies[1:]}) == 3
    assert len({body.material.name for body in scene.bodies[1:]}) == 1
    co.export(scene, tmp_path / "b.gdml")
    assert (tmp_path / "b.gdml").read_text().count("<material name") == 2
    co.save(scene, tmp_path / "c.yaml")
    for path in ("b.gdml", "c.yaml"):
        assert [body.material for body in co.load(tmp_path / path).bodies] == [body.material for body in scene.bodies]
