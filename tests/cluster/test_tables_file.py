"""Files of prepared tables, which workers map without any preparation: whole, of one edition, and the same to the bit."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.parallel import shared_state as recipe
from conicoid.parallel.shared_state import LazyBodies, ReplacedFileError, TablesFile, open_scene_tables, source_version

from . import subject


def crowd(count=300):
    """Return bodies of several kinds, with names and materials, of more bytes than travel with each task.

    Shared workers keep scenes. So a test in which they must open or prepare one takes a count of its own.
    """
    rng = np.random.default_rng(5)
    places = rng.uniform(-2, 2, (count, 3))
    bodies = [co.Body(co.Box(x - 0.05, x + 0.05) - co.Sphere(0.06, x), "red", f"box {k}") for k, x in enumerate(places)]
    tilted = co.Cylinder((0, 0, -1), (0, 0, 1), 0.2).rotate((1, 2, 3), 40)
    return co.Scene([*bodies, co.Spheres(rng.normal(size=(50, 3)), 0.1), tilted], background="white")


@pytest.fixture
def scene_with_tables(tmp_path):
    """Return a scene, its file of tables, and the hash of its head."""
    scene = crowd()
    shared = recipe.shared_scene(scene)
    shared.share_tables(source_version(), str(tmp_path))
    path, digest = shared.reference().tables
    return scene, path, digest


@pytest.mark.skipif(os.name != "posix", reason="files have no modes")
def test_a_file_that_others_can_write_to_is_not_unpickled(tmp_path):
    scene = crowd(301)  # it must outlive its recipe
    shared, umask = recipe.shared_scene(scene), os.umask(0o002)
    try:
        shared.share_tables(source_version(), str(tmp_path))
    finally:
        os.umask(umask)
    path, digest = shared.reference().tables
    assert TablesFile(path, source_version(), digest).digest == digest
    os.chmod(path, 0o666)
    for known in (None, digest):  # a worker knows the hash from its task, but numbers have none
        with pytest.raises(ReplacedFileError, match="another user"):
            TablesFile(path, source_version(), known)


@pytest.mark.skipif(os.name != "posix", reason="files have no modes")
def test_workers_do_not_unpickle_files_that_others_can_write(processes, tmp_path):
    """By the whole route: a stranger who can write to the store plants a file under the name that the next run opens."""
    executor, rays = co.parallel.Workers(processes, chunk=50, store=tmp_path), subject.rays(100)
    expected = crowd(303).first_hit(rays, executor=executor)
    (path,) = tmp_path.iterdir()
    whole = path.read_bytes()
    assert whole.count(b"conicoid.") > 0, "a pickle names classes"
    path.write_bytes(whole.replace(b"conicoid.", b"conicoix."))
    os.chmod(path, 0o666)
    assert crowd(303).first_hit(rays, executor=executor) == expected
    assert b"conicoix." not in path.read_bytes(), "it was written anew"
    assert os.stat(path).st_mode & 0o022 == 0


def test_opened_tables_give_the_same_answers(scene_with_tables):
    scene, path, digest = scene_with_tables
    again, rays = open_scene_tables(path, source_version(), digest), subject.rays(5, 40)
    local, far = (
        {name: getattr(one, name)(rays) for name in ("first_hit", "occluded", "spans", "crossings", "lengths")}
        for one in (scene, again)
    )
    assert subject.differences(local, far) == []
    assert again._prepared.key == scene._prepared.key
    tables, others = again._prepared.geometry.floats, scene._prepared.geometry.floats
    assert tables.ctypes.data % 64 == others.ctypes.data % 64 == 0
    assert np.array_equal(tables, others)
    assert np.array_equal(again.render(40, 30).pixels, scene.render(40, 30).pixels)
    assert again == scene
    assert again.replace(background="black").first_hit(rays) == scene.first_hit(rays)


def test_opening_prepares_nothing_and_reads_no_bodies(scene_with_tables, monkeypatch):
    scene, path, digest = scene_with_tables
    monkeypatch.setattr("conicoid.prepare.prepared_scene.prepare", None)
    monkeypatch.setattr("conicoid.prepare.lowering.lower", None)
    again, rays = open_scene_tables(path, source_version(), digest), subject.rays(200)
    hits = again.first_hit(rays)
    assert hits.name.tolist() == scene.first_hit(rays).name.tolist()
    assert isinstance(again.bodies, LazyBodies)
    assert not again.bodies.are_read
    assert again.bodies[3].name == "box 3"
    assert again.bodies.are_read


def test_the_file_is_written_in_no_process_twice(scene_with_tables, tmp_path):
    scene, path, digest = scene_with_tables
    before = os.stat(path)
    same = crowd()
    shared = recipe.shared_scene(same)
    shared.share_tables(source_version(), str(tmp_path))
    assert same._cached_prepared is not None  # it came from the file
    assert shared.reference().tables == (path, digest)
    assert os.stat(path).st_mtime_ns == before.st_mtime_ns
    rays = subject.rays(200)
    edited, other = same.replace(3, co.Sphere(0.7)), scene.replace(3, co.Sphere(0.7))
    assert np.array_equal(edited.first_hit(rays).t, other.first_hit(rays).t)


def test_workers_map_it(tmp_path):
    scene, rays = crowd(), subject.rays(300)
    with co.parallel.Processes(1) as pool:  # of two workers, one may do all the work
        executor = co.parallel.Workers(pool, chunk=50, store=tmp_path)
        assert scene.first_hit(rays, executor=executor) == scene.first_hit(rays)
        reference = recipe.shared_scene(scene).reference()
        maps = "/proc/self/maps"
        if os.path.exists(maps):
            mapped = pool.submit(_reads, maps).result()
            assert os.path.basename(reference.tables[0]) in mapped
    assert [path.suffix for path in tmp_path.iterdir()] == [".tables"]


def _reads(path):
    with open(path) as file:
        return file.read()


def test_other_editions_and_damage_are_refused(scene_with_tables, tmp_path):
    _, path, digest = scene_with_tables
    with pytest.raises(ValueError, match=r"holds tables of conicoid .*; this process has 0\.0\.9"):
        open_scene_tables(path, "0.0.9 (sources 12345678)", digest)
    with pytest.raises(ReplacedFileError, match="was replaced by another file of tables"):
        open_scene_tables(path, source_version(), b"another hash")
    data = bytearray(Path(path).read_bytes())
    for name, content, message in (
        ("cut", data[:-100], "is incomplete"),
        ("other", b"PK" + data[2:], "is not a file of tables"),
        ("empty", b"", "is not a file of tables"),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(ValueError, match=message):
            TablesFile(tmp_path / name, source_version())
    length = int.from_bytes(data[18:26], "little")
    data[(26 + length + 63) // 64 * 64 + 10] ^= 1  # in the first pickle
    (tmp_path / "damaged").write_bytes(data)
    with pytest.raises(ValueError, match="is damaged"):
        TablesFile(tmp_path / "damaged", source_version()).prepared(())


def test_a_process_that_dies_while_it_writes_leaves_no_such_file(processes, tmp_path):
    program = (
        "import os, sys\n"
        "from conicoid.parallel import shared_state\n"
        "from conicoid.parallel.shared_state import source_version\n"
        "from tests.cluster.test_tables_file import crowd\n"
        "whole = shared_state._write_sections\n"
        "def half(file, *more):\n"
        "    whole(file, *more)\n"
        "    file.flush()\n"
        "    os._exit(9)\n"
        "shared_state._write_sections = half\n"
        "scene = crowd(301)\n"
        "shared_state.shared_scene(scene).share_tables(source_version(), sys.argv[1])\n"
    )
    assert subprocess.run([sys.executable, "-c", program, tmp_path]).returncode == 9
    assert not list(tmp_path.glob("[!.]*"))  # but for the partial file, whose name begins with a dot
    executor, rays = co.parallel.Workers(processes, chunk=50, store=tmp_path), subject.rays(100)
    assert crowd(301).first_hit(rays, executor=executor) == crowd(301).first_hit(rays)
    assert len(list(tmp_path.glob("[!.]*.tables"))) == 1


def test_without_room_each_prepares_for_itself(processes, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(recipe, "write_tables", full)
    scene, rays = crowd(302), subject.rays(100)
    assert scene.first_hit(rays, executor=processes) == scene.first_hit(rays)
    assert recipe.shared_scene(scene).reference().tables is None
    with pytest.raises(FileNotFoundError, match="no such folder"):
        co.parallel.Workers(processes, store=tmp_path / "nowhere")


def test_a_file_that_another_program_replaced_is_not_read(scene_with_tables):
    scene, path, _ = scene_with_tables
    reference = recipe.SharedReference(
        recipe.shared_scene(scene).key, recipe.shared_scene(scene).data, None, (path, b"another")
    )
    recipe._own_objects.pop(reference.key)
    (again,) = recipe.find_shared(reference)
    assert not isinstance(again.bodies, LazyBodies)  # it was made from the recipe
    assert again == scene


def test_tables_of_another_scene_are_not_used(scene_with_tables):
    _, path, _ = scene_with_tables
    scene = crowd(304)
    shared, rays = recipe.shared_scene(scene), subject.rays(200)
    os.link(path, os.path.join(os.path.dirname(path), os.path.basename(path).replace(_key(path), shared.key.hex())))
    shared.share_tables(source_version(), os.path.dirname(path))
    assert shared.reference().tables is None
    assert scene.first_hit(rays) == crowd(304).first_hit(rays)


def _key(path):
    return os.path.basename(path).partition("-")[0]


def test_stretched_balls_are_prepared_by_each(processes, tmp_path):
    scene, rays = co.Scene([subject.large_scene().bodies[0].shape.scale((1, 2, 1))]), subject.rays(300)
    executor = co.parallel.Workers(processes, store=tmp_path)
    assert scene.first_hit(rays, executor=executor) == scene.first_hit(rays)
    assert list(tmp_path.iterdir()) == []
