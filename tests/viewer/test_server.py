"""The page's server: this machine only, its own page only, the scene's data only; picks of visible bodies."""

import http.client
import json
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.viewer.scene_data import pick
from conicoid.viewer.server import Server
from conicoid.viewer.session import Session, stamp_of

from .browser import serve

# --- The page's server: this machine only, its own page only, the scene's data only


BARREL = Path(__file__).resolve().parents[2] / "examples" / "scenes" / "barrel.yaml"
SCENE = co.Scene([co.Body(co.Sphere(1), name="ball"), co.Box((2, -1, -1), (3, 1, 1)) - co.Sphere(1, (2, 0, 0))])
RAY = {"origin": [-5.0, 0.1, 0.2], "direction": [1.0, 0.01, 0.003]}


@pytest.fixture(scope="module")
def server():
    with serve(Session(SCENE, "two")) as found:
        yield found


def ask(server, method, name, body=None, **headers):
    link = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=120)
    path = name if name.startswith("/") else f"/{server.token}/{name}"
    own = {"Host": f"127.0.0.1:{server.server_port}"}
    if method == "POST":
        own |= {"Origin": f"http://127.0.0.1:{server.server_port}", "Content-Type": "application/json"}
    link.request(method, path, body, {**own, **{key.replace("_", "-"): value for key, value in headers.items()}})
    answer = link.getresponse()
    data = answer.read()
    link.close()
    return answer.status, data


def test_it_serves_the_page_and_the_scene(server):
    status, text = ask(server, "GET", "")
    assert status == 200
    assert b"<canvas" in text
    assert b"connect-src 'self'" in text
    assert json.loads(ask(server, "GET", "version")[1]) == {"version": 0, "trouble": None}
    assert json.loads(ask(server, "GET", "scene")[1])["item_count"] == 2


def test_the_engine_explains_picks(server):
    status, text = ask(server, "POST", "why", json.dumps(RAY | {"body": 1}))
    assert (status, json.loads(text)) == (200, {"text": SCENE.explain(*RAY.values(), body=1).text})
    assert ask(server, "POST", "why", json.dumps(RAY | {"body": -1}))[0] == 400


def test_picks_are_the_engines_to_the_last_digit(server):
    status, text = ask(server, "POST", "pick", json.dumps(RAY))
    found = json.loads(text)["found"]
    hit, crossings = SCENE.first_hit(RAY["origin"], RAY["direction"]), SCENE.crossings(RAY["origin"], RAY["direction"])
    spans = SCENE.spans(RAY["origin"], RAY["direction"])
    assert status == 200
    assert (found["t"], found["name"], found["face"]) == (hit.t, "ball", int(hit.face))
    for name in ("point", "normal", "uv"):
        assert found[name] == getattr(hit, name).tolist()
    assert [row["t"] for row in found["crossings"]] == crossings.t.tolist()
    assert [(row["enter"], row["exit"]) for row in found["spans"]] == list(
        zip(spans.t_enter.tolist(), spans.t_exit.tolist(), strict=True)
    )


def test_picks_pass_over_hidden_and_cut_bodies(server):
    hidden = json.loads(ask(server, "POST", "pick", json.dumps(RAY | {"hidden": [0]}))[1])["found"]
    assert hidden["name"] != "ball"
    assert hidden["t"] > 6
    section = {"normal": [-1.0, 0.0, 0.0], "offset": 0.0}  # the part at x >= 0 stays
    cut = json.loads(ask(server, "POST", "pick", json.dumps(RAY | {"section": section}))[1])["found"]
    assert cut["face"] is None
    assert cut["t"] == 5.0
    assert cut["name"] == "ball"
    assert np.allclose(cut["point"], [0, 0.15, 0.215])


@pytest.mark.parametrize(("method", "name", "body", "headers", "status"), [
    ("GET", "", None, {"Host": "evil.example"}, 421),
    ("GET", "scene", None, {"Origin": "http://evil.example"}, 403),
    ("GET", "scene", None, {"Origin": "null"}, 403),
    ("POST", "pick", "{}", {"Origin": "http://evil.example"}, 403),
    ("POST", "pick", "{}", {"Content_Type": "text/plain"}, 415),
    ("POST", "pick", "{}", {}, 400),
    ("POST", "pick", "[" * 5000, {}, 400),
    ("POST", "pick", '{"origin": [0, 0, 0], "direction": [1, 0, 0], "hidden": [1e999]}', {}, 400),
    ("POST", "numbers", '{"item": 1e999}', {}, 400),
    ("POST", "edit", '{"path": ["bodies", 1e999], "value": 1}', {}, 400),
    ("POST", "pick", "x" * 70000, {}, 413),
    ("POST", "scene", "{}", {}, 404),
    ("GET", "../pyproject.toml", None, {}, 404),
    ("GET", "/", None, {}, 404),
    ("GET", "/scene", None, {}, 404),
    ("GET", "/wrong/scene", None, {}, 404),
])  # fmt: skip
def test_everything_else_is_refused(server, method, name, body, headers, status):
    assert ask(server, method, name, body, **headers)[0] == status


def test_it_listens_on_this_machine_only(server):
    assert server.server_address[0] == "127.0.0.1"
    with socket.socket() as other:
        other.bind(("", 0))
        address = socket.gethostbyname(socket.gethostname())
    if not address.startswith("127."):
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection((address, server.server_port), timeout=2)


def test_numbers_can_be_edited(server):
    numbers = json.loads(ask(server, "POST", "numbers", json.dumps({"item": 0}))[1])
    radius = next(row for row in numbers if row["label"] == "radius")
    assert radius["value"] == 1.0
    with serve(Session(SCENE, "two")) as other:
        status, _ = ask(other, "POST", "edit", json.dumps({"path": radius["path"], "value": 0.5}))
        assert status == 200
        assert json.loads(ask(other, "POST", "pick", json.dumps(RAY))[1])["found"]["t"] > 4.4
        status, text = ask(other, "POST", "edit", json.dumps({"path": radius["path"], "value": -1}))
        assert status == 400
        assert "radius" in json.loads(text)["error"]


_QUADRIC_BALL = co.Quadric(coefficients=dict(xx=1, yy=1, zz=1, constant=-1))


@pytest.mark.parametrize(
    ("shape", "depth"),
    [
        (_QUADRIC_BALL, 9 - 2**0.5),
        (_QUADRIC_BALL.painted("red"), 9 - 2**0.5),
        (co.Complement(co.Complement(_QUADRIC_BALL)), 9 - 2**0.5),
        (co.Disc((0, 0, 0), (0, 1, 0), 9.0) & _QUADRIC_BALL, 9.0),
        (co.Wall(_QUADRIC_BALL, 0), 9 - 2**0.5),
    ],
    ids=["quadric", "painted", "complement", "clipped", "wall"],
)
def test_every_coefficient_of_a_quadric_can_be_edited(shape, depth):
    session = Session(co.Scene([shape]), "ball")
    rows = {row["label"]: row for row in session.numbers({"item": 0})}
    assert set(rows) >= {"xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant"}
    session.edit({"path": rows["x"]["path"], "value": -2.0})  # x² - 2 x + y² + z² <= 1: its middle is at x = 1
    found = session.pick({"origin": [1, -9, 0], "direction": [0, 1, 0]})["found"]
    assert found["t"] == pytest.approx(depth, rel=1e-15)


def test_an_edit_changes_one_number_of_a_boolean():
    ball = co.Quadric(coefficients=dict(xx=1, yy=1, zz=1, constant=-1))
    session = Session(co.Scene([(ball & co.Box()).translate((1, 2, 3)), co.Sphere(1)]), "two")
    row = next(row for row in session.numbers({"item": 0}) if row["label"] == "low x")
    session.edit({"path": row["path"], "value": -0.5})
    expected = (ball & co.Box((-0.5, -1, -1), (1, 1, 1))).translate((1, 2, 3))
    assert session._scene == co.Scene([expected, co.Sphere(1)])


def test_a_page_that_goes_away_is_no_news(server, capfd):
    with socket.create_connection(("127.0.0.1", server.server_port)) as link:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # closing resets
        link.sendall(f"GET /{server.token}/ HTTP/1.1\r\nHost: 127.0.0.1:{server.server_port}\r\n\r\n".encode())
    assert ask(server, "GET", "version")[0] == 200
    time.sleep(0.3)
    assert "Traceback" not in capfd.readouterr().err


def test_the_file_is_followed(tmp_path):
    path = tmp_path / "scene.yaml"
    co.save(SCENE, path)
    session = Session(co.load(path), "scene", path)
    assert session.version() == {"version": 0, "trouble": None}
    path.write_text("conicoid: 1\nbodies:\n  - shape: {Spere: {}}\n")
    changed = session.version()
    assert changed["version"] == 1
    assert "3" in changed["trouble"]
    assert "Spere" in changed["trouble"]
    co.save(co.Scene([co.Sphere(2)]), path)
    assert session.version()["trouble"] is None
    assert session.scene()["item_count"] == 1


@pytest.mark.parametrize(
    "error",
    [
        ZeroDivisionError("float division by zero"),
        MemoryError(),
        RecursionError("deep"),
        KeyError("x"),
        AssertionError(),
    ],
)
def test_errors_are_shown_until_they_are_repaired(error, tmp_path, monkeypatch):
    path = tmp_path / "scene.yaml"
    co.save(SCENE, path)
    session = Session(co.load(path), "scene", path)

    def fail(path: object) -> None:
        raise error

    with monkeypatch.context() as patch:
        patch.setattr("conicoid.viewer.session.load", fail)
        co.save(co.Scene([co.Sphere(2)]), path)
        for _ in range(3):
            changed = session.version()
            assert changed["version"] == 1
            assert changed["trouble"].startswith(f"{path}: ")
        assert '"version": -1' in session.page() or '"version":-1' in session.page()
    assert session.version()["trouble"] is not None, "an unchanged file is not tried at once"
    session._next_refresh = 0.0
    assert session.version() == {"version": 2, "trouble": None}
    assert session.scene()["item_count"] == 1


def test_missing_files_of_a_scene_are_awaited(tmp_path, monkeypatch):
    """The scene itself does not change when its file of balls appears at last."""
    monkeypatch.setattr("conicoid.viewer.session._PAUSE", 0.0)
    path = tmp_path / "scene.yaml"
    co.save(SCENE, path)
    session = Session(co.load(path), "scene", path)
    path.write_text("bodies: [{shape: {Spheres: {file: balls.npy}}}]\n")
    assert "balls.npy" in session.version()["trouble"]
    np.save(tmp_path / "balls.npy", np.ones((3, 4)))
    session._next_refresh = 0.0
    assert session.version() == {"version": 2, "trouble": None}
    assert session.scene()["item_count"] == 1


def test_a_change_during_the_first_read_is_noticed(tmp_path):
    path = tmp_path / "scene.yaml"
    co.save(SCENE, path)
    stamp, first = stamp_of(path), co.load(path)
    co.save(co.Scene([co.Sphere(2)]), path)
    session = Session(first, "scene", path, stamp=stamp)
    assert session.version() == {"version": 1, "trouble": None}
    assert session.scene()["item_count"] == 1


def test_many_clients_at_once_are_all_answered():
    """They come while the server is busy, and none is refused."""
    with Server(Session(SCENE, "two")) as server:
        links = [socket.create_connection(("127.0.0.1", server.server_port), timeout=5) for _ in range(64)]
        request = (
            f"GET /{server.token}/version HTTP/1.1\r\nHost: 127.0.0.1:{server.server_port}\r\nConnection: close\r\n\r\n"
        )
        for link in links:
            link.sendall(request.encode())
        threading.Thread(target=server.serve_forever, daemon=True).start()
        for link in links:
            link.settimeout(120)
            with link, link.makefile("rb") as answer:
                assert answer.read().startswith(b"HTTP/1.1 200 ")
        server.shutdown()


def test_requests_are_answered_where_there_are_no_more_threads(server, monkeypatch):
    def refuse(self):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    assert ask(server, "GET", "version")[0] == 200


@pytest.mark.skipif(os.name == "nt", reason="Ctrl-C is sent by a signal")
def test_control_c_ends_it():
    command = [sys.executable, "-m", "conicoid", "view", str(BARREL), "--no-browser"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=_hear_control_c) as running:
        try:
            line = ""
            while "http://127.0.0.1:" not in line:
                line = running.stderr.readline()
                assert line or running.poll() is None
            running.send_signal(signal.SIGINT)
            _, rest = running.communicate(timeout=120)
        finally:
            running.kill()
    assert running.returncode == 0
    assert "ended" in rest
    assert "Traceback" not in rest


def _hear_control_c():
    """Let Ctrl-C interrupt: a shell lets processes in the background ignore it, and children inherit that."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


# --- The engine's answers about a ray of the page: only of visible bodies


FUEL = co.Body(co.Cylinder((0, 0, -1), (0, 0, 1), 1), name="fuel")
CLAD = co.Body(co.Cylinder((0, 0, -1), (0, 0, 1), 2) - co.Cylinder((0, 0, -1), (0, 0, 1), 1), name="clad")


@pytest.mark.parametrize("order", [(FUEL, CLAD), (CLAD, FUEL)])
def test_a_hidden_body_does_not_answer_for_the_wall_it_shares(order):
    """From the axis, the fuel's wall and the bore of the clad are one surface at t = 1. The clad ends at t = 2."""
    scene = co.Scene(list(order))
    hidden = [body.name for body in order].index("fuel")
    found = pick(scene, {"origin": [0, 0, 0], "direction": [1, 0, 0], "hidden": [hidden]})["found"]
    assert (found["name"], found["t"], found["entering"]) == ("clad", 1.0, True)
    assert found["point"] == [1.0, 0.0, 0.0]
    assert found["normal"] == [-1.0, 0.0, 0.0]  # out of the clad: towards the axis
    assert [(row["name"], row["t"]) for row in found["crossings"]] == [("clad", 1.0), ("clad", 2.0)]
    assert [(row["name"], row["enter"], row["exit"]) for row in found["spans"]] == [("clad", 1.0, 2.0)]


def test_hidden_bodies_are_not_picked():
    scene = co.Scene([FUEL, CLAD])
    assert pick(scene, {"origin": [0, 0, 0], "direction": [1, 0, 0], "hidden": [0, 1]}) == {"found": None}
