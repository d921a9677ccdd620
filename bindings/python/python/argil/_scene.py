"""Scenes that change, and sparse bricks that follow them."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from . import _native, _output
from ._arrays import as_points
from ._mesh import Mesh
from ._numbers import Vector2, Vector3, length, number, to_scene, unit, vector3
from ._operators import Material
from ._sdf3 import SDF3, Box

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

SceneNode = _native.SceneNode

_OPERATORS = {"union": "union", "difference": "subtract", "intersection": "intersect", "paint": "paint"}


def _operator(name: str) -> str:
    if name not in _OPERATORS:
        raise ValueError(f"operator: {name!r} is none of {', '.join(_OPERATORS)}")
    return _OPERATORS[name]


class NodeInfo(NamedTuple):
    """A brush or a group of a scene."""

    node: SceneNode
    name: str
    #: The shape, such as "Sphere", or "Group".
    kind: str
    visible: bool
    material: str | None
    #: Where it stands in the scene file, such as brushes[0].brushes[2].
    path: str
    #: The group around it, or None for the scene.
    parent: SceneNode | None


class Scene:
    """An ordered list of brushes and groups that can be changed, with undo. The axis z points up, as everywhere in Python.

    >>> from argil import *
    >>> scene = Scene(sphere(1))
    >>> hole = scene.add(cylinder(0.3), "difference", k=0.1, name="hole")
    >>> scene.translate(hole, (0.2, 0, 0))
    >>> scene.undo()
    True
    """

    def __init__(self, solid: SDF3 | None = None) -> None:
        self._native = _native.Scene()
        if solid is not None:
            self.add(solid)
            self._native.forget_history()

    @classmethod
    def _of(cls, native: _native.Scene) -> Scene:
        scene = cls()
        scene._native = native
        return scene

    @classmethod
    def load(
        cls,
        path: str | os.PathLike[str],
        *,
        external: bool | Sequence[str | os.PathLike[str]] = False,
        progress: Any = None,
    ) -> Scene:
        """Reads a scene file, .json or .argil. Meshes that it names are read too, from its folder.

        `external` allows others: True all, or a list of files these.

        Raises SceneError with the place in the file, or OSError.
        """
        return cls._of(_native.Scene.load(os.fspath(path), _output.external_of(external), _output.progress_of(progress)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a scene file, .json, which has y up: the solid is turned."""
        name = os.fspath(path)
        if not name.lower().endswith(".json"):
            raise ValueError(f"{name}: a scene file is a .json file")
        self._native.save(name)

    def add(
        self,
        solid: SDF3,
        operator: str = "union",
        *,
        k: float | None = None,
        chamfer: float | None = None,
        name: str | None = None,
        parent: SceneNode | None = None,
    ) -> SceneNode:
        """Appends a solid, which joins ("union"), cuts ("difference"), limits ("intersection") or paints what is before it."""
        if not isinstance(solid, SDF3):
            raise TypeError(f"expected a solid, not {solid!r}")
        blend, profile = _blend(solid._blend if k is None else k, chamfer)
        return self._native.add(solid._node, _operator(operator), blend, profile, name, parent)

    def group(
        self,
        operator: str = "union",
        *,
        k: float | None = None,
        name: str | None = None,
        parent: SceneNode | None = None,
    ) -> SceneNode:
        """Appends an empty group. What is added to it is combined first, and then joins the scene as one solid."""
        return self._native.group(_operator(operator), length("k", k or 0.0), name, parent)

    def remove(self, node: SceneNode) -> None:
        """Removes a brush, or a group with its contents."""
        self._native.remove(node)

    def move(self, node: SceneNode, index: int, parent: SceneNode | None = None) -> None:
        """Moves a node to another place in the scene or in a group."""
        if index < 0:
            raise ValueError(f"index: {index} is below 0")
        self._native.move_to(node, parent, index)

    def translate(self, node: SceneNode, offset: Vector3) -> None:
        """Moves a node, along the axes of the group around it."""
        self._transform(node, "translate", by=to_scene(vector3("offset", offset)))

    def rotate(self, node: SceneNode, angle: float, vector: Vector3 = (0, 0, 1)) -> None:
        """Rotates a node about an axis through the origin, by an angle in radians."""
        axis = to_scene(unit("vector", vector3("vector", vector)))
        self._transform(node, "rotate", axis=axis, degrees=math.degrees(number("angle", angle)))

    def scale(self, node: SceneNode, factor: float) -> None:
        """Scales a node about the origin."""
        self._transform(node, "scale", by=number("factor", factor))

    def _transform(self, node: SceneNode, kind: str, **parameters: Any) -> None:
        self._native.transform(node, json.dumps({"type": kind, **parameters}))

    def rename(self, node: SceneNode, name: str) -> None:
        """Names a node."""
        self._native.rename(node, name)

    def set_visible(self, node: SceneNode, visible: bool) -> None:
        """Shows or hides a node."""
        self._native.set_visible(node, bool(visible))

    def set_operator(self, node: SceneNode, operator: str) -> None:
        """Changes how a node combines with what is before it."""
        self._native.set_operator(node, _operator(operator))

    def set_blend(self, node: SceneNode, k: float | None = None, *, chamfer: float | None = None) -> None:
        """Changes the blend radius of a node's joint."""
        self._native.set_blend(node, *_blend(k, chamfer))

    def paint(self, node: SceneNode, color: Any, name: str | None = None, **material: Any) -> None:
        """Gives a node a material, under a name of its own or the color's."""
        own = color if isinstance(color, Material) else Material(color, **material)
        known = name or (color if isinstance(color, str) else "color " + "-".join(f"{c:.3f}" for c in own.color))
        self._native.paint(node, known, own._json())

    def undo(self) -> bool:
        """Takes the last change back. Returns whether there was one."""
        return self._native.undo()

    def redo(self) -> bool:
        """Repeats what was taken back. Returns whether there was something."""
        return self._native.redo()

    @property
    def undo_depth(self) -> int:
        """Changes that can be taken back."""
        return self._native.undo_depth

    def nodes(self) -> list[NodeInfo]:
        """Returns all brushes and groups, each before its contents."""
        return [self.info(node) for node in self._native.nodes()]

    def __iter__(self) -> Iterator[NodeInfo]:
        return iter(self.nodes())

    def __len__(self) -> int:
        """The number of brushes."""
        return self._native.brush_count

    def info(self, node: SceneNode) -> NodeInfo:
        """Returns name, kind and place of a node. Raises KeyError if it is gone."""
        return NodeInfo(node, *self._native.facts(node))

    def find(self, name: str) -> SceneNode:
        """Returns the first node of a name. Raises KeyError if there is none."""
        for own in self.nodes():
            if own.name == name:
                return own.node
        raise KeyError(f"no node is named {name!r}")

    def solid(self) -> SDF3:
        """Returns the scene as it is now as a solid, which later changes do not touch."""
        return SDF3(self._native.solid())

    def bricks(
        self,
        resolution: int = 256,
        *,
        voxel_size: float | None = None,
        bounds: Box | None = None,
        progress: Any = None,
    ) -> Bricks:
        """Returns sparse bricks of the scene, which follow its changes. `bounds` is the box of an infinite scene."""
        size = None if voxel_size is None else number("voxel_size", voxel_size)
        count = int(number("resolution", resolution))
        if not 8 <= count <= 1 << 22:
            raise ValueError(f"resolution: {count} is not from 8 to {1 << 22}")
        if bounds is None and self._native.brush_count:
            # An infinite scene needs a box.
            self._native.solid().finite_bounds()
        native = self._native.bricks(count, size, _output.checked_box(bounds), _output.progress_of(progress))
        return Bricks(self, native)

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
        """Renders the scene: see `SDF3.render`."""
        options = _output.picture_options(camera, eye, target, field_of_view, show, ground, sun, samples, bounds)
        return _output.render(self.solid(), size, options, progress)

    def show(self) -> Any:
        """Opens the scene in Argil's editor: see `SDF3.show`."""
        return self.solid().show()

    def _repr_png_(self) -> bytes | None:
        return self.solid()._repr_png_()

    def __repr__(self) -> str:
        return f"<argil.Scene of {len(self)} brushes>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt_scene, self._native.to_json()


def _rebuilt_scene(text: str, grids: list[tuple[str, int, bytes]]) -> Scene:
    return Scene._of(_native.Scene.from_json(text, grids))


def _blend(k: float | None, chamfer: float | None) -> tuple[float, str]:
    if chamfer is not None:
        if k:
            raise ValueError("k and chamfer exclude each other")
        return length("chamfer", chamfer), "chamfer"
    return length("k", k or 0.0), "smooth"


class EditReport(NamedTuple):
    """What following the changes of a scene took."""

    milliseconds: float
    #: The box outside of which nothing changed, or None if nothing did.
    changed: Box | None
    #: Whether all bricks were built again, and why.
    rebuilt: bool
    reason: str | None


class Bricks:
    """A scene as sparse bricks of distances. Changes rebuild only the bricks that they touch, and the result equals a fresh build.

    >>> from argil import *
    >>> bricks = sphere(1).bricks(128)
    >>> bricks -= sphere(0.3).translate((1, 0, 0))
    >>> bricks |= box(0.2).translate((0, 0, 1)).k(0.1)
    >>> bool(bricks.diff_from_rebuild() == 0)
    True
    """

    def __init__(self, scene: Scene, native: _native.Bricks) -> None:
        #: The scene that the bricks follow. Call `apply` after changing it.
        self.scene = scene
        self._native = native

    def apply(self, progress: Any = None) -> EditReport:
        """Follows all changes of the scene since the last call."""
        took, changed, rebuilt, reason = self._native.apply(_output.progress_of(progress))
        box = None if changed is None else (tuple(changed[0]), tuple(changed[1]))
        return EditReport(took, box, rebuilt, reason)  # type: ignore[arg-type]

    def edit(self, solid: SDF3, operator: str = "union", **options: Any) -> EditReport:
        """Adds a solid to the scene, as `Scene.add` does, and follows."""
        self.scene.add(solid, operator, **options)
        return self.apply()

    def __ior__(self, solid: SDF3) -> Bricks:
        self.edit(solid, "union")
        return self

    def __isub__(self, solid: SDF3) -> Bricks:
        self.edit(solid, "difference")
        return self

    def __iand__(self, solid: SDF3) -> Bricks:
        self.edit(solid, "intersection")
        return self

    def undo(self) -> bool:
        """Takes the last change of the scene back, and follows."""
        is_done = self.scene.undo()
        self.apply()
        return is_done

    def redo(self) -> bool:
        """Repeats what was taken back, and follows."""
        is_done = self.scene.redo()
        self.apply()
        return is_done

    @property
    def memory_bytes(self) -> int:
        """Bytes of all samples and tables."""
        return self._native.memory_bytes

    @property
    def resolution(self) -> tuple[int, int, int]:
        """Voxels along each axis."""
        x, y, z = self._native.resolution or (0, 0, 0)
        return x, y, z

    @property
    def voxel_size(self) -> float:
        """The edge of a voxel."""
        return self._native.facts()[0]

    @property
    def brick_count(self) -> int:
        """The number of bricks of 8³ voxels."""
        return self._native.facts()[1]

    @property
    def bounds(self) -> Box:
        """The box of the voxels."""
        low, high = self._native.facts()[2]
        return _output.plain_box(low, high)

    def distance(self, points: ArrayLike) -> NDArray[np.float32]:
        """Returns stored distances, interpolated, of points of shape (N, 3). Beyond the stored band, they are lower bounds."""
        return self._native.distances(as_points("points", points))

    def mesh(self, *, normals: bool = True, colors: bool = False) -> Mesh:
        """Returns the stored surface as triangles."""
        return Mesh(self._native.mesh(normals, colors))

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
        """Renders the stored surface: see `SDF3.render`. `show` may also be "bricks"."""
        options = _output.picture_options(camera, eye, target, field_of_view, show, ground, sun, samples, bounds)
        return self._native.render(*_output._size(size), options, _output.progress_of(progress))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the bricks and their scene to an .argil file."""
        name = os.fspath(path)
        if not name.lower().endswith(".argil"):
            raise ValueError(f"{name}: bricks are saved as an .argil file")
        self._native.save(name)

    def diff_from_rebuild(self) -> int | None:
        """Counts the cells that differ from bricks that are built from nothing: 0, unless there is a fault."""
        return self._native.diff_from_rebuild()

    def _repr_png_(self) -> bytes | None:
        return _native.encode_png(self.render((480, 360)))

    def __repr__(self) -> str:
        x, y, z = self.resolution
        return f"<argil.Bricks of {x} × {y} × {z} voxels, {self.memory_bytes / 2**20:.1f} MiB>"
