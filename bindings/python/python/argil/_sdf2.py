"""Profiles: solids of two dimensions.

In a scene, a profile is a solid that is the same at every z, as an endless prism.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, SupportsFloat

from . import _native, _output
from ._arrays import as_points
from ._numbers import (
    ENDLESS,
    Vector2,
    half,
    is_number,
    length,
    lying,
    modified,
    number,
    point2,
    shape,
    size2,
    translated,
    turned,
    unit,
    upright,
    vector2,
)
from ._operators import Solid, counts, ramp_along
from .ease import Ease, linear

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._sdf3 import SDF3

_ORIGIN = (0.0, 0.0)
_UP = (0.0, 1.0)
_Z = [0.0, 0.0, 1.0]

#: Operators that users add with `@op2`, by name.
_operators: dict[str, Callable[..., Any]] = {}


class SDF2(Solid):
    """A profile, by its signed distance in the plane. `extrude` and `revolve` make solids of it.

    >>> from argil import *
    >>> ring = circle(1) - circle(0.8)
    >>> pipe = ring.extrude(3)
    """

    __slots__ = ()
    _axes_count = 2

    def distance(self, points: ArrayLike) -> NDArray[np.float32]:
        """Returns the signed distance of each point: shape (N,) for points of shape (N, 2), in single precision."""
        import numpy as np

        flat = as_points("points", points, 2)
        # Python's z is the scene's y, which is the profile's.
        space = np.zeros((len(flat), 3), dtype=flat.dtype)
        space[:, 0], space[:, 2] = flat[:, 0], flat[:, 1]
        return self._node.distances(space, None)

    def __call__(self, points: ArrayLike) -> NDArray[np.float64]:
        """Returns distances of shape (N, 1), as functions for `@op2` expect them."""
        import numpy as np

        return self.distance(points).reshape(-1, 1).astype(np.float64)

    @property
    def bounds(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The box of the profile: its lowest and its highest corner."""
        found = self.extrude(1)._node.bounds()
        if found is None:
            raise ValueError("the profile is empty: nothing is inside")
        (x0, y0, _), (x1, y1, _) = found
        return (float(x0), float(y0)), (float(x1), float(y1))

    def _repr_png_(self) -> bytes | None:
        try:
            (x0, y0), (x1, y1) = self.bounds
        except ValueError:
            return None
        thin = self.extrude(0.02 * max(x1 - x0, y1 - y0))
        try:
            return _native.encode_png(thin.render((480, 360), camera=(0, 89.9, 3.4)))
        except ValueError:
            return None

    def __repr__(self) -> str:
        return f"<argil.SDF2 of {_output.described(self)}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _output.rebuilt, ("SDF2", *self._node.to_json(), self._blend)

    def __getattr__(self, name: str) -> Any:
        if name in _operators:
            return functools.partial(_operators[name], self)
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    # Places.

    def translate(self, offset: Vector2) -> SDF2:
        """Moves the profile."""
        return self._of(translated(self._node, [*vector2("offset", offset), 0.0]))

    def scale(self, factor: Vector2 | SupportsFloat) -> SDF2:
        """Scales by one factor, or by one per axis. Factors that differ make distances bounds."""
        if is_number(factor):
            return self._of(modified(self._node, "scale", by=number("factor", factor)))
        x, y = vector2("factor", factor)
        return self._of(modified(self._node, "stretch", by=[x, y, max(x, y)]))

    def rotate(self, angle: float) -> SDF2:
        """Rotates about the origin by an angle in radians, clockwise, as fogleman/sdf does."""
        return self._of(turned(self._node, _Z, -math.degrees(number("angle", angle))))

    def circular_array(self, count: int) -> SDF2:
        """Repeats around the origin at equal angles."""
        from ._sdf3 import _count

        around = modified(upright(self._node), "radial_repeat", count=_count("count", count))
        return self._of(lying(around))

    def repeat(self, spacing: Vector2 | SupportsFloat, count: Any = None, padding: Any = 0) -> SDF2:
        """Repeats at a distance along each axis. See `SDF3.repeat`."""
        del padding
        steps = size2("spacing", spacing)
        many = counts(count, steps)
        own = {} if many is None else {"count": [*many, 1]}
        return self._of(modified(self._node, "repeat", spacing=[*steps, 0.0], **own))

    def mirror(self, x: bool = False, y: bool = False) -> SDF2:
        """Keeps the positive side along each chosen axis, and adds its mirror image."""
        return self._of(modified(self._node, "mirror", axes=[bool(x), bool(y), False]))

    def elongate(self, size: Vector2 | SupportsFloat) -> SDF2:
        """Cuts the profile at the origin and pulls the halves apart by a distance to each side along each axis."""
        return self._of(modified(self._node, "elongate", by=[*size2("size", size), 0.0]))

    # Solids.

    def extrude(self, h: float) -> SDF3:
        """Returns the solid of height `h` over the profile, half of it above and half of it below z = 0."""
        from ._sdf3 import SDF3

        return SDF3(upright(modified(self._node, "extrude", half_depth=0.5 * length("h", h))))

    def extrude_to(self, b: SDF2, h: float, e: Ease = linear) -> SDF3:
        """Returns the solid of height `h` that goes from this profile at the bottom to another one at the top."""
        from ._sdf3 import SDF3

        height = number("h", h)
        if height <= 0:
            raise ValueError(f"h: {height} is not above 0")
        ramp = ramp_along([0.0, 0.0, -0.5 * height], [0.0, 0.0, 0.5 * height], e)
        both = self._morphed(b, ramp)._node
        layer = shape("box", half_size=[ENDLESS, ENDLESS, 0.5 * height])
        return SDF3(upright(both.joined(layer, "intersect", 0.0, "smooth", 0.0, None)))

    def revolve(self, offset: float = 0.0) -> SDF3:
        """Returns the solid that the profile makes around z, at a distance. Its y becomes z."""
        from ._sdf3 import SDF3

        return SDF3(modified(self._node, "revolve", offset=number("offset", offset)))


# Shapes.


def _placed(node: _native.Node, center: Vector2) -> SDF2:
    return SDF2(translated(node, [*point2("center", center), 0.0]))


def circle(radius: float = 1, center: Vector2 = _ORIGIN) -> SDF2:
    """Circle."""
    return _placed(lying(shape("cylinder", radius=number("radius", radius), half_height=ENDLESS)), center)


def line(normal: Vector2 = _UP, point: Vector2 = _ORIGIN) -> SDF2:
    """Half plane above a point, in the direction of the normal."""
    x, y = unit("normal", vector2("normal", normal))
    a, b = vector2("point", point)
    return SDF2(shape("plane", normal=[-x, -y, 0.0], offset=-(a * x + b * y)))


def slab2(
    x0: float | None = None,
    y0: float | None = None,
    x1: float | None = None,
    y1: float | None = None,
    k: float | None = None,
) -> SDF2:
    """Strip between lines: `argil.d2.slab`."""
    parts = []
    for value, normal in ((x0, (1, 0)), (x1, (-1, 0)), (y0, (0, 1)), (y1, (0, -1))):
        if value is not None:
            point = (number("x", value), 0) if normal[0] else (0, number("y", value))
            parts.append(line(normal, point))
    if not parts:
        raise ValueError("slab: at least one of x0, y0, x1, y1 is needed")
    return parts[0].intersection(*parts[1:], k=k)


def rectangle(
    size: Vector2 | SupportsFloat = 1,
    center: Vector2 = _ORIGIN,
    a: Vector2 | None = None,
    b: Vector2 | None = None,
) -> SDF2:
    """Rectangle of a size along each axis around a center, or between two corners."""
    if a is not None and b is not None:
        low, high = vector2("a", a), vector2("b", b)
        size = tuple(q - p for p, q in zip(low, high, strict=True))
        center = tuple(0.5 * (p + q) for p, q in zip(low, high, strict=True))
    return _placed(shape("box", half_size=[*half(size2("size", size)), ENDLESS]), center)


def rounded_rectangle(size: Vector2 | SupportsFloat, radius: Sequence[float] | float, center: Vector2 = _ORIGIN) -> SDF2:
    """Rectangle with rounded corners: one radius, or those at right top, right bottom, left bottom and left top."""
    width, height = half(size2("size", size))
    if is_number(radius):
        own = number("radius", radius)
        return _placed(shape("box", half_size=[width, height, ENDLESS], rounding=own), center)
    parts = list(radius)  # type: ignore[arg-type]
    if len(parts) != 4:
        raise ValueError(f"radius: expected 1 or 4 numbers, not {len(parts)}")
    r0, r1, r2, r3 = (number(f"radius[{i}]", part) for i, part in enumerate(parts))
    node = shape("extruded_rounded_box", half_size=[width, ENDLESS, height], corner_radii=[r1, r0, r2, r3])
    return _placed(lying(node), center)


def _outline(points: Sequence[Sequence[float]]) -> _native.Node:
    start, *others = points
    path = {"start": list(start), "segments": [{"to": list(point)} for point in others]}
    return shape("extrusion", outline=path, half_depth=ENDLESS)


def polygon(points: Sequence[Vector2] | ArrayLike) -> SDF2:
    """Polygon of up to 257 corners, by the even-odd rule. Corners are of shape (N, 2)."""
    corners = [vector2(f"points[{i}]", point) for i, point in enumerate(points)]  # type: ignore[arg-type]
    if len(corners) < 3:
        raise ValueError(f"points: {len(corners)} corners enclose nothing")
    return SDF2(_outline(corners))


def equilateral_triangle() -> SDF2:
    """Equilateral triangle of side 2 around the origin that points up."""
    k = math.sqrt(3)
    return SDF2(_outline([(-1, -1 / k), (1, -1 / k), (0, 2 / k)]))


def hexagon(r: float) -> SDF2:
    """Regular hexagon with flat sides at top and bottom, whose corners are at the distance r."""
    return SDF2(shape("hex_prism", apothem=number("r", r) * math.sqrt(3) / 2, half_depth=ENDLESS))


def rounded_x(w: float, r: float) -> SDF2:
    """Cross of two diagonal strokes of width 2 r, in a square of side w."""
    width, radius = number("w", w), number("r", r)
    stroke = shape("box", half_size=[width / math.sqrt(2) + radius, radius, ENDLESS], rounding=radius)
    one, other = turned(stroke, _Z, 45.0), turned(stroke, _Z, -45.0)
    return SDF2(one.joined(other, "union", 0.0, "smooth", 0.0, None))


def vesica(r: float, d: float) -> SDF2:
    """Lens where two circles of radius r overlap, whose centers are 2 d apart."""
    radius, away = number("r", r), number("d", d)
    if not 0 <= away < radius:
        raise ValueError(f"d: {away} is not from 0 to below r, {radius}")
    return circle(radius, (-away, 0)) & circle(radius, (away, 0))


def extrude(other: SDF2, h: float) -> SDF3:
    """See `SDF2.extrude`."""
    return other.extrude(h)


def extrude_to(a: SDF2, b: SDF2, h: float, e: Ease = linear) -> SDF3:
    """See `SDF2.extrude_to`."""
    return a.extrude_to(b, h, e)


def revolve(other: SDF2, offset: float = 0.0) -> SDF3:
    """See `SDF2.revolve`."""
    return other.revolve(offset)
