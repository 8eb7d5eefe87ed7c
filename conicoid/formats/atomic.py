"""Outputs that appear whole or not at all."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A new empty file beside `path`, with the same suffix; it takes the place of `path` if the block succeeds.

    Raises OSError, naming what is in the way, where `path` cannot be a file or its folder cannot be written to.
    """
    final = Path(path).resolve()
    if final.is_dir():
        raise IsADirectoryError(21, "is a directory", str(path))
    if final.exists() and not final.is_file():
        raise OSError(22, "is not a regular file", str(path))
    if not final.parent.is_dir():
        raise FileNotFoundError(2, "no such folder", str(final.parent))
    partial = final.with_name(f".{final.stem[:40]}-{secrets.token_hex(4)}{final.suffix}")
    os.close(os.open(partial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
    try:
        yield partial
        if final.exists():
            partial.chmod(final.stat().st_mode & 0o777)
        os.replace(partial, final)
    finally:
        partial.unlink(missing_ok=True)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text in UTF-8, whole or not at all."""
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8", newline="\n")
