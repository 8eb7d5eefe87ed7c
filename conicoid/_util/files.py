"""Files: output that appears whole or not at all, input that can be read to its end, and errors of scene files."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import stat
import zlib
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from io import BufferedReader
from os import PathLike, fspath
from pathlib import Path
from typing import Any

from .text import suggest_name

_NO_SYNC = {errno.EINVAL, errno.ENOTSUP, errno.ENOSYS, errno.EBADF, errno.EACCES, errno.EPERM}
"""Errors of systems and files that cannot be synchronised."""


@contextlib.contextmanager
def replace_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a new empty file beside `path`, with the same suffix; it replaces `path` if the block succeeds.

    Its content is on the disk before its name is, so that neither a full disk nor a power cut leaves half of it. Raises
    OSError with the name `path` if that cannot be a file, its folder cannot be written to, or the disk is full.
    """
    final = resolve_output(path)
    with _name_output_in_errors(path, final):
        partial, lock = create_partial(final, final.suffix)
        try:
            yield partial
            _sync_to_disk(partial, os.O_RDWR)
            if final.exists():  # the new file keeps the permissions of the old one
                partial.chmod(final.stat().st_mode & 0o777)
            os.replace(partial, final)
        except BaseException:
            partial.unlink(missing_ok=True)
            raise
        finally:
            release_partial(lock)
        if os.name == "posix":  # the folder holds the name; other systems cannot open one
            _sync_to_disk(final.parent, os.O_RDONLY)


_NAMES = 4  # saves of one output at a time whose remains are found


def create_partial(final: Path, suffix: str, folder: bool = False) -> tuple[Path, int]:
    """Create a hidden file or folder beside an output. Return it, and a lock until `release_partial` or a kill.

    Those of the same output that no process has locked are remains of killed ones, and go first. Windows and file
    systems without locks keep them.
    """
    # Few names for each output, as a search of the folder would take long among the frames of a film
    start = f".{final.stem[:40]}-{zlib.crc32(final.name.encode(errors='surrogatepass')):08x}"
    for partial in (names := [final.with_name(f"{start}{k}{suffix}") for k in range(_NAMES)]):
        with contextlib.suppress(OSError):
            lock = _open_plain(partial, folder)
            try:
                if _lock(lock, partial, otherwise=False):
                    shutil.rmtree(partial, ignore_errors=True) if folder else partial.unlink()
            finally:
                os.close(lock)
    # Nobody takes the last one for remains
    for partial in (*names, last := final.with_name(f"{start}-{os.urandom(4).hex()}{suffix}")):
        with contextlib.nullcontext() if partial == last else contextlib.suppress(FileExistsError, FileNotFoundError):
            if folder:
                partial.mkdir()
            # Exclusive: a file of that name, or a link planted there, is never written to
            lock = _open_plain(partial, folder, 0 if folder else os.O_CREAT | os.O_EXCL)
            if _lock(lock, partial, otherwise=True) or partial == last:
                break
            os.close(lock)
    if os.name != "posix":  # other systems do not rename an open file
        os.close(lock)
        lock = -1
    return partial, lock


def release_partial(lock: int) -> None:
    """Release the lock of `create_partial` or `lock_file`."""
    if lock >= 0:
        os.close(lock)


def lock_file(path: Path) -> int:
    """Lock a file that is about to replace a partial one, whose lock does not cover it. Return the lock."""
    if os.name != "posix":
        return -1
    lock = _open_plain(path, False)
    _lock(lock, path, otherwise=True)
    return lock


def _open_plain(path: Path, folder: bool, more: int = 0) -> int:
    """Return a descriptor of a file, or of a folder, that can be locked; of no link."""
    kind = os.O_RDONLY | getattr(os, "O_DIRECTORY", 0) if folder else os.O_RDWR  # NFS locks what can be written
    return os.open(path, kind | more | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0), 0o666)


def _lock(descriptor: int, path: Path, otherwise: bool) -> bool:
    """Lock a file or folder, and return whether it is still the one at `path`; `otherwise` where there are no locks."""
    try:
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return os.path.samestat(os.fstat(descriptor), os.lstat(path))
    except (BlockingIOError, FileNotFoundError):
        return False
    except (ImportError, OSError):
        return otherwise


def resolve_output(path: str | os.PathLike[str]) -> Path:
    """Return the path of a file to write, with links followed.

    Raises OSError with the path for a folder, a device, or a missing parent folder.
    """
    final = resolve_links(path)
    if final.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a directory", str(path))
    if final.exists() and not final.is_file():
        raise OSError(errno.EINVAL, "is not a regular file", str(path))
    if not final.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "no such folder", str(final.parent))
    return final


def resolve_links(path: str | os.PathLike[str]) -> Path:
    """Return a path with links followed; raise OSError for links in a circle, and names that no file can have."""
    check_name(path)
    try:
        return Path(path).resolve()
    except RuntimeError:
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), os.fspath(path)) from None


def check_name(path: str | os.PathLike[str]) -> None:
    """Raise OSError for a name that this system cannot write, such as half a surrogate pair, or one with NUL."""
    try:
        is_name = b"\0" not in os.fsencode(path)
    except UnicodeEncodeError:
        is_name = False
    if not is_name:
        raise OSError(errno.EILSEQ, "is no name that a file can have here", os.fspath(path))


@contextlib.contextmanager
def _name_output_in_errors(path: str | os.PathLike[str], final: Path) -> Iterator[None]:
    """Let errors of a partial file name the file that it was to become."""
    start = os.fspath(final.with_name(f".{final.stem[:40]}-"))
    try:
        yield
    except OSError as error:
        if error.errno is None or not str(error.filename or start).startswith(start):
            raise
        raise OSError(error.errno, error.strerror, os.fspath(path)) from None


def _sync_to_disk(path: Path, flags: int) -> None:
    """Wait until a file or folder is on the disk, on systems that support it."""
    try:
        descriptor = os.open(path, flags)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
    except OSError as error:
        if error.errno not in _NO_SYNC:
            raise


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text in UTF-8, whole or not at all."""
    with replace_file(path) as partial:
        partial.write_text(text, encoding="utf-8", newline="\n")


# --- Input: no wait for a pipe, no read of a device, no more memory than the machine has

MAX_FILE_BYTES = 64 << 30
"""The largest content of a file in memory."""
_READ_ONLY = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)


def open_regular(path: str | os.PathLike[str]) -> BufferedReader:
    """Open a regular file, or a link to one, for reading; raise OSError at once for anything else."""
    check_name(path)
    _check_regular(os.stat(path).st_mode, path)  # before `open`, which some devices react to
    descriptor = os.open(path, _READ_ONLY)
    try:  # again, since the file may have been replaced meanwhile
        _check_regular(os.fstat(descriptor).st_mode, path)
    except OSError:
        os.close(descriptor)
        raise
    return open(descriptor, "rb")


def read_regular(path: str | os.PathLike[str], most: int) -> bytes:
    """Return the contents of a regular file; `most` + 1 bytes of a larger one, by which a caller notices it."""
    with open_regular(path) as file:
        return file.read(min(os.fstat(file.fileno()).st_size, most) + 1)


def refuse_devices(folder: str | os.PathLike[str]) -> None:
    """Raise OSError for pipes and devices in a folder, and in folders that links in it lead to."""
    folders, found = [os.path.realpath(folder)], set()
    while folders:
        path = folders.pop()
        if path not in found:  # links may lead in a circle
            found.add(path)
            with os.scandir(path) as entries:
                for entry in entries:
                    if entry.is_dir():
                        folders.append(os.path.realpath(entry.path) if entry.is_symlink() else entry.path)
                    elif not entry.is_file():
                        _check_regular(os.stat(entry.path).st_mode, entry.path)


def _check_regular(mode: int, path: str | os.PathLike[str]) -> None:
    """Raise OSError unless a mode is that of a regular file."""
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "is a directory", os.fspath(path))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "is not a regular file", os.fspath(path))


def resolve_part(path: str | os.PathLike[str], name: str, root: str | os.PathLike[str]) -> str:
    """Return the path, without links, of a file that the file `path` names relative to its own folder.

    Raise ValueError unless it lies within the folder `root`.
    """
    if not name or "\0" in name:
        raise ValueError(f"{name[:40]!r} is no name of a file")
    # A file from a stranger must not read others of this machine, neither by ".." nor by a link that leads out
    found, within = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(path)), name)), os.path.realpath(root)
    if not Path(found).is_relative_to(within):
        raise ValueError(f"file {name[:80]!r} is outside of the folder that may be read (root=, --root): {within}")
    return found


def check_memory(size: int) -> None:
    """Raise ValueError for more bytes than any machine should take for a file, or than this one has."""
    most = min(MAX_FILE_BYTES, _machine_memory())
    if size > most:
        raise ValueError(f"takes {size / 2**30:,.1f} GiB of memory, at most {most / 2**30:,.1f} GiB can be had")


def _machine_memory() -> int:
    """Return the bytes of memory of this machine, or the limit of a file if the system does not report them."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return MAX_FILE_BYTES


# Errors of scene files: every problem with its line, reported at once, and suggestions for misspelt names.

MAX_LISTED_PROBLEMS, MAX_MESSAGE_WIDTH = 18, 100
"""The largest number of lines of a message, and their width: one screen, with its first and last line."""
MAX_PROBLEMS = 1000


@dataclass(frozen=True, order=True)
class Problem:
    """One mistake. `line` and `column` count from 1; 0 stands for the file as a whole."""

    line: int
    column: int
    where: str
    message: str


class SceneFileError(ValueError):
    """A scene file that cannot be used. `problems` has them in the order of the file, at most about `MAX_PROBLEMS`."""

    def __init__(self, path: str | PathLike[str], problems: Iterable[Problem]) -> None:
        self.path = fspath(path)
        self.problems = tuple(sorted(set(problems)))
        super().__init__(self.path, self.problems)

    def __str__(self) -> str:
        lines: list[str] = []
        rows = 0
        for problem in self.problems[:MAX_LISTED_PROBLEMS]:
            line = self._line(problem)
            rows += -(-len(line) // MAX_MESSAGE_WIDTH)  # a long line takes several of the screen
            if lines and rows > MAX_LISTED_PROBLEMS:
                break
            lines.append(line)
        rest = len(self.problems) - len(lines)
        if rest > 0:
            # A reader stops at that number, so there may be more
            least = "at least " if len(self.problems) >= MAX_PROBLEMS else ""
            lines.append(f"{self._file}: and {least}{rest} more problem{'s' if rest > 1 else ''}")
        return "\n".join(lines)

    @property
    def _file(self) -> str:
        """The path for messages."""
        return _cut_middle(printable(self.path), 400)

    def _line(self, problem: Problem) -> str:
        """Return the line of a message for a problem."""
        place = f":{problem.line}:{problem.column}" if problem.line else ""
        where = f"{_cut_middle(printable(problem.where), 160)}: " if problem.where else ""
        return f"{self._file}{place}: {where}{_cut_middle(printable(problem.message), 600)}"


class UnreadableFileError(SceneFileError, OSError):
    """A file that exists and cannot be read: no permission, a folder, a failing disk."""

    def __reduce__(self) -> tuple[Any, ...]:
        return unreadable_error, (self.path, OSError(self.errno, self.strerror))


class MissingFileError(UnreadableFileError, FileNotFoundError):
    """A file that does not exist, which `except FileNotFoundError` catches too."""


def unreadable_error(path: str | PathLike[str], error: OSError) -> SceneFileError:
    """Return the error for a scene file in place of an OSError, of the same kind and with its fields."""
    reason = (error.strerror or str(error)).lower()
    kind = MissingFileError if isinstance(error, FileNotFoundError) else UnreadableFileError
    unreadable = kind(path, [Problem(0, 0, "", f"cannot be read: {reason}")])
    unreadable.errno, unreadable.strerror, unreadable.filename = error.errno, error.strerror, fspath(path)
    return unreadable


def read_bounded(path: str | PathLike[str], most: int, before: int = 0) -> bytes:
    """Return the contents of a file.

    Raise SceneFileError for one that cannot be read, and for more than `most` bytes with the `before` read already.
    """
    try:
        if "\0" in fspath(path):
            raise OSError(errno.EINVAL, "a path cannot hold a zero character")
        raw = read_regular(path, most)
    except OSError as error:
        raise unreadable_error(path, error) from None
    if before + len(raw) > most:
        parts = " with all its parts" if before else ""
        message = f"is too large{parts}: at most {most >> 20} MB are read"
        raise SceneFileError(path, [Problem(0, 0, "", message)])
    return raw


def printable(text: str) -> str:
    """Return text on one line, without characters that a terminal would obey."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def _cut_middle(text: str, width: int) -> str:
    """Return text without its middle if it is longer than `width`."""
    return text if len(text) <= width else f"{text[: width // 2 - 2]} ... {text[-width // 2 + 3 :]}"


MAX_COMPARISONS = 20_000
"""Names that all typos of a file together are compared with: about a second."""


class Suggestions:
    """Suggestions for misspelt names of one file; none after many, since only the first are read."""

    def __init__(self) -> None:
        self.budget = MAX_COMPARISONS

    def __call__(self, name: str, known: Collection[str]) -> str:
        """Return a suggestion in brackets, or the list of known names if that is short; else ""."""
        if len(known) > self.budget:
            return ""
        self.budget -= len(known)
        return suggest_name(name, known)
