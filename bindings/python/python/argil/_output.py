"""Meshes, files, volumes and pictures of solids."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from . import _native
from ._numbers import number, to_scene, vector2, vector3

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ._mesh import Mesh
    from ._sdf3 import SDF3, Box

MESHES = (".stl", ".obj", ".ply", ".glb", ".gltf", ".3mf")
VOLUMES = (".vdb", ".nvdb", ".npy", ".nrrd")
OWN = (".argil", ".json")


def progress_of(progress: Any) -> Any:
    """Returns a function of stage, done and total from a function or a tqdm bar."""
    if progress is None or not hasattr(progress, "update"):
        if progress is not None and not callable(progress):
            raise TypeError(f"progress: expected a function of stage, done and total, or a tqdm bar, not {progress!r}")
        return progress

    latest = ""

    def advance(stage: str, done: int, total: int) -> None:
        nonlocal latest
        if stage != latest:
            latest = stage
            progress.reset(total=total or None)
            progress.set_description(stage, refresh=False)
        progress.total = total or None
        progress.update(done - progress.n)

    return advance


def external_of(external: bool | Sequence[str | os.PathLike[str]]) -> bool | tuple[str, ...]:
    """Returns which files outside of its folder a scene may read: all, none, or these."""
    if isinstance(external, bool):
        return external
    if isinstance(external, (str, bytes, os.PathLike)):
        raise TypeError(f"external: expected True, False or a list of files, not {external!r}")
    return tuple(os.path.abspath(os.fspath(file)) for file in external)


def checked_box(bounds: Any) -> list[list[float]] | None:
    """Returns two corners, or raises ValueError."""
    if bounds is None:
        return None
    try:
        low, high = bounds
    except (TypeError, ValueError):
        raise ValueError(f"bounds: expected ((x0, y0, z0), (x1, y1, z1)), not {bounds!r}") from None
    corners = [list(vector3("bounds[0]", low)), list(vector3("bounds[1]", high))]
    if any(a >= b for a, b in zip(*corners, strict=True)):
        raise ValueError(f"bounds: the first corner, {low!r}, is not below the second, {high!r}")
    return corners


def step_of(step: Any) -> float | None:
    """Returns the distance between samples from one number, or from three that are equal."""
    if step is None or not hasattr(step, "__len__"):
        return None if step is None else number("step", step)
    sizes = vector3("step", step)
    if max(sizes) > min(sizes) * 1.0001:
        raise ValueError(f"step: {step!r} differs per axis, but voxels are cubes: pass one number")
    return sizes[0]


def _voxel_size(solid: SDF3, voxel_size: Any, samples: Any, box: list[list[float]] | None) -> float:
    if voxel_size is not None:
        size = number("voxel_size", voxel_size)
        if size <= 0:
            raise ValueError(f"voxel_size: {size} is not above 0")
        return size
    if samples is None:
        raise ValueError("samples: a number is needed where no voxel size is given")
    count = number("samples", samples)
    if not 1 <= count <= 2**33:
        raise ValueError(f"samples: {count:g} is not from 1 to 2³³")
    low, high = box if box is not None else solid._node.finite_bounds()
    volume = math.prod(b - a for a, b in zip(low, high, strict=True))
    longest = max(b - a for a, b in zip(low, high, strict=True))
    # At least ten voxels along the longest side, and as many as a mesh can have at most.
    return min(max((volume / count) ** (1 / 3), longest / 3500), longest / 10)


def mesh(
    solid: SDF3,
    voxel_size: float | None,
    samples: float | None,
    bounds: Box | None,
    method: str,
    max_triangles: int | None,
    normals: bool,
    colors: bool | None,
    progress: Any,
) -> Mesh:
    from ._mesh import Mesh

    box = checked_box(bounds)
    if max_triangles is not None and max_triangles < 4:
        raise ValueError(f"max_triangles: {max_triangles} is not above 3")
    size = _voxel_size(solid, voxel_size, samples, box)
    with_colors = solid._node.has_materials if colors is None else bool(colors)
    native = solid._node.mesh(size, box, method, max_triangles, bool(normals), with_colors, progress_of(progress))
    if not native.triangle_count:
        # Raises ValueError for a solid that is empty.
        solid._node.finite_bounds()
        raise ValueError(f"no part of the solid is as large as a voxel of {size:.4g}: pass a smaller voxel_size")
    return Mesh(native)


def save(
    solid: SDF3,
    path: str | os.PathLike[str],
    step: Any,
    bounds: Box | None,
    samples: float | None,
    verbose: bool,
    progress: Any,
    options: dict[str, Any],
) -> None:
    name = os.fspath(path)
    ending = os.path.splitext(name)[1].lower()
    for unused in ("workers", "batch_size", "sparse"):
        options.pop(unused, None)
    size = options.pop("voxel_size", None)
    size = step_of(step) if size is None else size
    if ending in MESHES:
        scale = options.pop("scale", 1.0)
        made = solid.mesh(size, samples=samples, bounds=bounds, progress=progress, **options)
        made.save(name, scale=scale)
        if verbose:
            print(f"{name}: {made}")
        return
    if ending not in VOLUMES + OWN:
        known = ", ".join(MESHES + VOLUMES + OWN)
        raise ValueError(f"{name}: unknown extension; name it {known}")
    half_width = number("half_width", options.pop("half_width", 3.0)) if ending in VOLUMES else 3.0
    if options:
        raise TypeError(f"save: unexpected arguments for {ending}: {', '.join(options)}")
    if ending == ".json":
        if size is not None or bounds is not None:
            raise TypeError("save: a scene file has neither a step nor bounds")
        solid._node.save_scene(name)
        return
    box = checked_box(bounds)
    voxel = _voxel_size(solid, size, samples, box)
    solid._node.save_volume(name, voxel, box, half_width, progress_of(progress))


def plain_box(low: Sequence[float], high: Sequence[float]) -> Box:
    """Returns two corners of Python's own numbers."""
    x0, y0, z0 = (float(part) for part in low)
    x1, y1, z1 = (float(part) for part in high)
    return (x0, y0, z0), (x1, y1, z1)


def voxel_grid(
    solid: SDF3, resolution: int, bounds: Box | None
) -> tuple[float, tuple[float, float, float], tuple[int, int, int]]:
    """Returns the distance between samples, the position of the first one, and how many there are along x, y and z."""
    box = checked_box(bounds)
    count = int(number("resolution", resolution))
    if not 1 <= count <= 2048:
        raise ValueError(f"resolution: {count} is not from 1 to 2048")
    low, high = box or solid._node.finite_bounds()
    size = max(b - a for a, b in zip(low, high, strict=True)) / count
    if box is None:
        low, high = [a - 2 * size for a in low], [b + 2 * size for b in high]
        size = max(b - a for a, b in zip(low, high, strict=True)) / count
    sides = list(zip(low, high, strict=True))
    nx, ny, nz = (max(math.ceil((b - a) / size - 1e-3), 1) for a, b in sides)
    x, y, z = ((a + b) / 2 - (n - 1) * size / 2 for (a, b), n in zip(sides, (nx, ny, nz), strict=True))
    return float(size), (float(x), float(y), float(z)), (nx, ny, nz)


def voxels(solid: SDF3, resolution: int, bounds: Box | None, progress: Any) -> NDArray[np.float32]:
    size, first, counts = voxel_grid(solid, resolution, bounds)
    return solid._node.grid(first, size, counts, progress_of(progress))


def from_array(values: Any, spacing: float, origin: Any, iso: float | None, fog: bool, progress: Any) -> SDF3:
    import io

    import numpy as np

    array = np.asarray(values)
    if array.ndim != 3:
        raise ValueError(f"values: expected an array [z, y, x], not one of shape {array.shape}")
    if array.dtype.kind not in "fiub":
        raise TypeError(f"values: expected numbers, not an array of {array.dtype}")
    size = number("spacing", spacing)
    if size <= 0:
        raise ValueError(f"spacing: {size} is not above 0")
    if not np.isfinite(array).all():
        raise ValueError("values: there are some that are not finite: replace them first")
    content = io.BytesIO()
    np.save(content, np.ascontiguousarray(array, dtype=np.float32))
    level = None if iso is None else number("iso", iso)
    place = vector3("origin", origin)
    return volume("values.npy", content.getvalue(), None, bool(fog), level, size, place, progress)


def volume(
    name: str,
    content: bytes | None,
    grid: str | None,
    fog: bool | None,
    iso: float | None,
    voxel_size: float | None,
    origin: Sequence[float] | None,
    progress: Any,
) -> SDF3:
    """Reads a volume, which has the axes of Python, from a file or from its bytes."""
    from ._sdf3 import SDF3

    node = _native.Node.from_volume(name, content, grid, fog, iso, voxel_size, origin, progress_of(progress))
    return SDF3(node).rotate(-math.pi / 2, (1, 0, 0))


def picture_options(
    camera: Any, eye: Any, target: Any, field_of_view: Any, show: Any, ground: Any, sun: Any, samples: Any, bounds: Any
) -> str:
    """Returns what the native part takes: see `SDF3.render`."""
    values: dict[str, Any] = {"show": str(show), "ground": bool(ground)}
    if (eye is None) != (target is None):
        raise ValueError("render: eye and target go together")
    if eye is not None:
        values["look_at"] = [to_scene(vector3(name, place)) for name, place in (("eye", eye), ("target", target))]
    elif camera is not None:
        values["orbit"] = list(vector3("camera", camera))
    if field_of_view is not None:
        values["field_of_view"] = number("field_of_view", field_of_view)
    if sun is not None:
        values["sun"] = list(vector2("sun", sun))
    if samples is not None:
        values["samples"] = int(samples)
    if bounds is not None:
        values["bounds"] = checked_box(bounds)
    return json.dumps(values)


def _size(size: Sequence[int]) -> tuple[int, int]:
    try:
        width, height = (int(part) for part in size)
    except (TypeError, ValueError):
        raise ValueError(f"size: expected (width, height), not {size!r}") from None
    if width < 1 or height < 1:
        raise ValueError(f"size: {width} × {height} pixels are none")
    return width, height


def render(solid: Any, size: Sequence[int], options: str, progress: Any) -> NDArray[np.uint8]:
    return solid._node.render(*_size(size), options, progress_of(progress))


def save_picture(solid: Any, path: str | os.PathLike[str], size: Sequence[int], options: str, progress: Any) -> None:
    name = os.fspath(path)
    if not name.lower().endswith(".png"):
        raise ValueError(f"{name}: a picture is a .png file")
    _native.write_png(name, render(solid, size, options, progress))


def turntable(
    solid: Any,
    path: str | os.PathLike[str],
    frames: int,
    size: Sequence[int],
    seconds: float,
    camera: Any,
    options: dict[str, Any],
    progress: Any,
) -> None:
    count = int(number("frames", frames))
    if not 1 <= count <= 1000:
        raise ValueError(f"frames: {count} is not from 1 to 1000")
    if not number("seconds", seconds) > 0:
        raise ValueError(f"seconds: {seconds} is not above 0")
    name = os.fspath(path)
    if not name.lower().endswith(".gif"):
        raise ValueError(f"{name}: a turntable is a .gif file")
    azimuth, elevation, distance = vector3("camera", camera or (30.0, 20.0, 3.6))
    pictures = []
    for nth in range(count):
        place = (azimuth + 360.0 * nth / count, elevation, distance)
        own = picture_options(camera=place, eye=None, target=None, **options)
        pictures.append(render(solid, size, own, progress))
    _native.write_gif(name, pictures, seconds / count)


def notebook_picture(solid: Any) -> bytes | None:
    """Returns a picture as PNG for a notebook, or None for a solid that has no picture."""
    try:
        return _native.encode_png(solid.render((480, 360)))
    except ValueError:
        return None


def show(solid: Any) -> Any:
    program = os.environ.get("ARGIL_STUDIO") or shutil.which("argil-studio")
    command = [program] if program else None
    if command is None and (found := shutil.which("argil")):
        command = [found, "studio"]
    if command is None:
        raise FileNotFoundError(
            "argil-studio: the editor is not installed: build it by `cargo install --path apps/argil-studio`, "
            "or set ARGIL_STUDIO to its path; render() and save() work without it"
        )
    folder = tempfile.mkdtemp(prefix="argil-")
    path = os.path.join(folder, "scene.json")
    solid._node.save_scene(path)
    return subprocess.Popen([*command, path])


def described(solid: Any) -> str:
    return str(solid._node.description)


def rebuilt(kind: str, text: str, grids: list[tuple[str, int, bytes]], blend: float | None) -> Any:
    """Makes a solid from what pickle has stored."""
    from . import _sdf2, _sdf3

    own = {"SDF2": _sdf2.SDF2, "SDF3": _sdf3.SDF3}[kind](_native.Node.from_json(text, grids))
    own._blend = blend
    return own


def sample_slice(
    solid: SDF3,
    w: int = 1024,
    h: int = 1024,
    x: float | None = None,
    y: float | None = None,
    z: float | None = None,
    bounds: Box | None = None,
) -> tuple[NDArray[np.float32], tuple[float, float, float, float], str]:
    """Returns distances in a plane, as an image for matplotlib, with its extent and the names of its axes."""
    import numpy as np

    chosen = [(axis, value) for axis, value in enumerate((x, y, z)) if value is not None]
    if len(chosen) != 1:
        raise ValueError("slice: one of x, y and z must be given")
    axis, at = chosen[0]
    low, high = checked_box(bounds) or solid._node.finite_bounds()
    across, up = {0: (2, 1), 1: (2, 0), 2: (1, 0)}[axis]
    places = [np.linspace(low[a], high[a], n) for a, n in ((up, w), (across, h))]
    grid = np.empty((w, h, 3))
    grid[..., axis] = number("xyz"[axis], at)
    grid[..., up] = places[0][:, None]
    grid[..., across] = places[1][None, :]
    values = solid.distance(grid.reshape(-1, 3)).reshape(w, h)
    extent = (float(low[across]), float(high[across]), float(low[up]), float(high[up]))
    return values, extent, "XYZ"[across] + "XYZ"[up]


def show_slice(solid: SDF3, abs: bool = False, **options: Any) -> None:
    """Plots distances in a plane by matplotlib. `abs` shows them without their sign."""
    import matplotlib.pyplot as plt
    import numpy as np

    values, extent, axes = sample_slice(solid, **options)
    image = plt.imshow(np.abs(values) if abs else values, extent=extent, origin="lower")
    plt.xlabel(axes[0])
    plt.ylabel(axes[1])
    plt.colorbar(image)
    plt.show()
