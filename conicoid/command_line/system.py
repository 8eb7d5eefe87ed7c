"""What `conicoid info --system` prints: what a report of a problem, or of a time, has to say."""

from __future__ import annotations

import platform

from ..bench.report import compiler, processor, versions
from ..compiler.kernel_cache.place import cache_directory
from ..compiler.machine_code import SHIPPED, about, levels
from ..engine.threads import thread_count


def report() -> list[str]:
    """Versions, the processor, where kernels come from, and where what is kept is kept."""
    from .. import __version__

    kept = cache_directory()
    lines = [
        f"conicoid   {__version__}",
        f"python     {', '.join([platform.python_version(), *versions('numpy', 'numba')])}",
        f"platform   {platform.platform()}",
        f"processor  {processor()}, {thread_count()} threads",
        f"kernels    {', '.join(dict.fromkeys((about(), compiler())))}",
        f"cache      {'none' if kept is None else kept}{'' if SHIPPED is None else ', not needed for kernels'}",
    ]
    if levels():
        lines.insert(5, f"levels     {', '.join(levels())} (CONICOID_LEVEL chooses another)")
    return lines
