"""Worlds as tiles, baked by this process and by workers of Dask."""

from __future__ import annotations

import os
import pickle
from pathlib import Path

import argil
import numpy as np
import pytest
from argil import box, sphere, world


def scene(folder: Path) -> Path:
    path = folder / "scene.json"
    (sphere(0.8) - box(1.2).k(0.1)).save(path)
    return path


def contents(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def test_a_world_is_planned_baked_and_finished(tmp_path: Path) -> None:
    plan = world.plan(scene(tmp_path), 0.005)
    store = tmp_path / "store"
    assert plan.tiles > 3 and pickle.loads(pickle.dumps(plan)) == plan
    plan.save(tmp_path / "plan.json")
    assert world.Plan.load(tmp_path / "plan.json") == plan
    with pytest.raises(FileNotFoundError):
        world.finish(plan, store)
    store.mkdir()
    with pytest.raises(ValueError, match="missing"):
        world.finish(plan, store)
    done = world.bake(plan, store=store)
    assert done.baked + done.empty == done.tiles == plan.tiles and done.bricks > 100
    assert world.bake(plan, store=store).present == done.baked
    assert not world.status(plan, store).finished
    place = world.finish(plan, store, verify=True)
    found = world.status(plan, store, verify=True)
    assert found.finished and found.present == found.tiles == done.baked and found.damaged == []
    assert (Path(place) / "manifest.json").exists()
    tile = next(path for path in Path(place).rglob("tiles/0/*") if path.stat().st_size > 1000)
    tile.write_bytes(tile.read_bytes()[:-1])
    assert world.status(plan, store, verify=True).damaged == [f"0/{tile.name}"]


def test_bad_plans_are_refused(tmp_path: Path) -> None:
    with pytest.raises(argil.SceneError, match="no plan"):
        (tmp_path / "none.json").write_text("{}")
        world.Plan.load(tmp_path / "none.json")
    with pytest.raises(OSError):
        world.plan(tmp_path / "nowhere.json", 0.1)
    for size in (0.0, -1.0, float("nan"), 1e-9):
        with pytest.raises(ValueError):
            world.plan(scene(tmp_path), size)
    with pytest.raises(ValueError, match="bits"):
        world.plan(scene(tmp_path), 0.1, bits=12)
    plan = world.plan(scene(tmp_path), 0.1)
    with pytest.raises(OSError):
        world.bake(plan, store="/proc/none")


def test_workers_of_dask_make_the_same_world(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    plan = world.plan(scene(tmp_path), 0.005)
    world.bake(plan, store=tmp_path / "one")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        # A worker that dies is replaced, and what it did not finish is baked by another one.
        pids = client.run(os.getpid)
        os.kill(next(iter(pids.values())), 9)
        done = world.bake(plan, client, store=tmp_path / "many", shards=8)
    assert done.baked + done.present + done.empty == plan.tiles
    assert contents(tmp_path / "one") == contents(tmp_path / "many")


def cluster_of(store: str, plan: world.Plan) -> None:
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        world.bake(plan, client, store=store, shards=4)


def test_an_object_store_holds_the_same_world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """S3 as moto serves it: two processes bake, and what is there is byte for byte what a folder holds."""
    server = pytest.importorskip("moto.server").ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    try:
        address = "http://{}:{}".format(*server.get_host_and_port())
        for name, value in {
            "AWS_ENDPOINT": address,
            "AWS_ALLOW_HTTP": "true",
            "AWS_ACCESS_KEY_ID": "someone",
            "AWS_SECRET_ACCESS_KEY": "a-secret-of-a-test",
            "AWS_REGION": "us-east-1",
            "ARGIL_TILE_CACHE": str(tmp_path / "cache"),
        }.items():
            monkeypatch.setenv(name, value)
        import boto3

        bucket = boto3.resource("s3", endpoint_url=address).create_bucket(Bucket="worlds")
        plan = world.plan(scene(tmp_path), 0.005)
        world.bake(plan, store=tmp_path / "one")
        near = world.finish(plan, tmp_path / "one")
        store = "s3://worlds/all"
        cluster_of(store, plan)
        again = world.bake(plan, store=store)
        assert again.baked == 0 and again.present + again.empty == plan.tiles
        assert not world.status(plan, store).finished
        far = world.finish(plan, store, verify=True)
        held = {own.key.removeprefix("all/"): own.get()["Body"].read() for own in bucket.objects.all()}
        assert held == contents(tmp_path / "one")
        # Read in parts, through the cache on the disk, and edited.
        done = world.export(far, tmp_path / "far")
        assert done.missing == 0 and done == world.export(near, tmp_path / "near")
        assert contents(tmp_path / "far") == contents(tmp_path / "near")
        kept = contents(tmp_path / "cache")
        assert kept.pop("argil-tiles/CACHEDIR.TAG").startswith(b"Signature: ")
        assert kept and all(held[f"{plan.hash}/{name.split('/', 2)[2]}"].startswith(own) for name, own in kept.items())
        assert world.edit(far, '{"edit": "remove", "node": "brushes[0]"}') == "edits/000001.jsonl"
        with pytest.raises(argil.SceneError, match="edits:1"):
            world.edit(far, '{"edit": "remove", "node": "brushes[7]"}')
        monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "")
        with pytest.raises(OSError) as error:
            world.bake(plan, store="s3://nowhere/all")
        assert "a-secret" not in str(error.value)
    finally:
        server.stop()


def test_an_export_as_zarr_is_the_field(tmp_path: Path) -> None:
    zarr = pytest.importorskip("zarr")
    solid = sphere(0.8) - box(1.2).k(0.1)
    # 256 voxels: whole shards.
    voxel = 1.6 / 252
    plan = world.plan(scene(tmp_path), voxel)
    world.bake(plan, store=tmp_path / "store")
    done = world.export(world.finish(plan, tmp_path / "store"), tmp_path / "world.zarr")
    assert done.missing == 0 and done.levels > 3
    pyramid = zarr.open_group(tmp_path / "world.zarr", mode="r").attrs["ome"]["multiscales"][0]
    random = np.random.default_rng(4)
    for nth, data in enumerate(pyramid["datasets"]):
        array = zarr.open_array(tmp_path / "world.zarr" / data["path"], mode="r")
        scale, shift = (own[own["type"]] for own in data["coordinateTransformations"])
        assert scale[0] == pytest.approx(voxel * 2**nth) and array.shards == (128, 128, 128)
        assert nth > 0 or array.shape == (256, 256, 256)
        places = np.stack([random.integers(0, side, 4000) for side in array.shape], 1)
        found = array[:][tuple(places.T)]
        z, y, x = (places * scale + shift).T
        # Files have y up, and Python z.
        own = solid.distance(np.stack([x, -z, y], 1).astype(np.float32))
        band = 16 * scale[0]
        off = np.abs(found - np.clip(own, -band, band)) / scale[0]
        assert np.percentile(off, 90) < 0.1 and off.max() < 4
        assert off[np.abs(own) < 0.5 * scale[0]].max(initial=0.0) < 0.02
        assert ((found < 0) == (own < 0))[np.abs(own) > 1e-3 * scale[0]].all()
    with pytest.raises(OSError, match=r"zarr\.json"):
        (tmp_path / "other.zarr").mkdir()
        (tmp_path / "other.zarr" / "zarr.json").write_text("{}")
        world.export(tmp_path / "store" / plan.hash, tmp_path / "other.zarr")
    with pytest.raises(ValueError, match="voxel_size"):
        world.export(tmp_path / "store" / plan.hash, tmp_path / "x", voxel_size=-1)


def test_an_export_without_a_tile_is_coarser_there(tmp_path: Path) -> None:
    zarr = pytest.importorskip("zarr")
    solid = sphere(0.8) - box(1.2).k(0.1)
    voxel = 1.6 / 400
    plan = world.plan(scene(tmp_path), voxel)
    world.bake(plan, store=tmp_path / "store")
    folder = world.finish(plan, tmp_path / "store")
    next((tmp_path / "store" / plan.hash / "tiles" / "0").iterdir()).unlink()
    world.edit(folder, '{"edit": "remove", "node": "brushes[0]"}')
    with pytest.warns(UserWarning, match="edits"):
        done = world.export(folder, tmp_path / "world.zarr")
    assert done.missing == done.edits_left_out == 1
    pyramid = zarr.open_group(tmp_path / "world.zarr", mode="r").attrs["ome"]["multiscales"][0]
    array = zarr.open_array(tmp_path / "world.zarr" / "0", mode="r")
    random = np.random.default_rng(4)
    places = np.stack([random.integers(0, side, 20000) for side in array.shape], 1)
    z, y, x = (places * voxel + pyramid["datasets"][0]["coordinateTransformations"][1]["translation"]).T
    own = solid.distance(np.stack([x, -z, y], 1).astype(np.float32))
    assert ((array[:][tuple(places.T)] < 0) == (own < 0))[np.abs(own) > 64 * voxel].all()


def test_meshes_outside_of_the_folder_need_consent(tmp_path: Path) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    mesh = tmp_path / "mesh.stl"
    sphere(0.5).save(mesh, step=0.1)
    path = inner / "scene.json"
    path.write_text('{"argil": 1, "brushes": [{"shape": {"type": "mesh", "path": "../mesh.stl", "resolution": 32}}]}')
    other = [tmp_path / "other.stl"]
    for external in (False, other, []):
        with pytest.raises(argil.SceneError, match="outside"):
            world.plan(path, 0.05, external=external)
        with pytest.raises(argil.SceneError, match="outside"):
            argil.Scene.load(path, external=external)
    with pytest.raises(TypeError, match="external"):
        world.plan(path, 0.05, external="mesh.stl")
    plan = world.plan(path, 0.05, external=[mesh])
    assert world.bake(plan, store=tmp_path / "store").baked > 0
    # A plan from a file has no consent of its own.
    plan.save(inner / "plan.json")
    again = world.Plan.load(inner / "plan.json")
    with pytest.raises(argil.SceneError, match="outside"):
        world.bake(again, store=tmp_path / "store")
    for external in (True, [mesh]):
        again = world.Plan.load(inner / "plan.json", external=external)
        assert world.bake(again, store=tmp_path / "store").baked == 0
