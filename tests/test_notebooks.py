"""The notebooks among the examples run from top to bottom, in a kernel of their own."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parent.parent
NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))


@pytest.fixture
def client(monkeypatch, tmp_path):
    """nbclient, with a kernel that is this very Python and finds the package in the tree."""
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


@pytest.mark.filterwarnings("default")  # what Jupyter's own packages warn of is not ours
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
    """The numbers of a cell's last result."""
    text = re.sub(r"array|float64|np\.", "", outputs[-1].data["text/plain"])
    return [float(word) for word in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", text)]


@pytest.mark.filterwarnings("default")
def test_a_scene_in_a_notebook_that_a_program_runs_is_a_page_in_itself(client, tmp_path):
    """A widget there would have its HTML load a front end from the network."""
    pytest.importorskip("anywidget", reason="needs anywidget")
    import nbformat

    book = nbformat.v4.new_notebook()
    sources = ["import conicoid as co\nscene = co.Scene([co.Sphere()])\nscene.view(height=300)", "scene"]
    book.cells = [nbformat.v4.new_code_cell(source) for source in sources]
    nbformat.write(book, tmp_path / "scene.ipynb")
    for (output,) in client(tmp_path / "scene.ipynb"):
        assert set(output.data) == {"text/html", "text/plain"}
        assert "<iframe" in output.data["text/html"]
