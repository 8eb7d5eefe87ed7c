"""Reader of untrusted XML files into a tree with line numbers.

The parser is that of defusedxml: document types, entities and external references are refused, so that no entity bomb
can go off and no other file is opened. Size, depth and the number of elements are limited. `XmlEntityBuilder` allows
entities that stand for whole files, if the caller accepts their paths.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any
from xml.parsers import expat
from xml.sax import SAXParseException
from xml.sax.xmlreader import InputSource

from defusedxml.common import DefusedXmlException, DTDForbidden, EntitiesForbidden
from defusedxml.expatreader import DefusedExpatParser

from .._util.files import Problem, SceneFileError, read_bounded

MAX_XML_BYTES = 64 << 20
MAX_ATTRIBUTES = 3_000_000
"""Most bytes of a file with all its parts, and most '=' signs of one file, which bound its attributes."""


@dataclass(slots=True, eq=False)
class XmlElement:
    """An element: attributes, children, its own text without that of its children, and line and column of its start."""

    tag: str
    line: int
    column: int
    attributes: dict[str, str]
    children: list[XmlElement] = field(default_factory=list)
    pieces: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The element's own text."""
        return "".join(self.pieces)

    def all(self, tag: str) -> list[XmlElement]:
        """Return the children with a tag, in the order of the file."""
        return [child for child in self.children if child.tag == tag]


def read_xml(
    path: str | os.PathLike[str], doctype: bool = False, parts: Callable[[str], str] | None = None, hint: str = ""
) -> XmlElement:
    """Return the root element of an XML file.

    Parameters
    ----------
    path
        The file.
    doctype
        Whether a document type that declares no entity is allowed. Files that it refers to are not read.
    parts
        Returns the path of the file that an entity stands for, or raises ValueError; None refuses all entities.
    hint
        Text that is appended to the error for a refused entity.

    Raises
    ------
    SceneFileError
        The file cannot be read, is not XML, is too large or too deep, or declares something that is refused.

    """
    raw = read_bounded_bytes(path, 0)
    # Parse all bytes at once: an attribute of many megabytes that arrives in pieces is scanned again with each piece.
    builder: XmlTreeBuilder
    if parts is None:
        builder = XmlTreeBuilder(bufsize=MAX_XML_BYTES + 1, forbid_dtd=not doctype)
    else:
        builder = XmlEntityBuilder(parts, len(raw), bufsize=MAX_XML_BYTES + 1)
    source = InputSource(os.fspath(path))
    source.setByteStream(io.BytesIO(raw))
    try:
        builder.parse(source)
    except SAXParseException as error:
        line, column = error.getLineNumber() or 0, (error.getColumnNumber() or 0) + 1
        raise SceneFileError(path, [Problem(line, column, "", f"is not XML: {error.getMessage()}")]) from None
    except DefusedXmlException as error:
        what = "a document type (DOCTYPE)" if isinstance(error, DTDForbidden) else "an entity or an external reference"
        advice = "" if isinstance(error, DTDForbidden) else hint
        raise SceneFileError(path, [Problem(*builder.place, "", f"is refused: it declares {what}{advice}")]) from None
    except XmlLimitError as error:
        raise SceneFileError(path, [Problem(*builder.place, "", str(error))]) from None
    except (LookupError, ValueError) as error:
        raise SceneFileError(path, [Problem(0, 0, "", f"is not XML that can be read: {error}")]) from None
    return builder.root


def read_bounded_bytes(path: str | os.PathLike[str], before: int) -> bytes:
    """Return the contents of a file. Raise SceneFileError if it is too large, with the `before` bytes read already."""
    raw = read_bounded(path, MAX_XML_BYTES, before)
    # Before the parser: it makes all attributes of an element at once, and asks nobody
    if raw.count(b"=") > MAX_ATTRIBUTES:
        raise SceneFileError(path, [Problem(0, 0, "", f"has more than {MAX_ATTRIBUTES:,} attributes (or '=' signs)")])
    return raw


# Parser for untrusted XML; it builds elements directly in expat callbacks, without SAX events between.

MAX_DEPTH = 32
MAX_ELEMENTS = 1_000_000


class XmlLimitError(Exception):
    """Raised when a document exceeds a limit."""


class XmlTreeBuilder(DefusedExpatParser):  # type: ignore[misc]
    """A parser that builds a tree of elements, whose root is `root`."""

    root: XmlElement

    def __init__(self, **options: Any) -> None:
        self._parser: Any = None
        super().__init__(**options)
        self.stack: list[XmlElement] = []
        self.count = 0

    @property
    def place(self) -> tuple[int, int]:
        """Line and column of the parser's position, from 1."""
        return self.getLineNumber() or 0, (self.getColumnNumber() or 0) + 1

    def reset(self) -> None:
        """Connect expat to the methods of this class in place of a SAX handler."""
        super().reset()
        # Straight from expat: SAX events between would cost time for each element
        self._parser.StartElementHandler = self._begin
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._text

    def _begin(self, name: str, attributes: dict[str, str]) -> None:
        at, open_ones = self._parser, self.stack
        element = XmlElement(name, at.CurrentLineNumber, at.CurrentColumnNumber + 1, attributes)
        self.count += 1
        if self.count > MAX_ELEMENTS:
            raise XmlLimitError(f"has more than {MAX_ELEMENTS:,} elements")
        if len(open_ones) >= MAX_DEPTH:
            raise XmlLimitError(f"nests its elements deeper than {MAX_DEPTH} levels")
        if open_ones:
            open_ones[-1].children.append(element)
        else:
            self.root = element
        open_ones.append(element)

    def _end(self, _: str) -> None:
        self.stack.pop()

    def _text(self, data: str) -> None:
        self.stack[-1].pieces.append(data)


# XML files that include others by entities: `<!ENTITY materials SYSTEM "materials.xml">`, then `&materials;`.
#
# Only whole files are included, and only those that the caller accepts. Entities of text, which may grow without
# bounds, parameter entities, and external subsets of document types are not read.

MAX_XML_FILES, MAX_XML_FILE_DEPTH = 200, 8
"""Most inclusions of files, and most levels of files within files."""


class XmlEntityBuilder(XmlTreeBuilder):
    """A parser that includes files: it checks each declaration of an entity and follows references itself.

    Parameters
    ----------
    path_of
        Returns the path of the file that an entity names, or raises ValueError.
    size
        Bytes of the first file.
    **options
        Options of the parser.

    """

    def __init__(self, path_of: Callable[[str], str], size: int, **options: Any) -> None:
        self.path_of, self.size = path_of, size
        self.declared: set[str] = set()
        self.bytes_read = self.depth = 0
        super().__init__(forbid_dtd=False, forbid_external=False, **options)

    def defused_entity_decl(
        self, name: str, is_parameter_entity: bool, value: Any, base: Any, sysid: Any, pubid: Any, notation_name: Any
    ) -> None:
        """Accept an entity that stands for a file. Raise EntitiesForbidden for any other."""
        if is_parameter_entity or value is not None or pubid or notation_name or not sysid:
            raise EntitiesForbidden(name, value, base, sysid, pubid, notation_name)
        self.declared.add(sysid)

    def external_entity_ref(self, context: Any, base: Any, sysid: Any, pubid: Any) -> int:
        """Parse the file that an entity stands for. Raise SceneFileError if it is refused or invalid."""
        if sysid not in self.declared:
            return 1  # the external part of a document type
        outer, place = self._parser, self.place
        first = self._source.getSystemId()
        self.bytes_read += 1
        if self.bytes_read > MAX_XML_FILES or self.depth >= MAX_XML_FILE_DEPTH:
            limit = f"takes in files more than {MAX_XML_FILES} times, or nested deeper than {MAX_XML_FILE_DEPTH} levels"
            raise SceneFileError(first, [Problem(*place, "", limit)])
        try:
            path = self.path_of(sysid)
        except ValueError as error:
            raise SceneFileError(first, [Problem(*place, "", f"an entity: {error}")]) from None
        raw = read_bounded_bytes(path, self.size)
        self.size += len(raw)
        self.depth += 1
        # One parser inside the other, so that elements may begin in one file and hold those of another
        self._parser = outer.ExternalEntityParserCreate(context)
        try:
            self._parser.Parse(raw, True)
        except expat.ExpatError as error:
            problem = Problem(error.lineno, error.offset + 1, "", f"is not XML: {expat.ErrorString(error.code)}")
            raise SceneFileError(path, [problem]) from None
        except SAXParseException as error:
            raise SceneFileError(path, [Problem(0, 0, "", f"is not XML: {error.getMessage()}")]) from None
        finally:
            self._parser = outer
            self.depth -= 1
        return 1
