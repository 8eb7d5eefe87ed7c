"""An aspheric doublet: three conic constants and the place of the film, found by the derivatives of the spot.

A cemented achromat of f = 100 at f / 4 has spherical aberration. Rays are traced from wall to wall, their derivatives
with them: `hits.jvp` says how a hit and its normal move, `co.derivatives.refract_jvp` how the refracted ray turns.
Gauss's method for least squares then finds the conics in a few steps.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import conicoid as co

RADII, THICKNESSES, INDICES = (62.8, -45.7, -128.2), (4.0, 2.5), (1.0, 1.5168, 1.6727, 1.0)
"""Lenses of N-BK7 and SF5 at 588 nm; lengths in mm."""
APERTURE, FIELDS, FOCUS = 12.0, (0.0, 0.2, 0.4), 97.1
START = np.array([0.0, 0.0, 0.0, FOCUS])
"""Three conic constants, of spheres, and the distance of the film from the last vertex."""


def surface(radius: float, conic: float, z: float) -> co.Quadric:
    """x² + y² - 2 R z + (1 + κ) z² <= 0 about the vertex: the side of the wall where its center of curvature is."""
    coefficients = dict(xx=1, yy=1, zz=1 + conic, z=-2 * radius)
    return co.Quadric(coefficients=coefficients).translate((0, 0, z))


def walls(conics: Any) -> list[co.Scene]:
    """The three walls, each a scene: in a sequence of surfaces the next one is known."""
    places = np.concatenate([[0.0], np.cumsum(THICKNESSES)])
    return [co.Scene([co.Body(surface(*each), name="wall")]) for each in zip(RADII, conics, places, strict=True)]


def pupil(rings: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions (fields, rays, 3): rings of rays on the entrance, for each angle in degrees."""
    points = [(0.0, 0.0)]
    for ring in range(1, rings + 1):
        angles = 2 * np.pi * np.arange(6 * ring) / (6 * ring)
        radius = APERTURE * ring / rings
        points += list(zip(radius * np.cos(angles), radius * np.sin(angles), strict=True))
    flat = np.array([(x, y, 0.0) for x, y in points])
    tilts = np.radians(FIELDS)
    directions = np.array([(0.0, np.sin(a), np.cos(a)) for a in tilts])[:, None]
    return flat - 10 * directions, np.broadcast_to(directions, (len(FIELDS), len(flat), 3))


def trace(unknowns: np.ndarray, rings: int = 6, moved_by: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """(spots (fields, rays, 2), their derivatives (unknowns, fields, rays, 2)) on the film.

    moved_by: how many of the unknowns, from the first, are of interest.
    """
    points, directions = pupil(rings)
    d_points, d_directions = np.zeros((2, 4, *points.shape))
    for k, scene in enumerate(walls(unknowns[:3])):
        hits = scene.first_hit(points, directions)
        conic = co.parameters(scene, "wall.coefficients.zz")
        eta = INDICES[k] / INDICES[k + 1]
        for i in range(moved_by):
            moved = hits.jvp(conic, [float(i == k)], d_origins=d_points[i], d_directions=d_directions[i])
            d_points[i] = moved.point
            d_directions[i] = co.derivatives.refract_jvp(directions, hits.normal, eta, d_directions[i], moved.normal)
        points, directions = hits.point, co.refract(directions, hits.normal, eta)[0]
    film = sum(THICKNESSES) + unknowns[3]
    t = (film - points[..., 2]) / directions[..., 2]
    d_film = np.array([0.0, 0.0, 0.0, 1.0])[:, None, None]
    d_t = (d_film - d_points[..., 2] - t * d_directions[..., 2]) / directions[..., 2]
    spots = points + t[..., None] * directions
    d_spots = d_points + t[..., None] * d_directions + d_t[..., None] * directions
    return spots[..., :2], d_spots[..., :2]


def about_their_middle(spots: np.ndarray) -> np.ndarray:
    """Spots (..., fields, rays, 2) about the middle of each field's."""
    return spots - spots.mean(axis=-2, keepdims=True)


def spot_size(unknowns: np.ndarray) -> float:
    """Root mean square distance from the middle of a field's spot, in mm."""
    spots = about_their_middle(trace(unknowns, moved_by=0)[0])
    return float(np.sqrt((spots**2).sum(axis=-1).mean()))


def solve(start: np.ndarray = START, free: tuple[int, ...] = (0, 1, 2, 3), steps: int = 12) -> np.ndarray:
    """Gauss's method for least squares, damped as Levenberg and Marquardt do."""
    unknowns, damping = np.array(start), 1e-6
    for _ in range(steps):
        spots, slopes = (about_their_middle(each) for each in trace(unknowns))
        rest, matrix = spots.ravel(), slopes[list(free)].reshape(len(free), -1).T
        normal = matrix.T @ matrix
        change = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), -matrix.T @ rest)
        trial = unknowns.copy()
        trial[list(free)] += change
        better = spot_size(trial) < spot_size(unknowns)
        unknowns, damping = (trial, damping / 10) if better else (unknowns, damping * 100)
    return unknowns


def picture(scale: float = 1.0) -> co.Image:
    """The spots of three fields, 16 µm wide: above of spheres with the film at its best place, below of conics."""
    size, width = max(8, round(160 * scale)), 0.016
    rows = []
    for unknowns in (solve(free=(3,)), solve()):
        spots = about_their_middle(trace(unknowns, rings=24 if scale > 0.5 else 6, moved_by=0)[0])
        places = np.floor((spots / width + 0.5) * size).astype(int)
        panels = []
        for field in places:
            counts = np.zeros((size, size))
            inside = ((field >= 0) & (field < size)).all(axis=1)
            np.add.at(counts, (size - 1 - field[inside, 1], field[inside, 0]), 1)
            panels.append(np.pad(np.sqrt(np.minimum(counts, 16)), 2, constant_values=1.0))
        rows.append(np.concatenate(panels, axis=1))
    return co.Image(np.concatenate(rows), colormap="dusk", vmin=0, vmax=4)


if __name__ == "__main__":
    spheres, conics = solve(free=(3,)), solve()
    print(f"spheres:  film at {spheres[3]:.4f} mm, spot {1e3 * spot_size(spheres):.3f} µm")
    print(f"conics {conics[:3].round(4)}:  film at {conics[3]:.4f} mm, spot {1e3 * spot_size(conics):.3f} µm")
    picture().save("aspheric_doublet.png")
