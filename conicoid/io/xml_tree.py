"""XML as a tree with line numbers, from files that nobody vouches for.

The parser is defusedxml's: document types, entities and external references are refused, so that no
bomb can go off and no other file is opened. Size, depth and the number of elements are limited.
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

from defusedxml.common import EntitiesForbidden
from defusedxml.expatreader import DefusedExpatParser

from .._util.file_errors import Problem, SceneFileError, unreadable_error
from .._util.safe_files import open_regular

MAX_XML_BYTES = 64 << 20
MAX_ATTRIBUTES = 3_000_000


@dataclass(slots=True, eq=False)
class XmlElement:
    """One element: its attributes, its own text (without that of its children), and where it begins."""

    tag: str
    line: int
    column: int
    attributes: dict[str, str]
    children: list[XmlElement] = field(default_factory=list)
    pieces: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        return "".join(self.pieces)

    def all(self, tag: str) -> list[XmlElement]:
        """The children of a kind, in the order of the file."""
        return [child for child in self.children if child.tag == tag]


def read_xml(
    path: str | os.PathLike[str], doctype: bool = False, parts: Callable[[str], str] | None = None, hint: str = ""
) -> XmlElement:
    """The root element of a file. Raises SceneFileError for anything that is no harmless XML of bearable size.

    doctype: is a document type allowed, if it declares no entity? What it may refer to is not read.
    parts: gives the path of a file that an entity stands for, or raises ValueError; None where entities are refused,
    with a `hint` at what may be done.
    """
    from defusedxml.common import DefusedXmlException, DTDForbidden

    raw = read_bounded_bytes(path, 0)
    # All at once: an attribute of many megabytes that comes in small pieces is scanned anew with each
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
        told = "" if isinstance(error, DTDForbidden) else hint
        raise SceneFileError(path, [Problem(*builder.place, "", f"is refused: it declares {what}{told}")]) from None
    except XmlLimitError as error:
        raise SceneFileError(path, [Problem(*builder.place, "", str(error))]) from None
    except (LookupError, ValueError) as error:
        raise SceneFileError(path, [Problem(0, 0, "", f"is not XML that can be read: {error}")]) from None
    return builder.root


def read_bounded_bytes(path: str | os.PathLike[str], before: int) -> bytes:
    """The contents of a file, where what was read before and it are bearable."""
    raw = _read_bytes(path)
    if raw.count(b"=") > MAX_ATTRIBUTES:
        raise SceneFileError(path, [Problem(0, 0, "", f"has more than {MAX_ATTRIBUTES:,} attributes (or '=' signs)")])
    if before + len(raw) > MAX_XML_BYTES:
        found = f"is too large with all its parts: at most {MAX_XML_BYTES >> 20} MB are read"
        raise SceneFileError(path, [Problem(0, 0, "", found)])
    return raw


def _read_bytes(path: str | os.PathLike[str]) -> bytes:
    """The contents of a regular file of bearable size."""
    try:
        if "\0" in os.fspath(path):
            raise OSError(22, "a path cannot hold a zero character")
        with open_regular(path) as file:
            raw = file.read(min(os.fstat(file.fileno()).st_size, MAX_XML_BYTES) + 1)
    except OSError as error:
        raise unreadable_error(path, error) from None
    if len(raw) > MAX_XML_BYTES:
        raise SceneFileError(path, [Problem(0, 0, "", f"is too large: at most {MAX_XML_BYTES >> 20} MB are read")])
    return raw


# The parser of XML that nobody vouches for: elements are made of what expat reports, without a layer between.

MAX_DEPTH = 32
MAX_ELEMENTS = 1_000_000


class XmlLimitError(Exception):
    """A limit is passed."""


class XmlTreeBuilder(DefusedExpatParser):  # type: ignore[misc]
    """Makes a tree."""

    root: XmlElement

    def __init__(self, **given: Any) -> None:
        self._parser: Any = None
        super().__init__(**given)
        self.open: list[XmlElement] = []
        self.count = 0

    @property
    def place(self) -> tuple[int, int]:
        """Line and column of what is being read, from 1."""
        return self.getLineNumber() or 0, (self.getColumnNumber() or 0) + 1

    def reset(self) -> None:
        """Have everything reported here, and not to a handler of SAX."""
        super().reset()
        self._parser.StartElementHandler = self._begin
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._text

    def _begin(self, name: str, attributes: dict[str, str]) -> None:
        at, open_ones = self._parser, self.open
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
        self.open.pop()

    def _text(self, data: str) -> None:
        self.open[-1].pieces.append(data)


# XML files that take in others by entities: `<!ENTITY materials SYSTEM "materials.xml">`, then `&materials;`.
#
# Only whole files are taken in, that whoever asks finds harmless. Entities of text, which may grow without bounds,
# parameter entities, and external subsets of document types are not read.

MAX_XML_FILES, MAX_XML_FILE_DEPTH = 200, 8
"""How often files are taken in, and how deep they may take in others."""


class XmlEntityBuilder(XmlTreeBuilder):
    """Takes in files: declarations are looked at one by one, references are followed by itself.

    path_of gives the path of a file or raises ValueError; size: of the first file.
    """

    def __init__(self, path_of: Callable[[str], str], size: int, **given: Any) -> None:
        self.path_of, self.size = path_of, size
        self.declared: set[str] = set()
        self.taken = self.depth = 0
        super().__init__(forbid_dtd=False, forbid_external=False, **given)

    def defused_entity_decl(
        self, name: str, is_parameter_entity: bool, value: Any, base: Any, sysid: Any, pubid: Any, notation_name: Any
    ) -> None:
        """Only files are allowed."""
        if is_parameter_entity or value is not None or pubid or notation_name or not sysid:
            raise EntitiesForbidden(name, value, base, sysid, pubid, notation_name)
        self.declared.add(sysid)

    def external_entity_ref(self, context: Any, base: Any, sysid: Any, pubid: Any) -> int:
        """Parse a file in place of its entity."""
        del base, pubid
        if sysid not in self.declared:
            return 1  # the external part of a document type
        outer, place = self._parser, self.place
        first = self._source.getSystemId()
        self.taken += 1
        if self.taken > MAX_XML_FILES or self.depth >= MAX_XML_FILE_DEPTH:
            told = f"takes in files more than {MAX_XML_FILES} times, or nested deeper than {MAX_XML_FILE_DEPTH} levels"
            raise SceneFileError(first, [Problem(*place, "", told)])
        try:
            path = self.path_of(sysid)
        except ValueError as error:
            raise SceneFileError(first, [Problem(*place, "", f"an entity: {error}")]) from None
        raw = read_bounded_bytes(path, self.size)
        self.size += len(raw)
        self.depth += 1
        self._parser = outer.ExternalEntityParserCreate(context)
        try:
            self._parser.Parse(raw, True)
        except expat.ExpatError as error:
            found = Problem(error.lineno, error.offset + 1, "", f"is not XML: {expat.ErrorString(error.code)}")
            raise SceneFileError(path, [found]) from None
        except SAXParseException as error:
            raise SceneFileError(path, [Problem(0, 0, "", f"is not XML: {error.getMessage()}")]) from None
        finally:
            self._parser = outer
            self.depth -= 1
        return 1
