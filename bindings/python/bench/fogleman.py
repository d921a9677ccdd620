"""Times fogleman/sdf's own examples here and there, in pairs: same solids, same voxels, meshes in memory.

    python bench/fogleman.py PATH_TO_FOGLEMAN_SDF [--rounds 3] [--check]

With --check, meshes are compared by trimesh: closed, and of equal volume.
"""

from __future__ import annotations

import argparse
import math
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

EXAMPLES = ("example", "gearlike", "weave", "blobby", "knurling", "pawn")


def solid_of(path: Path, package: str) -> tuple[Any, dict[str, Any]]:
    """Runs an example with one changed line, and returns what it would save."""
    text = path.read_text().replace("from sdf import *", f"from {package} import *")
    kept: list[tuple[Any, dict[str, Any]]] = []
    lines = [line.replace("f.save(", "_keep(f, ") if line.startswith("f.save(") else line for line in text.splitlines()]
    exec("\n".join(lines), {"_keep": lambda f, path, **options: kept.append((f, options))})
    return kept[0]


def theirs(folder: Path, name: str, check: bool) -> None:
    """Prints seconds, triangles, step and volume of their mesh."""
    sys.path.insert(0, str(folder))
    import numpy as np
    from sdf import core

    f, options = solid_of(folder / "examples" / f"{name}.py", "sdf")
    (x0, y0, z0), (x1, y1, z1) = core._estimate_bounds(f)
    step = ((x1 - x0) * (y1 - y0) * (z1 - z0) / options.get("samples", core.SAMPLES)) ** (1 / 3)
    begin = time.perf_counter()
    points = core.generate(f, verbose=False, **options)
    seconds = time.perf_counter() - begin
    volume = 0.0
    if check:
        a, b, c = np.array(points, dtype=float).reshape(-1, 3, 3).transpose(1, 0, 2)
        volume = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)
    print(seconds, len(points) // 3, step, volume)


def ours(folder: Path, name: str, step: float) -> tuple[float, Any]:
    """Returns seconds and the mesh."""
    begin = time.perf_counter()
    f, _ = solid_of(folder / "examples" / f"{name}.py", "argil")
    mesh = f.mesh(step, normals=False)
    mesh.vertices, mesh.triangles  # noqa: B018
    return time.perf_counter() - begin, mesh


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--theirs", default="")
    options = parser.parse_args()
    if options.theirs:
        theirs(options.folder, options.theirs, options.check)
        return
    import argil  # noqa: F401

    print(f"{'':10}{'fogleman/sdf':>14}{'argil':>10}{'':>8}{'triangles':>22}{'volume':>10}")
    product, count = 1.0, 0
    for name in EXAMPLES:
        if options.only and name != options.only:
            continue
        best, pairs = [], []
        for nth in range(options.rounds):
            # A process of its own, so that neither warms the other's caches.
            command = [sys.executable, __file__, str(options.folder), "--theirs", name]
            command += ["--check"] if options.check and nth == 0 else []
            told = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
            seconds, triangles, step, volume = float(told[0]), int(told[1]), float(told[2]), float(told[3])
            if nth == 0:
                first_volume = volume
            own, mesh = min((ours(options.folder, name, step) for _ in range(3)), key=lambda pair: pair[0])
            best.append(seconds)
            pairs.append(own)
        ratio = sorted(best)[len(best) // 2] / sorted(pairs)[len(pairs) // 2]
        product *= ratio
        count += 1
        text = ""
        if options.check:
            made = mesh.to_trimesh()
            off = (mesh.volume - first_volume) / first_volume
            text = f"{100 * off:+9.3f}%  {'closed' if made.is_watertight and mesh.is_watertight else 'OPEN'}"
        print(
            f"{name:10}{sorted(best)[len(best) // 2]:12.2f} s{1e3 * sorted(pairs)[len(pairs) // 2]:7.0f} ms"
            f"{ratio:7.0f}×{triangles:12,}{mesh.triangles.shape[0]:10,}{text}",
            flush=True,
        )
    print(f"geometric mean {math.exp(math.log(product) / count):.0f}×")


if __name__ == "__main__":
    main()
