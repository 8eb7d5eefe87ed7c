"""What differs between a page read in the repository and on the site."""

from __future__ import annotations

import re
from typing import Any

from docs.tools import reference
from docs.tools.live import SCENES

_OUTSIDE = {  # from pages in docs/
    "../CONTRIBUTING.md": "project/contributing.md",
    "../CHANGELOG.md": "project/changelog.md",
    "../SECURITY.md": "project/security.md",
}
_PICTURE = re.compile(r"^!\[([^\]]*)\]\(images/(\w+)\.\w+\)$", re.MULTILINE)
_PROGRAM = re.compile(r"`(\w+\.(?:py|ipynb))`")


def process(app: Any, name: str, content: list[str]) -> None:
    """Handle the event "source-read": replace links out of docs/, entries of the reference, and live pictures."""
    text = content[0]
    for file, page in _OUTSIDE.items():
        text = text.replace(f"]({file})", f"]({page})")
    if name == "gallery":
        text = text.replace("[`examples/`](../examples)", "`examples/`")
        text = _PROGRAM.sub(r'<a href="examples/\1"><code>\1</code></a>', text)
        text = _PICTURE.sub(_alive, text)
    if name.startswith("reference/"):
        text = reference.directives(text)
    content[0] = text


def _alive(found: re.Match[str]) -> str:
    title, name = found[1], {"hero": "glass_water_mirror"}.get(found[2], found[2])
    if name not in SCENES:
        return found[0]
    return (
        f'{found[0]}\n\n<details class="live"><summary>Walk around in it</summary>'
        f'<iframe loading="lazy" src="live/{name}.html" title="{title}"></iframe>'
        f'<a href="live/{name}.html">The page alone</a></details>'
    )
