"""Threads, signals, progress, memory, pickles, and what importing takes."""

from __future__ import annotations

import concurrent.futures
import copy
import gc
import io
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import argil
import numpy as np
import pytest
import tqdm
from argil import box, cylinder, sphere


def knot() -> argil.SDF3:
    return (sphere(1) & box(1.5)) - cylinder(0.5) - cylinder(0.5).orient((1, 0, 0)).k(0.1)


def test_threads_share_solids_and_run_at_once() -> None:
    solid = knot()
    at = np.random.default_rng(1).normal(size=(200_000, 3))
    expected = solid.distance(at)
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        assert all(np.array_equal(found, expected) for found in pool.map(lambda _: solid.distance(at), range(16)))
        meshes = list(pool.map(lambda _: knot().mesh(0.05), range(8)))
    assert len({len(mesh) for mesh in meshes}) == 1


def test_other_threads_run_while_one_meshes() -> None:
    ticks = 0
    done = threading.Event()

    def count() -> None:
        nonlocal ticks
        while not done.is_set():
            ticks += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    knot().mesh(0.004)
    done.set()
    thread.join()
    assert ticks > 20


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize(
    "work",
    [
        "solid.mesh(0.0012)",
        "solid.twist(1).distance(np.full((60_000_000, 3), 0.3, np.float32))",
        "solid.closest_point(np.random.default_rng(1).normal(size=(3_000_000, 3)))",
        "solid.render((4000, 4000), samples=64)",
        "solid.bricks(2000)",
    ],
)
def test_ctrl_c_stops_long_work(work: str) -> None:
    text = f"""
import signal, sys, numpy as np
# What a shell starts in the background ignores it.
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.path.insert(0, {str(Path(__file__).parent)!r})
from test_work import knot
solid = knot()
solid.distance([(0, 0, 0)])
print("ready", flush=True)
try:
    {work}
except KeyboardInterrupt:
    print("stopped", float(solid.distance([(2, 0, 0)])[0]), flush=True)
"""
    process = subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline().strip() == "ready"
    time.sleep(0.7)
    assert process.poll() is None, "the work was over too soon"
    begin = time.perf_counter()
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=30)
    assert output.startswith("stopped 1"), output
    assert time.perf_counter() - begin < 5
    assert process.returncode == 0


def test_progress_is_reports_and_may_stop_the_work() -> None:
    reports: list[tuple[str, int, int]] = []
    knot().mesh(0.004, progress=lambda *values: reports.append(values))
    assert reports and all(isinstance(stage, str) and done <= max(total, done) for stage, done, total in reports)

    class Enough(Exception):
        pass

    def stop(stage: str, done: int, total: int) -> None:
        raise Enough

    with pytest.raises(Enough):
        knot().mesh(0.002, progress=stop)
    assert knot().distance([(2, 0, 0)])[0] == pytest.approx(1.25, abs=1e-3)


def test_progress_bars_are_advanced() -> None:
    reports: list[tuple[str, float, float | None]] = []

    class Bar(tqdm.tqdm):  # type: ignore[type-arg]
        """A bar that remembers how far it was."""

        def update(self, n: float | None = 1) -> bool | None:
            super().update(n)
            reports.append((self.desc, self.n, self.total))
            return None

    ring = box((1, 1, 4)).circular_array(24, 1.6).twist(0.75)
    with Bar(file=io.StringIO()) as bar:
        (knot() - ring.k(0.1)).mesh(0.004, progress=bar)
    steps = [(n, total) for desc, n, total in reports if desc.startswith("bricks")]
    assert len(steps) > 1 and steps == sorted(steps) and steps[0][0] < steps[-1][0]
    assert all(total is not None and 0 <= n <= total for n, total in steps), steps


def resident_bytes() -> int:
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory as Linux tells it")
def test_a_hundred_thousand_objects_leak_nothing() -> None:
    at = np.zeros((10, 3), np.float32)

    def some(count: int) -> None:
        for nth in range(count):
            solid = (sphere(1 + nth % 7) | box(1).translate((nth % 5, 0, 0))).rotate(0.1)
            if nth % 10 == 0:
                solid.distance(at)
            if nth % 500 == 0:
                solid.mesh(0.2).vertices.sum()
        gc.collect()

    some(5_000)
    before = resident_bytes()
    some(95_000)
    grown = resident_bytes() - before
    assert grown < 20e6, f"{grown / 1e6:.1f} MB"


def test_long_chains_are_built_used_and_dropped() -> None:
    solid = sphere(0.1)
    for nth in range(20_000):
        solid = solid | sphere(0.1).translate((nth % 100, nth // 100, 0))
    assert solid.distance([(0, 0, 1)])[0] == pytest.approx(0.9, abs=1e-4)
    moved = sphere(1)
    for _ in range(100_000):
        moved = moved.translate((1e-6, 0, 0))
    del moved
    twice = sphere(1)
    for _ in range(40):
        twice = twice | twice.translate((1, 0, 0))
    with pytest.raises(ValueError, match="parts"):
        twice.mesh(0.1)


@pytest.mark.parametrize("copied", [lambda s: pickle.loads(pickle.dumps(s)), copy.copy, copy.deepcopy])
def test_solids_and_scenes_are_pickled(copied: object) -> None:
    at = np.random.default_rng(1).normal(size=(1000, 3))
    solids = [
        knot().paint("gold"),
        argil.circle(1).revolve(2).named("ring"),
        argil.Mesh.from_arrays(*_tetrahedron()).sdf(resolution=32),
        sphere(1).transition_linear(box(1)),
    ]
    for solid in solids:
        again = copied(solid)  # type: ignore[operator]
        assert np.array_equal(again.distance(at), solid.distance(at))
    smooth = copied(sphere(1).k(0.3))  # type: ignore[operator]
    assert (box(1) | smooth).distance(at) == pytest.approx((box(1) | sphere(1).k(0.3)).distance(at))
    function = argil.SampledSDF3(lambda p: np.linalg.norm(p, axis=1) - 0.5)
    assert copied(function).volume(0.05) == pytest.approx(function.volume(0.05))  # type: ignore[operator]
    mesh = copied(sphere(1).mesh(0.2))  # type: ignore[operator]
    assert mesh.volume == sphere(1).mesh(0.2).volume
    profile = copied(argil.hexagon(1))  # type: ignore[operator]
    assert np.array_equal(profile.distance(at[:, :2]), argil.hexagon(1).distance(at[:, :2]))
    scene = argil.Scene(knot())
    scene.add(sphere(0.2), name="small")
    assert [info.name for info in copied(scene)] == [info.name for info in scene]  # type: ignore[operator]


def _tetrahedron() -> tuple[list[tuple[float, float, float]], list[tuple[int, int, int]]]:
    corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    return corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def _measured(solid: argil.SDF3) -> float:
    return solid.volume(0.05)


def test_processes_take_solids() -> None:
    import multiprocessing

    with multiprocessing.get_context("spawn").Pool(2) as pool:
        found = pool.map(_measured, [sphere(1), knot()])
    assert found == pytest.approx([sphere(1).volume(0.05), knot().volume(0.05)])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes of POSIX")
def test_forks_work_after_their_parents_did() -> None:
    import multiprocessing
    import warnings

    expected = sphere(1).volume(0.05)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        with multiprocessing.get_context("fork").Pool(2) as pool:
            found = pool.map_async(_measured, [sphere(1), sphere(1)]).get(30)
    assert found == pytest.approx([expected, expected])


def test_importing_takes_no_numpy() -> None:
    text = "import sys, argil; print('numpy' in sys.modules); from argil import *; print(X, Z * 2)"
    reports = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True).stdout
    assert reports.split("\n")[:2] == ["False", "[1 0 0] [0 0 2]"]
