"""`SceneLike`: the parts of a `Scene` that the packages below `conicoid.scene` use.

`Scene` is the facade on top and imports every package below it, so none of these may import it. They annotate their
arguments with this protocol and recognise a scene with `is_scene`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeGuard, overload

if TYPE_CHECKING:
    import numpy as np

    from .._util.records import BoxEnds, FloatArray
    from ..geometry.body import Body
    from ..geometry.bounds.aabb import Bounds
    from ..geometry.entries import Bodies
    from ..geometry.shape import Solid
    from ..prepare.prepared_scene import PreparedScene
    from .hits import Hits
    from .points import BodiesAt
    from .spans import Crossings, Spans

_MARKERS = ("bodies", "first_hit")
"""Members that `is_scene` looks for. Shapes and bodies have neither; a prepared scene has no `first_hit`."""


class SceneLike(Protocol):
    """Bodies, lights, a camera and a background, with queries along rays and at points.

    `conicoid.scene.scene.Scene` documents the members. Cameras, lights and backgrounds have the type `Any` here, since
    their classes belong to higher layers.
    """

    _cached_prepared: PreparedScene | None
    """`_prepared`, or None before the first query."""

    def __init__(self, items: Any = (), lights: Any = (), camera: Any = None, *, unit: str | None = None) -> None: ...

    def _close_gaps(self) -> None: ...

    @property
    def bodies(self) -> Bodies: ...

    @property
    def lights(self) -> tuple[Any, ...]: ...

    @property
    def camera(self) -> Any: ...

    @property
    def background(self) -> Any: ...

    @property
    def domain(self) -> Solid | None: ...

    @property
    def unit(self) -> str | None: ...

    @property
    def materials(self) -> tuple[Any, ...]: ...

    @property
    def body_count(self) -> int: ...

    @property
    def extent(self) -> BoxEnds: ...

    @property
    def bounds(self) -> Bounds: ...

    @property
    def _prepared(self) -> PreparedScene:
        """The tables and the tree, built on first use."""

    @property
    def _firsts(self) -> Any:
        """The first body number of each entry, and last the number of bodies."""

    @property
    def _parts(self) -> tuple[Any, ...]:
        """The arguments of `Scene` that give an equal scene."""

    def __len__(self) -> int: ...

    def body(self, number: Any) -> Body: ...

    @overload
    def __getitem__(self, name: str | int | np.integer[Any]) -> Body: ...

    @overload
    def __getitem__(self, name: slice) -> tuple[Body, ...]: ...

    def __getitem__(self, name: Any) -> Any: ...

    def first_hit(
        self,
        origins: Any,
        directions: Any = None,
        t_min: Any = 0.0,
        t_max: Any = 0.0,
        *,
        executor: Any = None,
        device: Literal["cpu", "cuda"] | None = None,
    ) -> Hits: ...

    def occluded(
        self,
        origins: Any,
        directions: Any = None,
        t_min: Any = 0.0,
        t_max: Any = 0.0,
        *,
        executor: Any = None,
        device: Literal["cpu", "cuda"] | None = None,
    ) -> Any: ...

    def spans(
        self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = 0.0, *, executor: Any = None
    ) -> Spans: ...

    def crossings(
        self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = 0.0, *, executor: Any = None
    ) -> Crossings: ...

    def lengths(
        self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = 0.0, *, executor: Any = None
    ) -> FloatArray: ...

    def line_integral(
        self, values: Any, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = 0.0, *,
        otherwise: Any = None, overlaps: Literal["both", "error"] | None = None, executor: Any = None,
    ) -> Any: ...  # fmt: skip

    def stream(
        self, rays: Any, query: str = "first_hit", *, chunk: int | None = None, executor: Any = None, **options: Any
    ) -> Any: ...

    def contains(self, points: Any, *, executor: Any = None, device: Literal["cpu", "cuda"] | None = None) -> Any: ...

    def body_at(self, points: Any, *, executor: Any = None, device: Literal["cpu", "cuda"] | None = None) -> Any: ...

    def bodies_at(self, points: Any, *, executor: Any = None) -> BodiesAt: ...

    def at(self, time: float) -> SceneLike: ...

    def fitting_camera(self, aspect: float = 4 / 3) -> Any: ...

    def _edited(self, bodies: Bodies, *parts: Any) -> SceneLike:
        """Return a scene of other bodies, which reuses prepared tables; `parts` replace those after the bodies."""


def is_scene(thing: object) -> TypeGuard[SceneLike]:
    """Return whether `thing` is a scene.

    The class decides, so no property runs: an `isinstance` check of a protocol would prepare the scene.
    """
    members: list[Mapping[str, Any]] = [vars(kind) for kind in type(thing).__mro__]
    return all(any(name in own for own in members) for name in _MARKERS)
