"""Every broken scene file is refused with its line, what is wrong and what was expected; the command says so too."""

from __future__ import annotations

import re

import pytest

from conicoid._util.files import SceneFileError
from conicoid.io.scene_file.scene_file import read_scene

from .broken import CASES


def test_there_are_enough():
    assert len(CASES) >= 60
    assert len({case.name for case in CASES}) == len(CASES)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_refused_with_line_and_reason(case, tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_bytes(case.content)
    with pytest.raises(SceneFileError) as caught:
        read_scene(path)
    message = str(caught.value)
    for phrase in case.phrases:
        assert phrase in message
    matching = [line for line in message.splitlines() if case.phrases[0] in line]
    place = f"{re.escape(str(path))}:{case.line}:\\d+: " if case.line else f"{re.escape(str(path))}: "
    assert any(re.match(place, line) for line in matching), message
    assert len(message) < 20_000
