"""Model with signed distance fields.

>>> from argil import *
>>> f = sphere(1) & box(1.5)
>>> f -= cylinder(0.5).orient(X) | cylinder(0.5).orient(Y) | cylinder(0.5).orient(Z)
>>> f.mesh(samples=1e5).is_watertight
True

The names and the order of arguments are those of fogleman/sdf. The axis z points up, and angles are in radians.
"""

from __future__ import annotations

import math as _math
from typing import TYPE_CHECKING, Any

from . import d2, d3, ease, world
from ._functions import (
    SampledSDF2,
    SampledSDF3,
    Sampling,
    SamplingWarning,
    op2,
    op3,
    op23,
    op32,
    sdf2,
    sdf3,
)
from ._load import load
from ._mesh import Mesh
from ._native import SceneError, __version__
from ._operators import Material
from ._outlines import image, measure_image, measure_text, text
from ._output import sample_slice, show_slice
from ._scene import Bricks, EditReport, NodeInfo, Scene, SceneNode
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
    vesica,
)
from ._sdf3 import (
    SDF3,
    bend,
    bend_linear,
    bend_radial,
    blend,
    box,
    capped_cone,
    capped_cylinder,
    capsule,
    circular_array,
    cylinder,
    difference,
    dilate,
    dodecahedron,
    ellipsoid,
    elongate,
    erode,
    icosahedron,
    intersection,
    negate,
    octahedron,
    orient,
    plane,
    pyramid,
    repeat,
    rotate,
    rotate_to,
    rounded_box,
    rounded_cone,
    rounded_cylinder,
    scale,
    shell,
    slab,
    slice,
    sphere,
    tetrahedron,
    torus,
    transition_linear,
    transition_radial,
    translate,
    twist,
    union,
    wireframe_box,
    wrap_around,
)
from ._shapes import (
    bezier_tube,
    box_frame,
    capped_torus,
    chain_link,
    cut_sphere,
    gyroid,
    heightmap,
    rhombus,
    schwarz_p,
    solid_angle,
    spline_tube,
    superellipsoid,
)

pi = _math.pi
degrees = _math.degrees
radians = _math.radians

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    ORIGIN: NDArray[np.float64]
    X: NDArray[np.float64]
    Y: NDArray[np.float64]
    Z: NDArray[np.float64]
    UP: NDArray[np.float64]

#: Arrays that are made when they are first asked for, because importing NumPy takes longer than all the rest.
_VECTORS = {"ORIGIN": (0, 0, 0), "X": (1, 0, 0), "Y": (0, 1, 0), "Z": (0, 0, 1), "UP": (0, 0, 1)}


def __getattr__(name: str) -> Any:
    if name in _VECTORS:
        import numpy as np

        value = np.array(_VECTORS[name])
        value.setflags(write=False)
        globals()[name] = value
        return value
    if name == "np":
        import numpy as np

        return np
    raise AttributeError(f"module 'argil' has no attribute {name!r}")


def generate(solid: SDF3, *arguments: Any, **options: Any) -> Any:
    """See `SDF3.generate`."""
    return solid.generate(*arguments, **options)


def save(path: Any, solid: SDF3, *arguments: Any, **options: Any) -> None:
    """See `SDF3.save`."""
    solid.save(path, *arguments, **options)


__all__ = [
    "ORIGIN",
    "SDF2",
    "SDF3",
    "UP",
    "Bricks",
    "EditReport",
    "Material",
    "Mesh",
    "NodeInfo",
    "SampledSDF2",
    "SampledSDF3",
    "Sampling",
    "SamplingWarning",
    "Scene",
    "SceneError",
    "SceneNode",
    "X",
    "Y",
    "Z",
    "__version__",
    "bend",
    "bend_linear",
    "bend_radial",
    "bezier_tube",
    "blend",
    "box",
    "box_frame",
    "capped_cone",
    "capped_cylinder",
    "capped_torus",
    "capsule",
    "chain_link",
    "circle",
    "circular_array",
    "cut_sphere",
    "cylinder",
    "d2",
    "d3",
    "degrees",
    "difference",
    "dilate",
    "dodecahedron",
    "ease",
    "ellipsoid",
    "elongate",
    "equilateral_triangle",
    "erode",
    "extrude",
    "extrude_to",
    "generate",
    "gyroid",
    "heightmap",
    "hexagon",
    "icosahedron",
    "image",
    "intersection",
    "line",
    "load",
    "measure_image",
    "measure_text",
    "negate",
    "np",
    "octahedron",
    "op2",
    "op3",
    "op23",
    "op32",
    "orient",
    "pi",
    "plane",
    "polygon",
    "pyramid",
    "radians",
    "rectangle",
    "repeat",
    "revolve",
    "rhombus",
    "rotate",
    "rotate_to",
    "rounded_box",
    "rounded_cone",
    "rounded_cylinder",
    "rounded_rectangle",
    "rounded_x",
    "sample_slice",
    "save",
    "scale",
    "schwarz_p",
    "sdf2",
    "sdf3",
    "shell",
    "show_slice",
    "slab",
    "slice",
    "solid_angle",
    "sphere",
    "spline_tube",
    "superellipsoid",
    "tetrahedron",
    "text",
    "torus",
    "transition_linear",
    "transition_radial",
    "translate",
    "twist",
    "union",
    "vesica",
    "wireframe_box",
    "world",
    "wrap_around",
]
