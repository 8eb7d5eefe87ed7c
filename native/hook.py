"""The hook of hatchling that puts machine code into wheels: `pip install .`, `pip wheel .`, `python -m native.wheels`.

`CONICOID_KERNELS` chooses the levels of its machine that a wheel gets, as "x86-64-v3,x86-64-v4"; where it names none of
them, as when it is unset, the wheel gets all. With "none" it gets no machine code, and needs no compiler to be made.
Source archives and editable installs have none.
"""

from __future__ import annotations

import importlib.util
import os
import sys
import sysconfig
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

if TYPE_CHECKING:
    from native.targets import Target

VARIABLE = "CONICOID_KERNELS"


@contextmanager
def step(name: str) -> Iterator[None]:
    """Print a step before it begins, and its seconds after it ended: whole lines, as pip shows no others."""
    print(f"{name} ...", flush=True)
    begin = time.monotonic()
    yield
    print(f"  {time.monotonic() - begin:.0f} s", flush=True)


class KernelsHook(BuildHookInterface[Any]):
    """The part of a build that adds the extension, the engine for pages, and the tag of the platform to a wheel."""

    PLUGIN_NAME = "custom"

    def __init__(self, root: str, *arguments: Any, **options: Any) -> None:
        super().__init__(root, *arguments, **options)
        if root not in sys.path:  # for `hatch build`, which does not go through native/backend.py
            sys.path.insert(0, root)

    def dependencies(self) -> list[str]:
        """Return the requirements of a wheel: compilers, and the imports of conicoid."""
        if self._target() is None:
            return []
        project = self.metadata.core
        build = self.metadata.config["dependency-groups"]["build"]
        return [*project.dependencies, *project.optional_dependencies["jit"], *build]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the extension and the engine for pages."""
        target = None if version == "editable" else self._target()
        if target is None:
            return
        from native import build, page  # compilers must be there for these

        self._scratch = tempfile.TemporaryDirectory()
        folder = Path(self.config.get("folder") or self._scratch.name)
        with step("kernels to LLVM code"):
            build.lowered(folder)
        with step("the engine for pages"):
            engine = page.build(folder)
        with step(f"machine code for {target.name}: {', '.join(level.name for level in target.levels)}"):
            extension = build.build(target, folder)
        build_data |= {"pure_python": False, "tag": f"cp311-abi3-{target.tag}"}
        build_data["force_include"] |= {str(extension): f"conicoid/{extension.name}", str(engine): page.PAGE_ENGINE}

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove intermediate files."""
        if hasattr(self, "_scratch"):
            self._scratch.cleanup()

    def _target(self) -> Target | None:
        """Return the target of the wheel with its levels, None for a wheel without machine code.

        Raises SystemExit, which pip shows, where machine code cannot be made.
        """
        text = os.environ.get(VARIABLE, "")
        if text == "none":
            return None
        from native.build import host
        from native.targets import TARGETS

        try:
            if "target" in self.config:  # native/wheels.py makes wheels for other machines too
                target = TARGETS[self.config["target"]]
            else:
                target = host()
                _check_numba(target, self.config["newest-python"], self.config["without-numba"])
        except SystemExit as error:
            raise SystemExit(
                f"{error}. {VARIABLE}=none makes a wheel without machine code, "
                "which Numba compiles at first use: extra `jit`"
            ) from None
        chosen, own = text.split(",") if text else [], [level.name for level in target.levels]
        # Wheels for all systems: a level of another machine says nothing about this one
        others = TARGETS.values() if "target" in self.config else ()
        known = dict.fromkeys(own) | dict.fromkeys(level.name for other in others for level in other.levels)
        if set(chosen) - known.keys():
            raise SystemExit(f"{VARIABLE} must be none, or some of {', '.join(known)}; got {text[:80]!r}")
        return target.only(",".join(name for name in chosen if name in own))


def _check_numba(target: Target, newest: list[int], without: list[str]) -> None:
    """Raise SystemExit unless this Python has Numba, or pip can install it for this machine, the target."""
    version = ".".join(map(str, sys.version_info[:2]))
    if sys.implementation.name != "cpython" or sysconfig.get_config_var("Py_GIL_DISABLED"):
        raise SystemExit("Machine code is made by and for CPython with its lock")
    if importlib.util.find_spec("numba") is not None:
        return
    if list(sys.version_info[:2]) > newest or target.name in without:
        raise SystemExit(
            f"Machine code is made by Numba, which cannot be installed for Python {version} on {target.name}; "
            f"a wheel that another Python or machine makes may serve here (`make wheels`)"
        )
