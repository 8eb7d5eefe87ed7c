"""`conicoid info --system` prints all that a report of a problem needs."""

import platform
from importlib import metadata

import pytest

import conicoid as co
from conicoid._jit.machine_code import SHIPPED, levels

from .children import COMMAND, child
from .command_line import failure, run


def by_name(text: str) -> dict[str, str]:
    """Return the lines by their first words."""
    return {line.partition(" ")[0]: line.partition(" ")[2].strip() for line in text.splitlines()}


def test_the_report_has_versions_and_places():
    lines = by_name(run("info", "--system").stdout)
    assert lines["conicoid"] == co.__version__
    assert f"{platform.python_version()}, numpy {metadata.version('numpy')}" in lines["python"]
    assert lines["platform"] == platform.platform()
    assert ("levels" in lines) == (SHIPPED is not None)
    assert ("machine code of the package" if SHIPPED is not None else "compiled by Numba") in lines["kernels"]


@pytest.mark.skipif(SHIPPED is None, reason="the kernels of this checkout are compiled")
def test_every_level_can_be_chosen_and_no_other(monkeypatch):
    for level in levels():
        monkeypatch.setenv("CONICOID_LEVEL", level)
        with child(COMMAND, "info", "--system") as running:
            code, out, errors = running.end(60)
        assert code == 0, errors
        assert by_name(out)["kernels"].endswith(f"for {level}")
    monkeypatch.setenv("CONICOID_LEVEL", "x86-64-v9")
    with child(COMMAND, "info", "--system") as running:
        code, _, errors = running.end(60)
    assert code == 2
    assert errors.startswith(f"error: CONICOID_LEVEL must be {' or '.join(levels())} on this processor")
    assert "got 'x86-64-v9'" in errors


@pytest.mark.parametrize(("options", "message"), [
    ((), "give either a scene file or --system\n"), (("scene.yaml", "--system"), "give either a scene file or --system\n"),
    (("--system", "--check"), "--check goes with a scene file"),
])  # fmt: skip
def test_a_scene_or_the_system(options, message):
    assert f"error: info: {message}" in failure("info", *options)
