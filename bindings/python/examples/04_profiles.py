"""Profiles that are extruded and revolved."""

from argil import *

star = polygon([(r * np.cos(a), r * np.sin(a)) for r, a in zip([1, 0.45] * 5, np.arange(10) * pi / 5)])
vase = rounded_rectangle((0.3, 2.2), 0.12).translate((0, 0.1)) | circle(0.25, (0.1, 1.1))
f = star.extrude_to(circle(0.7), 1.5, ease.in_out_quad).translate((-1.6, 0, 0)).paint("gold")
f |= vase.revolve(0.7).translate((1.4, 0, 0)).paint("clay")
