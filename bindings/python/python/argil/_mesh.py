"""Triangle meshes."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from . import _native

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._sdf3 import SDF3 as Solid3
    from ._sdf3 import Box


class Mesh:
    """Triangles with shared corners. The axis z points up."""

    def __init__(self, native: _native.Mesh) -> None:
        self._native = native
        self._arrays: dict[str, Any] = {}

    def _array(self, name: str) -> Any:
        if name not in self._arrays:
            self._arrays[name] = getattr(self._native, name)
        return self._arrays[name]

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Mesh:
        """Reads triangles from a .glb, .gltf, .obj, .ply, .stl or .3mf file. `sdf` turns them into a solid."""
        return cls(_native.Mesh.from_file(os.fspath(path)))

    @classmethod
    def from_arrays(cls, vertices: ArrayLike, triangles: ArrayLike) -> Mesh:
        """Makes a mesh of corners of shape (V, 3) and triangles of shape (T, 3)."""
        import numpy as np

        from ._arrays import as_points

        corners = np.ascontiguousarray(as_points("vertices", vertices), dtype=np.float32)
        indices = np.asarray(np.from_dlpack(triangles) if hasattr(triangles, "__dlpack__") else triangles)  # type: ignore[arg-type]
        if corners.ndim != 2 or corners.shape[1] != 3:
            raise ValueError(f"vertices: expected shape (V, 3), not {corners.shape}")
        if indices.ndim != 2 or indices.shape[1] != 3 or indices.dtype.kind not in "iu":
            raise ValueError(f"triangles: expected integers of shape (T, 3), not {indices.dtype} of {indices.shape}")
        if indices.size and (indices.min() < 0 or indices.max() >= len(corners)):
            raise ValueError(f"triangles: an index is not from 0 to {len(corners) - 1}")
        return cls(_native.Mesh.from_arrays(corners, np.ascontiguousarray(indices, dtype=np.uint32)))

    @property
    def vertices(self) -> NDArray[np.float32]:
        """Corners: an array (V, 3)."""
        return self._array("vertices")

    @property
    def triangles(self) -> NDArray[np.uint32]:
        """The corners of each triangle, counterclockwise seen from outside: an array (T, 3)."""
        return self._array("triangles")

    @property
    def normals(self) -> NDArray[np.float32]:
        """A unit normal per corner: an array (V, 3), or (0, 3) if they were left out."""
        return self._array("normals")

    @property
    def colors(self) -> NDArray[np.float32]:
        """A linear base color per corner: an array (V, 3), or (0, 3) if they were left out."""
        return self._array("colors")

    @property
    def voxel_size(self) -> float:
        """The distance between the samples that it was made from."""
        return self._native.voxel_size

    @property
    def is_watertight(self) -> bool:
        """Whether every edge belongs to two triangles that face the same side."""
        return self._native.is_watertight

    @property
    def volume(self) -> float:
        """The enclosed volume."""
        return self._native.volume

    @property
    def area(self) -> float:
        """The area of the surface."""
        return self._native.area

    def center_of_mass(self) -> tuple[float, float, float]:
        """Returns the center of mass of what is enclosed, with a constant density."""
        x, y, z = self._native.center_of_mass()
        return x, y, z

    @property
    def bounding_box(self) -> Box:
        """The lowest and the highest corner of its box."""
        if not len(self.vertices):
            raise ValueError("the mesh is empty")
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        return (
            (float(low[0]), float(low[1]), float(low[2])),
            (float(high[0]), float(high[1]), float(high[2])),
        )

    @property
    def size(self) -> tuple[float, float, float]:
        """The lengths of its box."""
        low, high = self.bounding_box
        return high[0] - low[0], high[1] - low[1], high[2] - low[2]

    def sdf(self, voxel_size: float | None = None, half_width: float | None = None, *, resolution: int = 128) -> Solid3:
        """Returns the solid that the triangles enclose. Holes are closed.

        It is sampled at `voxel_size`, or at `resolution` places along its longest side, from 16 to 512: smaller voxels than 1/512 of it are not
        made. `half_width` is
        accepted and changes nothing: distances are known everywhere.
        """
        del half_width
        from ._sdf3 import SDF3

        if voxel_size is not None:
            if not voxel_size > 0:
                raise ValueError(f"voxel_size: {voxel_size} is not above 0")
            resolution = min(max(16, round(max(self.size) / voxel_size)), 512)
        return SDF3(self._native.solid(resolution))

    def save(self, path: str | os.PathLike[str], *, scale: float = 1.0) -> None:
        """Writes the triangles to a .glb, .gltf, .obj, .ply, .stl or .3mf file, all lengths multiplied by `scale`."""
        from ._numbers import number

        name, factor = os.fspath(path), number("scale", scale)
        if factor <= 0:
            raise ValueError(f"scale: {factor} is not above 0")
        self._native.save(name, name.lower().endswith((".glb", ".gltf", ".3mf")), factor)

    def to_trimesh(self) -> Any:
        """Returns a `trimesh.Trimesh` with shared corners, normals and colors."""
        import numpy as np
        import trimesh

        options: dict[str, Any] = {"process": False}
        if len(self.normals):
            options["vertex_normals"] = self.normals
        if len(self.colors):
            linear = np.clip(self.colors, 0, 1)
            srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
            options["vertex_colors"] = np.round(255 * srgb).astype(np.uint8)
        return trimesh.Trimesh(self.vertices, self.triangles.astype(np.int64), **options)

    def to_pyvista(self) -> Any:
        """Returns a `pyvista.PolyData`, with the arrays "Normals" and "Colors" if there are any."""
        import pyvista

        data = pyvista.PolyData.from_regular_faces(self.vertices, self.triangles.astype("int64"))
        for name, values in (("Normals", self.normals), ("Colors", self.colors)):
            if len(values):
                data.point_data[name] = values
        return data

    def __repr__(self) -> str:
        count, corners = self._native.triangle_count, self._native.vertex_count
        return f"<argil.Mesh of {count:,} triangles and {corners:,} corners, voxels of {self.voxel_size:.4g}>"

    def __reduce__(self) -> tuple[Any, ...]:
        # Normals and colors are left out.
        return Mesh.from_arrays, (self.vertices, self.triangles)

    def __len__(self) -> int:
        return self._native.triangle_count
