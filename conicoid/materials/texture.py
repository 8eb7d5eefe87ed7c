"""Patterns and textures: colours that vary over a surface or through space, and their mean colours."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import fields
from functools import partial
from typing import Any, ClassVar, Literal, TypeAlias, get_args

import numpy as np

from .._util.records import dataclass
from .._util.text import check_choice
from .._util.validation import (
    as_integer,
    check_fields,
    check_flag,
    check_nonnegative,
    check_number,
    check_numbers,
    check_positive,
    format_value,
    warn,
)
from .color import BYTE, Color, check_color, linear_rgb
from .image_file import Pixels, image_array, read_pixels

Scale: TypeAlias = float | tuple[float, float] | tuple[float, float, float]


@dataclass(frozen=True)
class Checker:
    """Squares (or cubes) of two colours: `a` where the sum of floor(coordinate / scale) is even, `b` where it is odd.

    In space the colour is taken just under the surface (scale / 2²⁰ deep, against the normal). So a wall on a boundary
    of the cubes has the one colour of the matter behind it.

    Parameters
    ----------
    a, b : Color
        The two colours.
    scale : float or tuple of 2 or 3 floats
        Side of a square in uv, or of a cube in world units with `space=True`. Two or three numbers are the sides along
        each coordinate.
    space : bool
        Cubes in space, not squares in uv.
    """

    a: Color = (0.8, 0.8, 0.8)
    b: Color = (0.1, 0.1, 0.1)
    scale: Scale = 1.0
    space: bool = False

    def __post_init__(self) -> None:
        # The dataclass is frozen: normalised fields are set around it.
        check_fields(self, a=check_color, b=check_color, scale=partial(_check_scale, most=3), space=check_flag)

    @property
    def scales(self) -> tuple[float, float, float]:
        """Sides along each of three coordinates."""
        if isinstance(self.scale, tuple):
            return (*self.scale, 1.0) if len(self.scale) == 2 else self.scale
        return self.scale, self.scale, self.scale


def _check_scale(owner: str, field: str, scale: Any, most: int = 2) -> Any:
    """Return one side, or the sides along two coordinates, or along `most`."""
    if not hasattr(scale, "__len__") or isinstance(scale, str) or getattr(scale, "ndim", 1) == 0:
        return check_positive(owner, field, scale)
    return _check_sides(owner, field, scale, 2 if len(scale) == 2 else most)


# Textures. Their coordinates are `scale` times as fine as the coordinates of the mapping, and begin at `offset`.
# Mappings are
#
# - "uv": the surface's own coordinates;
# - "latitude": on balls and other bodies of revolution, u and the latitude from south to north,
#   asin(2 v - 1) / 180° + 1/2: maps of the Earth where longitude and latitude are equally spaced;
# - "box": two axes of the world, across the one along which the normal is longest.

TextureMapping: TypeAlias = Literal["uv", "latitude", "box"]
Wrap: TypeAlias = Literal["repeat", "clamp", "mirror"]
Along: TypeAlias = Literal["u", "v", "x", "y", "z"]
Sides: TypeAlias = float | tuple[float, float]


_BRIGHTEST_TEXEL = 16
"""Times white: most textures have no brighter pixel."""


class ImagePath(str):
    """The name of an image file; in a scene file relative to its folder."""


def _check_sides(owner: str, field: str, value: Any, count: int = 2) -> Any:
    """Return the sides along some coordinates."""
    return tuple(
        check_positive(owner, f"{field}[{i}]", side) for i, side in enumerate(check_numbers(owner, field, value, count))
    )


def pair_sides(sides: Sides) -> tuple[float, float]:
    """Return two sides, of one or two."""
    return sides if isinstance(sides, tuple) else (sides, sides)


@dataclass(frozen=True, eq=False)
class ImageTexture:
    """A picture on a surface: once from u = 0 to 1, and from v = 0, its lower edge, to 1.

    Pixels are interpolated. Where the texture is small in a picture, smaller copies of it are read.

    Parameters
    ----------
    image : path or array_like
        A file, .png, .jpg, .webp or .exr, or an array (height, width, 3) as for `Image`. Files are read at once; a
        scene file may name those in its own folder, or below.
    mapping : {"uv", "latitude", "box"}
        Coordinates of the picture.
    scale : float or (float, float)
        Size in these coordinates, one number or one for each.
    offset : (float, float)
        Place of the lower left corner.
    wrap : {"repeat", "clamp", "mirror"} or two of them
        Content beyond the edges, at the sides and above and below: the picture again, its last pixels, or its mirror
        image; one word for both, or two. On "latitude" nothing is above and below.
    data : bool
        The numbers are plain data, as roughness or normals, and no colours in sRGB.

    Raises
    ------
    ValueError
        If a file cannot be read, or a field is out of range.
    """

    image: ImagePath
    mapping: TextureMapping = "uv"
    scale: Sides = 1.0
    offset: tuple[float, float] = (0.0, 0.0)
    wrap: Wrap | tuple[Wrap, Wrap] = ("repeat", "clamp")
    data: bool = False
    # No field of the dataclass: set per instance, so that `fields` and `replace` see only the arguments.
    pixels: ClassVar[Pixels]
    """The decoded picture."""

    def __post_init__(self) -> None:
        name = "ImageTexture"
        check_fields(self, mapping=_check_mapping, scale=_check_scale, offset=_check_pair)
        wraps = self.wrap if isinstance(self.wrap, tuple | list) else (self.wrap, self.wrap)
        if len(wraps) != 2:
            raise ValueError(f"{name}: wrap must be a word, or two, got {format_value(self.wrap)}")
        first, second = (check_choice(name, "wrap", each, get_args(Wrap)) for each in wraps)
        vars(self).update(wrap=(first, second), data=check_flag(name, "data", self.data))
        pixels = _pixels_of(self.image)
        # An absolute path, as the working directory may change before the scene is saved.
        is_file = isinstance(self.image, str | os.PathLike)
        vars(self).update(pixels=pixels, image=ImagePath(os.path.abspath(self.image)) if is_file else pixels)

    @property
    def mean(self) -> tuple[float, float, float]:
        """Mean of all pixels, in linear light."""
        r, g, b = self.pixels.linear(self.data).mean(axis=(0, 1), dtype=np.float64).tolist()
        return r, g, b

    def __repr__(self) -> str:
        from_file = isinstance(self.image, str)
        width, height = self.pixels.size
        image = repr(str(self.image)) if from_file else f"<{width} x {height}, {self.pixels.digest}>"
        rest = [
            f"{one.name}={getattr(self, one.name)!r}"
            for one in fields(self)[1:]
            if repr(getattr(self, one.name)) != repr(one.default)
        ]
        return f"ImageTexture({', '.join([image, *rest])})"

    def _key(self) -> tuple[Any, ...]:
        """Return the values that equality and hashes use."""
        rest = tuple(getattr(self, one.name) for one in fields(self)[1:])
        # The digest stands for the pixels, so that equal pictures from two files are equal.
        return self.pixels.digest, *rest

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ImageTexture) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())


def _pixels_of(image: Any) -> Pixels:
    """Return the pixels of a file or an array."""
    if isinstance(image, Pixels):
        return image
    if isinstance(image, str | os.PathLike):
        try:
            return read_pixels(image)
        except ValueError as error:
            raise ValueError(f"ImageTexture: image {error}") from None
    array = image_array("ImageTexture", "image", image)
    if array.dtype != np.uint8:
        array = array.astype(np.float32)
        # Most values above white, and no more than 255: probably bytes as floats.
        if np.count_nonzero(array > 1) * 2 > array.size and _BRIGHTEST_TEXEL < (most := float(array.max())) <= BYTE:
            hint = f"most numbers of the array, up to {most:g}, are beyond 1, which is white"
            warn(f"ImageTexture: {hint}: colours are linear light, or sRGB bytes in uint8")
    if array.ndim != 3 or array.shape[2] != 3 or array.size == 0:
        raise ValueError(f"ImageTexture: image must be a file or have shape (height, width, 3), got {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError("ImageTexture: image must hold finite numbers")
    return Pixels(np.array(array))


# Patterns by a formula.


@dataclass(frozen=True)
class Gradient:
    """A ramp from `a` to `b` along a coordinate; beyond its ends it has their colours.

    Parameters
    ----------
    a, b : Color
        Colours at the beginning and at the end.
    along : {"u", "v", "x", "y", "z"}
        The coordinate: u or v of the surface, or x, y or z of the world.
    length : float
        Length of the ramp.
    offset : float
        Coordinate of its beginning.
    """

    a: Color = (0.0, 0.0, 0.0)
    b: Color = (1.0, 1.0, 1.0)
    along: Along = "v"
    length: float = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "along", check_choice("Gradient", "along", self.along, get_args(Along)))
        check_fields(self, a=check_color, b=check_color, length=check_positive, offset=check_number)


@dataclass(frozen=True)
class Noise:
    """Clouds of `a` and `b` in space: Perlin's noise (Improving noise, 2002), a sum of octaves.

    Each octave is half as large and half as strong as the one before. The sum n, between -1 and 1, becomes the share
    (1 + contrast · n) / 2 of `b`, cut to [0, 1].

    Parameters
    ----------
    a, b : Color
        The two colours.
    scale : float
        Size of the features of the first octave, about.
    octaves : int
        Number of octaves, 1 to 16.
    contrast : float
        Factor of the sum, >= 0.
    """

    a: Color = (0.0, 0.0, 0.0)
    b: Color = (1.0, 1.0, 1.0)
    scale: float = 1.0
    octaves: int = 4
    contrast: float = 1.5

    def __post_init__(self) -> None:
        check_fields(
            self, a=check_color, b=check_color, scale=check_positive, octaves=_octaves, contrast=check_nonnegative
        )


@dataclass(frozen=True)
class Wood:
    """Rings around a vertical trunk: dark `late` wood at the end of each, `early` wood before it.

    Parameters
    ----------
    early, late : Color
        Colours of the wood.
    ring : float
        Thickness of a ring.
    offset : (float, float)
        (x, y) of the trunk's middle.
    roughness : float
        How far rings are out of round, in rings.
    """

    early: Color = (0.55, 0.33, 0.15)
    late: Color = (0.28, 0.14, 0.05)
    ring: float = 0.1
    offset: tuple[float, float] = (0.0, 0.0)
    roughness: float = 0.6

    def __post_init__(self) -> None:
        check_fields(
            self,
            early=check_color,
            late=check_color,
            ring=check_positive,
            offset=_check_pair,
            roughness=check_nonnegative,
        )


PlainPattern: TypeAlias = Color | ImageTexture | Gradient | Noise | Wood


@dataclass(frozen=True)
class Brick:
    """A wall in running bond: every other course is shifted by half a brick.

    Parameters
    ----------
    bricks, mortar : Color or texture
        Their colours.
    size : (float, float)
        (length, height) of a brick with its joint.
    joint : float
        Width of the joint, less than both of `size`.
    variation : float
        Spread of the brightness of bricks, in [0, 1]; at 0.2 each is 0.8 to 1.2 times as bright.
    mapping : {"box", "uv", "latitude"}
        "box" is for walls in the world.
    """

    bricks: PlainPattern = (0.45, 0.13, 0.08)
    mortar: PlainPattern = (0.6, 0.58, 0.55)
    size: tuple[float, float] = (0.25, 0.083)
    joint: float = 0.01
    variation: float = 0.2
    mapping: TextureMapping = "box"

    def __post_init__(self) -> None:
        check_fields(
            self,
            bricks=_check_plain,
            mortar=_check_plain,
            size=_check_sides,
            joint=check_nonnegative,
            variation=check_nonnegative,
            mapping=_check_mapping,
        )
        if self.joint >= min(self.size):
            raise ValueError(f"Brick: joint must be less than both of size, got {self.joint} of {self.size}")
        if self.variation > 1:
            raise ValueError(f"Brick: variation must be in [0, 1], got {self.variation}")


# A Checker is a pattern of colours only: as a texture of roughness or bumps it has no meaning.

Texture: TypeAlias = ImageTexture | Gradient | Noise | Wood | Brick
Pattern: TypeAlias = Checker | ImageTexture | Gradient | Noise | Wood | Brick
TEXTURES = (ImageTexture, Gradient, Noise, Wood, Brick)
PATTERNS = (Checker, *TEXTURES)


def _check_mapping(owner: str, field: str, value: Any) -> Any:
    return check_choice(owner, field, value, get_args(TextureMapping))


def _check_pair(owner: str, field: str, value: Any) -> Any:
    return check_numbers(owner, field, value, 2)


def _check_plain(owner: str, field: str, value: Any) -> Any:
    """Return a texture of one part as it is, or a colour."""
    return value if isinstance(value, ImageTexture | Gradient | Noise | Wood) else check_color(owner, field, value)


def _octaves(owner: str, field: str, value: Any) -> int:
    """Return a whole number from 1 to 16."""
    count = as_integer(value)
    if count is None or not 1 <= count <= 16:
        raise ValueError(f"{owner}: {field} must be a whole number from 1 to 16, got {format_value(value)}")
    return count


# One value for a pattern, for outputs without patterns.


def mean_color(pattern: Any) -> tuple[float, float, float]:
    """Return one colour for a pattern: a mean, or the first colour of a Checker and the bricks of a Brick."""
    if isinstance(pattern, ImageTexture):
        return pattern.mean
    if isinstance(pattern, Brick):
        return mean_color(pattern.bricks)
    if isinstance(pattern, Checker):
        return linear_rgb(pattern.a)
    ends: Iterable[Any] = ()
    if isinstance(pattern, Gradient | Noise):
        ends = pattern.a, pattern.b
    elif isinstance(pattern, Wood):
        ends = pattern.early, pattern.late
    else:
        return linear_rgb(pattern)
    (ar, ag, ab), (br, bg, bb) = map(linear_rgb, ends)
    return (ar + br) / 2, (ag + bg) / 2, (ab + bb) / 2


def mean_grey(pattern: Any) -> float:
    """Return one number for a pattern of numbers, in [0, 1]."""
    return min(1.0, max(0.0, sum(mean_color(pattern)) / 3))
