"""Lines that `conicoid info` and benchmarks print: bodies, memory, findings of a check, versions, the processor."""

from __future__ import annotations

import platform
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._jit.machine_code import describe_code, levels
from .._util.files import printable
from .._util.text import format_bytes, format_count
from ..geometry.general_quadric import Quadric
from ..geometry.labels import count_bodies, distinct_materials
from ..kernels.threads import thread_count
from ..materials.color import srgb_encode
from ..materials.texture import PATTERNS

if TYPE_CHECKING:
    from ..apps.checks.findings import Findings
    from ..prepare.prepared_scene import Memory
    from ..scene.scene import Scene


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


# The lines that `conicoid info` prints: bodies of a scene, its memory, findings of a check, and the system.

LISTED = 50
"""The largest number of lines of one kind; the rest are counted."""
_WIDTHS = (16, 16, 22)
"""The least widths of the columns of names, materials and shapes."""


def list_bodies(scene: Scene) -> list[str]:
    """Return a line for each entry: ids, name, material, shape and bounds; below a general quadric, its class."""
    rows, number = [("id", "name", "material", "shape", "bounds")], 0
    quadrics: dict[int, str] = {}
    for body in scene.bodies[:LISTED]:
        count = count_bodies(body)
        ids = f"{number}" if count == 1 else f"{number}-{number + count - 1}" if count else "none"
        number += count
        name, kind = printable(body.name or ""), type(body.shape).__name__
        if isinstance(body.shape, Quadric):
            quadrics[len(rows)] = str(body.shape.classification)
        rows.append((ids, name, _material_of(body), kind, _box(*body.shape.bounds)))
    if len(rows) == 1:
        return ["no bodies"]
    widths = [max([least, *(len(row[k]) for row in rows)]) for k, least in enumerate(_WIDTHS, 1)]
    lines = []
    for k, (ids, *cells, bounds) in enumerate(rows):
        padded = (f"{cell:<{width}}" for cell, width in zip(cells, widths, strict=True))
        lines.append(" ".join([f"{ids:>9} ", *padded, bounds]))
        lines += [f"{'':>9}  {quadrics[k]}"] if k in quadrics else []
    if len(scene.bodies) > LISTED:
        lines.append(f"{'':>9}  and {format_count(len(scene.bodies) - LISTED, 'more entry', 'more entries')}")
    return lines


def totals(scene: Scene) -> list[str]:
    """Return the numbers of bodies, lights and distinct surfaces, the bounds, and the memory."""
    from ..kernels.tables import SURFACE_KIND, length

    return [
        f"bodies    {scene.body_count:,}",
        f"lights    {len(scene.lights):,}",
        f"surfaces  {int(length(scene._prepared.geometry, SURFACE_KIND)):,}",
        f"bounds    {_box(*scene.bounds)}",
        *([f"unit      {scene.unit}"] if scene.unit else []),
        f"memory    {_memory(scene.memory)}",
    ]


def findings(found: Findings) -> list[str]:
    """Return the number of findings, the worst of each kind, and the checks that were skipped."""
    from ..apps.checks.findings import KINDS

    lines = [f"findings  {len(found):,}"]
    for kind in KINDS:
        of_kind = [finding for finding in found if finding.kind == kind]
        lines.extend(printable(str(finding)) for finding in of_kind[:LISTED])
        if len(of_kind) > LISTED:
            lines.append(f"{kind}: and {len(of_kind) - LISTED:,} more")
    return [*lines, *(f"not looked for: {text}" for text in found.omissions)]


def _material_of(body: Any) -> str:
    """Return the material of an entry, or the number of its materials."""
    used = distinct_materials([body])
    return _material(used[0]) if len(used) == 1 else f"{len(used)} materials"


def _material(material: Any) -> str:
    """Return the name of a material; without a name its colour, and "-" for no material."""
    if material is None:
        return "-"
    if material.name:
        return printable(material.name)
    if np.any(np.asarray(material.transparency) != 0):
        return "clear"
    if isinstance(material.color, (str, *PATTERNS)):
        return str(material.color) if isinstance(material.color, str) else type(material.color).__name__.lower()
    bytes_ = np.round(255 * np.clip(srgb_encode(np.asarray(material.color)), 0, 1)).astype(int)
    return "#" + "".join(f"{channel:02x}" for channel in bytes_.tolist())


def _box(low: Any, high: Any) -> str:
    """Return bounds as text."""
    if (low > high).any():  # (inf, -inf) for no points
        return "empty"
    return "  ".join(f"{axis} [{a:.6g}, {b:.6g}]" for axis, a, b in zip("xyz", low, high, strict=True))


def _memory(memory: Memory) -> str:
    """Return the bytes in all, and for each primitive."""
    each = ", ".join(
        f"{part / max(memory.primitives, 1):.0f} bytes a primitive for {name}"
        for name, part in (("the tables", memory.tables), ("the tree", memory.tree))
    )
    return (
        f"{format_bytes(memory.tables + memory.tree)} for "
        f"{format_count(memory.primitives, 'primitive', 'primitives')}: {each}"
    )


# --- info --system


def system_report() -> list[str]:
    """Return versions, the processor, and the origin of the kernels.

    A report of a problem, or of a time, needs these lines.
    """
    from .._util.version import __version__

    lines = [
        f"conicoid   {__version__}",
        f"python     {', '.join([platform.python_version(), *versions('numpy', 'numba')])}",
        f"platform   {platform.platform()}",
        f"processor  {processor()}, {thread_count()} threads",
        f"kernels    {describe_code()}",
    ]
    if levels():
        lines.append(f"levels     {', '.join(levels())} (CONICOID_LEVEL chooses another)")
    return lines
