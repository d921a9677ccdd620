"""Solids by name, as functions of a package with fogleman's names: `argil` or his own."""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import Any

import numpy as np

Make = Callable[[Any], Any]


#: Lopsided, so that no turn and no mirror image of it is itself. It does not reach the origin's axes everywhere.
def body(s: Any) -> Any:
    return s.capsule((0.1, -0.3, 0.2), (0.6, 0.4, 0.7), 0.25).union(s.box((0.4, 0.6, 0.3), (0.3, 0.1, -0.2)), k=0.1)


#: Shapes whose distances agree everywhere.
SHAPES: dict[str, Make] = {
    "sphere": lambda s: s.sphere(0.8, (0.1, 0.2, -0.3)),
    "plane": lambda s: s.plane((0.3, -0.2, 1), (0.1, 0.2, 0.3)),
    "slab along z": lambda s: s.slab(z0=-0.3, z1=0.4),
    "slab above": lambda s: s.slab(z0=-0.3),
    "slab beside": lambda s: s.slab(x1=0.2),
    "box": lambda s: s.box((1, 0.6, 1.4), (0.1, 0.2, 0.3)),
    "box of corners": lambda s: s.box(a=(-0.3, -0.2, -0.1), b=(0.7, 0.6, 0.5)),
    "cube": lambda s: s.box(1.2),
    "rounded box": lambda s: s.rounded_box((1, 0.8, 1.2), 0.2),
    "wireframe box": lambda s: s.wireframe_box((1, 0.8, 1.2), 0.1),
    "torus": lambda s: s.torus(0.7, 0.2),
    "capsule": lambda s: s.capsule((-0.5, 0.1, -0.4), (0.3, 0.4, 0.6), 0.3),
    "cylinder": lambda s: s.cylinder(0.5),
    "capped cylinder": lambda s: s.capped_cylinder((-0.4, 0.1, -0.5), (0.3, 0.5, 0.6), 0.35),
    "rounded cylinder": lambda s: s.rounded_cylinder(0.6, 0.15, 1.3),
    "capped cone": lambda s: s.capped_cone((-0.3, 0.2, -0.6), (0.2, -0.1, 0.7), 0.6, 0.25),
    "rounded cone": lambda s: s.rounded_cone(0.6, 0.25, 0.9),
}

#: Shapes whose surface agrees, and whose distances differ: one of them is a bound where the other is exact.
SURFACES: dict[str, Make] = {
    "pyramid": lambda s: s.pyramid(1.2),
    "slab of all axes": lambda s: s.slab(-0.3, -0.4, -0.5, 0.4, 0.5, 0.6),
    "ellipsoid": lambda s: s.ellipsoid((0.8, 0.5, 0.6)),
    "tetrahedron": lambda s: s.tetrahedron(0.6),
    "octahedron": lambda s: s.octahedron(0.8),
    "dodecahedron": lambda s: s.dodecahedron(0.8),
    "icosahedron": lambda s: s.icosahedron(0.8),
}

#: Operators whose distances agree everywhere.
OPERATORS: dict[str, Make] = {
    "union": lambda s: s.sphere(0.5) | s.box(0.8).translate((0.4, 0.1, 0)),
    "smooth union": lambda s: s.sphere(0.5) | s.box(0.8).translate((0.4, 0.1, 0)).k(0.3),
    "union of three": lambda s: s.sphere(0.5).union(s.box(0.6).translate((0.5, 0, 0)), s.torus(0.7, 0.1), k=0.2),
    "difference": lambda s: s.sphere(0.7) - s.cylinder(0.3),
    "smooth difference": lambda s: s.sphere(0.7) - s.cylinder(0.3).k(0.2),
    "intersection": lambda s: s.sphere(0.7) & s.box(1.0),
    "smooth intersection": lambda s: s.sphere(0.7) & s.box(1.0).k(0.2),
    "blend": lambda s: s.sphere(0.7).blend(s.box(1.0), k=0.3),
    "negate": lambda s: body(s).negate(),
    "dilate": lambda s: body(s).dilate(0.1),
    "erode": lambda s: body(s).erode(0.1),
    "shell": lambda s: body(s).shell(0.1),
    "translate": lambda s: body(s).translate((0.2, -0.3, 0.4)),
    "scale": lambda s: body(s).scale(0.7),
    "scale per axis": lambda s: body(s).scale((0.7, 1.2, 0.9)),
    "rotate": lambda s: body(s).rotate(0.7, (1, 2, -1)),
    "rotate about z": lambda s: body(s).rotate(pi / 3),
    "rotate to": lambda s: body(s).rotate_to((1, 2, 3), (-1, 0.5, 1)),
    "rotate back": lambda s: body(s).rotate_to((0, 0, 1), (0, 0, -1)),
    "orient along x": lambda s: body(s).orient((1, 0, 0)),
    "orient along y": lambda s: body(s).orient((0, 1, 0)),
    "orient": lambda s: body(s).orient((1, -2, 0.5)),
    "circular array": lambda s: s.box(0.3).circular_array(5, 0.8),
    "repeat": lambda s: s.sphere(0.3).repeat((1, 1.2, 0.9), 1),
    "repeat per axis": lambda s: s.sphere(0.3).repeat((1, 1.2, 0), (2, 1, 0)),
    "repeat without end": lambda s: s.sphere(0.3).repeat((1, 1.2, 0.9), padding=1),
    "revolve": lambda s: s.rectangle((0.3, 0.6)).revolve(0.5),
    "extrude a circle": lambda s: s.circle(0.5).extrude(0.6),
    "extrude a rectangle": lambda s: s.rectangle((0.8, 0.5), (0.1, 0.2)).extrude(0.6),
    "extrude a polygon": lambda s: s.polygon([(-0.5, -0.4), (0.6, -0.3), (0.1, 0.1), (0.2, 0.6)]).extrude(0.6),
    "extrude a hexagon": lambda s: s.hexagon(0.6).extrude(0.5),
    "extrude a triangle": lambda s: s.equilateral_triangle().extrude(0.5),
    "extrude a cross": lambda s: s.rounded_x(0.8, 0.1).extrude(0.5),
    "extrude a rounded rectangle": lambda s: s.rounded_rectangle(np.array((1.0, 0.8)), 0.2).extrude(0.5),
    "extrude corners": lambda s: s.rounded_rectangle(np.array((1.0, 0.8)), (0.05, 0.1, 0.2, 0.3)).extrude(0.5),
    "profiles": lambda s: (s.circle(0.6) - s.circle(0.2).translate((0.3, 0))).rotate(0.6).scale(0.9).extrude(0.4),
    "ring of profiles": lambda s: s.circle(0.2, (0.5, 0)).circular_array(5).extrude(0.4),
}

#: Operators whose surface agrees, and whose distances differ: Argil's are bounds.
DEFORMATIONS: dict[str, Make] = {
    "twist": lambda s: body(s).twist(1.3),
    "bend": lambda s: body(s).bend(0.9),
    "bend linear": lambda s: body(s).bend_linear((-0.2, 0, 0), (0.7, 0.2, 0.1), (0.1, 0.2, 0.4), s.ease.in_out_quad),
    "bend radial": lambda s: body(s).bend_radial(0.2, 0.8, 0.4, s.ease.in_out_cubic),
    "transition linear": lambda s: s.box(1.0).transition_linear(
        s.sphere(0.6), np.array((0, 0, -0.4)), np.array((0, 0, 0.4)), s.ease.in_out_sine
    ),
    "transition radial": lambda s: s.box((1.2, 1.2, 0.4)).transition_radial(s.sphere(0.7), 0.1, 0.7),
    "extrude to": lambda s: s.rectangle(0.8).extrude_to(s.circle(0.5), 1.0, s.ease.in_out_quad),
    "wrap around": lambda s: s.box((2.0, 0.2, 0.5)).wrap_around(-1.5, 1.5),
    "blend of a twisted solid": lambda s: s.sphere(0.9) - (body(s).twist(1.1) | body(s).twist(-1.3)).k(0.15),
    "blends around a twisted solid": lambda s: body(s).twist(1.1) | s.sphere(0.4).translate((0, 0, 0.6)).k(0.3)
    & s.box(1.6).k(0.2),
    "shell of a twisted solid": lambda s: body(s).twist(1.1).shell(0.1).dilate(0.03) | s.sphere(0.2).k(0.1),
    "blends of a transition": lambda s: s.cylinder(0.5).transition_linear(
        s.cylinder(0.2), s.Z * -0.3, s.Z * 0.4, s.ease.out_quad
    )
    & s.slab(z0=-0.6, z1=0.6)
    | s.sphere(0.4).translate((0, 0, 0.8)).k(0.2),
    "blend of a bent list": lambda s: (s.box(0.5) | body(s).bend(0.7) | s.sphere(0.3).translate((0, -0.6, 0)))
    - s.cylinder(0.2).k(0.15),
    "vesica": lambda s: s.vesica(0.8, 0.4).extrude(0.5),
    "slice": lambda s: body(s).slice().extrude(0.5),
    "line": lambda s: (s.circle(0.7) & s.line((0.3, 1), (0.1, -0.2))).extrude(0.5),
    "slab of profiles": lambda s: (s.circle(0.7) & s.d2.slab(x0=-0.3, y1=0.4)).extrude(0.5),
    "elongate": lambda s: s.sphere(0.4).elongate((0.2, 0.3, 0.1)),
    "elongate a profile": lambda s: s.circle(0.4).elongate((0.2, 0.1)).extrude(0.5),
}
