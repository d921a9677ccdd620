"""Letters around a ring."""

from argil import *

w, h = measure_text(None, "signed distances", height=0.7)
f = text(None, "signed distances", height=0.7).extrude(0.3).orient(Y)
f = f.wrap_around(-w / 2 - 0.4, w / 2 + 0.4).paint("red")
r = (w + 0.8) / (2 * pi)
f |= (cylinder(r + 0.02) - cylinder(r - 0.2) & slab(z0=-0.6, z1=0.6).k(0.1)).paint("stone")
