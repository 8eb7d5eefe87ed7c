"""XML as a tree with line numbers, from files that nobody vouches for.

The parser is defusedxml's: document types, entities and external references are refused, so that no
bomb can go off and no other file is opened. Size, depth and the number of elements are limited.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from xml.sax import SAXParseException
from xml.sax.xmlreader import InputSource

from ..errors import Problem, SceneFileError, cannot_be_read
from ..regular import open_regular

MAX_BYTES = 64 << 20
MAX_ATTRIBUTES = 3_000_000


@dataclass(slots=True, eq=False)
class Element:
    """One element: its attributes, its own text (without that of its children), and where it begins."""

    tag: str
    line: int
    column: int
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)
    pieces: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        return "".join(self.pieces)

    def all(self, tag: str) -> list[Element]:
        """The children of a kind, in the order of the file."""
        return [child for child in self.children if child.tag == tag]


def read_xml(
    path: str | os.PathLike[str], doctype: bool = False, parts: Callable[[str], str] | None = None, hint: str = ""
) -> Element:
    """The root element of a file. Raises SceneFileError for anything that is no harmless XML of bearable size.

    doctype: is a document type allowed, if it declares no entity? What it may refer to is not read.
    parts: gives the path of a file that an entity stands for, or raises ValueError; None where entities are refused,
    with a `hint` at what may be done.
    """
    from defusedxml.common import DefusedXmlException, DTDForbidden

    from .xml_builder import Builder, TooMuch

    raw = checked_bytes(path, 0)
    # All at once: an attribute of many megabytes that comes in small pieces is scanned anew with each
    builder: Builder
    if parts is None:
        builder = Builder(bufsize=MAX_BYTES + 1, forbid_dtd=not doctype)
    else:
        from .xml_parts import BuilderOfParts

        builder = BuilderOfParts(parts, len(raw), bufsize=MAX_BYTES + 1)
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
    except TooMuch as error:
        raise SceneFileError(path, [Problem(*builder.place, "", str(error))]) from None
    except (LookupError, ValueError) as error:
        raise SceneFileError(path, [Problem(0, 0, "", f"is not XML that can be read: {error}")]) from None
    return builder.root


def checked_bytes(path: str | os.PathLike[str], before: int) -> bytes:
    """The contents of a file, where what was read before and it are bearable."""
    raw = _bytes(path)
    if raw.count(b"=") > MAX_ATTRIBUTES:
        raise SceneFileError(path, [Problem(0, 0, "", f"has more than {MAX_ATTRIBUTES:,} attributes (or '=' signs)")])
    if before + len(raw) > MAX_BYTES:
        found = f"is too large with all its parts: at most {MAX_BYTES >> 20} MB are read"
        raise SceneFileError(path, [Problem(0, 0, "", found)])
    return raw


def _bytes(path: str | os.PathLike[str]) -> bytes:
    """The contents of a regular file of bearable size."""
    try:
        if "\0" in os.fspath(path):
            raise OSError(22, "a path cannot hold a zero character")
        with open_regular(path) as file:
            raw = file.read(min(os.fstat(file.fileno()).st_size, MAX_BYTES) + 1)
    except OSError as error:
        raise cannot_be_read(path, error) from None
    if len(raw) > MAX_BYTES:
        raise SceneFileError(path, [Problem(0, 0, "", f"is too large: at most {MAX_BYTES >> 20} MB are read")])
    return raw
