"""A solid that is edited in place."""

from argil import *

bricks = box((3, 2, 0.4)).paint("green").bricks(resolution=256)
rng = np.random.default_rng(4)
for x, y in rng.uniform(-1, 1, (30, 2)) * (1.3, 0.8):
    bricks -= sphere(0.16).translate((x, y, 0.22)).k(0.08)

f = bricks.scene.solid()
