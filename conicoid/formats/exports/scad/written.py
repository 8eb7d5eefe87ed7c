"""A scene as an OpenSCAD model: a solid for each body, in its colour."""

from __future__ import annotations

from collections import Counter

from ...errors import printable
from ...imports.imported import counted
from ...scene_file import SceneLike
from ..bodies import color_of, is_void, solids_of
from ..exported import Exported, Options, Report
from ..lowered import lowered
from .solids import Call, Writer, color


def exported(scene: SceneLike, options: Options) -> Exported:
    """The text of a .scad or .csg file, which are of one grammar here."""
    report = Report("OpenSCAD")
    items = solids_of(scene, report)
    lines: list[str] = []
    colors: Counter[str] = Counter()
    for number, item in enumerate(items):
        if options.progress is not None and number % 256 == 0:
            options.progress(number, len(items))
        if is_void(item.material):
            report.narrow("left out: invisible", item.name)
            continue
        with report.about(item.name):
            writer = Writer()
            look, is_all = color_of(item.material)
            whole = Call(f"color({color(look)})", (writer.call(lowered(item.solid)),))
            lines += [f"// {printable(item.name)}", *whole.lines()]
            colors[look] += 1
            if colors[look] == 2:
                report.narrow("one of several bodies of a colour, which are read back as one", item.name)
            if writer.is_rounded:
                report.narrow("numbers are rounded to float64", item.name)
            if not is_all:
                report.narrow("only the colour is said of how it looks", item.name)
            if item.material is not None and item.material.properties:
                report.narrow("not said: properties of the material", item.name)
    report.check()
    if not colors:
        raise ValueError("export: there is no visible body to write")
    facts = [f"{counted(sum(colors.values()), 'solid')} of {counted(len(colors), 'colour')}"]
    remarks = report.remarks
    return Exported("\n".join([*lines, ""]), (*facts, *remarks), remarks)
