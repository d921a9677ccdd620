"""Numbers and vectors as the native part takes them.

The axis z points up in Python, and y in a scene: `to_scene` and `size_to_scene` convert.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from typing import Any, SupportsFloat, TypeAlias

from . import _native

#: Three numbers: a tuple, a list or an array.
Vector3: TypeAlias = Sequence[SupportsFloat] | Any
#: Two numbers: a tuple, a list or an array.
Vector2: TypeAlias = Sequence[SupportsFloat] | Any

#: The largest length. Boxes, cylinders and extrusions of this length are infinite.
ENDLESS = 1e6


def number(name: str, value: Any) -> float:
    """Returns a finite number, or raises ValueError or TypeError."""
    try:
        result = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected a number, not {value!r}") from None
    if not math.isfinite(result):
        raise ValueError(f"{name}: {result} is not a finite number")
    return result


def length(name: str, value: Any) -> float:
    """Returns a length, of which all from `ENDLESS` on are infinite."""
    try:
        result = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected a number, not {value!r}") from None
    if math.isnan(result):
        raise ValueError(f"{name}: nan is not a number")
    return min(result, ENDLESS)


def is_number(value: Any) -> bool:
    """Whether a value is one number, and not a sequence."""
    return isinstance(value, (int, float)) or (hasattr(value, "__float__") and not hasattr(value, "__len__"))


def _several(name: str, value: Any, count: int) -> list[Any]:
    if isinstance(value, (str, bytes)) or not isinstance(value, Iterable):
        raise TypeError(f"{name}: expected {count} numbers, not {value!r}")
    parts = list(value)
    if len(parts) != count:
        raise ValueError(f"{name}: expected {count} numbers, not {len(parts)}")
    return parts


def point3(name: str, value: Vector3) -> tuple[float, float, float]:
    """Returns a center. One number for it is rather an argument at a wrong place."""
    x, y, z = (number(f"{name}[{i}]", part) for i, part in enumerate(_several(name, value, 3)))
    return x, y, z


def point2(name: str, value: Vector2) -> tuple[float, float]:
    """Returns a center. One number for it is rather an argument at a wrong place."""
    x, y = (number(f"{name}[{i}]", part) for i, part in enumerate(_several(name, value, 2)))
    return x, y


def vector3(name: str, value: Vector3 | SupportsFloat) -> tuple[float, float, float]:
    """Returns three finite numbers. One number stands for all of them, as in fogleman's library."""
    if is_number(value):
        same = number(name, value)
        return same, same, same
    return point3(name, value)


def vector2(name: str, value: Vector2 | SupportsFloat) -> tuple[float, float]:
    """Returns two finite numbers. One number stands for both, as in fogleman's library."""
    if is_number(value):
        same = number(name, value)
        return same, same
    return point2(name, value)


def size3(name: str, value: Vector3 | SupportsFloat) -> tuple[float, float, float]:
    """Returns three lengths, from one or three numbers."""
    parts = [value] * 3 if is_number(value) else _several(name, value, 3)
    x, y, z = (length(f"{name}[{i}]", part) for i, part in enumerate(parts))
    return x, y, z


def size2(name: str, value: Vector2 | SupportsFloat) -> tuple[float, float]:
    """Returns two lengths, from one or two numbers."""
    parts = [value] * 2 if is_number(value) else _several(name, value, 2)
    x, y = (length(f"{name}[{i}]", part) for i, part in enumerate(parts))
    return x, y


def to_scene(v: Sequence[float]) -> list[float]:
    """Returns a point or a direction in a scene's axes."""
    x, y, z = v
    return [x, z, -y]


def size_to_scene(v: Sequence[float]) -> list[float]:
    """Returns lengths along the axes in a scene's order."""
    x, y, z = v
    return [x, z, y]


def half(v: Sequence[float]) -> list[float]:
    """Returns half of each length. What is infinite stays so."""
    return [part if part >= ENDLESS else 0.5 * part for part in v]


def unit(name: str, v: Sequence[float]) -> tuple[float, ...]:
    """Returns a vector of length 1."""
    size = math.sqrt(sum(part * part for part in v))
    if size == 0.0:
        raise ValueError(f"{name}: (0, 0, 0) has no direction")
    return tuple(part / size for part in v)


def shape(kind: str, **parameters: Any) -> _native.Node:
    """Creates a shape of a scene."""
    return _native.Node.shape(json.dumps({"type": kind, **parameters}))


def modified(node: _native.Node, kind: str, **parameters: Any) -> _native.Node:
    """Applies a modifier of a scene."""
    return node.modified(json.dumps({"type": kind, **parameters}))


def translated(node: _native.Node, by: Sequence[float]) -> _native.Node:
    """Translates, in a scene's axes."""
    return node if not any(by) else modified(node, "translate", by=list(by))


def turned(node: _native.Node, axis: Sequence[float], degrees: float) -> _native.Node:
    """Rotates, in a scene's axes."""
    return node if degrees == 0.0 else modified(node, "rotate", axis=list(axis), degrees=degrees)


def upright(node: _native.Node) -> _native.Node:
    """Turns what lies along the scene's z so that it stands: from a profile's axes to Python's."""
    return turned(node, [1, 0, 0], -90.0)


def lying(node: _native.Node) -> _native.Node:
    """Turns what stands so that it lies along the scene's z."""
    return turned(node, [1, 0, 0], 90.0)


def color_of(value: Any) -> list[float]:
    """Returns linear RGB from three numbers from 0 to 1, or from sRGB text such as "#c84b31" or "red"."""
    if isinstance(value, str):
        text = _NAMED_COLORS.get(value.lower(), value).lstrip("#")
        if len(text) == 3:
            text = "".join(digit * 2 for digit in text)
        try:
            parts = [int(text[i : i + 2], 16) / 255.0 for i in (0, 2, 4)]
        except ValueError:
            parts = []
        if len(text) != 6 or not parts:
            known = ", ".join(sorted(_NAMED_COLORS))
            raise ValueError(f"color: {value!r} is neither #rrggbb nor one of {known}")
        return [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return list(vector3("color", value))


_NAMED_COLORS = {
    "black": "101010", "blue": "2f6fbf", "brown": "7a4f2e", "clay": "b5654a", "gold": "d9a441",
    "gray": "8a8a8a", "green": "4f8f4a", "orange": "d9762b", "pink": "d98aa6", "purple": "7a56a6",
    "red": "b8352f", "sand": "d2b48c", "stone": "b9b3a6", "white": "ededea", "yellow": "e0c341",
}  # fmt: skip
