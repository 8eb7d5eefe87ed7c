"""White light through a prism of flint, all of it: what each wall mirrors, and what it lets through."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

import conicoid as co

Progress = Callable[[int, int], None]
GLASS, APEX, ACROSS = "N-SF66", 50.0, 24
WAVES = np.linspace(0.40, 0.70, 160)  # μm
WIDTH, HEIGHT, VIEW = 760, 430, 7.0  # pixels; and how wide the view is
BEAM, HIGH = 0.03, 1.9  # half the width of the beam; how high the prism is


def prism() -> co.Scene:
    """A prism with its edges along z, the upper one at y = HIGH / 2."""
    c, s = math.cos(math.radians(APEX / 2)), math.sin(math.radians(APEX / 2))
    walls = [(c, s, 0), (-c, s, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    body = co.Polyhedron(walls, [s * HIGH / 2, s * HIGH / 2, HIGH / 2, 1, 1])
    return co.Scene([co.Body(body, co.glass(GLASS), name="prism")])


def least_deviation(wavelength: float) -> float:
    """Degrees D by which light is turned that goes through symmetrically: n = sin((A + D) / 2) / sin(A / 2)."""
    n = co.optics.glass(GLASS)(wavelength)
    return math.degrees(2 * math.asin(n * math.sin(math.radians(APEX / 2)))) - APEX


def beam(wavelength: float) -> tuple[co.Rays, np.ndarray]:
    """(rays, their wavelengths): white light, at the angle at which one colour goes through symmetrically."""
    turn = math.radians(least_deviation(wavelength) / 2)
    along, across = np.array([math.cos(turn), math.sin(turn), 0.0]), np.array([-math.sin(turn), math.cos(turn), 0.0])
    target = np.array([-0.55 * HIGH * math.tan(math.radians(APEX / 2)), -0.05 * HIGH, 0.0])
    places = target - 6 * along + np.linspace(-BEAM, BEAM, ACROSS)[:, None, None] * across
    waves = np.broadcast_to(WAVES, (ACROSS, len(WAVES)))
    return co.Rays(np.broadcast_to(places, (*waves.shape, 3)), along), waves


def color(wavelength: np.ndarray) -> np.ndarray:
    """Linear sRGB of single wavelengths, as far as it has them (Wyman, Sloan and Shirley, JCGT 2(2), 2013)."""

    def bell(height: float, middle: float, below: float, above: float) -> np.ndarray:
        t = 1000 * (wavelength - middle)
        return height * np.exp(-0.5 * (t / np.where(t < 0, below, above)) ** 2)

    x = bell(1.056, 0.5998, 37.9, 31.0) + bell(0.362, 0.442, 16.0, 26.7) + bell(-0.065, 0.5011, 20.4, 26.2)
    y = bell(0.821, 0.5688, 46.9, 40.5) + bell(0.286, 0.5309, 16.3, 31.1)
    z = bell(1.217, 0.437, 11.8, 36.0) + bell(0.681, 0.459, 26.0, 13.8)
    matrix = [[3.2404542, -1.5371385, -0.4985314], [-0.969266, 1.8760108, 0.041556], [0.0556434, -0.2040259, 1.0572252]]
    rgb = np.maximum(np.stack([x, y, z], -1) @ np.transpose(matrix), 0)
    return rgb / rgb.mean(axis=0)


def drawn(paths: co.optics.Paths, scale: float) -> np.ndarray:
    """The light of all segments in the plane z = 0, added up: (height, width, 3)."""
    width, height = round(WIDTH * scale), round(HEIGHT * scale)
    step, total = VIEW / width, np.zeros((height * width, 3))
    light = color(paths.wavelength) * paths.weight[:, None]
    both = paths.lines(VIEW)
    length = np.linalg.norm(both[:, 1] - both[:, 0], axis=1)
    counts = np.ceil(length / step).astype(int)
    first = np.cumsum(counts) - counts
    for begin in range(0, len(counts), 2000):  # a point of each segment for each pixel
        rows = slice(begin, begin + 2000)
        which = np.repeat(np.arange(len(counts))[rows], counts[rows])
        share = (np.arange(len(which)) - (first[which] - first[begin]) + 0.5) / counts[which]
        at = both[which, 0] + (both[which, 1] - both[which, 0]) * share[:, None]
        column = np.floor(at[:, 0] / step + width / 2).astype(int)
        row = np.floor(height / 2 - at[:, 1] / step).astype(int)
        seen = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        pixel = row[seen] * width + column[seen]
        for channel in range(3):
            total[:, channel] += np.bincount(pixel, light[which[seen], channel], height * width)
    return total.reshape(height, width, 3)


def picture(progress: Progress | None = None, scale: float = 1.0) -> co.Image:
    """The picture, `scale` times its full size."""
    scene = prism()
    rays, waves = beam(0.53)
    light = drawn(co.optics.trace_paths(scene, rays, depth=6, wavelength=waves), scale)
    height, width = light.shape[:2]
    x, y = np.meshgrid(np.arange(width) + 0.5 - width / 2, height / 2 - np.arange(height) - 0.5)
    inside = scene.contains(np.stack([x, y, 0 * x], -1) * VIEW / width)
    glass = np.where(inside[..., None], (0.025, 0.032, 0.042), (0.003, 0.003, 0.004))
    bright = light / rays.size * 60 * scale
    if progress is not None:
        progress(1, 1)
    return co.Image(np.minimum(glass + bright / (1 + bright), 1.0).astype(np.float32))


if __name__ == "__main__":
    for line, wave in (("C", 0.6562725), ("d", 0.5875618), ("F", 0.4861327)):
        print(f"{line}: n = {co.optics.glass(GLASS)(wave):.6f}, least deviation {least_deviation(wave):.4f}°")
    picture().save("prism.webp")
