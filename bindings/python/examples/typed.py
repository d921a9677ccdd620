"""All that a program with types asks of the package: mypy and pyright check it."""

from __future__ import annotations

import argil
import numpy as np
from argil import SDF2, SDF3, Mesh, Scene, box, circle, cylinder, ease, sdf3, sphere
from numpy.typing import NDArray


def part(radius: float) -> SDF3:
    body = sphere(radius) & box(1.5 * radius)
    holes = cylinder(0.5 * radius).orient((1, 0, 0)) | cylinder(0.5 * radius)
    return (body - holes.k(0.05)).paint("gold", metallic=1)


def ring(profile: SDF2) -> SDF3:
    return profile.revolve(1.0).bend_radial(0.5, 1.5, 0.2, ease.in_out_quad)


solid: SDF3 = part(1) | ring(circle(0.2)).translate((0, 0, 1))
points: NDArray[np.float64] = np.zeros((10, 3))
distances: NDArray[np.float32] = solid.distance(points)
near, how_far = solid.closest_point(points, 2.0)
hits, where, normals = solid.cast_rays(points, points + 1)
(x0, y0, z0), (x1, y1, z1) = solid.bounds
mesh: Mesh = solid.mesh(0.05, max_triangles=5_000)
vertices: NDArray[np.float32] = mesh.vertices
center: tuple[float, float, float] = mesh.center_of_mass()
picture: NDArray[np.uint8] = solid.render((64, 48), camera=(30, 20, 3))

scene = Scene(solid)
hole = scene.add(cylinder(0.1), "difference", name="hole")
scene.translate(hole, (0.1, 0, 0))
bricks = scene.bricks(64)
bricks -= sphere(0.1)
report: argil.EditReport = bricks.apply()


@sdf3(bounds=((-1, -1, -1), (1, 1, 1)), lipschitz=1.0)
def ball(radius: float) -> object:
    return lambda p: np.linalg.norm(p, axis=1) - radius


def main() -> None:
    print(distances, near, how_far, hits, where, normals, x1 - x0, y1 - y0, z1 - z0, vertices, center, picture, report)


if __name__ == "__main__":
    main()
