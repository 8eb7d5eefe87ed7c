"""Wheels with machine code, and the source archive, into `dist`: `python -m native.wheels [TARGET...]`.

Without names it makes those for all targets; `host` is this machine's. hatchling and the hook (hook.py) make each
wheel, as for `pip wheel .`; the kernels' LLVM code is made once for all. Each is inspected before it gets its name, and
a break leaves nothing behind.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import time
from pathlib import Path

from hatchling.builders.sdist import SdistBuilder
from hatchling.builders.wheel import WheelBuilder

from .build import host
from .inspection import ROOT, wrong_with_cuda_wheel, wrong_with_wheel
from .targets import TARGETS, Target

CUDA = "cuda"
"""The name in place of a target for the wheel conicoid-cuda, the kernels for GPUs."""
CUDA_PROJECT = """
[project]
name = "conicoid-cuda"
version = "{version}"
description = "Kernels of Conicoid for GPUs of NVIDIA's"
license = "MIT"
license-files = ["LICENSE"]
requires-python = ">=3.11"
dependencies = ["conicoid=={version}", "cuda-bindings>=12.9"]

[tool.hatch.build.targets.wheel]
packages = ["conicoid_cuda"]
"""


def wheel(target: Target, folder: Path) -> Path:
    """Make a wheel in the folder, where the hook uses existing files. ValueError if the wheel has a fault."""
    builder = WheelBuilder(str(ROOT))
    hook = builder.raw_config["tool"]["hatch"]["build"]["targets"]["wheel"]["hooks"]["custom"]
    hook |= {"target": target.name, "folder": str(folder)}
    made = Path(next(builder.build(directory=str(folder), versions=["standard"])))
    wrong = wrong_with_wheel(made)
    if wrong:
        raise ValueError(f"{made.name}: {'; '.join(wrong)}")
    return made


def cuda_wheel(folder: Path) -> Path:
    """Make the wheel of kernels for GPUs in the folder. ValueError if it has a fault."""
    from . import ptx

    project = folder / "cuda"
    package = project / "conicoid_cuda"
    package.mkdir(parents=True, exist_ok=True)
    version = WheelBuilder(str(ROOT)).metadata.version
    (project / "pyproject.toml").write_text(CUDA_PROJECT.format(version=version), encoding="utf-8")
    shutil.copy(ROOT / "LICENSE", project)
    (package / "__init__.py").write_text('"""Kernels of Conicoid for GPUs of NVIDIA\'s, as PTX."""\n', encoding="utf-8")
    ptx.build(folder, package)
    made = Path(next(WheelBuilder(str(project)).build(directory=str(folder), versions=["standard"])))
    wrong = wrong_with_cuda_wheel(made)
    if wrong:
        raise ValueError(f"{made.name}: {'; '.join(wrong)}")
    return made


def source_archive(folder: Path) -> Path:
    """Make the source archive in the folder."""
    return Path(next(SdistBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])))


def make(targets: list[Target | None], out: Path, scratch: Path, sources: bool) -> None:
    """Build, inspect, and only then move into `out`; print the names of the files, and how to install them."""
    begin, made = time.monotonic(), []
    for number, target in enumerate(targets, 1):
        print(f"Wheel {number} of {len(targets)}, for {target.name if target else CUDA}:", flush=True)
        made.append(wheel(target, scratch) if target else cuda_wheel(scratch))
    if sources:
        made.append(source_archive(scratch))
    out.mkdir(parents=True, exist_ok=True)
    print(f"Made in {time.monotonic() - begin:.0f} s:")
    for file in made:
        arriving = out / f".{file.name}.part"
        shutil.copyfile(file, arriving)  # the folders may be on different disks
        arriving.replace(out / file.name)
        print(f"{out / file.name}, {file.stat().st_size / 1e6:.2f} MB")
    print(f"To install it: pip install {out / made[0].name if len(made) == 1 else f'--find-links {out} conicoid'}")


def main() -> int:
    """Make the wheels that the command line names. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=f"host, {', '.join((*TARGETS, CUDA))}")
    parser.add_argument("--out", type=Path, default=ROOT / "dist")
    parser.add_argument("--folder", type=Path, help="keep what is made on the way, and use what is there")
    wanted = parser.parse_args()
    unknown = set(wanted.targets) - {"host", CUDA, *TARGETS}
    if unknown:
        parser.error(f"there is no target {', '.join(sorted(unknown))}")
    names = wanted.targets or (*TARGETS, CUDA)
    targets = [host() if name == "host" else TARGETS.get(name) for name in names]
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
