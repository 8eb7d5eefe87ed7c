"""XML files that take in others by entities: `<!ENTITY materials SYSTEM "materials.xml">`, then `&materials;`.

Only whole files are taken in, that whoever asks finds harmless. Entities of text, which may grow without bounds,
parameter entities, and external subsets of document types are not read.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from xml.parsers import expat
from xml.sax import SAXParseException

from defusedxml.common import EntitiesForbidden

from ..errors import Problem, SceneFileError
from .xml_builder import Builder
from .xml_tree import checked_bytes

MOST_PARTS, DEEPEST = 200, 8
"""How often files are taken in, and how deep they may take in others."""


class BuilderOfParts(Builder):
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
        if self.taken > MOST_PARTS or self.depth >= DEEPEST:
            told = f"takes in files more than {MOST_PARTS} times, or nested deeper than {DEEPEST} levels"
            raise SceneFileError(first, [Problem(*place, "", told)])
        try:
            path = self.path_of(sysid)
        except ValueError as error:
            raise SceneFileError(first, [Problem(*place, "", f"an entity: {error}")]) from None
        raw = checked_bytes(path, self.size)
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
