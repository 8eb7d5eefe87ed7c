"""`co.load` knows a Zemax lens file by what is in it, and gives the scene of its lenses."""

from __future__ import annotations

import pytest

import conicoid as co

from .test_zmx import SINGLET
from .zemax_text import file


@pytest.mark.parametrize("name", ["lens.zmx", "lens.txt"])
@pytest.mark.parametrize("encoding", ["utf-16", "utf-8"])
def test_a_lens_file_is_a_scene(tmp_path, name, encoding):
    path = tmp_path / name
    path.write_bytes(file(SINGLET).encode(encoding))
    scene = co.load(path)
    assert scene.bodies == co.optics.load_zmx(path).bodies
    assert scene.notes[0] == "2 surfaces, 1 body"
    assert len(co.load(path, only="lens").bodies) == 1
    with pytest.raises(ValueError, match="load: depth means nothing for a Zemax lens file"):
        co.load(path, depth=2)


def test_what_is_refused_is_refused_with_its_line(tmp_path):
    path = tmp_path / "lens.zmx"
    path.write_text(file([SINGLET[0], dict(kind="COORDBRK"), SINGLET[1]]), encoding="utf-8")
    with pytest.raises(co.SceneFileError, match=r"lens\.zmx:\d+:1: surface 2: TYPE: 'COORDBRK' is not supported"):
        co.load(path)
    obscured = [SINGLET[0] | dict(more=["STOP", "OBSC 0 1 2"]), SINGLET[1]]
    path.write_text(file(obscured), encoding="utf-8")
    with pytest.raises(ValueError, match="strict is set"):
        co.load(path, strict=True)


def test_glasses_of_the_catalogue_are_known_by_name():
    """Schott's own n_d of N-BK7 is 1.51680; what a file says of index and Abbe number is not needed then."""
    rows = [SINGLET[0] | dict(glass="N-BK7 0 0 1.5 40 0 0 0"), SINGLET[1]]
    system = co.optics.read_zmx(file(rows))
    assert system.media[1].index(0.5875618) == pytest.approx(1.51680, abs=5e-6)
    assert system.omissions == ()
    assert co.optics.prescription([(50, 6, "N-BK7"), (-50, None)], 10).media[1].index(0.4861327) == pytest.approx(
        1.52238, abs=5e-6
    )
