"""Easing functions: curves from 0 to 1, for `bend_linear`, `transition_linear` and their like.

Any function of NumPy arrays will do in their place. Argil samples it into cubic pieces, exact to 1e-4 of its range; a step is
refused. Formulas: Robert Penner's easing functions, https://robertpenner.com/easing/.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    import numpy as np

#: A function of an array of places from 0 to 1.
Ease: TypeAlias = "Callable[[Any], Any]"

__all__ = [
    "linear",
    *(f"{way}_{name}" for name in (
        "quad", "cubic", "quart", "quint", "sine", "expo", "circ", "elastic", "back", "bounce", "square",
    ) for way in ("in", "out", "in_out")),
]  # fmt: skip


def _where(condition: Any, a: Any, b: Any) -> Any:
    import numpy as np

    return np.where(condition, a, b)


def _array(t: Any) -> np.ndarray[Any, Any]:
    import numpy as np

    return np.asarray(t, dtype=np.float64)


def linear(t: Any) -> Any:
    """A straight line."""
    return t


def _out(ease: Ease, t: Any) -> Any:
    return 1 - ease(1 - _array(t))


def _in_out(ease: Ease, t: Any) -> Any:
    t = _array(t)
    return _where(t < 0.5, ease(2 * t) / 2, 1 - ease(2 - 2 * t) / 2)


def in_quad(t: Any) -> Any:
    """t²."""
    return _array(t) ** 2


def out_quad(t: Any) -> Any:
    """Mirrored t²."""
    return _out(in_quad, t)


def in_out_quad(t: Any) -> Any:
    """t² at both ends."""
    return _in_out(in_quad, t)


def in_cubic(t: Any) -> Any:
    """t³."""
    return _array(t) ** 3


def out_cubic(t: Any) -> Any:
    """Mirrored t³."""
    return _out(in_cubic, t)


def in_out_cubic(t: Any) -> Any:
    """t³ at both ends."""
    return _in_out(in_cubic, t)


def in_quart(t: Any) -> Any:
    """t⁴."""
    return _array(t) ** 4


def out_quart(t: Any) -> Any:
    """Mirrored t⁴."""
    return _out(in_quart, t)


def in_out_quart(t: Any) -> Any:
    """t⁴ at both ends."""
    return _in_out(in_quart, t)


def in_quint(t: Any) -> Any:
    """t⁵."""
    return _array(t) ** 5


def out_quint(t: Any) -> Any:
    """Mirrored t⁵."""
    return _out(in_quint, t)


def in_out_quint(t: Any) -> Any:
    """t⁵ at both ends."""
    return _in_out(in_quint, t)


def in_sine(t: Any) -> Any:
    """A quarter of a cosine."""
    import numpy as np

    return 1 - np.cos(_array(t) * (math.pi / 2))


def out_sine(t: Any) -> Any:
    """A quarter of a sine."""
    return _out(in_sine, t)


def in_out_sine(t: Any) -> Any:
    """Half of a cosine."""
    return _in_out(in_sine, t)


def in_expo(t: Any) -> Any:
    """Powers of 2, with 0 at the start."""
    t = _array(t)
    return _where(t == 0, 0.0, 2.0 ** (10 * t - 10))


def out_expo(t: Any) -> Any:
    """Mirrored powers of 2, with 1 at the end."""
    t = _array(t)
    return _where(t == 1, 1.0, 1 - 2.0 ** (-10 * t))


def in_out_expo(t: Any) -> Any:
    """Powers of 2 at both ends."""
    t = _array(t)
    half = _where(t < 0.5, 2.0 ** (20 * t - 11), 1 - 2.0 ** (9 - 20 * t))
    return _where(t == 0, 0.0, _where(t == 1, 1.0, half))


def in_circ(t: Any) -> Any:
    """A quarter of a circle."""
    import numpy as np

    return 1 - np.sqrt(np.maximum(0, 1 - _array(t) ** 2))


def out_circ(t: Any) -> Any:
    """A mirrored quarter of a circle."""
    return _out(in_circ, t)


def in_out_circ(t: Any) -> Any:
    """Quarters of a circle at both ends."""
    return _in_out(in_circ, t)


def in_elastic(t: Any, k: float = 0.5) -> Any:
    """A growing swing of period `k`."""
    import numpy as np

    u = _array(t) - 1
    return -(2.0 ** (10 * u)) * np.sin((u - k / 4) * (2 * math.pi) / k)


def out_elastic(t: Any, k: float = 0.5) -> Any:
    """A swing of period `k` that fades."""
    import numpy as np

    t = _array(t)
    return 2.0 ** (-10 * t) * np.sin((t - k / 4) * (2 * math.pi / k)) + 1


def in_out_elastic(t: Any, k: float = 0.5) -> Any:
    """A swing of period `k` in the middle."""
    import numpy as np

    u = 2 * _array(t)
    v = u - 1
    swing = np.sin((v - k / 4) * (2 * math.pi) / k)
    return _where(u < 1, -0.5 * 2.0 ** (10 * v) * swing, 0.5 * 2.0 ** (-10 * v) * swing + 1)


def in_back(t: Any) -> Any:
    """It goes back before it goes on."""
    t = _array(t)
    return t * t * (2.70158 * t - 1.70158)


def out_back(t: Any) -> Any:
    """It goes too far and comes back."""
    return _out(in_back, t)


def in_out_back(t: Any) -> Any:
    """It goes back before, and too far after."""
    k = 1.70158 * 1.525
    return _in_out(lambda u: u * u * ((k + 1) * u - k), t)


def out_bounce(t: Any) -> Any:
    """Four bounces."""
    t = _array(t)
    a = 121 * t * t / 16
    b = 363 / 40 * t * t - 99 / 10 * t + 17 / 5
    c = 4356 / 361 * t * t - 35442 / 1805 * t + 16061 / 1805
    d = 54 / 5 * t * t - 513 / 25 * t + 268 / 25
    return _where(t < 4 / 11, a, _where(t < 8 / 11, b, _where(t < 9 / 10, c, d)))


def in_bounce(t: Any) -> Any:
    """Four bounces at the start."""
    return _out(out_bounce, t)


def in_out_bounce(t: Any) -> Any:
    """Bounces at both ends."""
    t = _array(t)
    return _where(t < 0.5, in_bounce(2 * t) / 2, out_bounce(2 * t - 1) / 2 + 0.5)


def in_square(t: Any) -> Any:
    """A step at the end. Curves with steps are refused."""
    return _where(_array(t) < 1, 0.0, 1.0)


def out_square(t: Any) -> Any:
    """A step at the start. Curves with steps are refused."""
    return _where(_array(t) > 0, 1.0, 0.0)


def in_out_square(t: Any) -> Any:
    """A step in the middle. Curves with steps are refused."""
    return _where(_array(t) < 0.5, 0.0, 1.0)


def _pieces(ease: Ease) -> list[list[float]]:
    """Returns a function as cubic pieces of equal length: the fewest that are exact to 1e-6, or 110."""
    import numpy as np

    if ease is linear:
        return [[0.0, 1.0, 0.0, 0.0]]
    places = np.linspace(0, 1, 997)
    try:
        exact = np.broadcast_to(np.asarray(ease(places), dtype=np.float64), places.shape)
    except (TypeError, ValueError) as error:
        raise ValueError(f"e: the easing function failed for an array of places: {error}") from error
    if not np.all(np.isfinite(exact)):
        raise ValueError("e: the easing function returned values that are not finite")
    pieces = np.zeros((1, 4))
    # Bounces have kinks at multiples of 1/110.
    for count in (1, 2, 4, 8, 16, 32, 64, 110):
        at = np.asarray(ease(np.linspace(0, 1, 3 * count + 1)), dtype=np.float64)
        a, b, c, d = at[0:-1:3], at[1::3], at[2::3], at[3::3]
        one, two, three = b - a, c - 2 * b + a, d - 3 * c + 3 * b - a
        pieces = np.stack([a, 3 * one - 1.5 * two + three, 4.5 * two - 4.5 * three, 4.5 * three], axis=1)
        along = places * count
        nth = np.minimum(along.astype(int), count - 1)
        u = along - nth
        p = pieces[nth]
        found = p[:, 0] + u * (p[:, 1] + u * (p[:, 2] + u * p[:, 3]))
        if np.max(np.abs(found - exact)) < 1e-6:
            break
    else:
        steps = np.abs(np.diff(exact))
        if steps.max() > 0.25 * max(np.ptp(exact), 1e-9):
            raise ValueError("e: the easing function has a step, which a solid cannot follow")
    return [[float(c) for c in piece] for piece in pieces]
