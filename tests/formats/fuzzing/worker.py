"""Run cases in a process with limits of memory and time: python -m tests.formats.fuzzing.worker FIRST COUNT FOLDER
KIND...

Every failure is a line of JSON. After the failures of a kind a line gives the number of cases, how many of them were
accepted, and the largest memory of the process so far.
"""

import faulthandler
import json
import resource
import signal
import sys
import time
import traceback
import warnings
from pathlib import Path
from typing import Any

from .import_cases import IMPORTS
from .ray_cases import ray_case
from .scene_cases import mutated_case, schema_case

SECONDS, BYTES = 10, 2 << 30
"""Seconds of processor time for one case, so that a busy machine makes no difference."""
KINDS = {"mutated": mutated_case, "schema": schema_case, "rays": ray_case, **IMPORTS}


class TooSlow(BaseException):
    """A case that takes too long. It is not an Exception, so that nobody catches it."""


def too_slow(*_: Any) -> None:
    raise TooSlow


def report(line: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(line) + "\n")
    sys.stdout.flush()


def peak() -> int:
    """Return the most bytes that this process had in memory. (`ru_maxrss` counts its parent's memory at the fork.)"""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM:"))


def limit() -> None:
    """Bound the memory and the time of this process."""
    faulthandler.enable()
    warnings.simplefilter("error")
    warnings.filterwarnings("ignore", message=".* is linear light, .* times white")  # random numbers may be that
    mapped = (
        int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize() if sys.platform == "linux" else 0
    )
    if mapped:
        resource.setrlimit(resource.RLIMIT_AS, (mapped + BYTES, resource.getrlimit(resource.RLIMIT_AS)[1]))
    signal.signal(signal.SIGPROF, too_slow)


def run(kind: str, first: int, count: int, folder: Path) -> None:
    accepted, slowest = 0, 0.0
    for seed in range(first, first + count):
        started = time.process_time()
        try:
            signal.setitimer(signal.ITIMER_PROF, SECONDS)
            accepted += KINDS[kind](seed, folder)
        except (Exception, TooSlow) as error:
            signal.setitimer(signal.ITIMER_PROF, 0)
            last = "".join(traceback.format_exception(error)[-6:])
            report(
                {"kind": kind, "seed": seed, "error": f"{type(error).__name__}: {error}"[:500], "trace": last[-3000:]}
            )
        signal.setitimer(signal.ITIMER_PROF, 0)
        slowest = max(slowest, time.process_time() - started)
    report({"kind": kind, "done": count, "accepted": accepted, "peak": peak(), "slowest": slowest})


if __name__ == "__main__":
    limit()
    for kind in sys.argv[4:]:
        run(kind, int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]))
