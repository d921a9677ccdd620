"""Solids of three dimensions, for names that profiles have too: `d3.slab` beside `d2.slab`."""

from ._functions import op3, op32, sdf3
from ._sdf3 import SDF3, box, cylinder, plane, slab, sphere

__all__ = ["SDF3", "box", "cylinder", "op3", "op32", "plane", "sdf3", "slab", "sphere"]
