"""What two- and three-dimensional solids have in common: the operators, and how Python composes them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from . import _native
from ._numbers import color_of, is_number, length, number
from .ease import Ease, _pieces

if TYPE_CHECKING:
    from typing import Self


class Material:
    """How a surface looks, in the metallic-roughness model.

    `color` is linear RGB from 0 to 1, or sRGB text such as "#c84b31" or "gold". `roughness` goes from 0, a mirror, to 1,
    chalk. `metallic` is 0 or 1. `emission` is linear RGB up to 1000.
    """

    __slots__ = ("color", "emission", "metallic", "roughness")

    def __init__(
        self,
        color: Any = "stone",
        *,
        roughness: float = 0.55,
        metallic: float = 0.0,
        emission: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        self.color = tuple(color_of(color))
        self.roughness = number("roughness", roughness)
        self.metallic = number("metallic", metallic)
        self.emission = tuple(color_of(emission))

    def __repr__(self) -> str:
        color = ", ".join(f"{part:.3g}" for part in self.color)
        return f"Material(({color}), roughness={self.roughness:g}, metallic={self.metallic:g})"

    def _json(self) -> str:
        return json.dumps({
            "base_color": self.color,
            "roughness": self.roughness,
            "metallic": self.metallic,
            "emission": self.emission,
        })  # fmt: skip


class Solid:
    """A solid of two or three dimensions. It never changes: every method returns a new one."""

    __slots__ = ("_blend", "_lazy_node")

    #: 2 or 3.
    _axes_count: int
    _blend: float | None
    _lazy_node: _native.Node | None

    def __init__(self, node: _native.Node | None) -> None:
        self._lazy_node = node
        self._blend = None

    @property
    def _node(self) -> _native.Node:
        node = self._lazy_node
        if node is None:
            raise TypeError("this solid has no shape")
        return node

    def _of(self, node: _native.Node) -> Self:
        return type(self)(node)

    def __or__(self, other: Self) -> Self:
        """Joins both solids. `other.k(0.1)` blends them."""
        return self.union(other) if isinstance(other, Solid) else NotImplemented

    def __and__(self, other: Self) -> Self:
        """Keeps what is in both solids."""
        return self.intersection(other) if isinstance(other, Solid) else NotImplemented

    def __sub__(self, other: Self) -> Self:
        """Cuts the other solid out."""
        return self.difference(other) if isinstance(other, Solid) else NotImplemented

    def __invert__(self) -> Self:
        """Returns everything else: the same as `negate()`."""
        return self.negate()

    def k(self, k: float | None = None) -> Self:
        """Sets the blend radius of the joint in which this solid is the second operand.

        `a | b.k(0.1)` joins smoothly, within 0.1 of where the distances of both are equal. The surface stands out by up to
        a quarter of that. The formula is Inigo Quilez's quadratic polynomial smooth minimum. None or 0 makes a hard joint.
        """
        copy = self._of(self._node)
        copy._blend = None if k is None else _radius(k)
        return copy

    def _combined(self, others: Sequence[Self], kind: str, k: float | None, profile: str = "smooth") -> Self:
        node = self._node
        for other in others:
            self._check_alike(other)
            own = other._blend if k is None else k
            node = node.joined(other._node, kind, _radius(own or 0.0), profile, 0.0, None)
        return self._of(node)

    def _check_alike(self, other: Any) -> None:
        """Raises TypeError for what has other dimensions, or is no solid."""
        if not (isinstance(other, Solid) and other._axes_count == self._axes_count):
            raise TypeError(f"cannot combine {type(self).__name__} with {type(other).__name__}")

    def union(self, *others: Self, k: float | None = None, chamfer: float | None = None) -> Self:
        """Joins solids, in order. `k` is the blend radius, and `chamfer` makes a flat face of that radius instead.

        >>> import argil
        >>> ball = argil.sphere(1).union(argil.sphere(1).translate((1, 0, 0)), k=0.5)
        """
        return self._joint(others, "union", k, chamfer)

    def difference(self, *others: Self, k: float | None = None, chamfer: float | None = None) -> Self:
        """Cuts other solids out, in order. See `union` for `k` and `chamfer`."""
        return self._joint(others, "subtract", k, chamfer)

    def intersection(self, *others: Self, k: float | None = None, chamfer: float | None = None) -> Self:
        """Keeps what is in all solids. See `union` for `k` and `chamfer`."""
        return self._joint(others, "intersect", k, chamfer)

    def _joint(self, others: Sequence[Self], kind: str, k: float | None, chamfer: float | None) -> Self:
        if chamfer is not None:
            if k is not None:
                raise ValueError("k and chamfer exclude each other")
            return self._combined(others, kind, chamfer, "chamfer")
        return self._combined(others, kind, k)

    def blend(self, *others: Self, k: float = 0.5) -> Self:
        """Interpolates the distances: k = 0 is this solid, and k = 1 the other one."""
        node = self._node
        for other in others:
            self._check_alike(other)
            share = number("k", k)
            if not 0.0 <= share <= 1.0:
                raise ValueError(f"k: {share} is not from 0 to 1")
            node = node.joined(other._node, "morph", 0.0, "smooth", share, None)
        return self._of(node)

    def paint_with(self, *others: Self, k: float | None = None) -> Self:
        """Colors what lies within other solids with their materials, without changing the surface."""
        return self._combined(others, "paint", k)

    def _morphed(self, other: Self, ramp: dict[str, Any]) -> Self:
        self._check_alike(other)
        return self._of(self._node.joined(other._node, "morph", 0.0, "smooth", 1.0, json.dumps(ramp)))

    def negate(self) -> Self:
        """Returns everything else: the inside becomes the outside."""
        return self._of(self._node.complement())

    def dilate(self, r: float) -> Self:
        """Moves the surface outward by a distance, which rounds edges."""
        return self._of(self._node.modified(json.dumps({"type": "round", "radius": number("r", r)})))

    def erode(self, r: float) -> Self:
        """Moves the surface inward by a distance."""
        return self._of(self._node.modified(json.dumps({"type": "round", "radius": -number("r", r)})))

    def shell(self, thickness: float) -> Self:
        """Keeps a shell along the surface, half of its thickness on each side."""
        half = 0.5 * number("thickness", thickness)
        return self._of(self._node.modified(json.dumps({"type": "shell", "half_thickness": half})))

    def paint(self, color: Any = None, **material: Any) -> Self:
        """Gives the surface a color or a `Material`, where it has none yet.

        `color` is linear RGB, sRGB text such as "#c84b31", a name such as "gold", or a `Material`. `roughness`, `metallic`
        and `emission` are those of `Material`.
        """
        own = color if isinstance(color, Material) else Material("stone" if color is None else color, **material)
        return self._of(self._node.painted(own._json()))

    def named(self, name: str) -> Self:
        """Names this part, for scene files and the editor."""
        return self._of(self._node.named(str(name)))


def _radius(k: Any) -> float:
    radius = length("k", k)
    if radius < 0:
        raise ValueError(f"k: {radius} is negative")
    return radius


def ramp_along(p0: Sequence[float], p1: Sequence[float], e: Ease) -> dict[str, Any]:
    """Returns a ramp between two points of a scene."""
    return {"line": {"from": list(p0), "to": list(p1), "curve": _pieces(e)}}


def ramp_with_radius(r0: float, r1: float, e: Ease) -> dict[str, Any]:
    """Returns a ramp with the distance from the upright axis."""
    return {"radius": {"from": r0, "to": r1, "curve": _pieces(e)}}


def counts(count: Any, spacing: Sequence[float], name: str = "count") -> list[int] | None:
    """Returns the number of copies along each axis: `count` on each side of the middle one, or None without end."""
    if count is None:
        return None
    parts = [count] * len(spacing) if is_number(count) else list(count)
    if len(parts) != len(spacing):
        raise ValueError(f"{name}: expected {len(spacing)} numbers, not {len(parts)}")
    result = []
    for i, (part, step) in enumerate(zip(parts, spacing, strict=True)):
        sides = number(f"{name}[{i}]", part)
        if sides < 0 or sides != int(sides):
            raise ValueError(f"{name}[{i}]: {part} is not a count")
        result.append(1 if step == 0 else 2 * int(sides) + 1)
    return result
