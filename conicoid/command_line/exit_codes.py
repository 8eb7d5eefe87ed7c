"""With which code the command `conicoid` ends, and why."""

from __future__ import annotations

import errno

DONE = 0
FAILED = 1
"""The machine's fault, not the input's: a full disk, too little memory, a package that is missing; or a bug."""
MISTAKE = 2
"""The input's, or the command line's: a message says what is wrong, and nothing is written."""
FOUND = 3
"""A check has found something: what was asked for is done, and says that a person should look."""
INTERRUPTED = 130
"""By Ctrl-C: 128 and the number of the signal, as shells have it."""
CLOSED = 141
"""Nobody reads the results any more (`| head`): what a program has that SIGPIPE ends."""

_OF_PATHS = frozenset(
    getattr(errno, name)
    for name in (
        "EACCES", "EADDRINUSE", "EADDRNOTAVAIL", "EEXIST", "EINVAL", "EISDIR", "ELOOP", "ENAMETOOLONG", "ENODEV",
        "ENOENT", "ENOTDIR", "ENXIO", "EPERM", "EROFS", "ETXTBSY",
    )
    if hasattr(errno, name)
)  # fmt: skip
"""What is wrong with a name that was given: there is no such file, a folder is none, a port is taken."""


def code_of(error: OSError) -> int:
    """MISTAKE where another name would do, else FAILED."""
    return MISTAKE if error.errno in _OF_PATHS else FAILED
