"""Values against formulas in NumPy, against Rust's own, and against each other."""

from __future__ import annotations

import math
from pathlib import Path

import argil
import cases
import numpy as np
import pytest
from argil import SDF3, Z, box, capped_cylinder, capsule, cylinder, sphere, torus

ALL = cases.SHAPES | cases.SURFACES | cases.OPERATORS | cases.DEFORMATIONS


def points(count: int = 20_000, size: float = 1.5) -> np.ndarray:
    return np.random.default_rng(5).uniform(-size, size, (count, 3))


@pytest.mark.parametrize(
    ("solid", "formula"),
    [
        (sphere(0.7), lambda p: np.linalg.norm(p, axis=1) - 0.7),
        (torus(0.8, 0.2), lambda p: np.hypot(np.hypot(p[:, 0], p[:, 1]) - 0.8, p[:, 2]) - 0.2),
        (cylinder(0.4), lambda p: np.hypot(p[:, 0], p[:, 1]) - 0.4),
        (
            box((1.0, 1.4, 0.6)),
            lambda p: (
                np.linalg.norm(np.maximum(np.abs(p) - (0.5, 0.7, 0.3), 0), axis=1)
                + np.minimum((np.abs(p) - (0.5, 0.7, 0.3)).max(axis=1), 0)
            ),
        ),
        (sphere(0.5).translate((0, 0, 1)), lambda p: np.linalg.norm(p - (0, 0, 1), axis=1) - 0.5),
        (
            capsule((0, 0, -1), (0, 0, 1), 0.3),
            lambda p: np.linalg.norm(p - np.stack([0 * p[:, 0], 0 * p[:, 0], p[:, 2].clip(-1, 1)], 1), axis=1) - 0.3,
        ),
    ],
)
def test_distances_follow_their_formulas(solid: argil.SDF3, formula: object) -> None:
    at = points()
    assert np.abs(solid.distance(at) - formula(at)).max() < 3e-6  # type: ignore[operator]


@pytest.mark.parametrize("name", ALL)
def test_gradients_are_differences(name: str) -> None:
    solid = ALL[name](argil)
    at = points(2000)
    gradient, step = solid.gradient(at), 1e-3
    for axis in range(3):
        moved = np.eye(3)[axis] * step
        slope = (solid.distance(at + moved) - solid.distance(at - moved)) / (2 * step)
        # Creases have no gradient.
        assert np.mean(np.abs(gradient[:, axis] - slope) < 0.02) > 0.97


#: Solids without an end have no mesh.
ENDLESS = {"plane", "cylinder", "negate", "slab along z", "slab above", "slab beside", "repeat without end"}


@pytest.mark.parametrize("name", [name for name in ALL if name not in ENDLESS])
def test_no_distance_is_farther_from_0_than_the_surface(name: str) -> None:
    solid = ALL[name](argil)
    surface = solid.mesh(samples=20_000, normals=False)
    at = points(800)
    found = np.abs(solid.distance(at))
    nearest = np.full(len(at), np.inf)
    for part in np.array_split(surface.vertices, 20):
        away = np.linalg.norm(at[:, None, :] - part[None], axis=2)
        nearest = np.minimum(nearest, away.min(axis=1))
    assert np.all(found <= nearest + 0.01 * surface.voxel_size + 1e-4), (found - nearest).max()


# Around the axis of what is wrapped, distances jump where they are only bounds.
@pytest.mark.parametrize("name", [name for name in ALL if name != "wrap around"])
def test_distances_are_nowhere_steeper_than_1(name: str) -> None:
    solid = ALL[name](argil)
    at = points(4000)
    rng = np.random.default_rng(1)
    away = rng.normal(size=at.shape) * rng.uniform(0.01, 0.5, (len(at), 1))
    rise = np.abs(solid.distance(at) - solid.distance(at + away))
    assert (rise / np.linalg.norm(away, axis=1)).max() < 1.001


@pytest.mark.parametrize("name", [name for name in ALL if name not in ENDLESS])
def test_meshes_are_closed_and_on_the_surface(name: str) -> None:
    solid = ALL[name](argil)
    mesh = solid.mesh(samples=60_000)
    assert mesh.is_watertight
    off = np.abs(solid.distance(mesh.vertices)) / mesh.voxel_size
    # At creases, and where distances are bounds, one step along an edge does not find the surface.
    assert np.mean(off) < 0.02 and off.max() < 0.3
    low, high = solid.bounds
    assert np.all(mesh.vertices.min(axis=0) >= np.array(low) - 1e-4)
    assert np.all(mesh.vertices.max(axis=0) <= np.array(high) + 1e-4)
    # The share of random points that are inside is the share of the box.
    at = np.random.default_rng(2).uniform(low, high, (40_000, 3))
    share = np.mean(solid.distance(at) < 0) * np.prod(np.subtract(high, low))
    assert mesh.volume == pytest.approx(share, rel=0.15, abs=0.01)


def test_volumes_and_centers_are_those_of_the_solids() -> None:
    assert sphere(1).volume() == pytest.approx(4 / 3 * math.pi, rel=1e-3)
    assert box((1, 2, 3)).volume() == pytest.approx(6, rel=2e-3)
    center = box((1, 2, 3), (5, 6, 7)).center_of_mass()
    assert center == pytest.approx((5, 6, 7), abs=1e-3)
    half = sphere(1) & argil.slab(z0=0)
    assert half.center_of_mass() == pytest.approx((0, 0, 3 / 8), abs=2e-3)


def test_boxes_are_tight_and_infinite_sides_are() -> None:
    low, high = sphere(1, (1, 2, 3)).bounds
    assert low == pytest.approx((0, 1, 2), abs=2e-3) and high == pytest.approx((2, 3, 4), abs=2e-3)
    low, high = cylinder(0.5).bounds
    assert low[2] == -math.inf and high[2] == math.inf and high[0] == pytest.approx(0.5, abs=1e-3)
    low, high = (argil.plane() & sphere(2)).bounds
    assert low[2] == pytest.approx(0, abs=4e-3)
    cut = sphere(1) - box(4, (2, 0, 0))
    assert 0 <= cut.bounds[1][0] < 0.05


def test_closest_points_and_rays_meet_the_surface() -> None:
    solid = sphere(1) - box(1.2)
    at = points(300)
    near, distance = solid.closest_point(at)
    assert np.abs(solid.distance(near)).max() < 1e-3
    assert np.linalg.norm(near - at, axis=1) == pytest.approx(distance, rel=1e-4, abs=1e-5)
    assert np.isnan(solid.closest_point([(9, 9, 9)], 1.0)[1]).all()
    far, hit, normal = sphere(1).cast_rays([(0, 0, 5), (0, 3, 5)], (0, 0, -1))
    assert far[0] == pytest.approx(4, abs=1e-4) and far[1] == math.inf
    assert hit[0] == pytest.approx((0, 0, 1), abs=1e-3) and np.isnan(hit[1]).all()
    assert normal[0] == pytest.approx((0, 0, 1), abs=1e-2)
    # Within a distance.
    assert np.isinf(sphere(1).cast_rays([(0, 0, 5)], [(0, 0, -1)], 3.0)[0]).all()


def test_voxels_are_distances_in_order() -> None:
    solid = box((1.0, 2.0, 3.0), (0.1, 0.2, 0.3))
    low, high = (-1.0, -2.0, -2.5), (1.0, 2.0, 2.5)
    grid = solid.voxels(50, bounds=(low, high))
    assert grid.shape == (50, 40, 20) and grid.dtype == np.float32
    z, y, x = [np.arange(n) * 0.1 + 0.05 + first for n, first in zip(grid.shape, reversed(low), strict=True)]
    at_z, at_y, at_x = np.meshgrid(z, y, x, indexing="ij")
    expected = solid.distance(np.stack((at_x, at_y, at_z), -1).reshape(-1, 3))
    assert np.abs(grid.reshape(-1) - expected).max() < 1e-5
    spacing, origin = solid.voxel_grid(50, bounds=(low, high))
    assert spacing == pytest.approx(0.1) and origin == pytest.approx((x[0], y[0], z[0]))


@pytest.mark.parametrize("order", ["C", "F"])
def test_arrays_come_back_in_place(order: str, tmp_path: Path) -> None:
    solid = box((1.0, 2.0, 3.0), (0.1, 0.2, 0.3)) | sphere(0.4, (1, 0, 0))
    spacing, origin = solid.voxel_grid(80)
    array = solid.voxels(80)
    path = tmp_path / "solid.npy"
    np.save(path, np.asarray(array, order=order))
    at = points(500) * (0.6, 1.2, 1.7)
    at = at[np.abs(solid.distance(at)) < 1.5 * spacing]
    assert len(at) > 10
    for copy in (
        argil.load(path, voxel_size=spacing, origin=origin),
        SDF3.from_array(array, spacing, origin),
        SDF3.from_array(-array, spacing, origin, 0.0, fog=True),
        SDF3.from_array(array + 0.25, spacing, origin, 0.25),
    ):
        assert np.abs(copy.distance(at) - solid.distance(at)).max() < 0.5 * spacing
        assert np.asarray(copy.bounds) == pytest.approx(np.asarray(solid.bounds), abs=4 * spacing)
    # Without a size and a place, the longest side is 2.
    low, high = argil.load(path).bounds
    assert high[2] - low[2] > 1.8 and abs(high[2] + low[2]) < 0.1
    assert all(type(part) is float for corner in (*solid.bounds, *SDF3.from_array(array, 0.1).bounds) for part in corner)


def test_a_number_stands_for_all_axes() -> None:
    at = points(200)
    same = lambda a, b: np.abs(a.distance(at) - b.distance(at)).max() < 1e-6
    assert same(capped_cylinder(0, 10 * Z, 1), capped_cylinder((0, 0, 0), (0, 0, 10), 1))
    assert same(capsule(-0.5, 0.5, 0.2), capsule((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5), 0.2))
    assert same(sphere(1).translate(1), sphere(1).translate((1, 1, 1)))


def test_callables_return_columns_as_theirs() -> None:
    values = sphere(1)(np.zeros((3, 3)))
    assert values.shape == (3, 1) and values.dtype == np.float64


def test_sharp_edges_stay_with_dual_contouring() -> None:
    mesh = box(1).mesh(0.1, method="dc")
    assert np.abs(mesh.vertices).max() == pytest.approx(0.5, abs=1e-3)
    assert mesh.volume == pytest.approx(1, rel=5e-3)


def test_fewer_triangles_and_colors() -> None:
    few = sphere(1).mesh(0.05, max_triangles=500)
    assert 300 < len(few) <= 500 and few.is_watertight
    red = sphere(1).paint("#ff0000") | sphere(1).translate((3, 0, 0)).paint((0, 0, 1))
    colors = red.mesh(0.2).colors
    assert {tuple(row) for row in colors.round(2)} == {(1.0, 0.0, 0.0), (0.0, 0.0, 1.0)}
    assert len(sphere(1).mesh(0.2).colors) == 0
