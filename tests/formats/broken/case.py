"""A scene file with mistakes: (name, content, line, phrases that the message must hold).

Line 0 stands for the file as a whole. Contents that are not text are bytes.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Broken:
    name: str
    content: bytes
    line: int
    phrases: tuple[str, ...]


def broken(name: str, content: str | bytes, line: int, *phrases: str) -> Broken:
    return Broken(name, content.encode() if isinstance(content, str) else content, line, phrases)


def sphere(fields: str) -> str:
    """Return a scene with one sphere, in line 2."""
    return f"bodies:\n  - shape: {{Sphere: {fields}}}\n"


def body(text: str) -> str:
    return f"bodies:\n  - {text}\n"
