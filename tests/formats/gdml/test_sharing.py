"""Volumes that stand in many places are worked out once: the same answers, in memory of what is written."""

import tracemalloc

import numpy as np

import conicoid as co

from .files import placed, scene_of, text_of, volume

SOLIDS = """<box name="hall" x="2000" y="2000" z="2000" lunit="mm"/>
<box name="shelf" x="90" y="5.9" z="3.1"/><tube name="pin" rmin="0.3" rmax="0.7" z="2.9" deltaphi="360" aunit="deg"/>
<box name="chip" x="0.9" y="0.7" z="0.3"/><trd name="wedge" x1="0.5" x2="0.3" y1="0.4" y2="0.2" z="0.6"/>"""


def nested(rows: int, columns: int) -> str:
    """Shelves of pins with two chips in each, some shelves turned by quarters and some by 30 degrees."""
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
    return text_of(SOLIDS, "".join(parts))


def test_what_is_shared_answers_as_what_is_made_alone(tmp_path):
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


def test_memory_follows_what_is_written(tmp_path):
    def peak(rows: int) -> int:
        text = nested(rows, 50)
        scene_of(tmp_path, text)
        tracemalloc.start()
        assert len(scene_of(tmp_path, text).bodies) == 1 + rows * 151
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    few, many = peak(41), peak(161)
    assert many - few < 120 * 151 * 100  # bytes a body that is one more of what there is: less than its shape alone
