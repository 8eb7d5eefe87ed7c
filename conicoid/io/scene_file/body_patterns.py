"""Bodies of a scene file that are written alike: one is parsed, the others are matched and built together.

Its user is who writes thousands of bodies as plain YAML. 10,000 bodies of five leaves that are written out take 0.5 s
here and 4 s without; POV-Ray's whole process takes 2 s for as many.

The text of one body is parsed by itself. Its plain numbers and words become slots of a regular expression. Any text
that the expression matches, from dash to dash, is an item with the same tree, except for the words in the slots:

- A slot takes only text that a parser reads as one word in any case. All else that decides a parser's steps
  (indentation, brackets, quotes) is equal.
- The item has no anchor, so nothing outside depends on it; and no alias, tag or block text, which are no plain words.
- A parser reaches each dash of a list in the same state, whatever items came before. So empty lines replace the matched
  items, and the remaining text is parsed. There the dash after each cut must begin an item of `bodies`.

If any of this fails, the whole text is parsed as if this module did not exist. Items of one pattern are the rows of a
`Template`. Those in doubt are parsed and read alone, with reports.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..._util.records import construct_many, dataclass
from ..._util.validation import SuppressedWarning, raise_warnings
from ...geometry.body import Body
from . import yaml_parser
from .fields import MaterialType
from .nodes import (
    BAD,
    DECIMAL,
    MappingNode,
    Node,
    NodeReader,
    ScalarNode,
    SequenceNode,
    TextType,
    TooManyProblems,
    is_text,
)
from .shape_reader import STEP_COMPOSED, PartBudget, ShapeReader
from .template import Template, build_batch
from .yaml_parser import YamlDocument, YamlError, join_surrogates

_LEAST, _PATTERN_COUNT, _GROUP = 20, 3, 8
"""Least bodies of a file that are worth a search, of an outline that becomes a pattern, and of a group."""
_MOST_PATTERNS, _MOST_OUTLINES, _LONGEST = 16, 10_000, 4_000
"""Most patterns of a file, most outlines that are remembered, most characters of a pattern."""
_STEP = 2_000
"""Bodies between two reports of progress."""

_HEAD = re.compile(r"bodies:[ ]*+\r?\n(?:[ ]*+(?:#[^\n]*+)?\r?\n)*+(?=([ ]*+)- )")
"""The key of the bodies, up to the line of the first body, whose indentation is the group."""
_SECTION = re.compile(r"\n(?=[^ \-#\r\n\t])")
"""The end of a line before another section."""
_OUTLINE = re.compile(r"[-+.0-9eE]+|: +[^][{},\n]*")
"""Parts of an item that its outline leaves out: numbers, and values on the line of their key."""
_OTHER_LINES = re.compile("\r(?!\n)|[\x85\u2028\u2029]|[|>][0-9]*\\+")
"""Breaks that only a parser counts, and block texts that keep the empty lines after them."""
_LETTERS = r"[A-Za-z0-9_./()=+-]"
_WORD = rf"[A-Za-z_](?:{_LETTERS}| ++(?={_LETTERS}))*+"
_QUOTED_TEXT = {"'": "[ -&(-~]*+", '"': r"[ !#-\[\]-~]*+"}
"""Characters between quotes of either kind that stand for themselves: printable ASCII without quote or escape."""


class PatternItem(NamedTuple):
    """An item that matches a pattern, and its line."""

    pattern: TextPattern
    match: re.Match[str]
    line: int

    def parsed(self) -> Node:
        """Return its tree, with all lines and columns."""
        root = yaml_parser.parse_document(self.match.group(), first_line=self.line).root
        assert isinstance(root, SequenceNode)
        return root.items[0]


DocumentItem: TypeAlias = Node | PatternItem


@dataclass
class PatternDocument(YamlDocument):
    """A document whose tree may lack some bodies."""

    bodies: list[DocumentItem] | None = None
    """All bodies in their order; None if all of them are in the tree."""


@dataclass(eq=False)
class TextPattern:
    """A parsed item, and the slots where other items have words of their own."""

    item: MappingNode
    rows: int
    slots: list[ScalarNode]
    numbers: list[int]
    """The slots for numbers."""
    shared: list[int]
    """The slots for words other than numbers, the name and the material."""
    match: Callable[[str, int], re.Match[str] | None]


def parse_patterned_document(text: str, progress: Callable[[int], Any] | None = None) -> PatternDocument:
    """Return the document of `yaml_parser.parse_document`, with bodies of patterns outside of the tree; same errors."""
    cut = _TextCut(text)
    if cut.is_worth_it:
        cut.go_through(progress)
    if cut.size:
        removed = len(text) - sum(map(len, cut.remainder))
        try:
            rest = yaml_parser.parse_document(
                "".join(cut.remainder), progress and (lambda done: progress(done + removed))
            )
        except YamlError:
            rest = YamlDocument()
        bodies = cut.put_back(rest.root)
        if bodies is not None:
            return PatternDocument(rest.root, rest.problems, rest.distinct + cut.size, bodies)
    return PatternDocument(**vars(yaml_parser.parse_document(text, progress)))


class _TextCut:
    """A text, from which bodies that match patterns are cut."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.remainder: list[str] = []  # the pieces of text that remain to be parsed
        self.items: list[PatternItem | int] = []  # for each body: the item if it is cut out, or the line if it remains
        self.size = 0  # the number of values of the bodies that are cut out
        self.patterns: list[TextPattern] = []  # the last used first
        self.outlines: dict[str, int] = {}  # how often each outline occurred
        head = _HEAD.match(text, 0 if text.startswith("bodies:") else text.find("\nbodies:") + 1)
        self.is_worth_it = False
        odd = not text.isascii() or any(mark in text for mark in "\r|>")  # the search takes longer
        if head and not (odd and _OTHER_LINES.search(text)) and join_surrogates(text) is text:
            section = _SECTION.search(text, head.end())
            self.begin, self.end, self.indent = head.end(), section.end() if section else len(text), head.group(1)
            self.is_worth_it = text.count(f"\n{self.indent}- ", self.begin, self.end) >= _LEAST

    def go_through(self, progress: Callable[[int], Any] | None) -> None:
        """Match all bodies. The last one remains in any case: no dash after it marks its end."""
        text, begin, rest = self.text, self.begin, 0
        line = text.count("\n", 0, begin) + 1
        while True:
            if progress is not None and len(self.items) % _STEP == 0:
                progress(begin)
            item = self._matched(begin, line)
            if item is not None:
                self.remainder += [text[rest:begin], "\n" * item.pattern.rows]
                self.items.append(item)
                self.size += item.pattern.item.size
                line += item.pattern.rows
                begin = rest = item.match.end()
                continue
            self.items.append(line)
            end = text.find(f"\n{self.indent}- ", begin, self.end) + 1
            if not end:
                break
            self._learn(text[begin:end])
            line += text.count("\n", begin, end)
            begin = end
        self.remainder.append(text[rest:])

    def _matched(self, begin: int, line: int) -> PatternItem | None:
        """Return the item at a position if it matches a pattern; the last used one is tried first."""
        for k, pattern in enumerate(self.patterns):
            match = pattern.match(self.text, begin)
            if match:
                self.patterns.insert(0, self.patterns.pop(k))
                return PatternItem(pattern, match, line)
        return None

    def _learn(self, item: str) -> None:
        """Count the outline of an item, and make the item a pattern if it is the `_PATTERN_COUNT`-th of its outline."""
        if len(self.patterns) < _MOST_PATTERNS and len(self.outlines) < _MOST_OUTLINES and len(item) <= _LONGEST:
            outline = _OUTLINE.sub(":", item)
            count = self.outlines[outline] = self.outlines.get(outline, 0) + 1
            pattern = _pattern(item, self.indent) if count == _PATTERN_COUNT else None
            if pattern is not None:
                self.patterns.insert(0, pattern)

    def put_back(self, root: Node | None) -> list[DocumentItem] | None:
        """Return all bodies; None if the remaining ones are not the items of `bodies`, so that the cuts are not valid.

        The first and the last body remain, and the one after each cut. A node of a list begins in the line of its dash
        only where a parser waits for the next item of the list.
        """
        bodies = root.entries.get("bodies") if isinstance(root, MappingNode) else None
        if root is None or not isinstance(bodies, SequenceNode):
            return None
        listed = iter(bodies.items)
        items: list[DocumentItem] = []
        for item in self.items:
            node = item if type(item) is PatternItem else next(listed, None)
            if node is None or (type(item) is int and node.line != item):
                return None
            items.append(node)
        is_whole = next(listed, None) is None and root.size + self.size <= yaml_parser.MAX_NODES
        return items if is_whole else None


def _pattern(text: str, indent: str) -> TextPattern | None:
    """Return a pattern of an item, from its dash to the next; None for an item that is not plain enough."""
    try:
        document = yaml_parser.parse_document(text)
    except YamlError:
        return None
    root = document.root
    item = root.items[0] if type(root) is SequenceNode and len(root.items) == 1 else None
    if document.problems or type(item) is not MappingNode or "&" in text:  # perhaps an anchor
        return None
    begins = [0, *(row.end() for row in re.finditer("\n", text))]
    own = [id(item.entries.get(name)) for name in ("name", "material")]
    pattern, end, slots, numbers, shared = "", 0, list[ScalarNode](), list[int](), list[int]()
    for node in sorted(_scalars(item), key=lambda node: (node.line, node.column)):
        begin = begins[node.line - 1] + node.column - 1
        quote = "" if node.plain else text[begin]
        # Escapes, tags and blocks differ from the text of their node.
        if quote not in ("", *_QUOTED_TEXT) or not text.startswith(quote + node.text + quote, begin):
            return None
        is_number = node.plain and re.fullmatch(DECIMAL, node.text) is not None
        if is_number or is_text(node):
            if is_number or id(node) not in own:
                (numbers if is_number else shared).append(len(slots))
            slots.append(node)
            allowed = _QUOTED_TEXT[quote] if quote else DECIMAL if is_number else _WORD
            # Atomic groups: a word is matched as a whole, and a mismatch after it costs no backtracking.
            pattern += f"{re.escape(text[end:begin] + quote)}((?>{allowed})){re.escape(quote)}"
            end = begin + len(node.text) + 2 * len(quote)
    match = re.compile(f"{pattern}{re.escape(text[end:])}(?={indent}- )").match
    return TextPattern(item, text.count("\n"), slots, numbers, shared, match)


def _scalars(node: Node) -> Iterator[ScalarNode]:
    """Yield the words below a node that are not keys."""
    if isinstance(node, ScalarNode):
        yield node
    else:
        for part in node.items if isinstance(node, SequenceNode) else node.entries.values():
            yield from _scalars(part)


# From items to bodies.


GroupBody: TypeAlias = tuple[Body, int, int, int]
"""A body, its parts, the steps of its motions, and the rows above its name, by which `SceneReader` accepts it."""


def build_groups(items: Sequence[Any], shapes: ShapeReader) -> dict[int, GroupBody]:
    """Return the bodies that could be built in groups, by the places of their items. Nothing is reported or counted."""
    groups: dict[Any, list[tuple[int, tuple[str, ...]]]] = {}
    for place, item in enumerate(items):
        if type(item) is PatternItem:
            words = item.match.groups()
            groups.setdefault((item.pattern, *[words[slot] for slot in item.pattern.shared]), []).append((place, words))
    bodies: dict[int, GroupBody] = {}
    for (pattern, *_), rows in groups.items():
        if len(rows) >= _GROUP:
            found = _build(pattern, [words for _, words in rows], shapes)
            bodies.update((rows[k][0], body) for k, body in found)
    return bodies


def _build(pattern: TextPattern, rows: list[tuple[str, ...]], shapes: ShapeReader) -> Iterator[tuple[int, GroupBody]]:
    """Yield bodies with their places in the group, without those in doubt; none if the first one is."""
    entries, count, words = pattern.item.entries, len(rows), list(zip(*rows, strict=True))
    if "shape" not in entries or not entries.keys() <= {"shape", "name", "material", "move"}:
        return
    for node, word in zip(pattern.slots, rows[0], strict=True):
        node.text = word
    # The problems of a reader of its own, and its values by the ids of nodes, go with it
    reader = NodeReader(shapes.reader.folder)
    reader.suggestions.budget = 0  # nobody reads its suggestions
    reader.materials, reader.colors = shapes.reader.materials, shapes.reader.colors
    own = ShapeReader(reader, shapes.named_nodes, PartBudget(shapes.allowance.values))
    own.named_shapes = shapes.named_shapes
    first = _parse_plain(reader, lambda: own.moved(own.read(entries["shape"], ""), entries.get("move"), ""))
    if first is BAD:
        return
    parts, steps = 1 + own.size(first), own.allowance.steps // STEP_COMPOSED
    varied = [k for k in pattern.numbers if words[k].count(words[k][0]) < count]
    columns = {str(k): np.array(list(map(float, words[k]))) for k in varied}
    if columns:
        template = Template(pattern.item, {id(pattern.slots[k]): str(k) for k in varied})
        built = [first, *build_batch(template, columns, own, "")]
    else:  # bodies share a named shape, and equal shapes that are written out are objects of their own
        is_named = any(first is named for named in shapes.named_shapes.values())
        built = [first if is_named else first._with_motion(first.motion) for _ in range(count)]
    fields: dict[str, list[Any]] = {"material": [None] * count, "name": [None] * count}
    for field, kind in (("name", TextType()), ("material", MaterialType())):
        if field in entries:
            slot = next((k for k, node in enumerate(pattern.slots) if node is entries[field]), None)
            if slot is None:
                return
            plain = pattern.slots[slot].plain
            read = {word: partial(kind.read, ScalarNode(0, 0, word, plain), reader, "") for word in set(words[slot])}
            meanings = {word: _parse_plain(reader, read[word]) for word in read}
            fields[field] = list(map(meanings.__getitem__, words[slot]))
    row = entries["name"].line - pattern.item.line if "name" in entries else 0
    unbuilt = [None] * count
    made = construct_many(Body, count, shape=built, **fields, materials=unbuilt, material_index=unbuilt)
    for k, body in enumerate(made):
        if body.shape is not None and body.name is not BAD and body.material is not BAD:
            yield k, (body, parts, steps, row)


def _parse_plain(reader: NodeReader, read: Callable[[], Any]) -> Any:
    """Return what `read` reads without a report or warning; otherwise BAD."""
    reader.problems.clear()
    try:
        with raise_warnings():
            found = read()
    except (SuppressedWarning, TooManyProblems):
        return BAD
    return BAD if reader.problems else found
