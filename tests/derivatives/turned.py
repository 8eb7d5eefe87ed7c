"""The walls of lenses, of what is turned about an axis, and of flat faces, by the formulas that docstrings state."""

from __future__ import annotations

from typing import Any

from .plain import cross, dot, minus, mp, turns

# Conics of optics, about the vertex


def sag(radius: Any, conic: Any, r: Any) -> Any:
    """c r² / (1 + sqrt(1 - (1 + k) c² r²)); beyond the equator something real, which nobody asks for."""
    if not mp.isfinite(radius):
        return mp.mpf(0)
    return r * r / (radius * (1 + mp.sqrt(abs(1 - (1 + conic) * r * r / radius**2))))


def bent(radius: Any, conic: Any, semi: Any, edge: Any, y: Any) -> tuple[Any, Any]:
    """The curved part out to `semi`, or the plane where it is flat."""
    if not mp.isfinite(radius):
        return y[2], (y[0] / edge, y[1] / edge)
    f = y[0] ** 2 + y[1] ** 2 + (1 + conic) * y[2] ** 2 - 2 * radius * y[2]
    return f, (turns(y[0], y[1]), y[2] / sag(radius, conic, semi))


def conic(s: Any, face: int, y: Any) -> tuple[Any, Any]:
    r = s.aperture / 2
    if face == 0:
        return bent(s.radius_of_curvature, s.conic_constant, r, r, y)
    return y[2] - sag(s.radius_of_curvature, s.conic_constant, r), (y[0] / r, y[1] / r)


def around(radius: Any, ends: Any, y: Any) -> tuple[Any, Any]:
    """A cylinder between two heights."""
    low, high = sorted(ends)
    return y[0] ** 2 + y[1] ** 2 - radius**2, (turns(y[0], y[1]), (y[2] - low) / (high - low) if low < high else y[2])


def lens(s: Any, face: int, y: Any) -> tuple[Any, Any]:
    edge = s.diameter / 2
    semis = [(aperture or s.diameter) / 2 for aperture in (s.front_aperture, s.back_aperture)]
    walls = (s.front_radius, s.front_conic, semis[0]), (s.back_radius, s.back_conic, semis[1])
    heights = mp.mpf(0), s.thickness
    if face < 2:
        return bent(*walls[face], edge, [y[0], y[1], y[2] - heights[face]])
    rims = [height + sag(*one) for height, one in zip(heights, walls, strict=True)]
    if face > 2:
        return y[2] - rims[face - 3], (y[0] / edge, y[1] / edge)
    f, (u, v) = around(edge, rims, y)
    return f, (u, v if rims[0] < rims[1] else y[2])


def mirror(s: Any, face: int, y: Any) -> tuple[Any, Any]:
    r = s.diameter / 2
    if face == 0:
        return bent(s.radius_of_curvature, s.conic_constant, r, r, y)
    if face == 1:
        return y[2] - s.thickness, (y[0] / r, y[1] / r)
    return around(r if face == 2 else s.hole / 2, (sag(s.radius_of_curvature, s.conic_constant, r), s.thickness), y)


# Outlines


def through(corners: Any, x: Any) -> tuple[Any, Any]:
    a, b, c = corners[:3]
    return dot(cross(minus(b, a), minus(c, a)), minus(x, a)), None


def mesh(s: Any, face: int, x: Any) -> tuple[Any, Any]:
    return through([s.vertices[int(k)] for k in s.faces[face]], x)


def extrusion(s: Any, face: int, y: Any) -> tuple[Any, Any]:
    low, high = s.z_range
    if face >= len(s.outline):
        return y[2] - (low if face == len(s.outline) else high), None
    (a, b), (c, d) = s.outline[face], s.outline[(face + 1) % len(s.outline)]
    return through([[a, b, low], [c, d, low], [(a + c) * s.scale_at_top / 2, (b + d) * s.scale_at_top / 2, high]], y)


def revolution(s: Any, face: int, y: Any) -> tuple[Any, Any]:
    if face >= len(s.profile):
        angle = (s.start_angle if face == len(s.profile) else s.end_angle) * mp.pi / 180
        c, sine = mp.cos(angle), mp.sin(angle)
        widest, highest = max(r for r, _ in s.profile), max(abs(z) for _, z in s.profile)
        return sine * y[0] - c * y[1], ((c * y[0] + sine * y[1]) / widest, y[2] / highest)
    (r, z), (end, top) = s.profile[face], s.profile[(face + 1) % len(s.profile)]
    if abs(z - top) < mp.mpf(10) ** -9:
        widest = max(r, end)
        return y[2] - z, (y[0] / widest, y[1] / widest)
    radius = r + (end - r) * (y[2] - z) / (top - z)
    low, high = sorted((z, top))
    return y[0] ** 2 + y[1] ** 2 - radius**2, (turns(y[0], y[1]), (y[2] - low) / (high - low))
