"""Triangles of another program as a solid."""

from argil import *

knob = (sphere(0.6) | capsule((0, 0, 0), (0, 0, 1.2), 0.25).k(0.3)).mesh(0.02)
imported = Mesh.from_arrays(knob.vertices, knob.triangles).sdf(0.02)
f = imported.erode(0.04).shell(0.08) & plane((1, 0.4, 0))
f = f.paint("clay") | imported.translate((-1.2, 0, 0)).paint("gray")
