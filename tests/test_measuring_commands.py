"""Lengths, line integrals and measures on the command line; findings in the exit code; options given twice."""

from __future__ import annotations

import csv
import io
import math

import numpy as np
import pytest

import conicoid as co
from conicoid.cli import terminal as exit_codes
from conicoid.cli.app import app

from .command_line import arrays, refused, run

LEAD, WATER = (
    co.matte("gray", name="lead", properties={"mu": 1.5}),
    co.matte("blue", name="water", properties={"mu": 0.5}),
)
SCENE = co.Scene([
    co.Body(co.Sphere(1), LEAD, "ball"), co.Body(co.Box((2, -1, -1), (4, 1, 1)), WATER, "a block, of water"),
    co.Body(co.Sphere(0.5, (8, 0, 0)), LEAD), co.Body(co.Box((5, -1, -1), (6, 1, 1)), "red", "body 0"),
])  # fmt: skip
TABLE = np.array([[(0, 0, 9, 0, 0, -2), (-9, 0, 0, 1, 0, 0)], [(3, 0, 9, 0, 0, -1), (0, 9, 9, 0, 0, 1)]], float)
ALONG = [2, 2, 1, 1]
"""Of the second ray, along x through the middle of all: diameters and widths."""


@pytest.fixture
def files(tmp_path):
    SCENE.save(tmp_path / "scene.yaml")
    np.save(tmp_path / "rays.npy", TABLE)
    return tmp_path / "scene.yaml", tmp_path / "rays.npy"


def _rows(path):
    text = path.read_text(encoding="utf-8") if hasattr(path, "read_text") else path
    return list(csv.reader(io.StringIO(text)))


def test_lengths_inside_bodies(files, tmp_path):
    result = run("lengths", *files, "-o", tmp_path / "lengths.npz")
    assert result.exit_code == 0, result.output
    assert "lengths of 4 rays inside 4 bodies; 3 inside any" in result.stderr
    found = arrays(tmp_path / "lengths.npz")
    assert found["lengths"].tolist() == [[[2, 0, 0, 0], ALONG], [[0, 2, 0, 0], [0, 0, 0, 0]]]
    assert found["columns"].tolist() == ["ball", "a block, of water", "body 2", "body 3 (body 0)"]
    assert run("lengths", *files, "-o", tmp_path / "lengths.csv").exit_code == 0
    head, *rows = _rows(tmp_path / "lengths.csv")
    assert head == found["columns"].tolist()
    assert [[float(cell) for cell in row] for row in rows] == found["lengths"].reshape(4, 4).tolist()


def test_lengths_inside_materials(files):
    result = run("lengths", *files, "-o", "-", "--by", "material")
    assert result.exit_code == 0, result.output
    head, *rows = _rows(result.stdout)
    assert head == ["lead", "water", "material 2"]
    assert [float(cell) for cell in rows[1]] == [3, 2, 1]


@pytest.mark.parametrize(("options", "expected"), [
    (["--value", "lead=2", "--value", "water=10", "--otherwise", "0"], 2 * 3 + 10 * 2),
    (["--value", "lead=2", "--value", "water=1e1", "--otherwise", "100"], 2 * 3 + 10 * 2 + 100),
    (["--property", "mu", "--otherwise", "0"], 1.5 * 3 + 0.5 * 2),
])  # fmt: skip
def test_line_integrals(options, expected, files, tmp_path):
    result = run("lengths", *files, "-o", tmp_path / "found.npz", *options)
    assert result.exit_code == 0, result.output
    assert "line integrals of 4 rays" in result.stderr
    found = arrays(tmp_path / "found.npz")
    assert list(found) == ["line_integrals"]
    assert found["line_integrals"].shape == (2, 2)
    assert found["line_integrals"][0, 1] == expected
    result = run("lengths", *files, "-o", "-", *options)
    assert result.stdout.splitlines()[0] == "line_integral"
    assert float(result.stdout.splitlines()[2]) == expected


def test_a_property_by_energy_has_columns(files, tmp_path):
    scene = co.Scene([co.Body(co.Sphere(), co.matte(properties={"mu": [1.0, 0.25]}))])
    scene.save(files[0])
    result = run("lengths", *files, "-o", "-", "--property", "mu")
    assert result.stdout.splitlines()[:3] == ["line_integral_0,line_integral_1", "2.0,0.5", "2.0,0.5"]
    assert run("lengths", *files, "-o", tmp_path / "found.npz", "--property", "mu").exit_code == 0
    assert arrays(tmp_path / "found.npz")["line_integrals"].shape == (2, 2, 2)


@pytest.mark.parametrize(("options", "told"), [
    (["--by", "bodies"], "lengths: by must be 'body' or 'material', got 'bodies' (did you mean 'body'?)"),
    (["--otherwise", "0"], "lengths: --otherwise goes with --value or --property; it would be ignored"),
    (["--property", "mu", "--by", "material"], "lengths: --by goes with lengths, not with --value or --property"),
    (["--property", "mu", "--value", "lead=1"], "lengths: give either --value or --property"),
    (["--value", "lead"], "lengths: --value must be MATERIAL=NUMBER, got 'lead'"),
    (["--value", "=3"], "lengths: --value must be MATERIAL=NUMBER, got '=3'"),
    (["--value", "lead=1", "--value", "lead=2"], "lengths: --value is given twice for 'lead'"),
    (["--value", "lead=1"], "lengths: no value for material 'water'"), (["--value", "lead=1"], "--otherwise 0 would stand"),
    (["--value", "led=1"], "no material is called 'led'"), (["--value", "lead=nan"], "must be MATERIAL=NUMBER, got 'lead=nan'"),
])  # fmt: skip
def test_senseless_lengths(options, told, files, tmp_path):
    assert told in refused("lengths", *files, "-o", tmp_path / "found.csv", *options)
    assert not (tmp_path / "found.csv").exists()


def test_measures_of_every_body(files, tmp_path):
    result = run("measure", files[0])
    assert result.exit_code == 0, result.output
    assert "body 1 'a block, of water'" in result.stdout
    result = run("measure", files[0], "-o", tmp_path / "volumes.csv")
    assert result.exit_code == 0, result.output
    rows = list(csv.DictReader(io.StringIO((tmp_path / "volumes.csv").read_text(encoding="utf-8"))))
    assert [(row["body"], row["name"], row["material"]) for row in rows] == [
        ("0", "ball", "lead"), ("1", "a block, of water", "water"), ("2", "", "lead"), ("3", "body 0", ""),
    ]  # fmt: skip
    volumes = [4 / 3 * math.pi, 8, 4 / 3 * math.pi / 8, 4]
    assert [float(row["volume"]) for row in rows] == pytest.approx(volumes, rel=1e-15)
    assert [float(row["area"]) for row in rows] == pytest.approx([4 * math.pi, 24, math.pi, 16], rel=1e-15)
    assert [float(row["centroid_x"]) for row in rows] == pytest.approx([0, 3, 8, 5.5])
    assert float(rows[1]["inertia_xx"]) == pytest.approx(8 * (4 + 4) / 12)
    assert float(rows[3]["inertia_xx"]) == pytest.approx(4 * (4 + 4) / 12)
    assert float(rows[3]["inertia_yy"]) == pytest.approx(4 * (1 + 4) / 12)


def test_senseless_measures(files, tmp_path):
    assert "measures are written as .csv" in refused("measure", files[0], "-o", tmp_path / "found.npz")
    assert "would be lost" in refused("measure", files[0].rename(tmp_path / "scene.csv"), "-o", tmp_path / "scene.csv")


def test_long_names_are_not_cut(tmp_path):
    name = "a body whose name is as long as names of imported models are, with where it stands"
    co.Scene([
        co.Body(co.Sphere(), co.matte("red", name=f"material of {name}"), name), co.Body(co.Box((2, 2, 2), (3, 3, 3))),
    ]).save(tmp_path / "scene.yaml")  # fmt: skip
    lines = run("info", tmp_path / "scene.yaml").stdout.splitlines()
    assert f"{name} material of {name} Sphere" in lines[1]
    assert lines[1].index("x [") == lines[2].index("x [") == lines[0].index("bounds")
    lines = run("measure", tmp_path / "scene.yaml").stdout.splitlines()
    assert f"material 'material of {name}' " in lines[1]
    assert len({len(line) for line in lines}) == 1


def test_findings_are_in_the_exit_code(files, tmp_path):
    assert run("info", files[0], "--check").exit_code == exit_codes.EXIT_OK
    co.Scene([co.Sphere(), co.Sphere(1, (1, 0, 0))]).save(files[0])
    result = run("info", files[0], "--check")
    assert result.exit_code == exit_codes.EXIT_FINDINGS == 3
    assert "overlap: " in result.stdout
    assert run("info", files[0]).exit_code == exit_codes.EXIT_OK


def _options():
    """A value-taking option, and a flag, of each command that has one."""
    import typer.main

    for name, command in typer.main.get_command(app).commands.items():
        for option in command.params:
            if option.param_type_name == "option" and not option.multiple and option.name != "help":
                yield name, max(option.opts, key=len), [] if option.is_flag else ["1"] * option.nargs


@pytest.mark.parametrize(("command", "option", "value"), list(_options()))
def test_no_option_counts_only_the_last_time(command, option, value):
    result = run(command, option, *value, option, *value)
    assert result.exit_code == 2
    assert f"{option} is given twice" in " ".join(result.stderr.split())


@pytest.mark.parametrize("options", [
    ["--section", "z=0", "--slice", "x=0"], ["-o", "a.png", "--output", "b.png"], ["--section", "z=0"] * 3,
])  # fmt: skip
def test_an_option_twice_by_its_other_name(options, files):
    result = run("render", files[0], "-o", "x.png", *options)
    assert result.exit_code == 2
    assert " is given " in result.stderr


def test_a_section_beside_everything_is_told_of(files, tmp_path):
    small = ("--width", "40", "--height", "30", "--samples", "1")
    result = run("render", files[0], "-o", tmp_path / "x.png", "--section", "z=30", *small)
    assert result.exit_code == 0
    assert (
        "note: section: no solid is cut by z = 30, so the picture is white; bodies reach from z = -1 to 1"
        in result.stderr
    )
    assert "note" not in run("render", files[0], "-o", tmp_path / "x.png", "--section", "z=0.5", *small).stderr
    with pytest.warns(UserWarning, match="no solid is cut by x = -7") as caught:
        SCENE.section("x", -7, 8, 6)
    assert caught[0].filename == __file__
    with pytest.warns(UserWarning, match="no solid is cut in the window of this camera"):
        SCENE.section(co.OrthographicCamera((0, 0, 9), (0, 0, 10)), width=8, height=6)
    with pytest.warns(UserWarning, match="sheets have no inside"):
        co.Scene(co.Disc((0, 0, 0), (0, 0, 1), 1)).section("x", 0, 8, 6)


def test_a_view_of_nothing_is_told_of(files, tmp_path):
    view = ("render", files[0], "-o", tmp_path / "x.png", "--width", "40", "--height", "30", "--samples", "1")
    result = run(*view, "--position", "0,0,9", "--look-at", "0,0,10")
    assert result.exit_code == 0
    assert "note: no body is in view; --fit takes a camera that sees all that is bounded" in result.stderr
    assert "note" not in run(*view, "--position", "0,0,9", "--look-at", "0,0,0").stderr
    assert "note" not in run(*view, "--fit").stderr


@pytest.mark.parametrize(("arguments", "told"), [
    (["check", "scene.yaml"], "No such command 'check': conicoid info SCENE --check does that."),
    (["volume", "scene.yaml"], "conicoid measure does that."),
    (["render", "scene.yaml", "-o", "x.png", "--fov", "3"], "--field-of-view"),
    (["render", "scene.yaml", "-o", "x.png", "--size", "3"], "--height, --width"),
    (["trace", "scene.yaml", "rays.npy", "--out", "x.npz"], "--output"),
])  # fmt: skip
def test_commands_and_options_as_they_are_called_elsewhere(arguments, told):
    result = run(*arguments)
    assert result.exit_code == 2
    said = " ".join(result.stderr.replace("│", " ").split())
    assert told in said
    assert "--fit" not in said


def test_what_other_commands_are_called_is_no_command():
    from conicoid.cli import options as parts

    commands = [command.name or command.callback.__name__ for command in app.registered_commands]
    assert not set(parts._COMMANDS) & set(commands)
    assert {meant.split()[0] for meant in parts._COMMANDS.values()} <= {*commands, "--version"}
