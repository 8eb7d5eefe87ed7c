"""A CT scan of unknown ellipsoids: their places, sizes, turns and densities found from the sinogram.

Nothing is cut into voxels. `spans.jvp` says how every line integral changes with every number of every ellipsoid, also
at outlines, where pictures of voxels have no derivative; Gauss's method does the rest, starting from three plain balls.
"""

from __future__ import annotations

import numpy as np

import conicoid as co

TRUE = [
    ((0.9, 0.5, 0.7), 25.0, (1.1, 0.6, -0.2), 1.5),
    ((0.4, 0.8, 0.5), -40.0, (-1.0, -0.9, 0.4), 0.8),
    ((0.6, 0.35, 0.4), 70.0, (-0.3, 1.3, 0.1), -0.6),
]
"""Half-axes, degrees about z, middle, density above that of the surroundings."""
GUESS = [((0.6, 0.5, 0.6), 5.0, place, 1.0) for place in ((0.8, 0.4, 0.0), (-0.8, -0.6, 0.0), (-0.1, 1.0, 0.0))]
BACKGROUND = 1.0
SIZE, ANGLES = 20, np.arange(0, 180, 15)


def scene(figures: list) -> co.Scene:
    """The ellipsoids in a cylinder of water."""
    parts = [
        co.Body(co.Ellipsoid(radii).rotate("z", degrees).translate(middle), name=f"part{k}")
        for k, (radii, degrees, middle, _) in enumerate(figures)
    ]
    return co.Scene([co.Body(co.Cylinder((0, 0, -1.5), (0, 0, 1.5), 2.5), name="water"), *parts])


def densities(figures: list) -> np.ndarray:
    """Of the bodies, which overlap: the parts add to the water."""
    return np.array([BACKGROUND, *(density for *_, density in figures)])


def scan() -> co.Rays:
    """Parallel rays, (views, rows, columns), from outside of the water."""
    turn = np.radians(ANGLES)[:, None, None]
    height = ((np.arange(SIZE // 2) + 0.5) / (SIZE // 2) * 3 - 1.5)[:, None]
    aside = (np.arange(SIZE) + 0.5) / SIZE * 5 - 2.5
    forward = np.stack(np.broadcast_arrays(np.cos(turn), np.sin(turn), 0.0), axis=-1)
    origins = np.stack(np.broadcast_arrays(-aside * np.sin(turn), aside * np.cos(turn), height), axis=-1)
    return co.Rays(origins - 5 * forward, forward)


def unknowns(of: co.Scene) -> co.Parameters:
    """Half-axes, middles and turns; the axes of the turns are known."""
    return co.parameters(of, ["part*.radii*", "part*.degrees", "part*.offset*"])


def recovered(sinogram: np.ndarray, rays: co.Rays, steps: int = 25) -> tuple[co.Scene, np.ndarray, list[float]]:
    """(the scene, its densities, how far its sinogram was off after each step)."""
    at, values, damping = scene(GUESS), densities(GUESS), 1e-2
    spans = at.spans(rays)
    rest, history = spans.line_integral(values, overlaps="both") - sinogram, []
    for _ in range(steps):
        numbers = unknowns(at)
        columns = [spans.jvp(numbers, one).line_integral(values).ravel() for one in np.eye(len(numbers))]
        columns += list(np.moveaxis(spans.lengths(), -1, 0)[1:].reshape(len(values) - 1, -1))
        matrix = np.array(columns).T
        normal, right = matrix.T @ matrix, -matrix.T @ rest.ravel()
        while damping < 1e8:
            change = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), right)
            trial_values = values + np.concatenate([[0.0], change[len(numbers) :]])
            try:
                trial = numbers.scene(numbers.values + change[: len(numbers)])
            except ValueError:  # a half-axis below 0
                damping *= 10
                continue
            found = trial.spans(rays)
            off = found.line_integral(trial_values, overlaps="both") - sinogram
            if (off**2).sum() < (rest**2).sum():
                at, values, spans, rest, damping = trial, trial_values, found, off, damping / 10
                break
            damping *= 10
        history.append(float(np.sqrt((rest**2).mean())))
        if damping >= 1e8 or history[-1] < 1e-13:
            break
    return at, values, history


def picture(scale: float = 1.0) -> co.Image:
    """Views of the scanned, the guessed and the recovered ellipsoids, one above the other."""
    rays = scan()
    truth = scene(TRUE).line_integral(densities(TRUE), rays, overlaps="both")
    at, values, _ = recovered(truth, rays, steps=25 if scale > 0.5 else 2)
    size = max(8, round(160 * scale))
    view = co.OrthographicCamera((0, 0, 9), (0, 0, 0), up=(0, 1, 0), height=5.4).rays(size, size)
    parts = ((scene(TRUE), densities(TRUE)), (scene(GUESS), densities(GUESS)), (at, values))
    panels = [np.pad(one.line_integral(each, view, overlaps="both"), 2, constant_values=5.0) for one, each in parts]
    return co.Image(np.concatenate(panels, axis=1), colormap="grey", vmin=0)


if __name__ == "__main__":
    rays = scan()
    sinogram = scene(TRUE).line_integral(densities(TRUE), rays, overlaps="both")
    at, values, history = recovered(sinogram, rays)
    print("sinogram off by", *(f"{off:.2g}" for off in history))
    for name, value, true in zip(unknowns(at).names, unknowns(at).values, unknowns(scene(TRUE)).values, strict=True):
        print(f"{name:<26}{value:>12.8f}   scanned: {true:g}")
    print("densities", values.round(8))
    picture().save("recovered_ellipsoids.png")
