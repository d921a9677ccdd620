"""Distances, closest points and rays."""

from argil import *

f = torus(1, 0.35) - sphere(0.5).translate((1, 0, 0.2)).k(0.1)
points = np.random.default_rng(1).uniform(-1.5, 1.5, (200, 3))
near, distance = f.closest_point(points)
hits, where, normal = f.cast_rays(points, -points)

dots = sphere(0.03).instances(near[np.isfinite(distance)]).paint("red")
f = f.paint("stone") | dots
