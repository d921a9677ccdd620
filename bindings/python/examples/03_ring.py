"""Copies around an axis, and a twist."""

from argil import *

f = rounded_cylinder(1, 0.1, 5)
x = box((1, 1, 4)).rotate(pi / 4).circular_array(24, 1.6)
f -= (x.twist(0.75) | x.twist(-0.75)).k(0.1)
f -= cylinder(0.5).k(0.1)
