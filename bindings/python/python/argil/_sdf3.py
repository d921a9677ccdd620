"""Solids of three dimensions."""

from __future__ import annotations

import functools
import math
import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, SupportsFloat

from . import _native, _output
from ._arrays import as_points
from ._numbers import (
    ENDLESS,
    Vector2,
    Vector3,
    half,
    is_number,
    lying,
    modified,
    number,
    point3,
    shape,
    size3,
    size_to_scene,
    to_scene,
    translated,
    turned,
    unit,
    upright,
    vector3,
)
from ._operators import Solid, counts, ramp_along, ramp_with_radius
from .ease import Ease, linear

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._mesh import Mesh
    from ._scene import Bricks, Scene
    from ._sdf2 import SDF2

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
_ORIGIN = (0.0, 0.0, 0.0)
_UP = (0.0, 0.0, 1.0)

#: Operators that users add with `@op3`, by name.
_operators: dict[str, Callable[..., Any]] = {}


class SDF3(Solid):
    """A solid, by its signed distance: negative inside. Lengths have any unit, and the axis z points up.

    >>> from argil import *
    >>> f = sphere(1) & box(1.5)
    >>> c = cylinder(0.5)
    >>> f -= c.orient(X) | c.orient(Y) | c.orient(Z)
    >>> round(float(f.distance([(0, 0, 2)])[0]), 2)
    1.25
    """

    __slots__ = ()
    _axes_count = 3

    # Questions.

    def distance(self, points: ArrayLike, *, progress: Any = None) -> NDArray[np.float32]:
        """Returns the signed distance of each point: shape (N,) for points of shape (N, 3), in single precision.

        Where the field is only bounded, as in blends and behind cuts, values are nowhere farther from 0 than the distance.
        `progress` is a function of stage, done and total, or a tqdm bar.
        """
        return self._node.distances(as_points("points", points), _output.progress_of(progress))

    def gradient(self, points: ArrayLike, *, progress: Any = None) -> NDArray[np.float32]:
        """Returns the gradient of the distance at each point: shape (N, 3). On the surface, it points out of the solid."""
        return self._node.gradients(as_points("points", points), _output.progress_of(progress))

    def closest_point(
        self, points: ArrayLike, max_distance: float = math.inf, *, progress: Any = None
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Returns the closest point of the surface for each point, and its distance: shapes (N, 3) and (N,).

        Both are NaN where there is none within `max_distance`. No other point is closer by more than 1 % of the distance.
        """
        found = self._node.closest_points(as_points("points", points), float(max_distance), _output.progress_of(progress))
        return found[:, :3], found[:, 3]

    def cast_rays(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        max_distance: float = math.inf,
        *,
        progress: Any = None,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Returns where rays meet the surface: distances (N,), points (N, 3) and normals (N, 3).

        The distance is infinite, and the others are NaN, where a ray meets nothing within `max_distance`. Directions have
        any length but 0. A single origin or direction, of shape (3,), goes with all of the others.
        """
        starts, ways = _paired(origins, directions)
        found = self._node.cast_rays(starts, ways, float(max_distance), _output.progress_of(progress))
        return found[:, 0], found[:, 1:4], found[:, 4:]

    @property
    def bounds(self) -> Box:
        """The box of the solid: its lowest and its highest corner. Sides without an end are infinite.

        It holds all of the solid, and may be a few hundredths of its longest side larger.
        """
        found = self._node.bounds()
        if found is None:
            raise ValueError("the solid is empty: nothing is inside")
        low, high = found
        return _output.plain_box(low, high)

    def volume(self, voxel_size: float | None = None) -> float:
        """Returns the volume, from a mesh whose corners lie on the surface.

        The error is about a hundredth of what a layer of half a voxel holds. Without a size, there are 2 million voxels.
        """
        return self.mesh(voxel_size, samples=2**21, normals=False, colors=False).volume

    def center_of_mass(self, voxel_size: float | None = None) -> tuple[float, float, float]:
        """Returns the center of mass of the solid with a constant density, from a mesh as `volume` does."""
        return self.mesh(voxel_size, samples=2**21, normals=False, colors=False).center_of_mass()

    def __call__(self, points: ArrayLike) -> NDArray[np.float64]:
        """Returns distances of shape (N, 1), as functions for `@op3` expect them."""
        import numpy as np

        found = self._node.distances(as_points("points", points), None)
        return found.reshape(-1, 1).astype(np.float64)

    # Results.

    def mesh(
        self,
        voxel_size: float | None = None,
        *,
        samples: float | None = 2**22,
        bounds: Box | None = None,
        method: str = "mc",
        max_triangles: int | None = None,
        normals: bool = True,
        colors: bool | None = None,
        progress: Any = None,
    ) -> Mesh:
        """Returns the surface as triangles with shared corners, which lie on the exact surface.

        `voxel_size` is the distance between samples; without it, `samples` fill the box of the solid. `bounds` cuts the
        solid off, and the cut is closed. `method` is "mc" for marching cubes, whose meshes are closed and manifold, or "dc" for dual contouring,
        which keeps sharp edges. `max_triangles` simplifies. Colors are left out if nothing is painted, unless asked for.

        Raises ValueError if the solid is empty or has no end, or if there would be too many voxels, and MemoryError.
        """
        return _output.mesh(self, voxel_size, samples, bounds, method, max_triangles, normals, colors, progress)

    def generate(
        self,
        step: Any = None,
        bounds: Box | None = None,
        samples: float | None = 2**22,
        workers: int | None = None,
        batch_size: int | None = None,
        verbose: bool = False,
        sparse: bool = True,
    ) -> NDArray[np.float32]:
        """Returns the corners of triangles, three rows for each: the shape of fogleman/sdf. See `mesh` for shared corners.

        `workers`, `batch_size` and `sparse` are accepted and change nothing.
        """
        del workers, batch_size, sparse
        made = self.mesh(_output.step_of(step), samples=samples, bounds=bounds, normals=False)
        if verbose:
            print(made)
        return made.vertices[made.triangles.reshape(-1)]

    def save(
        self,
        path: str | os.PathLike[str],
        step: Any = None,
        bounds: Box | None = None,
        samples: float | None = 2**22,
        *,
        verbose: bool = False,
        progress: Any = None,
        **options: Any,
    ) -> None:
        """Writes the solid to a file, in the format of its extension.

        Triangles: .stl, .obj, .ply, .glb, .gltf, .3mf. Volumes for other programs: .vdb, .nvdb, .npy, .nrrd. Argil's own: .argil
        for sparse bricks, and .json for a scene that the editor opens. All have the axis z up, except .glb, .gltf, .argil and
        .json, which have y up by definition and are turned. `step`, or `voxel_size`, is the distance between samples.
        Options of `mesh` go on to it. Volumes take `half_width`, in voxels.

        Raises ValueError for an unknown extension, and OSError if the file cannot be written. An existing file stays whole
        until the new one is complete.
        """
        _output.save(self, path, step, bounds, samples, verbose, progress, options)

    def voxels(self, resolution: int = 128, *, bounds: Box | None = None, progress: Any = None) -> NDArray[np.float32]:
        """Returns distances on a grid: an array [z, y, x] with `resolution` samples along the longest side.

        All arrays of voxels have this order of axes: those of `from_array`, and those in .npy files. Samples lie in the middle of
        voxels. `bounds` is the box of the voxels; without it, the solid's box and two voxels. `voxel_grid` returns where they lie.
        """
        return _output.voxels(self, resolution, bounds, progress)

    def voxel_grid(self, resolution: int = 128, *, bounds: Box | None = None) -> tuple[float, tuple[float, float, float]]:
        """Returns the distance between the samples of `voxels`, and the position (x, y, z) of the first one.

        They bring an array back to its place:

        >>> from argil import SDF3, sphere
        >>> f = sphere(1)
        >>> spacing, origin = f.voxel_grid(32)
        >>> copy = SDF3.from_array(f.voxels(32), spacing, origin)
        """
        size, first, _ = _output.voxel_grid(self, resolution, bounds)
        return size, first

    @classmethod
    def from_array(
        cls,
        values: ArrayLike,
        spacing: float = 1.0,
        origin: Vector3 = (0, 0, 0),
        iso: float | None = None,
        *,
        fog: bool = False,
        progress: Any = None,
    ) -> SDF3:
        """Creates a solid from values on a grid: an array [z, y, x], as `voxels` returns.

        `spacing` is the distance between samples, and `origin` the position (x, y, z) of the first one. The surface is where
        values are `iso`, by default 0; inside, they are lower. With `fog` they are densities, which are higher inside, and the
        surface is at half of the largest one.

        Raises ValueError if the array has not three axes, a value is not finite, or there is no surface.
        """
        return _output.from_array(values, spacing, origin, iso, fog, progress)

    def bricks(self, resolution: int = 256, *, voxel_size: float | None = None, progress: Any = None) -> Bricks:
        """Returns the solid as sparse bricks, which follow edits in place. See `Bricks`."""
        from ._scene import Scene

        return Scene(self).bricks(resolution, voxel_size=voxel_size, progress=progress)

    def scene(self) -> Scene:
        """Returns a scene with this solid."""
        from ._scene import Scene

        return Scene(self)

    def render(
        self,
        size: Sequence[int] = (640, 480),
        *,
        camera: Vector3 | None = None,
        eye: Vector3 | None = None,
        target: Vector3 | None = None,
        field_of_view: float | None = None,
        show: str = "shaded",
        ground: bool = False,
        sun: Vector2 | None = None,
        samples: int | None = None,
        bounds: Box | None = None,
        progress: Any = None,
    ) -> NDArray[np.uint8]:
        """Returns a picture of the solid: an array (height, width, 3) of sRGB. `size` is width and height in pixels.

        `camera` is azimuth and elevation in degrees, and the distance in multiples of the solid's radius. By default,
        all of the solid is shown from (30, 20). `eye` and `target` are points instead. `field_of_view` is in degrees. `show` is "shaded", "normal",
        "depth" or "heat". `ground` adds a plane below. `sun` is azimuth and elevation in degrees. `samples` are rays per
        pixel, from 1 to 64. `bounds` is the box that is seen.
        """
        options = _output.picture_options(camera, eye, target, field_of_view, show, ground, sun, samples, bounds)
        return _output.render(self, size, options, progress)

    def save_picture(
        self,
        path: str | os.PathLike[str],
        size: Sequence[int] = (640, 480),
        *,
        camera: Vector3 | None = None,
        eye: Vector3 | None = None,
        target: Vector3 | None = None,
        field_of_view: float | None = None,
        show: str = "shaded",
        ground: bool = False,
        sun: Vector2 | None = None,
        samples: int | None = None,
        bounds: Box | None = None,
        progress: Any = None,
    ) -> None:
        """Writes what `render` returns to a PNG file."""
        options = _output.picture_options(camera, eye, target, field_of_view, show, ground, sun, samples, bounds)
        _output.save_picture(self, path, size, options, progress)

    def turntable(
        self,
        path: str | os.PathLike[str],
        frames: int = 36,
        size: Sequence[int] = (320, 240),
        seconds: float = 3.0,
        *,
        camera: Vector3 | None = None,
        field_of_view: float | None = None,
        show: str = "shaded",
        ground: bool = False,
        sun: Vector2 | None = None,
        samples: int | None = None,
        bounds: Box | None = None,
        progress: Any = None,
    ) -> None:
        """Writes an animation of one turn around the solid to a GIF file. The others are those of `render`."""
        pictures = {
            "field_of_view": field_of_view, "show": show, "ground": ground, "sun": sun, "samples": samples, "bounds": bounds,
        }  # fmt: skip
        _output.turntable(self, path, frames, size, seconds, camera, pictures, progress)

    def show(self) -> Any:
        """Opens the solid in Argil's editor, and returns its process. Raises FileNotFoundError if it is not installed."""
        return _output.show(self)

    def slice_image(
        self,
        w: int = 1024,
        h: int = 1024,
        x: float | None = None,
        y: float | None = None,
        z: float | None = None,
        bounds: Box | None = None,
    ) -> NDArray[np.float32]:
        """Returns distances in a plane: see `sample_slice`."""
        return _output.sample_slice(self, w, h, x, y, z, bounds)[0]

    def show_slice(
        self,
        w: int = 1024,
        h: int = 1024,
        x: float | None = None,
        y: float | None = None,
        z: float | None = None,
        bounds: Box | None = None,
        *,
        abs: bool = False,
    ) -> None:
        """Plots distances in a plane by matplotlib, without their sign if `abs` is true. See `sample_slice`."""
        _output.show_slice(self, abs, w=w, h=h, x=x, y=y, z=z, bounds=bounds)

    def _repr_png_(self) -> bytes | None:
        return _output.notebook_picture(self)

    def __repr__(self) -> str:
        return f"<argil.SDF3 of {_output.described(self)}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _output.rebuilt, ("SDF3", *self._node.to_json(), self._blend)

    def __getattr__(self, name: str) -> Any:
        if name in _operators:
            return functools.partial(_operators[name], self)
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    # Places.

    def translate(self, offset: Vector3) -> SDF3:
        """Moves the solid."""
        return self._of(translated(self._node, to_scene(vector3("offset", offset))))

    def scale(self, factor: Vector3 | SupportsFloat) -> SDF3:
        """Scales by one factor, or by one per axis, from 1e-3 to 1e3. Factors that differ make distances bounds."""
        if is_number(factor):
            return self._of(modified(self._node, "scale", by=number("factor", factor)))
        return self._of(modified(self._node, "stretch", by=size_to_scene(vector3("factor", factor))))

    def rotate(self, angle: float, vector: Vector3 = _UP) -> SDF3:
        """Rotates about an axis through the origin by an angle in radians, counterclockwise seen from its tip."""
        axis = unit("vector", vector3("vector", vector))
        return self._of(turned(self._node, to_scene(axis), math.degrees(number("angle", angle))))

    def rotate_to(self, a: Vector3, b: Vector3) -> SDF3:
        """Rotates by the angle between two directions, from `b` to `a`, as fogleman/sdf's code does.

        What pointed along `b` points along `a` then. His documentation says the opposite, which `point_along` does.
        """
        return self._turned_between(unit("b", vector3("b", b)), unit("a", vector3("a", a)))

    def orient(self, axis: Vector3) -> SDF3:
        """Rotates the solid so that what pointed along an axis points along z, as fogleman/sdf's code does.

        Solids that look the same from above and from below lie along the axis then. For others, see `point_along`.
        """
        return self.rotate_to(_UP, axis)

    def point_along(self, axis: Vector3) -> SDF3:
        """Rotates the solid so that its z points along an axis."""
        return self._turned_between(_UP, unit("axis", vector3("axis", axis)))

    def _turned_between(self, a: Sequence[float], b: Sequence[float]) -> SDF3:
        cosine = sum(p * q for p, q in zip(a, b, strict=True))
        axis = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        sine = math.sqrt(sum(part * part for part in axis))
        if sine < 1e-12:
            if cosine > 0:
                return self
            # His axis for half a turn.
            axis = (0.0, a[2], -a[1]) if a[1] or a[2] else (0.0, 0.0, a[0])
        return self._of(turned(self._node, to_scene(axis), math.degrees(math.atan2(sine, cosine))))

    def circular_array(self, count: int, offset: float = 0.0) -> SDF3:
        """Repeats around z at equal angles, at a distance from it. The first copy lies on the x axis."""
        moved = translated(self._node, [number("offset", offset), 0.0, 0.0])
        return self._of(modified(moved, "radial_repeat", count=_count("count", count)))

    def repeat(
        self,
        spacing: Vector3 | SupportsFloat,
        count: Any = None,
        padding: Any = 0,
    ) -> SDF3:
        """Repeats at a distance along each axis, 0 for an axis without copies.

        `count` is the number of copies on each side of the first, or None without end. Copies may overlap: as many as matter
        are looked at, so that `padding` is accepted and changes nothing.
        """
        del padding
        steps = size3("spacing", spacing)
        many = counts(count, steps)
        node = modified(
            self._node,
            "repeat",
            spacing=size_to_scene(steps),
            **({} if many is None else {"count": [int(n) for n in size_to_scene(many)]}),
        )
        return self._of(node)

    def mirror(self, x: bool = False, y: bool = False, z: bool = False) -> SDF3:
        """Keeps the positive side along each chosen axis, and adds its mirror image."""
        return self._of(modified(self._node, "mirror", axes=[bool(x), bool(z), bool(y)]))

    def instances(self, positions: ArrayLike, degrees: ArrayLike = 0.0, scales: ArrayLike = 1.0) -> SDF3:
        """Copies the solid to positions of shape (N, 3), each rotated about z and scaled. Copies cost little memory."""
        import numpy as np

        at = as_points("positions", positions)
        turns = np.broadcast_to(np.asarray(degrees, dtype=float), len(at))
        sizes = np.broadcast_to(np.asarray(scales, dtype=float), len(at))
        poses = [
            [*to_scene([float(c) for c in p]), float(turn), float(size)] for p, turn, size in zip(at, turns, sizes, strict=True)
        ]
        return self._of(modified(self._node, "instances", poses=poses))

    # Deformations.

    def elongate(self, size: Vector3 | SupportsFloat) -> SDF3:
        """Cuts the solid at the origin and pulls the halves apart by a distance to each side along each axis."""
        return self._of(modified(self._node, "elongate", by=size_to_scene(size3("size", size))))

    def twist(self, k: float) -> SDF3:
        """Rotates about z by `k` radians per unit of height. The solid must have an end."""
        return self._of(modified(self._node, "twist", degrees_per_unit=math.degrees(number("k", k))))

    def bend(self, k: float) -> SDF3:
        """Rotates in the x-y plane by `k` radians per unit along x. The solid must have an end."""
        bent = modified(lying(self._node), "bend", degrees_per_unit=math.degrees(number("k", k)))
        return self._of(upright(bent))

    def bend_linear(self, p0: Vector3, p1: Vector3, v: Vector3, e: Ease = linear) -> SDF3:
        """Moves by a share of `v`, which goes from 0 at `p0` to 1 at `p1` along an easing function."""
        ramp = ramp_along(to_scene(vector3("p0", p0)), to_scene(vector3("p1", p1)), e)
        return self._of(modified(self._node, "shift", by=to_scene(vector3("v", v)), along=ramp))

    def bend_radial(self, r0: float, r1: float, dz: float, e: Ease = linear) -> SDF3:
        """Lifts by a share of `dz`, which goes from 0 at the distance `r0` from z to 1 at `r1` along an easing function."""
        ramp = ramp_with_radius(number("r0", r0), number("r1", r1), e)
        return self._of(modified(self._node, "shift", by=[0.0, number("dz", dz), 0.0], along=ramp))

    def transition_linear(self, f1: SDF3, p0: Vector3 = (0, 0, -1), p1: Vector3 = _UP, e: Ease = linear) -> SDF3:
        """Morphs into another solid from `p0` to `p1`."""
        ramp = ramp_along(to_scene(vector3("p0", p0)), to_scene(vector3("p1", p1)), e)
        return self._morphed(f1, ramp)

    def transition_radial(self, f1: SDF3, r0: float = 0, r1: float = 1, e: Ease = linear) -> SDF3:
        """Morphs into another solid from the distance `r0` from z to `r1`."""
        return self._morphed(f1, ramp_with_radius(number("r0", r0), number("r1", r1), e))

    def wrap_around(self, x0: float, x1: float, r: float | None = None, e: Ease = linear) -> SDF3:
        """Wraps the part from `x0` to `x1` around z, once. Its y becomes the distance inward from the radius `r`."""
        from .ease import _pieces

        first, last = number("x0", x0), number("x1", x1)
        if first == last:
            raise ValueError(f"x1: start and end coincide, at {first}")
        radius = abs(last - first) / math.tau if r is None else number("r", r)
        node = modified(
            self._node,
            "wrap",
            **{"from": first, "to": last, "radius": radius, "curve": _pieces(e)},
        )
        return self._of(node)

    def displace(self, amplitude: float, frequency: float, seed: int = 0, octaves: int = 3) -> SDF3:
        """Moves the surface in and out by value noise. The frequency is in cells of noise per unit."""
        node = modified(
            self._node,
            "displace",
            amplitude=number("amplitude", amplitude),
            frequency=number("frequency", frequency),
            seed=int(seed),
            octaves=int(octaves),
        )
        return self._of(node)

    def slice(self) -> SDF2:
        """Returns the section at z = 0 as a profile."""
        from ._sdf2 import SDF2

        return SDF2(modified(lying(self._node), "extrude", half_depth=ENDLESS))


def _count(name: str, value: Any) -> int:
    count = number(name, value)
    if count != int(count) or count < 0:
        raise ValueError(f"{name}: {value} is not a count")
    return int(count)


def _paired(origins: Any, directions: Any) -> tuple[Any, Any]:
    import numpy as np

    both = []
    for name, values in (("origins", origins), ("directions", directions)):
        if not isinstance(values, np.ndarray) and hasattr(values, "__dlpack__"):
            values = np.from_dlpack(values)
        array = np.asarray(values)
        both.append(as_points(name, array.reshape(1, -1) if array.ndim == 1 and array.size == 3 else values))
    starts, ways = both
    if len(starts) != len(ways) and 1 in (len(starts), len(ways)):
        count = len(ways) if len(starts) == 1 else len(starts)
        starts, ways = (np.ascontiguousarray(np.broadcast_to(a, (count, 3))) for a in (starts, ways))
    return starts, ways


# Shapes.


def _placed(node: _native.Node, center: Vector3) -> SDF3:
    return SDF3(translated(node, to_scene(point3("center", center))))


def sphere(radius: float = 1, center: Vector3 = _ORIGIN) -> SDF3:
    """Sphere."""
    return _placed(shape("sphere", radius=number("radius", radius)), center)


def plane(normal: Vector3 = _UP, point: Vector3 = _ORIGIN) -> SDF3:
    """Half space above a point, in the direction of the normal."""
    n = unit("normal", vector3("normal", normal))
    offset = -sum(a * b for a, b in zip(n, vector3("point", point), strict=True))
    return SDF3(shape("plane", normal=to_scene([-part for part in n]), offset=offset))


def slab(
    x0: float | None = None,
    y0: float | None = None,
    z0: float | None = None,
    x1: float | None = None,
    y1: float | None = None,
    z1: float | None = None,
    k: float | None = None,
) -> SDF3:
    """Space between planes. `k` blends the edges where planes of two axes meet."""
    parts = []
    for axis, (low, high) in enumerate(((x0, x1), (y0, y1), (z0, z1))):
        normal = [0.0, 0.0, 0.0]
        normal[axis] = 1.0
        if low is not None and high is not None:
            low, high = number("xyz"[axis] + "0", low), number("xyz"[axis] + "1", high)
            if low >= high:
                raise ValueError(f"slab: {'xyz'[axis]}0 = {low} is not below {'xyz'[axis]}1 = {high}")
            sides = [ENDLESS] * 3
            sides[axis] = 0.5 * (high - low)
            middle = [0.5 * (low + high) * part for part in normal]
            parts.append(_placed(shape("box", half_size=size_to_scene(sides)), middle))
        elif low is not None:
            parts.append(plane(normal, [number("xyz"[axis] + "0", low) * part for part in normal]))
        elif high is not None:
            way = [-part for part in normal]
            parts.append(plane(way, [number("xyz"[axis] + "1", high) * part for part in normal]))
    if not parts:
        raise ValueError("slab: at least one of x0, y0, z0, x1, y1, z1 is needed")
    return parts[0].intersection(*parts[1:], k=k)


def box(
    size: Vector3 | SupportsFloat = 1,
    center: Vector3 = _ORIGIN,
    a: Vector3 | None = None,
    b: Vector3 | None = None,
) -> SDF3:
    """Box of a size along each axis around a center, or between two corners."""
    if a is not None and b is not None:
        low, high = vector3("a", a), vector3("b", b)
        size = tuple(q - p for p, q in zip(low, high, strict=True))
        center = tuple(0.5 * (p + q) for p, q in zip(low, high, strict=True))
    return _placed(shape("box", half_size=half(size_to_scene(size3("size", size)))), center)


def rounded_box(size: Vector3 | SupportsFloat, radius: float) -> SDF3:
    """Box with rounded edges, within its size."""
    sides = half(size_to_scene(size3("size", size)))
    return SDF3(shape("box", half_size=sides, rounding=number("radius", radius)))


def wireframe_box(size: Vector3 | SupportsFloat, thickness: float) -> SDF3:
    """The edges of a box as square beams, whose middles are on its edges."""
    thick = number("thickness", thickness)
    sides = [0.5 * (part + thick) for part in size_to_scene(size3("size", size))]
    return SDF3(shape("box_frame", half_size=sides, half_thickness=0.5 * thick))


def torus(r1: float, r2: float) -> SDF3:
    """Torus about z: a tube of radius `r2` around a circle of radius `r1`."""
    return SDF3(shape("torus", major_radius=number("r1", r1), minor_radius=number("r2", r2)))


def capsule(a: Vector3, b: Vector3, radius: float) -> SDF3:
    """Sphere swept from one point to another."""
    start, end = to_scene(vector3("a", a)), to_scene(vector3("b", b))
    return SDF3(shape("capsule", **{"from": start, "to": end, "radius": number("radius", radius)}))


def cylinder(radius: float) -> SDF3:
    """Infinite cylinder about z."""
    return SDF3(shape("cylinder", radius=number("radius", radius), half_height=ENDLESS))


def _between(node: _native.Node, a: Vector3, b: Vector3) -> SDF3:
    """Places what stands around the origin between two points."""
    start, end = vector3("a", a), vector3("b", b)
    axis = tuple(q - p for p, q in zip(start, end, strict=True))
    middle = tuple(0.5 * (p + q) for p, q in zip(start, end, strict=True))
    return SDF3(node).point_along(axis).translate(middle)


def capped_cylinder(a: Vector3, b: Vector3, radius: float) -> SDF3:
    """Cylinder between two points."""
    height = math.dist(vector3("a", a), vector3("b", b))
    node = shape("cylinder", radius=number("radius", radius), half_height=0.5 * height)
    return _between(node, a, b)


def rounded_cylinder(ra: float, rb: float, h: float) -> SDF3:
    """Cylinder about z of radius `ra` and height `h`, whose rims have the radius `rb`."""
    node = shape("cylinder", radius=number("ra", ra), half_height=0.5 * number("h", h), rounding=number("rb", rb))
    return SDF3(node)


def capped_cone(a: Vector3, b: Vector3, ra: float, rb: float) -> SDF3:
    """Cone between two points with a radius at each."""
    height = math.dist(vector3("a", a), vector3("b", b))
    node = shape(
        "capped_cone",
        half_height=0.5 * height,
        bottom_radius=number("ra", ra),
        top_radius=number("rb", rb),
    )
    return _between(node, a, b)


def rounded_cone(r1: float, r2: float, h: float) -> SDF3:
    """Hull of a sphere of radius `r1` at the origin and one of radius `r2` above it at `h`."""
    node = shape("round_cone", bottom_radius=number("r1", r1), top_radius=number("r2", r2), height=number("h", h))
    return SDF3(node)


def ellipsoid(size: Vector3 | SupportsFloat) -> SDF3:
    """Ellipsoid with semi-axes."""
    return SDF3(shape("ellipsoid", radii=size_to_scene(size3("size", size))))


def pyramid(h: float) -> SDF3:
    """Pyramid over a unit square at z = 0, whose tip is at `h`."""
    return SDF3(shape("pyramid", base=1.0, height=number("h", h)))


def _polyhedron(radius: float, planes: Sequence[tuple[Sequence[float], float]], symmetric: bool) -> SDF3:
    """Intersects a box with planes: their normals, and their distances from the origin."""
    node = shape("box", half_size=[radius] * 3)
    for normal, offset in planes:
        own = shape("plane", normal=to_scene(normal) if not symmetric else size_to_scene(normal), offset=offset)
        node = node.joined(own, "intersect", 0.0, "smooth", 0.0, None)
    return SDF3(modified(node, "mirror", axes=[True, True, True]) if symmetric else node)


def _radius(r: float) -> float:
    value = number("r", r)
    if value <= 0:
        raise ValueError(f"r: {value} is not above 0")
    return value


def tetrahedron(r: float) -> SDF3:
    """Tetrahedron whose faces are r/√3 from the origin."""
    r = _radius(r)
    normals = ((1, 1, -1), (-1, -1, -1), (1, -1, 1), (-1, 1, 1))
    return _polyhedron(1.5 * r, [(n, r / math.sqrt(3)) for n in normals], False)


def octahedron(r: float) -> SDF3:
    """Octahedron with its corners on the axes, at the distance r."""
    return SDF3(shape("octahedron", radius=number("r", r)))


def dodecahedron(r: float) -> SDF3:
    """Dodecahedron whose faces are 0.8507 r from the origin."""
    r = _radius(r)
    x, y, z = unit("", ((1 + math.sqrt(5)) / 2, 1.0, 0.0))
    return _polyhedron(2 * r, [(n, x * r) for n in ((x, y, z), (z, x, y), (y, z, x))], True)


def icosahedron(r: float) -> SDF3:
    """Icosahedron with its corners at 0.9511 r from the origin."""
    r = _radius(r) * 0.8506507174597755
    x, y, z = unit("", ((math.sqrt(5) + 3) / 2, 1.0, 0.0))
    w = math.sqrt(3) / 3
    return _polyhedron(2 * r, [(n, x * r) for n in ((x, y, z), (z, x, y), (y, z, x), (w, w, w))], True)


def _function(name: str) -> Callable[..., Any]:
    """Returns a method as a function, whose first argument is the solid."""
    method = getattr(SDF3, name)

    @functools.wraps(method)
    def call(other: SDF3, *arguments: Any, **options: Any) -> Any:
        from ._sdf2 import SDF2

        kind = SDF2 if isinstance(other, SDF2) else SDF3
        return getattr(kind, name)(other, *arguments, **options)

    return call


union = _function("union")
difference = _function("difference")
intersection = _function("intersection")
blend = _function("blend")
negate = _function("negate")
dilate = _function("dilate")
erode = _function("erode")
shell = _function("shell")
repeat = _function("repeat")
translate = _function("translate")
scale = _function("scale")
rotate = _function("rotate")
rotate_to = _function("rotate_to")
orient = _function("orient")
circular_array = _function("circular_array")
elongate = _function("elongate")
twist = _function("twist")
bend = _function("bend")
bend_linear = _function("bend_linear")
bend_radial = _function("bend_radial")
transition_linear = _function("transition_linear")
transition_radial = _function("transition_radial")
wrap_around = _function("wrap_around")
slice = _function("slice")
