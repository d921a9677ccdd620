"""A function of NumPy as a brush."""

from argil import *


@sdf3(bounds=((-1.2, -1.2, -0.5), (1.2, 1.2, 0.5)), lipschitz=1.8)
def ripples(height, length):
    def f(p):
        r = np.hypot(p[:, 0], p[:, 1])
        return np.maximum(np.abs(p[:, 2] - height * np.cos(r * 2 * pi / length)) - 0.08, r - 1.1)

    return f


f = ripples(0.12, 0.5).paint("blue") | cylinder(0.15) & slab(z0=-0.5, z1=0.5).k(0.1)
