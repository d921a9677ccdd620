"""Worlds as tiles, which many workers bake into a folder or an object store.

A plan describes a world. Its tiles share nothing and are always the same bytes, so whatever hands out work will do: Dask here, and
arrays of jobs with `argil world bake`. Workers can be stopped at any moment, and what they lack is baked by whoever comes next.
"""

from __future__ import annotations

import functools
import json
import os
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from . import _native, _output
from ._numbers import length

__all__ = ["BakeReport", "ExportReport", "Plan", "WorldStatus", "bake", "edit", "export", "finish", "plan", "status"]


@dataclass(frozen=True)
class Plan:
    """What is baked: a scene, a voxel size and an encoding. Plans can be pickled, and `save` writes what `argil world` reads."""

    text: str
    """The plan as JSON."""
    folder: str
    """The folder in which the scene's meshes are."""
    hash: str
    """The name of the world's folder in a store. Nothing in it ever changes."""
    tiles: int
    """How many tiles there can be."""
    external: bool | tuple[str, ...] = False
    """Meshes outside of the folder that may be read: all, none, or these files."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the plan. If the scene has meshes, they must be beside it."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.text)

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, external: bool | Sequence[str | os.PathLike[str]] = False) -> Plan:
        """Reads a plan from `save` or from `argil world plan`. Meshes are read from its folder, and from `external` files: see `plan`.

        Raises SceneError if it is none, and OSError.
        """
        with open(path, encoding="utf-8") as file:
            text = file.read()
        name, tiles = _native.read_world_plan(text, os.fspath(path))
        return cls(text, os.path.dirname(os.path.abspath(path)), name, tiles, _output.external_of(external))


@dataclass(frozen=True)
class BakeReport:
    """What workers did."""

    tiles: int
    """Tiles that they looked at."""
    present: int
    """Tiles that were there already."""
    baked: int
    """Tiles that they baked."""
    empty: int
    """Tiles that bounds did not rule out, and through which no surface passes. They are not stored."""
    bricks: int
    """Bricks in the baked tiles."""
    bytes: int
    """Bytes of the baked tiles."""


@dataclass(frozen=True)
class WorldStatus:
    """What a store has of a world."""

    tiles: int
    present: int
    damaged: list[str]
    """Damaged tiles, if they were read."""
    bytes: int
    finished: bool


@dataclass(frozen=True)
class ExportReport:
    """What `export` wrote."""

    levels: int
    files: int
    """Meshes of 3D Tiles, or shards of OME-Zarr."""
    bytes: int
    triangles: int
    missing: int
    """Tiles that the store lacks: the export is coarser there."""
    edits_left_out: int
    """Files of edits beside the world, which the export does not have."""


def plan(
    scene: str | os.PathLike[str],
    voxel_size: float,
    *,
    bits: int = 16,
    external: bool | Sequence[str | os.PathLike[str]] = False,
    progress: Any = None,
) -> Plan:
    """Plans the world of a scene file, whose finest voxels have an edge of `voxel_size` in the scene's unit.

    Which tiles there can be is found from bounds alone, in seconds. Scene files have y up. Solids write one with `save`.
    A scene reads meshes from its folder. `external` allows others: True all, or a list of files these.

    Raises SceneError or ValueError for the scene and the voxels, and OSError if a file cannot be read.
    """
    name = os.fspath(scene)
    size = length("voxel_size", voxel_size)
    files = _output.external_of(external)
    made = _native.plan_world(name, size, int(bits), files, _output.progress_of(progress))
    return Plan(made[0], os.path.dirname(os.path.abspath(name)), made[1], made[2], files)


def _bake_shard(plan: Plan, store: str, count: int, index: int) -> dict[str, int]:
    """Bakes a shard in a worker, with as many threads as the worker has."""
    try:
        from distributed import get_worker

        os.environ.setdefault("RAYON_NUM_THREADS", str(get_worker().state.nthreads))
    except (ImportError, ValueError, AttributeError):
        # Not in a worker of Dask.
        pass
    done: dict[str, int] = json.loads(_native.bake_world(plan.text, plan.folder, plan.external, store, index, count))
    return done


def bake(
    plan: Plan,
    client: Any = None,
    *,
    store: str | os.PathLike[str],
    shards: int | None = None,
    retries: int = 3,
    progress: Any = None,
) -> BakeReport:
    """Bakes the tiles that a store lacks: a folder, or an address such as s3://bucket/folder, which all workers can reach.

    With `client`, a `distributed.Client`, Dask's workers bake `shards` parts (by default, eight for each of their threads), and
    each is tried again `retries` times. Dask shows their progress, and brings back what dies with a worker. Without, this process
    bakes all, with all cores.

    Raises SceneError, OSError if the store fails again and again, and what Dask raises.
    """
    place = os.fspath(store)
    if "://" not in place:
        place = os.path.abspath(place)
    if client is None:
        done = [json.loads(_native.bake_world(plan.text, plan.folder, plan.external, place, 0, 1, _output.progress_of(progress)))]
    else:
        count = shards or max(1, min(plan.tiles, 8 * sum(client.nthreads().values())))
        if count < 1:
            raise ValueError(f"shards: {shards} is not at least 1")
        futures = client.map(
            functools.partial(_bake_shard, plan, place, count),
            range(count),
            key=[f"argil-bake-{plan.hash[:12]}-{index}-of-{count}" for index in range(count)],
            retries=retries,
            pure=False,
        )
        done = client.gather(futures)
    names = ("tiles", "present", "baked", "empty", "bricks", "bytes")
    return BakeReport(**{name: sum(own[name] for own in done) for name in names})


def status(plan: Plan, store: str | os.PathLike[str], *, verify: bool = False, progress: Any = None) -> WorldStatus:
    """Counts what a store has of a world. With `verify`, all tiles are read, and those that are damaged are named."""
    found = _native.world_status(plan.text, plan.folder, plan.external, os.fspath(store), bool(verify), _output.progress_of(progress))
    return WorldStatus(**json.loads(found))


def finish(plan: Plan, store: str | os.PathLike[str], *, verify: bool = False, progress: Any = None) -> str:
    """Writes a world's manifest, and returns the world's place: `argil render PLACE` and web pages read it from there.

    With `verify`, all tiles are read first, and those that are damaged are removed, so that `bake` bakes them again.

    Raises ValueError if tiles are missing or damaged.
    """
    return _native.finish_world(plan.text, plan.folder, plan.external, os.fspath(store), bool(verify), _output.progress_of(progress))


def edit(world: str | os.PathLike[str], edits: str) -> str:
    """Saves edits beside a finished world, and returns the name of their file. The tiles stay: readers bake what the edits reach.

    `world` is the place that `finish` returns, and `edits` has a JSON object on each line, as `argil edit` reads them.

    Raises SceneError if an edit cannot be performed, and OSError if the store cannot be written.
    """
    return _native.edit_world(os.fspath(world), edits)


def export(
    world: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    voxel_size: float | None = None,
    progress: Any = None,
) -> ExportReport:
    """Writes a finished world for other programs: a folder whose name ends in .zarr becomes OME-Zarr, and any other 3D Tiles 1.1.

    `voxel_size` is that of the finest level that is wanted, by default the world's. Edits beside the world are left out, with a warning.

    Raises SceneError if there is no world, and OSError if the folder exists and is something else, or cannot be written.
    """
    size = None if voxel_size is None else length("voxel_size", voxel_size)
    done = _native.export_world(os.fspath(world), os.fspath(output), size, _output.progress_of(progress))
    report = ExportReport(**json.loads(done))
    if report.edits_left_out:
        warnings.warn(
            f"{world}: edits that were saved beside it are not part of its tiles, and not exported", stacklevel=2
        )
    return report
