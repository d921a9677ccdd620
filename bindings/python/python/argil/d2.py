"""Profiles: all that the package itself has of two dimensions, and `slab`, which solids have too."""

from ._functions import op2, op23, sdf2
from ._sdf2 import (
    SDF2,
    circle,
    equilateral_triangle,
    extrude,
    extrude_to,
    hexagon,
    line,
    polygon,
    rectangle,
    revolve,
    rounded_rectangle,
    rounded_x,
    slab2,
    vesica,
)

slab = slab2

__all__ = [
    "SDF2",
    "circle",
    "equilateral_triangle",
    "extrude",
    "extrude_to",
    "hexagon",
    "line",
    "op2",
    "op23",
    "polygon",
    "rectangle",
    "revolve",
    "rounded_rectangle",
    "rounded_x",
    "sdf2",
    "slab",
    "vesica",
]
