"""Reads solids from files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

from . import _native, _output
from ._sdf3 import SDF3


def load(
    path: str | os.PathLike[str],
    *,
    resolution: int = 128,
    external: bool | Sequence[str | os.PathLike[str]] = False,
    progress: Any = None,
) -> SDF3:
    """Reads a solid from a file.

    Scenes: .json. Triangles: .obj, .ply, .stl, .3mf, .glb, .gltf; holes are closed, and the solid is sampled at `resolution` places
    along its longest side, from 16 to 512. Volumes: .vdb, .nvdb and .nrrd, at their own voxels, and
    .npy, which holds neither the size of voxels, taken as 1, nor a place. What has y up by definition,
    .json, .glb and .gltf, is turned, so that z points up. Scenes may name meshes in their folder, and `external` ones: True
    allows all, and a list of files these.

    Raises SceneError or ValueError for what the file holds, and OSError if it cannot be read.
    """
    name = os.fspath(path)
    if not os.path.isfile(name):
        reason = "is a folder" if os.path.isdir(name) else "no such file"
        raise (IsADirectoryError if os.path.isdir(name) else FileNotFoundError)(f"{name}: {reason}")
    if not 16 <= resolution <= 512:
        raise ValueError(f"resolution: {resolution} is not from 16 to 512")
    ending = os.path.splitext(name)[1].lower()
    if ending == ".json":
        return SDF3(_native.Scene.load(name, _output.external_of(external), _output.progress_of(progress)).solid())
    known = (*_output.MESHES, *_output.VOLUMES, ".json", ".grid")
    if ending not in known:
        raise ValueError(f"{name}: unknown extension; known are {', '.join(known)}")
    node = _native.Node.from_file(name, int(resolution), _output.progress_of(progress))
    solid = SDF3(node)
    # These files say which axis points up, and are turned already. All others have the axes of these points.
    return solid if ending in (".glb", ".gltf", ".3mf") else solid.rotate(-1.5707963267948966, (1, 0, 0))
