"""Smooth and flat joints, with colors that blend."""

from argil import *

f = sphere(0.75, (-3, 0, 0)).paint("red") | sphere(0.75, (3, 0, 0)).paint("blue")
f = f.union(capsule((-3, 0, 0), (3, 0, 0), 0.4).paint("sand"), k=0.8)
f |= box(1).translate((0, 0, 0.7)).rotate(pi / 4).paint("gold", metallic=1, roughness=0.3).k(0.4)
f = f.difference(cylinder(0.3).translate((0, 0, 0)), chamfer=0.1)
