"""Shapes that fogleman/sdf does not have. They stand along z."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, SupportsFloat

from . import _native
from ._numbers import Vector3, number, shape, size3, size_to_scene, to_scene, upright, vector3
from ._sdf3 import SDF3


def _half(size: Any) -> list[float]:
    return [0.5 * part for part in size_to_scene(size3("size", size))]


def box_frame(size: Vector3 | SupportsFloat, thickness: float) -> SDF3:
    """The twelve edges of a box as beams of a width, within its size."""
    return SDF3(shape("box_frame", half_size=_half(size), half_thickness=0.5 * number("thickness", thickness)))


def capped_torus(r1: float, r2: float, angle: float) -> SDF3:
    """Arc of a torus about z with round ends, around the y axis, by an angle in radians to each side."""
    import math

    node = shape(
        "capped_torus",
        major_radius=number("r1", r1),
        minor_radius=number("r2", r2),
        half_angle_degrees=math.degrees(number("angle", angle)),
    )
    return SDF3(upright(node))


def chain_link(length: float, r1: float, r2: float) -> SDF3:
    """Chain link along z: `length` of its straight part, radius of its bends, and of its wire."""
    node = shape(
        "link",
        half_length=0.5 * number("length", length),
        major_radius=number("r1", r1),
        minor_radius=number("r2", r2),
    )
    return SDF3(node)


def cut_sphere(radius: float, z: float) -> SDF3:
    """The part of a sphere above a height."""
    return SDF3(shape("cut_sphere", radius=number("radius", radius), cut=number("z", z)))


def solid_angle(radius: float, angle: float) -> SDF3:
    """The part of a sphere within an angle in radians around z."""
    import math

    degrees = math.degrees(number("angle", angle))
    return SDF3(shape("solid_angle", radius=number("radius", radius), half_angle_degrees=degrees))


def rhombus(x: float, y: float, height: float, rounding: float = 0.0) -> SDF3:
    """Rhombus with diagonals along x and y, as a plate of a height."""
    node = shape(
        "rhombus",
        half_length_x=0.5 * number("x", x),
        half_length_z=0.5 * number("y", y),
        half_height=0.5 * number("height", height),
        rounding=number("rounding", rounding),
    )
    return SDF3(node)


def superellipsoid(size: Vector3 | SupportsFloat, upright_exponent: float, level_exponent: float) -> SDF3:
    """Superellipsoid with semi-axes: exponents from 1 to 16, where 2 gives ellipses and large values approach a box."""
    radii = size_to_scene(size3("size", size))
    exponents = [number("upright_exponent", upright_exponent), number("level_exponent", level_exponent)]
    return SDF3(shape("superellipsoid", radii=radii, exponents=exponents))


def gyroid(size: Vector3 | SupportsFloat, period: float, thickness: float) -> SDF3:
    """Sheet along a gyroid in a box. `period` is the length after which it repeats, at least a hundredth of half the size."""
    return SDF3(
        shape("gyroid", half_size=_half(size), period=number("period", period), thickness=number("thickness", thickness))
    )


def schwarz_p(size: Vector3 | SupportsFloat, period: float, thickness: float) -> SDF3:
    """Sheet along Schwarz's P surface in a box."""
    return SDF3(
        shape("schwarz_p", half_size=_half(size), period=number("period", period), thickness=number("thickness", thickness))
    )


def bezier_tube(a: Vector3, control: Vector3, b: Vector3, ra: float, rb: float | None = None) -> SDF3:
    """Tube along a quadratic Bézier curve from `a` to `b`, with a radius at each end."""
    start, middle, end = (to_scene(vector3(n, p)) for n, p in (("a", a), ("control", control), ("b", b)))
    first = number("ra", ra)
    last = first if rb is None else number("rb", rb)
    return SDF3(shape("bezier_tube", **{"from": start, "control": middle, "to": end, "from_radius": first, "to_radius": last}))


def spline_tube(points: Sequence[Vector3], radii: Sequence[float] | float) -> SDF3:
    """Tube along a smooth curve through points, with one radius or one for each point."""
    from ._numbers import is_number

    places = [to_scene(vector3(f"points[{i}]", point)) for i, point in enumerate(points)]
    sizes = [radii] * len(places) if is_number(radii) else list(radii)  # type: ignore[arg-type]
    if len(sizes) != len(places):
        raise ValueError(f"radii: expected 1 or {len(places)}, not {len(sizes)}")
    along = [{"at": at, "radius": number("radii", r)} for at, r in zip(places, sizes, strict=True)]
    return SDF3(shape("spline_tube", points=along))


def heightmap(path: str | os.PathLike[str], size: Sequence[float], height: float, base: float = 0.1) -> SDF3:
    """Ground from a grayscale PNG image: black is at z = 0, white at `height`, and the bottom at -base."""
    from ._numbers import size2

    x, y = size2("size", size)
    node = _native.Node.heightmap(os.fspath(path), [0.5 * x, 0.5 * y], number("height", height), number("base", base))
    return SDF3(node)
