"""Reads solids from files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from . import _native, _output
from ._numbers import Vector3, number, vector3
from ._sdf3 import SDF3


def load(
    path: str | os.PathLike[str],
    *,
    resolution: int = 128,
    external: bool | Sequence[str | os.PathLike[str]] = False,
    voxel_size: float | None = None,
    origin: Vector3 | None = None,
    iso: float | None = None,
    fog: bool | None = None,
    grid: str | None = None,
    progress: Any = None,
) -> SDF3:
    """Reads a solid from a file.

    Scenes: .json, and .argil, which holds its scene beside its bricks. Triangles: .obj, .ply, .stl, .3mf, .glb, .gltf; holes
    are closed, and the solid is sampled at `resolution` places along its longest side, from 16 to 512. Volumes: .vdb, .nvdb,
    .nrrd and .npy, at their own voxels. What has y up by definition, .json, .argil, .glb and .gltf, is turned, so that z points
    up. Scenes may name meshes in their folder, and `external` ones: True allows all, and a list of files these.

    The axes of an array in a .npy file are [z, y, x], as in `SDF3.voxels`. It holds neither the size of voxels nor a place:
    `voxel_size` is the distance between samples, and `origin` the position (x, y, z) of the first one. Without them, the longest
    side is 2, and the middle is at the origin. `SDF3.voxel_grid` returns them for an array of `SDF3.voxels`. Both replace what a
    .nrrd file says.

    The surface of a volume is where values are `iso`, by default 0. `fog` tells whether values are densities, whose surface is at
    half of the largest one; by default, the file tells. `grid` is the name of a grid in a .vdb or .nvdb file.

    Raises SceneError or ValueError for what the file holds, TypeError for arguments that it does not take, and OSError if it
    cannot be read.
    """
    name = os.fspath(path)
    if not os.path.isfile(name):
        reason = "is a folder" if os.path.isdir(name) else "no such file"
        raise (IsADirectoryError if os.path.isdir(name) else FileNotFoundError)(f"{name}: {reason}")
    if not 16 <= resolution <= 512:
        raise ValueError(f"resolution: {resolution} is not from 16 to 512")
    ending = os.path.splitext(name)[1].lower()
    of_volumes = {"voxel_size": voxel_size, "origin": origin, "iso": iso, "fog": fog, "grid": grid}
    unused = [key for key, value in of_volumes.items() if value is not None]
    if ending in (".vdb", ".nvdb"):
        unused = [key for key in unused if key in ("voxel_size", "origin")]
    elif ending in _output.VOLUMES:
        unused = [key for key in unused if key == "grid"]
    if unused:
        raise TypeError(f"load: unexpected arguments for {ending}: {', '.join(unused)}")
    if ending in _output.VOLUMES:
        size = None if voxel_size is None else number("voxel_size", voxel_size)
        if size is not None and size <= 0:
            raise ValueError(f"voxel_size: {size} is not above 0")
        place = None if origin is None else vector3("origin", origin)
        level = None if iso is None else number("iso", iso)
        return _output.volume(name, None, grid, fog, level, size, place, progress)
    if ending in _output.OWN:
        return SDF3(_native.Scene.load(name, _output.external_of(external), _output.progress_of(progress)).solid())
    known = (*_output.MESHES, *_output.VOLUMES, *_output.OWN, ".grid")
    if ending not in known:
        raise ValueError(f"{name}: unknown extension; known are {', '.join(known)}")
    node = _native.Node.from_file(name, int(resolution), _output.progress_of(progress))
    solid = SDF3(node)
    # These files say which axis points up, and are turned already. All others have the axes of these points.
    return solid if ending in (".glb", ".gltf", ".3mf") else solid.rotate(-1.5707963267948966, (1, 0, 0))
