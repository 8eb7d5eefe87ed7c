"""Wheels with machine code, and the source archive, into `dist`: `python -m native.wheels [TARGET...]`.

Without names for all targets; `host` is this machine's. The kernels' LLVM code is made once for all; each wheel is
inspected before it gets its name, and what is interrupted leaves nothing behind.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from hatchling.builders.sdist import SdistBuilder
from hatchling.builders.wheel import WheelBuilder

from . import page
from .build import build, host, lowered
from .inspection import PAGE_ENGINE, ROOT, wrong_with_wheel
from .targets import TARGETS, Target


class _Wheel(WheelBuilder):
    """The package with an extension of its target, and the engine for pages."""

    target: Target
    extension: Path
    engine: Path

    def get_default_build_data(self) -> dict[str, Any]:
        inside = {str(self.extension): f"conicoid/{self.extension.name}", str(self.engine): PAGE_ENGINE}
        tag = f"cp311-abi3-{self.target.tag}"
        return super().get_default_build_data() | {"pure_python": False, "tag": tag, "force_include": inside}


def wheel(target: Target, extension: Path, engine: Path, folder: Path) -> Path:
    """A wheel in the folder. Raises ValueError if something is wrong with it."""
    builder = _Wheel(str(ROOT))
    builder.target, builder.extension, builder.engine = target, extension, engine
    made = Path(next(builder.build(directory=str(folder), versions=["standard"])))
    wrong = wrong_with_wheel(made)
    if wrong:
        raise ValueError(f"{made.name}: {'; '.join(wrong)}")
    return made


def source_archive(folder: Path) -> Path:
    """The source archive in the folder."""
    return Path(next(SdistBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])))


class _Progress:
    """Lines with the time since the beginning."""

    def __init__(self) -> None:
        self.begun = time.monotonic()

    def __call__(self, message: str) -> None:
        print(f"{time.monotonic() - self.begun:6.0f} s  {message}", flush=True)


def make(targets: list[Target], out: Path, scratch: Path, sources: bool) -> None:
    """Build, inspect, and only then move into `out`."""
    say = _Progress()
    say("kernels to LLVM code")
    lowered(scratch)
    say("the engine for pages")
    engine = page.build(scratch)
    made = []
    for number, target in enumerate(targets, 1):
        say(f"{target.name} ({number} of {len(targets)}): {', '.join(level.name for level in target.levels)}")
        made.append(wheel(target, build(target, scratch), engine, scratch))
    if sources:
        made.append(source_archive(scratch))
    out.mkdir(parents=True, exist_ok=True)
    for file in made:
        arriving = out / f".{file.name}.part"
        shutil.copyfile(file, arriving)  # the folders may be on different disks
        arriving.replace(out / file.name)
        say(f"{out / file.name}: {file.stat().st_size / 1e6:.2f} MB")


def main() -> int:
    """As the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=f"host, {', '.join(TARGETS)}")
    parser.add_argument("--out", type=Path, default=ROOT / "dist")
    parser.add_argument("--folder", type=Path, help="keep what is made on the way, and use what is there")
    wanted = parser.parse_args()
    unknown = set(wanted.targets) - {"host", *TARGETS}
    if unknown:
        parser.error(f"there is no target {', '.join(sorted(unknown))}")
    targets = [host() if name == "host" else TARGETS[name] for name in wanted.targets or TARGETS]
    with tempfile.TemporaryDirectory() as temporary:
        folder = wanted.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        try:
            make(targets, wanted.out, folder, sources=not wanted.targets)
        except KeyboardInterrupt:
            print("interrupted", file=sys.stderr)
            return 130
        except ValueError as error:
            print(error, file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
