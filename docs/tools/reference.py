"""The pages of docs/reference: lists of public names, each with the first line of its docstring.

The groups and their order are written by hand; `python -m docs.tools.reference` copies the lines from the docstrings.
Lines of numbers and of plain attributes, which have no docstring at run time, are written by hand. On the site each
entry becomes an autodoc directive, and the nested entries below it become its members.
"""

from __future__ import annotations

import inspect
import pkgutil
import re
from pathlib import Path
from typing import Any, NamedTuple

FOLDER = Path(__file__).resolve().parent.parent / "reference"
_ENTRY = re.compile(
    r"^- `(?P<name>co(?:nicoid)?\.[\w.]+)`: (?P<line>.*)$(?P<members>(?:\n  - `\w+`: .*$)*)", re.MULTILINE
)
_MEMBER = re.compile(r"^  - `(?P<name>\w+)`: (?P<line>.*)$", re.MULTILINE)


class Entry(NamedTuple):
    """A public name, such as `co.Sphere`, with the names of its listed members."""

    name: str
    members: tuple[str, ...]

    @property
    def path(self) -> str:
        """The name from the package's own name on, for autodoc."""
        return re.sub(r"^co\.", "conicoid.", self.name)

    @property
    def target(self) -> Any:
        """The object of that name."""
        return pkgutil.resolve_name(self.path)


def entries(text: str) -> list[Entry]:
    """Return the entries of a page."""
    return [_entry(found) for found in _ENTRY.finditer(text)]


def refreshed(text: str) -> str:
    """Return a page with the lines of today's docstrings."""
    return _ENTRY.sub(_refreshed_entry, text)


def directives(text: str) -> str:
    """Return a page in which autodoc's directives replace the entries."""
    return _ENTRY.sub(_directive, text)


def members_of(target: type) -> set[str]:
    """Return the public methods and properties of a class, inherited ones as well, that have a docstring."""
    owners = [owner for owner in target.__mro__ if owner.__module__.startswith("conicoid.")]
    values = {name: value for owner in reversed(owners) for name, value in vars(owner).items()}
    return {name for name, value in values.items() if not name.startswith("_") and _is_documented(value)}


def _is_documented(value: Any) -> bool:
    plain = value.__func__ if isinstance(value, classmethod | staticmethod) else value
    return (inspect.isroutine(plain) or inspect.isdatadescriptor(plain) or hasattr(plain, "attrname")) and bool(
        inspect.getdoc(plain)
    )


def _entry(found: re.Match[str]) -> Entry:
    return Entry(found["name"], tuple(member["name"] for member in _MEMBER.finditer(found["members"])))


def _refreshed_entry(found: re.Match[str]) -> str:
    target = _entry(found).target
    line = found["line"] if isinstance(target, float | str) else _first_line(target)  # numbers have no docstring
    documented = members_of(target) if isinstance(target, type) else ()
    members = _MEMBER.sub(
        lambda one: _member_line(target, one["name"]) if one["name"] in documented else one[0], found["members"]
    )
    return f"- `{found['name']}`: {line}{members}"


def _member_line(target: type, name: str) -> str:
    return f"  - `{name}`: {_first_line(getattr(target, name))}"


def _first_line(target: Any) -> str:
    return (inspect.getdoc(target) or "").partition("\n")[0]


def _directive(found: re.Match[str]) -> str:
    entry = _entry(found)
    target = entry.target
    lines = ["```{eval-rst}", f".. auto{_kind(target)}:: {entry.path}"]
    if entry.members:
        lines.append(f"   :members: {', '.join(entry.members)}")
    if isinstance(target, float | str):
        lines += ["", f"   {found['line']}"]
    elif _kind(target) == "data":
        lines.append("   :no-value:")
    return "\n".join([*lines, "```", ""])


def _kind(target: Any) -> str:
    if isinstance(target, type):
        return "exception" if issubclass(target, BaseException) else "class"
    return "function" if callable(target) else "data"


def main() -> None:
    """Copy the first lines of the docstrings into the pages."""
    for page in sorted(FOLDER.glob("*.md")):
        text = page.read_text(encoding="utf-8")
        page.write_text(refreshed(text), encoding="utf-8")


if __name__ == "__main__":
    main()
