"""The machine of a report or a benchmark: versions of packages, the processor."""

from __future__ import annotations

import platform
from importlib import metadata
from pathlib import Path


def versions(*packages: str) -> list[str]:
    """Return "name version" of each package that is installed."""
    names = {each.name for each in metadata.distributions()}
    return [f"{name} {metadata.version(name)}" for name in packages if name in names]


def processor() -> str:
    """Return the name of the processor, as far as the system has it."""
    try:
        # Linux names the processor here; `platform.processor` is often empty there.
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
