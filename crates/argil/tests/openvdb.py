"""Checks files of Argil with OpenVDB itself: python openvdb.py FOLDER. `openvdb.rs` writes the folder.

For each `NAME.vdb` there is `NAME.points`: voxels as four 32-bit numbers, three indices and the expected value, and
`NAME.txt`: voxel size, background, number of active voxels, class, and how far values may be off.
"""

import pathlib
import sys

import numpy
import pyopenvdb


def check(path):
    text = path.with_suffix(".txt").read_text().split("\n")
    voxel, background, active, off = (float(n) for n in text[0].split())
    grid = pyopenvdb.read(str(path), text[2])
    assert grid.gridClass == text[1], (grid.gridClass, text[1])
    assert grid.activeVoxelCount() == int(active), (grid.activeVoxelCount(), active)
    assert abs(grid.background - background) <= off, (grid.background, background)
    assert max(abs(own - voxel) for own in grid.transform.voxelSize()) <= 1e-7 * voxel
    data = path.with_suffix(".points").read_bytes()
    indices = numpy.frombuffer(data, "<i4").reshape(-1, 4)[:, :3].tolist()
    values = numpy.frombuffer(data, "<f4").reshape(-1, 4)[:, 3].tolist()
    accessor = grid.getConstAccessor()
    worst = 0.0
    for index, expected in zip(indices, values):
        value, is_active = accessor.probeValue(tuple(index))
        worst = max(worst, abs(value - expected))
        # A level set: inactive values are the background, with a sign.
        if text[1] == "level set":
            is_near = abs(abs(value) - grid.background) <= off
            assert is_near or is_active == (abs(value) < grid.background), (index, value)
            assert is_active or abs(value) == grid.background, (index, value)
    assert worst <= off, (path.name, worst)
    if text[1] == "level set":
        for value in grid.iterOffValues():
            assert abs(value.value) == grid.background, value
    print(path.name, len(values), "voxels, worst", worst)


paths = sorted(pathlib.Path(sys.argv[1]).glob("*.vdb"))
assert len(paths) >= 6, paths
for path in paths:
    check(path)
