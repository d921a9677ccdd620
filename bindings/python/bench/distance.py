"""Times the distances of 10⁷ points to 20 blended brushes (scenes/csg20.json) here and in fogleman/sdf.

python bench/distance.py PATH_TO_FOGLEMAN_SDF [--count 10000000]
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

SCENE = Path(__file__).parents[3] / "scenes" / "csg20.json"


def solid_of(s: Any) -> Any:
    """Builds the scene, in its own axes, with the functions of a package."""
    whole = None
    for brush in json.loads(SCENE.read_text())["brushes"]:
        shape = brush["shape"]
        kind = shape["type"]
        if kind == "sphere":
            own = s.sphere(shape["radius"])
        elif kind == "box":
            own = s.rounded_box(np.array(shape["half_size"]) * 2, shape["rounding"])
        elif kind == "torus":
            # About y, and then turned to z.
            own = s.torus(shape["major_radius"], shape["minor_radius"])
        else:
            own = s.capsule(shape["from"], shape["to"], shape["radius"])
        for modifier in brush.get("modifiers", []):
            if modifier["type"] == "translate":
                own = own.translate(np.array(modifier["by"]))
        cuts = brush.get("operator") == "subtract"
        if whole is None:
            whole = own
        else:
            whole = (whole.difference if cuts else whole.union)(own, k=brush["blend"])
    return whole


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=10_000_000)
    options = parser.parse_args()
    sys.path.insert(0, str(options.folder))
    import argil
    import sdf

    points = np.random.default_rng(1).uniform(-1, 1, (options.count, 3)).astype(np.float32)
    ours, theirs = solid_of(argil), solid_of(sdf)
    times: dict[str, list[float]] = {"argil": [], "fogleman/sdf": []}
    for _ in range(3):
        begin = time.perf_counter()
        found = ours.distance(points)
        times["argil"].append(time.perf_counter() - begin)
    begin = time.perf_counter()
    expected = np.concatenate([theirs(part).reshape(-1) for part in np.array_split(points, max(1, len(points) // 100_000))])
    times["fogleman/sdf"].append(time.perf_counter() - begin)
    print(f"largest difference {np.abs(found - expected).max():.2g}")
    for name, all_times in times.items():
        print(f"{name:14}{min(all_times):8.3f} s  {len(points) / min(all_times) / 1e6:8.2f} million points a second")
    print(f"{min(times['fogleman/sdf']) / min(times['argil']):.0f} times as fast")


if __name__ == "__main__":
    main()
