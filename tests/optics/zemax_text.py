"""Lens files in the form of Zemax, for the tests."""

SYSTEM = """VERS 140124 258 36214 L36214
MODE SEQ
NAME {name}
UNIT MM X W X CM MR CPMM
{aperture}
GCAT SCHOTT
FTYP {kind} 0 {fields} {waves} 0 0 0
XFLN 0 0 0 0
YFLN {heights}
{wave_lines}
PWAV {primary}
"""


def surface(number, curvature=0.0, thickness="0", glass=None, conic=None, semi=0.0, more=(), kind="STANDARD"):
    """Return the lines of one surface."""
    lines = [f"SURF {number}", f"  TYPE {kind}", f'  CURV {curvature!r} 0 0 0 0 ""', "  HIDE 0 0 0 0 0 0 0 0 0 0"]
    lines += [f"  {line}" for line in more]
    lines += [f"  DISZ {thickness}"]
    lines += [f"  GLAS {glass}"] if glass else []
    lines += [f"  CONI {conic!r}"] if conic is not None else []
    return "\n".join([*lines, f'  DIAM {semi!r} 1 0 0 1 ""', ""])


def file(surfaces, aperture="ENPD 10", kind=0, heights=(0,), waves=(0.5875618,), primary=1, name="a lens"):
    """Return a whole file of surfaces: a list of keyword arguments for each, for the lens alone."""
    lines = "\n".join(f"WAVM {i} {wave} 1" for i, wave in enumerate((*waves, 0.55, 0.55), 1))
    head = SYSTEM.format(name=name, aperture=aperture, kind=kind, fields=len(heights), waves=len(waves), primary=primary,
                         heights=" ".join(map(str, heights)), wave_lines=lines)  # fmt: skip
    inner = [surface(i, **one) for i, one in enumerate(surfaces, 1)]
    return head + surface(0, thickness="INFINITY") + "".join(inner) + surface(len(surfaces) + 1)
