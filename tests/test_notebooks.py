"""Results in notebooks: pictures, tables."""

import json
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid._util.text import MOST_ROWS

# --- The notebooks among the examples run from top to bottom, in a kernel of their own

ROOT = Path(__file__).resolve().parent.parent
NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))


@pytest.fixture
def client(monkeypatch, tmp_path):
    """Return nbclient with a kernel of this very Python, which finds the package in the tree."""
    monkeypatch.setenv("JUPYTER_PLATFORM_DIRS", "1")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    kernel = tmp_path / "kernels" / "python3"
    kernel.mkdir(parents=True)
    command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    (kernel / "kernel.json").write_text(json.dumps({"argv": command, "display_name": "Python 3", "language": "python"}))
    monkeypatch.setenv("JUPYTER_PATH", str(tmp_path))

    def run(path: Path) -> list[Any]:
        import nbclient
        import nbformat

        book = nbformat.read(path, as_version=4)
        nbclient.NotebookClient(
            book, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
        ).execute()
        return [cell.outputs for cell in book.cells if cell.cell_type == "code"]

    return run


def test_there_are_notebooks():
    assert NOTEBOOKS


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_is_stored_without_its_results(path: Path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in cells)


@pytest.mark.filterwarnings("default")  # warnings of Jupyter's own packages
def test_first_steps(client):
    _, hit, spans, volume, picture = client(ROOT / "examples" / "first_steps.ipynb")
    # 0.6² + x² = 1
    assert numbers(hit) == pytest.approx([2.2, -0.8, 0.6, 0, -0.8, 0.6, 0])
    # the cube ends at -1 and 1, the bore at ±sqrt(0.5² - 0.2²); from x = -3 on
    half = np.sqrt(0.25 - 0.04)
    assert numbers(spans) == pytest.approx([2, 3 + half, 3 - half, 4], abs=1e-7)  # as many digits as are printed
    value, error = numbers(volume)
    assert 0 < error < 0.01 * value
    assert "image/png" in picture[-1].data


def numbers(outputs: list[Any]) -> list[float]:
    """Return the numbers of a cell's last result."""
    text = re.sub(r"array|float64|np\.", "", outputs[-1].data["text/plain"])
    return [float(word) for word in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", text)]


@pytest.mark.filterwarnings("default")
def test_a_scene_in_a_notebook_that_a_program_runs_is_a_page_in_itself(client, tmp_path):
    """A widget's HTML would load a front end from the network."""
    pytest.importorskip("anywidget", reason="needs anywidget")
    import nbformat

    book = nbformat.v4.new_notebook()
    sources = ["import conicoid as co\nscene = co.Scene([co.Sphere()])\nscene.view(height=300)", "scene"]
    book.cells = [nbformat.v4.new_code_cell(source) for source in sources]
    nbformat.write(book, tmp_path / "scene.ipynb")
    for (output,) in client(tmp_path / "scene.ipynb"):
        assert set(output.data) == {"text/html", "text/plain"}
        assert "<iframe" in output.data["text/html"]


# --- Tables in notebooks: rows of the right rays, escaped texts, and the count of omitted rows

SCENE = co.Scene([co.Body(co.Sphere(), "red", "a<b"), co.Box((2, 2, 2), (3, 3, 3))])
RAYS = co.Rays([[(0, 0, 5), (9, 9, 9)], [(2.5, 2.5, 9), (0, 0, 5)]], (0, 0, -1))


def rows(value: object) -> list[list[str]]:
    """Return the texts of a table by row, the head first."""
    found = re.findall(r"<tr>(.*?)</tr>", value._repr_html_())
    return [re.findall(r"<t[hd]>(.*?)</t[hd]>", row) for row in found]


def test_hits_have_a_row_for_each_ray():
    head, *found = rows(SCENE.first_hit(RAYS))
    assert head == ["ray", "t", "body", "name", "face", "entering", "point", "normal"]
    assert [row[0] for row in found] == ["0, 0", "0, 1", "1, 0", "1, 1"]
    assert [row[1] for row in found] == ["4", "inf", "6", "4"]  # from z = 5 to 1, and from 9 to 3
    assert [row[3] for row in found] == ["a&lt;b", "", "", "a&lt;b"]
    assert found[0][6:] == ["(0, 0, 1)", "(0, 0, 1)"]


def test_one_hit_is_one_row():
    assert rows(SCENE.first_hit((0, 0, 5), (0, 0, -1)))[1][:3] == ["", "4", "0"]


def test_long_tables_count_omitted_rows():
    text = SCENE.first_hit(np.tile((0.0, 0.0, 5.0), (1000, 1)), (0, 0, -1))._repr_html_()
    assert text.count("<tr>") == MOST_ROWS + 1
    assert text.endswith("<p>and 980 more</p>")


def test_spans_and_crossings_name_the_ray_of_each_row():
    assert rows(SCENE.spans(RAYS)) == [
        ["ray", "t_enter", "t_exit", "body", "name"],
        ["0", "4", "6", "0", "a&lt;b"], ["2", "6", "7", "1", ""], ["3", "4", "6", "0", "a&lt;b"],
    ]  # fmt: skip
    head, *found = rows(SCENE.crossings(RAYS))
    assert head == ["ray", "t", "entering", "body", "face", "name"]
    assert [(row[0], row[1], row[2]) for row in found[:2]] == [("0", "4", "True"), ("0", "6", "False")]


def test_bodies_findings_and_prescriptions():
    assert rows(SCENE.bodies)[1][:3] == ["0", "a&lt;b", "Sphere"]
    assert rows(co.check(co.Scene([co.Sphere(), co.Sphere(1, (0.5, 0, 0))])))[1][:2] == ["overlap", "(0, 1)"]
    lens = co.optics.prescription([co.optics.Row(50, 4, 1.5, 20), co.optics.Row(-50, None, None, 20)], aperture=10)
    assert [row[0] for row in rows(lens)] == ["radius", "50", "-50"]
