"""Draw the figures of the documentation anew, into docs/images: python -m docs.tools.figures

Those of the tutorials are what the tutorials' own code saves; those of the theory come from `docs/tools/theory.py`.
"""

from __future__ import annotations

import contextlib
import re
import shutil
import tempfile
from pathlib import Path

DOCS = Path(__file__).resolve().parent.parent
IMAGES = DOCS / "images"
FENCE = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def run(page: Path, folder: Path) -> None:
    """Run the code of a page in a folder, block after block, with line numbers of the page."""
    text = page.read_text(encoding="utf-8")
    namespace: dict[str, object] = {"__name__": "documentation"}
    with contextlib.chdir(folder):
        for found in FENCE.finditer(text):
            exec(compile("\n" * text.count("\n", 0, found.start(1)) + found[1], str(page), "exec"), namespace)


def main() -> None:
    from docs.tools import theory

    for page in sorted((DOCS / "tutorials").glob("*.md")):
        with tempfile.TemporaryDirectory() as folder:
            run(page, Path(folder))
            for picture in Path(folder).glob("tutorial_*.webp"):
                shutil.copy(picture, IMAGES)
    for name, draw in theory.FIGURES.items():
        draw(1.0).save(IMAGES / f"theory_{name}.webp")


if __name__ == "__main__":
    main()
