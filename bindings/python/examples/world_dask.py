"""Bakes a world with two workers of Dask: `python examples/world_dask.py [FOLDER]`.

The same call works with the clients of dask-jobqueue and dask-kubernetes, if all workers reach the store.
"""

import sys
from pathlib import Path

from argil import box, gyroid, sphere, world
from distributed import Client, LocalCluster


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "world")
    folder.mkdir(exist_ok=True)
    solid = sphere(1) & gyroid(2, 0.4, 0.08) | box((2.4, 2.4, 0.1)).translate((0, 0, -1))
    solid.save(folder / "scene.json")
    plan = world.plan(folder / "scene.json", voxel_size=0.002)
    with LocalCluster(n_workers=2, threads_per_worker=1) as cluster, Client(cluster) as client:
        print(f"{plan.tiles} tiles; progress: {client.dashboard_link}")
        print(world.bake(plan, client, store=folder / "store"))
    print("argil render", world.finish(plan, folder / "store"))


if __name__ == "__main__":
    main()
