"""Every command with streams that are closed, full or without a reader, and how a command ends."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from conicoid import __main__ as entry
from conicoid.cli import terminal as exit_codes

from .children import ROOT
from .command_line import run, scene_file

# --- Every command with streams that are closed, full or without a reader, with missing inputs and outputs

GEOMETRY = """<geometry>
  <surface id="1" type="sphere" coeffs="0 0 0 1" boundary="vacuum"/>
  <cell id="1" region="-1" material="void"/>
</geometry>
"""
RENDER = "render scene.yaml -o x.png --width 8 --height 8 --samples 1"
TRACE = "trace scene.yaml rays.csv -o x.csv"
WRITERS = [RENDER, TRACE, "import geometry.xml -o x.yaml", "export scene.yaml x.html"]
TELLERS = ["info scene.yaml", "schema", "--help", "--version", "render --help"]
"""Commands whose results go to stdout."""
BOTH = ["import geometry.xml -o x.yaml"]
WRONG = ["info none.yaml", "render scene.yaml", "infoo", "render none.yaml -o x.png", "info scene.yaml --rays many"]

posix = pytest.mark.skipif(os.name == "nt", reason="streams as in a POSIX shell")
full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    scene_file(tmp_path)
    (tmp_path / "rays.csv").write_text("0,0,5,0,0,-1\n")
    (tmp_path / "geometry.xml").write_text(GEOMETRY)
    return tmp_path


def shell(folder: Path, command: str, streams: str = "", before: str = "") -> tuple[int, str, str]:
    """Return (exit code, stdout, stderr) of a command with redirections, after a prefix that sets its limits."""
    ran = subprocess.run(
        ["bash", "-c", f'{before} "{sys.executable}" -m conicoid {command} {streams}'],
        cwd=folder, capture_output=True, text=True, check=False, timeout=600,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert "Traceback" not in ran.stderr
    assert "Exception ignored" not in ran.stderr
    return ran.returncode, ran.stdout, ran.stderr


CASES = [
    # output into a file is independent of messages
    *((command, streams, 0, "") for command in WRITERS[:2] for streams in ("2>&-", "2>/dev/full", ">&- 2>&-", "<&-")),
    *((command, streams, 0, "") for command in (*TELLERS, *BOTH) for streams in ("2>&-", "2>/dev/full", "<&-")),
    # output to stdout is lost
    *((command, ">&-", 1, "error: standard output: bad file descriptor\n") for command in TELLERS),
    *((command, ">/dev/full", 1, "error: standard output: no space left on device\n") for command in TELLERS),
    *((command, "| true; exit ${PIPESTATUS[0]}", 141, "") for command in TELLERS[1:4]),
    # mistakes stay mistakes
    *((command, streams, 2, None) for command in WRONG for streams in (">&-", "2>&-", "2>/dev/full", ">/dev/full")),
]
FAST = {
    ("schema", ">&-"), ("schema", ">/dev/full"), ("--version", "2>&-"), ("schema", "| true; exit ${PIPESTATUS[0]}"),
    ("--help", ">/dev/full"), ("--help", "| true; exit ${PIPESTATUS[0]}"), ("info none.yaml", "2>/dev/full"),
    (RENDER, ">&- 2>&-"), ("import geometry.xml -o x.yaml", "2>/dev/full"),
}  # fmt: skip


@posix
@full
@pytest.mark.parametrize(
    ("command", "streams", "code", "message"),
    [pytest.param(*case, marks=[] if case[:2] in FAST else [pytest.mark.deep]) for case in CASES],
)
def test_streams(folder, command, streams, code, message):
    found, _, errors = shell(folder, command, streams)
    assert found == code, errors
    if message:
        assert errors == message
    if code == 0 and command in WRITERS:
        assert list(folder.glob("x.*"))


@pytest.mark.deep
@posix
@full
def test_read_output_is_whole_whichever_end_closes(folder):
    """The table of bodies is the same without a stderr, and no message goes into the file."""
    _, usual, _ = shell(folder, "info scene.yaml", "")
    assert shell(folder, "info scene.yaml", "2>&-")[1] == usual
    shell(folder, TRACE, "")
    expected = (folder / "x.csv").read_bytes()
    shell(folder, TRACE, ">&- 2>&- <&-")
    assert (folder / "x.csv").read_bytes() == expected


# Inputs and outputs ---------------------------------------------------------------------------------

OUTPUTS = {
    "render": ("render scene.yaml -o {}", ".png"),
    "trace": ("trace scene.yaml rays.csv -o {}", ".csv"),
    "spans": ("trace scene.yaml rays.csv --spans -o {}", ".npz"),
    "import": ("import geometry.xml -o {}", ".yaml"),
    "export": ("export scene.yaml {}", ".html"),
}


@pytest.mark.parametrize("name", OUTPUTS)
@pytest.mark.parametrize("place", ["missing", "folder", "device"])
def test_outputs_that_cannot_be(folder, monkeypatch, name, place):
    """The error comes before the work: the input does not exist."""
    monkeypatch.chdir(folder)
    command, suffix = OUTPUTS[name]
    output = folder / f"x{suffix}"
    if place == "missing":
        output = folder / "none" / f"x{suffix}"
    elif place == "folder":
        output.mkdir()
    else:
        output.symlink_to(os.devnull)
    result = run(*command.format(output).split())
    assert result.exit_code == exit_codes.EXIT_USAGE
    assert isinstance(result.exception, SystemExit)
    reasons = {"missing": "no such folder", "folder": "is a directory", "device": "is not a regular file"}
    assert reasons[place] in result.stderr
    assert len(result.stderr.splitlines()) == 1


INPUTS = ["info {}", "render {} -o x.png", "export {} x.html", "trace {} rays.csv -o x.csv",
          "trace scene.yaml {} -o x.csv", "import {} -o x.yaml"]  # fmt: skip


@pytest.mark.parametrize("command", INPUTS)
@pytest.mark.parametrize("kind", ["missing", "folder", "empty", "noise"])
def test_inputs_that_are_none(folder, monkeypatch, command, kind):
    monkeypatch.chdir(folder)
    path = folder / "input.csv"
    if kind == "folder":
        path.mkdir()
    elif kind != "missing":
        path.write_bytes(b"" if kind == "empty" else bytes(range(256)))
    result = run(*command.format(path).split())
    if result.exit_code == 0:
        assert kind == "empty"  # no rays, or no bodies: legal
        return
    assert result.exit_code == exit_codes.EXIT_USAGE
    assert isinstance(result.exception, SystemExit)
    assert "error" in result.stderr
    assert not list(folder.glob("x.*"))


@pytest.mark.parametrize(
    ("number", "code"),
    [("ENOSPC", 1), ("EDQUOT", 1), ("EIO", 1), ("EFBIG", 1), ("EMFILE", 1), ("ENOENT", 2), ("EACCES", 2), ("EROFS", 2), ("EADDRINUSE", 2)],
)  # fmt: skip
@pytest.mark.parametrize("command", WRITERS)
def test_a_disk_that_fails_is_no_mistake_in_the_input(folder, monkeypatch, command, number, code):
    monkeypatch.chdir(folder)

    def fail(*_, **__):
        raise OSError(getattr(errno, number), os.strerror(getattr(errno, number)))

    monkeypatch.setattr("os.replace", fail)
    result = run(*command.split())
    assert result.exit_code == code
    assert isinstance(result.exception, SystemExit)
    written = next(word for word in command.split() if word.startswith("x."))
    assert result.stderr.splitlines()[-1] == f"error: {written}: {os.strerror(getattr(errno, number)).lower()}"
    assert not list(folder.glob("*x*.???"))


@posix
@pytest.mark.parametrize(
    ("command", "space"),
    [
        ("info scene.yaml", 60_000),
        pytest.param("info scene.yaml", 200_000, marks=pytest.mark.deep),
        pytest.param("render scene.yaml -o x.png --width 30000 --height 30000", 6 << 20, marks=pytest.mark.deep),
    ],
)
def test_too_little_memory_is_one_line(folder, command, space):
    """A picture of ten gigabytes has six, or libraries do not fit into the address space."""
    found, out, errors = shell(folder, command, before=f"ulimit -v {space}; ")
    assert (found, out) == (1, "")
    lines = [line for line in errors.splitlines() if not line.startswith("compiling")]
    assert len(lines) == 1
    assert lines[0].startswith("error: ")


@pytest.mark.parametrize(("text", "message"), [("", "not enough memory for this"), ("a mebibyte", "a mebibyte")])
def test_too_little_memory_to_begin_with(monkeypatch, capsys, text, message):
    """Memory may be too little even for imports of modules. Python's own error has no text."""

    def refuse() -> None:
        raise MemoryError(*filter(None, [text]))

    monkeypatch.setattr("conicoid.cli.app.main", refuse)
    assert entry._command(False) == 1
    assert capsys.readouterr().err == f"error: {message}\n"


def test_exit_codes_are_documented():
    text = (ROOT / "docs" / "files.md").read_text(encoding="utf-8")
    table = text[text.index("| exit code |") :].split("\n\n")[0]
    listed = {int(line.split("|")[1]) for line in table.splitlines()[2:]}
    assert listed == {value for name, value in vars(exit_codes).items() if name.startswith("EXIT_")}


# --- The end of a command: it frees no data, and takes nothing from programs that go on or listen

BY_ANOTHER = """
import runpy, sys
sys.argv = ["conicoid", "--version"]
try:
    runpy.run_module("conicoid", run_name="__main__")
except SystemExit as end:
    print("ended with", end.code)
"""
LATE = """
import atexit, sys
from conicoid.__main__ import run
atexit.register(lambda: print("late"))
sys.argv = ["conicoid", "--version"]
run()
"""
WATCHED = """
import sys
from conicoid.__main__ import run
sys.argv = ["conicoid", "--version"]
if hasattr(sys, "monitoring"):
    sys.monitoring.use_tool_id(sys.monitoring.PROFILER_ID, "watcher")
else:
    sys.setprofile(lambda *event: None)
try:
    run()
finally:
    print("watched to the end")
"""


def output_of(*words: str, given: str = "") -> str:
    """Return Python's output, of both streams."""
    ran = subprocess.run(
        [sys.executable, *words], capture_output=True, text=True, input=given, timeout=120, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    return ran.stdout + ran.stderr


@pytest.mark.parametrize(("words", "given", "text"), [
    (("-c", BY_ANOTHER), "", "ended with 0\n"), (("-c", LATE), "", "late\n"), (("-c", WATCHED), "", "watched to the end\n"),
    (("-m", "cProfile", "-m", "conicoid", "--version"), "", "cumtime"), (("-i", "-m", "conicoid", "--version"), "print(6 * 7)\n", "42"),
], ids=["a program that runs it", "output at the end", "a watcher", "a profile", "a prompt"])  # fmt: skip
def test_the_end_of_a_command_takes_nothing_from_others(words, given, text):
    assert text in output_of(*words, given=given)
