"""The decks of a test, and the cells at points of them."""

from pathlib import Path
from typing import Any

import numpy as np

import conicoid as co


def load_deck(folder: Path, text: str, **options: Any) -> co.Scene:
    """Return the scene of a deck."""
    path = folder / "deck.mcnp"
    path.write_text(text, encoding="utf-8")
    return co.load(path, **options)


def names_at(scene: co.Scene, points: Any) -> list[str | None]:
    """Return the name of the body at each point."""
    names = [body.name for body in scene.bodies]
    return [None if number < 0 else names[number] for number in np.asarray(scene.body_at(points)).tolist()]


def chosen(seed: int, count: int, reach: float) -> Any:
    """Return points in a cube about the origin."""
    return np.random.default_rng(seed).uniform(-reach, reach, (count, 3))
