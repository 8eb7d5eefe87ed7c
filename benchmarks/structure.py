"""Figures of the code base: files, statements, comments, floors, circles, files for one hit, names, words.

    python benchmarks/structure.py [PACKAGE]

Statements are counted in the syntax tree, without docstrings, so that words cost nothing. Imports of every kind count
as arrows between files: those at the top, those within functions, and those for type checkers alone.
`tests/test_structure.py` holds the figures.
"""

from __future__ import annotations

import ast
import io
import re
import statistics
import sys
import tokenize
from collections import Counter
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

ONE_HIT = (
    "Scene.first_hit",
    "ray_queries.first_hit",
    "trace_first",
    "first_crossing",
    "next_leaf",
    "intersect_item",
    "cell_spans",
    "curved_roots",
    "quadric_roots",
    "nearer_hit",
)
"""The functions of one scalar first hit, from the user's array to the crossing: `CONTRIBUTING.md` lists their files."""

WORDS = (
    *(r"\b(?:is|are|was|were|be|been|being) (?:told|said|asked|met|given away)\b", r"\btold\b", r"\bsaid\b"),
    *(r"\basked\b", r"\bof which\b", r"\bwhat (?:is|are)\b", r"\bthat there (?:is|are)\b", r"\bas ever\b"),
    *(r"\belsewhere\b", r"\bworked out\b", r"\b(?:let|lets) go of\b", r"\bwhat there (?:is|are)\b"),
)
"""Words to avoid in plain English."""


class Module:
    """One source file: its name, its tree, its text."""

    def __init__(self, name: str, path: Path) -> None:
        self.name, self.path, self.text = name, path, path.read_text(encoding="utf-8")
        self.tree = ast.parse(self.text)
        self.package = name if path.name == "__init__.py" else name.rpartition(".")[0]

    @property
    def lines(self) -> int:
        """The number of lines of the file."""
        return self.text.count("\n")

    @cached_property
    def every_statement(self) -> list[ast.stmt]:
        """The statements of the file, docstrings among them. Expressions hold none, so the walk skips them."""
        found, waiting = [], [*self.tree.body]
        while waiting:
            node = waiting.pop()
            if isinstance(node, ast.stmt):
                found.append(node)
            for part in ("body", "orelse", "finalbody", "handlers", "cases"):
                waiting += getattr(node, part, ())
        return found

    @cached_property
    def docstrings(self) -> list[str]:
        """The docstrings of the file, its classes and functions, and the texts under constants."""
        expressions = (node for node in self.every_statement if isinstance(node, ast.Expr))
        values = (node.value for node in expressions if isinstance(node.value, ast.Constant))
        return [value.value for value in values if isinstance(value.value, str)]

    @property
    def statements(self) -> int:
        """The number of statements, without docstrings."""
        return len(self.every_statement) - len(self.docstrings)

    @property
    def comments(self) -> int:
        """The number of lines with a comment."""
        tokens = tokenize.generate_tokens(io.StringIO(self.text).readline)
        return sum(token.type == tokenize.COMMENT for token in tokens)

    def imports(self, names: Mapping[str, object]) -> Iterator[str]:
        """The modules of the package that this one imports anywhere."""
        for node in self.every_statement:
            if isinstance(node, ast.Import):
                yield from (alias.name for alias in node.names if alias.name in names)
            elif isinstance(node, ast.ImportFrom):
                base = node.module or ""
                if node.level:
                    parts = self.package.split(".")
                    base = ".".join([*parts[: len(parts) - node.level + 1], *filter(None, [node.module])])
                for alias in node.names:
                    full = f"{base}.{alias.name}"
                    if full in names or base in names:
                        yield full if full in names else base


def modules(package: Path) -> dict[str, Module]:
    """Name -> module, of every source file of a package."""
    found = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package.parent).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        found[name] = Module(name, path)
    return found


def arrows(found: Mapping[str, Module]) -> dict[str, set[str]]:
    """Module -> the modules that it imports."""
    return {name: {other for other in module.imports(found) if other != name} for name, module in found.items()}


def circles(graph: Mapping[str, set[str]]) -> list[list[str]]:
    """The strongly connected components of more than one node (Tarjan 1972), the largest first."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(start: str) -> None:
        work: list[tuple[str, Iterator[str]]] = [(start, iter(sorted(graph[start])))]
        index[start] = low[start] = len(index)
        stack.append(start)
        while work:
            node, successors = work[-1]
            for other in successors:
                if other not in index:
                    index[other] = low[other] = len(index)
                    stack.append(other)
                    work.append((other, iter(sorted(graph[other]))))
                    break
                if other in stack:
                    low[node] = min(low[node], index[other])
            else:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[node])
                if low[node] == index[node]:
                    component = [stack.pop()]
                    while component[-1] != node:
                        component.append(stack.pop())
                    if len(component) > 1:
                        found.append(sorted(component))

    for node in graph:
        if node not in index:
            visit(node)
    return sorted(found, key=len, reverse=True)


def floors(graph: Mapping[str, set[str]]) -> dict[str, int]:
    """Node -> its floor: 0 for one that imports nothing, else one above the highest that it imports."""
    found: dict[str, int] = {}

    def floor(node: str, path: tuple[str, ...] = ()) -> int:
        if node in path:
            raise ValueError(f"a circle of folders: {' -> '.join((*path, node))}")
        if node not in found:
            found[node] = 1 + max((floor(other, (*path, node)) for other in graph[node]), default=-1)
        return found[node]

    for node in graph:
        floor(node)
    return found


def folder_arrows(graph: Mapping[str, set[str]]) -> dict[str, set[str]]:
    """Layer -> the layers that it imports. Layers are the folders of the package."""
    folders = {_layer(name) for name in graph if name.count(".") > 1}
    layers: dict[str, set[str]] = {folder: set() for folder in folders}
    for name, others in graph.items():
        if name.count(".") and _layer(name) in folders:
            known = {_layer(other) for other in others if other.count(".")}
            layers[_layer(name)] |= (known & folders) - {_layer(name)}
    return layers


def _layer(name: str) -> str:
    return name.split(".")[1]


def defining_file(found: Mapping[str, Module], function: str) -> str | None:
    """The module that defines a function, or a method as `Class.name`, or a function as `module.name`."""
    owner, _, name = function.rpartition(".")
    for module in found.values():
        if owner and owner[0].islower() and not module.name.endswith("." + owner):
            continue
        for node in module.tree.body:
            scope = node.body if isinstance(node, ast.ClassDef) and node.name == owner else [node]
            if owner and owner[0].isupper() and scope == [node]:
                continue
            if any(isinstance(each, ast.FunctionDef) and each.name == name for each in scope):
                return module.name
    return None


def house_words(found: Mapping[str, Module]) -> list[tuple[str, str]]:
    """Return (module, sentence) for every line of a docstring with one of the words."""
    pattern = re.compile("|".join(WORDS), re.IGNORECASE)
    lines = ((name, line) for name, each in found.items() for text in each.docstrings for line in text.splitlines())
    return [(name, line.strip()) for name, line in lines if pattern.search(line)]


def public_names(package: Path) -> int:
    """Return how many names and packages the root offers."""
    tree = ast.parse((package / "__init__.py").read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    return sum(len(node.names) for node in block.body if isinstance(node, ast.ImportFrom))


def class_doubles(found: Mapping[str, Module]) -> dict[str, int]:
    """Return classes of the same name, and how often each occurs."""
    named = Counter(node.name for each in found.values() for node in each.tree.body if isinstance(node, ast.ClassDef))
    return {name: count for name, count in named.items() if count > 1}


def figures(package: Path) -> dict[str, object]:
    """The figures, by name."""
    found = modules(package)
    graph = arrows(found)
    lines = sorted(each.lines for each in found.values())
    rings = circles(graph)
    hit = {defining_file(found, function) for function in ONE_HIT}
    folders = folder_arrows(graph)
    return {
        "files": len(found),
        "lines": sum(lines),
        "statements without docstrings": sum(each.statements for each in found.values()),
        "comment lines, in percent": round(100 * sum(each.comments for each in found.values()) / sum(lines), 2),
        "median of lines a file": statistics.median(lines),
        "90th percentile of lines a file": lines[len(lines) * 9 // 10],
        "floors of folders": "circle" if circles(folders) else max(floors(folders).values()),
        "largest circle of files": len(rings[0]) if rings else 0,
        "files for one hit": len(hit),
        "names in the root": public_names(package),
        "class names used twice": len(class_doubles(found)),
        "lines of docstrings with house words": len(house_words(found)),
    }


if __name__ == "__main__":
    for name, value in figures(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "conicoid").items():
        print(f"{name:40} {value}")
